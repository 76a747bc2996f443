"""The document of the main report: the answer, the model and its budget, effects, and appendices."""

from __future__ import annotations

from dataclasses import replace
from string import ascii_uppercase
from typing import Any

from gd_analyze.figures.arm import arm_figure, playable
from gd_analyze.figures.elements import MOST_MARKED_SET_POINTS, Look, inertia_figure, vector_figure
from gd_analyze.figures.figure import FIGURE_WIDTH, Figure
from gd_analyze.figures.structure import Cell, cells, crosses, matrix_figure, shares_figure
from gd_analyze.formulas.writing import part_symbol
from gd_analyze.report.answer import VerdictList, element_details, shown_verdict_lists, validity
from gd_analyze.report.budget import BudgetPath, budget_data, terms_data
from gd_analyze.report.document import Document, PartWriter, opening_of, typeset_value
from gd_analyze.report.error_bars import error_bars
from gd_analyze.report.model_sections import made_of, model_parts
from gd_analyze.report.sections import sections
from gd_analyze.result import Drawing, Result
from gd_analyze.results.findings import Findings
from gd_analyze.results.model_facts import joint_errors
from gd_analyze.results.near_motion import tube_bound
from gd_analyze.results.run_result import (
    first_facts,
    notes,
    notices,
    provenance_lines,
    run_headline,
    stop_facts,
    subtitle,
)
from gd_analyze.results.shown_tables import text_comparison
from gd_analyze.text import percent, short_names

# Most rows of a table in an appendix on paper.
_MOST_ROWS_ON_PAPER = 10
_APPENDIX_NAMES = {
    "motion": "Motion",
    "recording": "Readings",
    "measured": "Measured",
    "torque": "Torque",
    "ranking": "Elements",
    "motions": "Motions",
    "terms": "Terms",
    "model": "Savings",
    "beyond": "Beyond",
    "elements": "By hand",
    "equations": "Equations",
    "data": "Data",
}
# Notices before the answer; the others follow it.
_NOTICES_BEFORE_ANSWER = 2


def main_report(findings: Findings) -> Document:
    """Make the document of a run's report; page and PDF show most of it, each in its own order."""
    path = BudgetPath.of(findings)
    matrix, bars = matrix_figure(findings), shares_figure(findings)
    writer = PartWriter()
    content = opening_of(_opening(findings)) | {
        "joints": short_names([joint.name for joint in findings.arm.joints]),
        "validity": validity(findings),
        "verdicts": [_verdict(group) for group in shown_verdict_lists(findings)],
        "cells": {label: _cell_words(cell) for label, cell in cells(findings).items()},
        "elements": element_details(findings),
        "played": playable(findings),
        # In the order in which figures and tables are numbered.
        "structure": writer.part(_structure(findings, matrix)),
        "shares": writer.part(_shares(findings, bars)),
        "budget": budget_data(findings, path),
        "errors": None,
    }
    if not findings.model.is_exact or path.moves:
        table = joint_errors(findings.model, tube_bound(findings), "errors", findings.proof)
        content["errors"] = error_bars(findings) | {"table": writer.part(table)}
    content |= {
        "model": writer.of(model_parts(findings)),
        "stops": writer.of(stop_facts(findings)),
        "terms": terms_data(findings, path) if made_of(findings) == "terms" else None,
        "effects": writer.of(effect_drawings(findings)),
    }
    appendices = replace(writer, most_on_paper=_MOST_ROWS_ON_PAPER).of(sections(findings))
    content["appendices"] = [
        part | {"letter": letter, "name": _APPENDIX_NAMES[part["key"]]}
        for letter, part in zip(ascii_uppercase, appendices, strict=False)
    ]
    # One legend explains matrix and bars, which stand side by side, and is as wide as both.
    legend = tuple(dict.fromkeys((*bars.legend, *matrix.legend)))
    beside = {
        "arm": arm_figure(findings),
        "legend": replace(matrix, rows=(), width=FIGURE_WIDTH, legend=legend),
    }
    return Document(content, writer.figures | beside, "main")


def _opening(findings: Findings) -> Result:
    """Title, headline, facts, the first notices, and the others as notes."""
    at_end = notes(findings)
    all_notices = (*findings.warnings, *notices(findings), *at_end)
    n_first = min(_NOTICES_BEFORE_ANSWER, len(all_notices) - len(at_end))
    return Result(
        title=findings.arm.title or findings.arm.name,
        subtitle=subtitle(findings),
        headline=run_headline(findings),
        facts=first_facts(findings),
        notices=all_notices[:n_first],
        notes=all_notices[n_first:],
        provenance=dict(provenance_lines(findings)),
    )


def _verdict(group: VerdictList) -> dict[str, Any]:
    """A list of elements: verdict, heading, symbols, and words."""
    symbols = [typeset_value(part_symbol(label)) for label in group.elements]
    return {"verdict": group.verdict, "heading": group.heading, "symbols": symbols, "words": group.words}


def _cell_words(cell: Cell) -> str:
    """A cell of the matrix for screen readers."""
    return f"{cell.label}, {cell.verdict}, {percent(cell.share)} of peak torque of joint {cell.joint}"


def _structure(findings: Findings, matrix: Figure) -> Drawing:
    return Drawing(
        "structure",
        "Every element of D (symmetric), h and c in its place.",
        replace(matrix, legend=()),
        "Figure and area: its largest torque over the peak torque of its joint; the square is full from "
        "100 %, above which elements cancel."
        f"{' ↓: at the joint of the column.' if crosses(findings) else ''}"
        f"{' On the diagonal the drive is added.' if findings.model.drives else ''}",
    )


def _shares(findings: Findings, bars: Figure) -> Drawing:
    return Drawing(
        "shares",
        "What makes each joint's torque.",
        replace(bars, legend=()),
        f"T, R: D q̈ by translation and rotation{'; J: drives' if findings.model.drives else ''}. "
        "Shares of the sum of RMS.",
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
