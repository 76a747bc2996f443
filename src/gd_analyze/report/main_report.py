"""The main job's answer: which of its parts terminal, JSON, page and PDF show, in order."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from string import ascii_uppercase
from typing import Any

from gd_analyze.figures.arm import arm_figure, playable
from gd_analyze.figures.figure import FIGURE_WIDTH
from gd_analyze.figures.structure import crosses, matrix_figure, shares_figure
from gd_analyze.report import model_sections, sections
from gd_analyze.report.budget import BudgetPath, budget_data, budget_words, terms_data
from gd_analyze.report.document import Document, PartWriter, opening_of
from gd_analyze.report.element_details import element_details
from gd_analyze.report.error_bars import error_bars
from gd_analyze.result import Drawing, Part, Result, Table
from gd_analyze.results import beside_log, motion_result, run_facts, shown_tables
from gd_analyze.results.findings import Findings
from gd_analyze.results.near_motion import margins
from gd_analyze.text import short_names


def matrix(findings: Findings) -> Drawing:
    """The matrix of elements."""
    return Drawing(
        "structure",
        "Every element of D (symmetric), h and c in its place.",
        matrix_figure(findings),
        "Figure and area: its largest torque over the peak torque of its joint; the square is capped at "
        "100 %, above which elements cancel."
        f"{' ↓: at the joint of the column.' if crosses(findings) else ''}"
        f"{' On the diagonal the drive is added.' if findings.model.drives else ''}",
    )


def structure(findings: Findings) -> tuple[Drawing, ...]:
    """The matrix of elements, and what makes each joint's torque; their legend stands beside the document."""
    drives, elements = findings.model.drives, matrix(findings)
    return (
        replace(elements, figure=replace(elements.figure, legend=())),
        Drawing(
            "shares",
            "What makes each joint's torque.",
            replace(shares_figure(findings), legend=()),
            "T, R: D q̈ by translation and rotation; h likewise, paler"
            f"{'; J: drives' if drives else ''}. Shares of the sum of RMS.",
        ),
    )


def errors_with_bars(findings: Findings) -> Iterator[Table]:
    """The errors of joints, where there are any or the budget can change."""
    if not findings.model.is_exact or BudgetPath.of(findings).moves:
        yield run_facts.errors_table(findings)


def errors_without_log(findings: Findings) -> Iterator[Table]:
    """The errors of joints, where no table of a log has them."""
    if not beside_log.has_log(findings):
        yield run_facts.errors_table(findings)


# Makes a part, several, or None.
Maker = Callable[..., Part | Iterable[Part] | None]
# What a terminal shows.
TERMINAL: tuple[Maker, ...] = (
    motion_result.measured_section,
    run_facts.elements_by_verdict,
    model_sections.equations_by_element,
    run_facts.stop_facts,
    errors_without_log,
    motion_result.motions_section,
    motion_result.recording_section,
    shown_tables.ranking_table,
)
# What a notebook shows.
NOTEBOOK: tuple[Maker, ...] = (matrix, *TERMINAL)
# What --json prints.
JSON: tuple[Maker, ...] = (
    run_facts.elements_by_verdict,
    model_sections.equations_by_element,
    run_facts.stop_facts,
    run_facts.errors_table,
    run_facts.first_facts,
    run_facts.settings_values,
    run_facts.check_values,
    motion_result.measured_section,
    motion_result.motions_section,
    motion_result.recording_section,
    shown_tables.ranking_table,
    shown_tables.ranked_terms_table,
    shown_tables.far_errors_table,
    model_sections.tube_section,
    shown_tables.difference_table,
    run_facts.model_values,
)
# What page and PDF show before the appendices, in the order of numbers; templates give each its place.
REPORT: dict[str, Maker] = {
    "log": sections.log_parts,
    "verdicts": run_facts.elements_by_verdict,
    "structure": structure,
    "left": sections.left_of_log,
    "errors": errors_with_bars,
    "model": model_sections.model_equations,
    "stops": run_facts.stop_facts,
    "effects": sections.effect_drawings,
}
# Their appendices, by the name in the bar of the page.
APPENDICES: dict[str, Maker] = {
    "Torque": sections.torque_appendix,
    "Motion": sections.motion_appendix,
    "Readings": sections.recording_appendix,
    "Measured": sections.measured_appendix,
    "Elements": sections.ranking_appendix,
    "Motions": sections.motions_appendix,
    "Terms": sections.terms_appendix,
    "Savings": model_sections.savings_appendix,
    "Beyond": model_sections.beyond_appendix,
    "By hand": model_sections.by_hand_appendix,
    "Equations": sections.equations_appendix,
    "Data": sections.data_appendix,
}
# Of these people may see the first rows alone.
_RANKINGS = (shown_tables.ranking_table, motion_result.motions_section)
# Most rows of a table on paper.
_MOST_ROWS_ON_PAPER = 10
# Notices before the answer of page and PDF; the others follow it.
_NOTICES_BEFORE_ANSWER = 2


