"""Opening, appendices and numbering of the main report, shared by page and PDF."""

from __future__ import annotations

from typing import NamedTuple

from gd_analyze.figures.arm import arm_figure
from gd_analyze.figures.dominance import dominance_figure
from gd_analyze.figures.joints import contributions_figure
from gd_analyze.report.numbering import Numbers
from gd_analyze.report.sections import sections
from gd_analyze.result import Drawing, Part, Result, Section, Table
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
    appendices = sections(findings)
    parts: tuple[Part, ...] = (arm, dominance, contributions, errors, *appendices)
    numbers = Numbers.of(parts)
    return MainReport(opening, arm, contributions, dominance, errors, appendices, numbers)
