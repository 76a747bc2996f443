"""Opening, appendices and numbering of the main report, shared by page and PDF."""

from __future__ import annotations

from typing import NamedTuple

from gd_analyze.figures.arm import arm_figure
from gd_analyze.figures.dominance import dominance_figure
from gd_analyze.figures.joints import contributions_figure
from gd_analyze.figures.trade_off import kind_name, trade_off_figure
from gd_analyze.report.numbering import Numbers
from gd_analyze.report.sections import sections
from gd_analyze.result import Column, Drawing, Part, Result, Section, Table
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import joint_errors
from gd_analyze.results.rows import dominance_note
from gd_analyze.results.run_result import (
    first_facts,
    notices,
    provenance_lines,
    run_headline,
    subtitle,
    tube_bound,
)


class MainReport(NamedTuple):
    """Parts of the main report, and the numbers of figures and tables."""

    opening: Result  # title, headline, facts and notices
    arm: Drawing
    contributions: Drawing
    dominance: Drawing
    errors: Table
    trade_off: tuple[Drawing, Table] | None  # if any budget gives fewer operations than the exact torque
    appendices: tuple[Section, ...]
    numbers: Numbers


def main_report(findings: Findings) -> MainReport:
    """Make the parts of a run's report."""
    opening = Result(
        title=findings.arm.title or findings.arm.name,
        subtitle=subtitle(findings),
        headline=run_headline(findings),
        facts=first_facts(findings),
        notices=(*findings.warnings, *notices(findings)),
        provenance=dict(provenance_lines(findings)),
    )
    arm = Drawing("arm", "Poses of the arm and the path of its end effector.", arm_figure(findings))
    contributions = Drawing(
        "contributions",
        "Torque by contribution over time.",
        contributions_figure(findings),
        "Positive parts are stacked above zero, negative ones below it; the line is their sum.",
    )
    dominance = Drawing(
        "dominance",
        "Dominant effect of each element of D and h over time.",
        dominance_figure(findings),
        dominance_note(findings),
    )
    errors = joint_errors(findings.model, tube_bound(findings), "errors")
    operations = findings.tables["trade_off"].operations.values
    has_fewer = bool((operations < findings.model.operations_full.total).any())
    trade_off = (_trade_off(findings), _trade_off_table(findings)) if has_fewer else None
    appendices = sections(findings)
    parts: tuple[Part, ...] = (arm, dominance, contributions, errors, *(trade_off or ()), *appendices)
    numbers = Numbers.of(parts)
    return MainReport(opening, arm, contributions, dominance, errors, trade_off, appendices, numbers)


def _trade_off(findings: Findings) -> Drawing:
    accuracy = findings.model.accuracy
    note = (
        "Dashed: the models of the slider. Other levels come from one quick search each; a longer search may "
        "find fewer operations."
    )
    if accuracy.asked.shares_of != "peak torque":
        note += f" Errors are shares of the error allowed by {accuracy.budget}."
    words = "Operations against error for other budgets and levels; the star is this report's model."
    return Drawing("trade_off", words, trade_off_figure(findings), note)


def _trade_off_table(findings: Findings) -> Table:
    """Operations and error of every kind of model, by budget."""
    table = findings.tables["trade_off"]
    columns = [Column("", "budget", table.budget.values.tolist(), shown="text")]
    names = ("level", "refit", "operations", "largest_share")
    for level, refit, counts, shares in zip(*(table[name].values for name in names), strict=True):
        columns.append(Column("", kind_name(level, refit), counts.tolist(), shown="count"))
        columns.append(Column("", "error", shares.tolist(), shown="percent"))
    title = f"Operations, and largest error of the {findings.model.accuracy.asked.shares_of}, by budget"
    note = "Choose a point with `--operations N` or `--budget`, and a level with `--level` and `--refit`."
    return Table("trade_off", title, tuple(columns), note)