def main_result(findings: Findings, makers: Iterable[Maker] = TERMINAL, top: int = 0) -> Result:
    """Make the main job's result, with the parts of `TERMINAL` or of `JSON`, and `top` rows of rankings."""
    parts: list[Part] = []
    for make in makers:
        parts += _made(make(findings, top) if make in _RANKINGS else make(findings))
    return Result(
        title=findings.arm.title or findings.arm.name,
        subtitle=run_facts.subtitle(findings),
        headline=run_facts.run_headline(findings),
        parts=tuple(parts),
        notices=run_facts.notices(findings),
        notes=run_facts.notes(findings),
        provenance=findings.provenance,
    )


def _made(made: Part | Iterable[Part] | None) -> Iterable[Part]:
    """What a maker made, as parts."""
    if made is None:
        return ()
    return (made,) if isinstance(made, Part) else made


def main_report(findings: Findings) -> Document:
    """Make the document of a run's report; page and PDF show most of it, each in its own order."""
    opening = main_result(findings, ())
    told = (*_further_warnings(findings), *opening.notices)
    opening = replace(
        opening,
        facts=run_facts.first_facts(findings),
        notices=told[:_NOTICES_BEFORE_ANSWER],
        notes=(*told[_NOTICES_BEFORE_ANSWER:], *opening.notes),
        provenance=run_facts.provenance_lines(findings),
    )
    writer = PartWriter(_MOST_ROWS_ON_PAPER)
    content = opening_of(opening) | {
        "lead": motion_result.agreement_sentence(findings).strip(),
        "headline": run_facts.model_headline(findings),
        "joints": short_names([joint.name for joint in findings.arm.joints]),
        "validity": _validity(findings),
        "next": findings.provenance.get("next", ""),
        "parts": {key: writer.of(_made(make(findings))) for key, make in REPORT.items()},
        "appendices": _appendices(findings, writer),
        "errors": error_bars(findings),
        # What the page's script reads and moves.
        "interactive": {
            "arm": playable(findings),
            "elements": element_details(findings),
            "budget": budget_data(findings),
            "terms": terms_data(findings),
        },
    }
    # One legend explains matrix and bars, which stand side by side, and is as wide as both.
    matrix, bars = matrix_figure(findings), shares_figure(findings)
    legend = tuple(dict.fromkeys((*bars.legend, *matrix.legend)))
    beside = {
        "arm": arm_figure(findings),
        "legend": replace(matrix, rows=(), width=FIGURE_WIDTH, legend=legend),
    }
    return Document(content, writer.figures | beside, "main")


def _appendices(findings: Findings, writer: PartWriter) -> list[dict[str, Any]]:
    """The appendices that the run has, with letters."""
    made = ((name, writer.of(_made(make(findings)))) for name, make in APPENDICES.items())
    named = [part | {"name": name} for name, written in made for part in written]
    return [part | {"letter": letter} for letter, part in zip(ascii_uppercase, named, strict=False)]


def _further_warnings(findings: Findings) -> list[str]:
    """Warnings without the verdict on a log, with which the report begins."""
    if not beside_log.has_log(findings):
        return [*findings.warnings]
    verdict = f"log {findings.trajectory.name}: {findings.tables['measured_torque'].attrs['opening']}"
    texts = (text.removeprefix(verdict).strip() for text in findings.warnings)
    return [text for text in texts if text]


def _validity(findings: Findings) -> str:
    """What the answer holds for: motion, margins and budget; "" where there is no model."""
    if findings.is_unreadable:
        return ""
    budget = budget_words(findings.model.accuracy.budget)
    along = "these motions" if findings.trajectory.motions else "this motion"
    return f"Valid within {margins(findings)} of {along}. Torque error allowed: {budget}."
