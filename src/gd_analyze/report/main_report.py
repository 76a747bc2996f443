"""What the main report opens with, its appendices and its numbers: once for page and paper."""

from __future__ import annotations

from typing import NamedTuple

from gd_analyze.figures.arm import arm_figure
from gd_analyze.figures.torques import contributions_figure
from gd_analyze.figures.trade_off import trade_off_figure
from gd_analyze.report.model_sections import nothing_to_trade, trade_off_table
from gd_analyze.report.numbering import Numbers
from gd_analyze.report.sections import sections
from gd_analyze.result import Drawing, Part, Result, Section
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import joint_errors
from gd_analyze.results.run_result import (
    first_facts,
    notices,
    provenance_lines,
    run_headline,
    subtitle,
    tube_bound,
)


class MainReport(NamedTuple):
    """Parts of the main report: `first` before the `appendices`, and the numbers of all."""

    opening: Result
    first: tuple[Part, ...]
    appendices: tuple[Section, ...]
    numbers: Numbers


def main_report(findings: Findings) -> MainReport:
    """Make the parts of a run's report."""
    first, appendices = first_parts(findings), sections(findings)
    return MainReport(opening_of(findings), first, appendices, Numbers.of((*first, *appendices)))


def opening_of(findings: Findings) -> Result:
    """Title, headline, facts and notices of the report."""
    return Result(
        title=findings.arm.title or findings.arm.name,
        subtitle=subtitle(findings),
        headline=run_headline(findings),
        facts=first_facts(findings),
        notices=(*findings.warnings, *notices(findings)),
        provenance=dict(provenance_lines(findings)),
    )


def first_parts(findings: Findings) -> tuple[Part, ...]:
    """Drawings and tables before the appendices, in order."""
    budget = findings.model.accuracy.budget
    contributions = Drawing(
        "contributions",
        "Torque by contribution over time.",
        contributions_figure(findings),
        "Positive parts are stacked above zero, negative ones below it; the line is their sum.",
    )
    arm = Drawing("arm", "Poses of the arm and the path of its end effector.", arm_figure(findings))
    parts: list[Part] = [arm, contributions, joint_errors(findings.model, tube_bound(findings), "errors")]
    if not nothing_to_trade(findings):
        of = findings.model.accuracy.asked.shares_of
        note = "" if of == "peak torque" else f" Errors are shares of what {budget} allows."
        words = "Operations against error for other budgets and levels; the star is this report's model."
        parts.append(Drawing("trade_off", words, trade_off_figure(findings), _TRADE_OFF + note))
        parts.append(trade_off_table(findings))
    return tuple(parts)


_TRADE_OFF = (
    "Dashed: the models of the slider. Other levels come from one quick search each; a longer search "
    "may find "
    "fewer operations."
)
