"""Opening, appendices and numbering of the main report, shared by page and PDF."""

from __future__ import annotations

from dataclasses import replace
from typing import NamedTuple

from gd_analyze.figures.arm import arm_figure
from gd_analyze.figures.elements import MOST_MARKED_SET_POINTS, Look, inertia_figure, vector_figure
from gd_analyze.figures.structure import crosses, matrix_figure, shares_figure
from gd_analyze.report.answer import VerdictList, shown_verdict_lists, validity
from gd_analyze.report.budget import BudgetPath
from gd_analyze.report.numbering import PartNumbers
from gd_analyze.report.sections import sections
from gd_analyze.result import Drawing, Result, Section, Table
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import joint_errors
from gd_analyze.results.near_motion import tube_bound
from gd_analyze.results.run_result import (
    first_facts,
    notes,
    notices,
    provenance_lines,
    run_headline,
    subtitle,
)
from gd_analyze.results.shown_tables import text_comparison

# Notices before the answer; the others follow it.
_NOTICES_BEFORE_ANSWER = 2


class MainReport(NamedTuple):
    """Parts of the main report, and the numbers of figures and tables."""

    opening: Result  # title, headline, facts and the first notices
    validity: str
    verdicts: tuple[VerdictList, ...]
    arm: Drawing  # for a page, which plays it
    structure: Drawing
    shares: Drawing
    effects: tuple[Drawing, ...]  # D and h by effect
    errors: Table | None  # None where no budget gives a model with errors
    notes: tuple[str, ...]  # notices that do not stand before the answer
    appendices: tuple[Section, ...]
    numbers: PartNumbers


def main_report(findings: Findings) -> MainReport:
    """Make the parts of a run's report."""
    all_notices = (*findings.warnings, *notices(findings), *notes(findings))
    opening = Result(
        title=findings.arm.title or findings.arm.name,
        subtitle=subtitle(findings),
        headline=run_headline(findings),
        facts=first_facts(findings),
        notices=all_notices[: min(_NOTICES_BEFORE_ANSWER, len(all_notices) - len(notes(findings)))],
        provenance=dict(provenance_lines(findings)),
    )
    matrix, bars = matrix_figure(findings), shares_figure(findings)
    # One legend explains both, which stand side by side.
    legend = tuple(dict.fromkeys((*bars.legend, *matrix.legend)))
    structure = Drawing(
        "structure",
        "Every element of D (symmetric), h and c in its place.",
        replace(matrix, legend=legend),
        "Figure and area: its largest torque over the peak torque of its joint; the square is full from "
        "100 %, above which elements cancel."
        f"{' ↓: at the joint of the column.' if crosses(findings) else ''}"
        f"{' On the diagonal the drive is added.' if findings.model.drives else ''}",
    )
    shares = Drawing(
        "shares",
        "What makes each joint's torque.",
        replace(bars, legend=()),
        f"T, R: D q̈ by translation and rotation{'; J: drives' if findings.model.drives else ''}. "
        "Shares of the sum of RMS.",
    )
    effects = effect_drawings(findings)
    errors = None
    if not findings.model.is_exact or BudgetPath.of(findings).moves:
        errors = joint_errors(findings.model, tube_bound(findings), "errors", findings.proof)
    appendices = sections(findings)
    numbers = PartNumbers.of((structure, shares, *((errors,) if errors else ()), *effects, *appendices))
    return MainReport(
        opening,
        validity(findings),
        shown_verdict_lists(findings),
        Drawing("arm", "Poses of the arm and the path of its end effector.", arm_figure(findings)),
        structure,
        shares,
        effects,
        errors,
        all_notices[_NOTICES_BEFORE_ANSWER:],
        appendices,
        numbers,
    )


def effect_drawings(findings: Findings) -> tuple[Drawing, Drawing]:
    """D and h by effect against the set points, in the order of [FGL87] Figs. 3.10 and 3.11."""
    is_marked = findings.trajectory.n_set_points <= MOST_MARKED_SET_POINTS
    hidden = "combined", "centrifugal", "coriolis"
    look = Look(x="set point", marked=is_marked, hidden=hidden)
    is_shown = text_comparison(findings) is not None
    orders = [f" In the order of Fig. {k} of [FGL87]." if is_shown else "" for k in ("3.10", "3.11")]
    marks = "Marks on curves and ticks below them: set points." if is_marked else ""
    matrix = "D by effect. At the right of a title: the verdict (J: drive, –: negligible, 0: zero)."
    vector = "h by effect."
    return (
        Drawing("inertia", f"{matrix}{orders[0]}", inertia_figure(findings, look), marks),
        Drawing(
            "coriolis_centrifugal",
            f"{vector}{orders[1]}",
            vector_figure(findings, "coriolis_centrifugal", look),
        ),
    )
