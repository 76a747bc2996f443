"""A result, or the main report, as a typeset PDF: parts as JSON values, figures as SVG, laid out by Typst."""

from __future__ import annotations

import datetime
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.figures.figure import FIGURE_WIDTH, ON_PAPER, Figure
from gd_analyze.figures.svg import figure_svg
from gd_analyze.formulas.formula import Formula, Symbol
from gd_analyze.formulas.languages import Typst
from gd_analyze.formulas.writing import part_symbol
from gd_analyze.report.answer import VerdictList
from gd_analyze.report.html import TEMPLATES
from gd_analyze.report.main_report import MainReport, main_report
from gd_analyze.report.model_sections import model_parts
from gd_analyze.report.numbering import PartNumbers, flat, is_seen
from gd_analyze.result import Drawing, Equations, Mark, Part, Result, Section, SeenColumn, SeenFact, Table
from gd_analyze.results.findings import Findings
from gd_analyze.results.near_motion import margins, tube_bound
from gd_analyze.results.run_result import stop_facts
from gd_analyze.text import pretty, signed, unbroken

_TYPST = Typst()
# Largest share of the allowed error that a bar shows; beyond it the other bars would vanish.
_LONGEST_BAR = 20.0
# Most rows of a table in the main report.
_MOST_ROWS = 10


def pdf_of(result: Result, created: str) -> bytes:
    """Typeset a result, dated ISO 8601; the same result gives the same bytes."""
    return typeset("result.typ", result_data(result), drawings_of(result.parts), created)


def prepare_pdf(findings: Findings, report: MainReport | None = None) -> Callable[[], bytes]:
    """Do all but the typesetting, which leaves the interpreter free for other threads.

    The returned callable typesets; the same findings give the same bytes.
    """
    report = report or main_report(findings)
    first, numbers = (report.structure, report.shares, *report.effects), report.numbers
    data = result_data(report.opening) | {
        "validity": pretty(report.validity),
        "verdicts": [_verdict(group) for group in report.verdicts],
        "errors": None if report.errors is None else _errors(findings, report.errors, numbers),
        "first": {part["key"]: part for part in parts_data(first, numbers)},
        "model": parts_data((*model_parts(findings), *stop_facts(findings)), numbers),
        "notes": [pretty(note) for note in report.notes],
        "appendices": parts_data(report.appendices, numbers, _MOST_ROWS),
        "joints": findings.arm.n_joints,
    }
    # The legend of matrix and bars is as wide as both.
    matrix = report.structure.figure
    matrix_drawing = replace(report.structure, figure=replace(matrix, legend=()))
    drawings = drawings_of((matrix_drawing, *first[1:], *report.appendices))
    drawings["legend"] = figure_svg(replace(matrix, rows=(), width=FIGURE_WIDTH))
    return partial(typeset, "report.typ", data, drawings, findings.provenance["created"])


def _verdict(group: VerdictList) -> dict[str, Any]:
    """A list of elements: verdict, heading, symbols, and words."""
    symbols = [_TYPST.symbol(part_symbol(label)) for label in group.elements]
    return {
        "verdict": group.verdict,
        "heading": group.heading,
        "symbols": symbols,
        "words": pretty(group.words),
    }


def _errors(findings: Findings, table: Table, numbers: PartNumbers) -> dict[str, Any]:
    """Bars and figures of every joint's error, sampled and proven, against the budget."""
    accuracy, bound = findings.model.accuracy, tube_bound(findings)
    used = _used(findings, accuracy.errors.largest)
    proven = None if bound is None else _used(findings, bound)
    return {
        "table": parts_data([table], numbers)[0],
        "used": used,
        "proven": proven,
        "proof": findings.proof,
        "longest": max([1.25, *used, *(proven or [])]),
        "near": "the motion" if bound is None else f"{margins(findings)} of the motion",
        "budget": accuracy.budget,
    }


def _used(findings: Findings, errors: FloatArray) -> list[float]:
    """Errors over allowed errors; 0 where an error is round-off."""
    allowed = findings.model.accuracy.allowed
    counts = (errors > findings.round_off) & (allowed > 0.0)
    used = np.divide(errors, allowed, out=np.zeros_like(allowed), where=counts)
    return np.minimum(used, _LONGEST_BAR).tolist()


def result_data(result: Result) -> dict[str, Any]:
    """A result as the JSON values that the templates lay out."""
    facts = [fact for fact in result.facts if isinstance(fact, SeenFact)]
    return {
        "title": result.title,
        "subtitle": result.subtitle,
        "headline": unbroken(pretty(result.headline)),
        "facts": [[pretty(fact.written), pretty(fact.label)] for fact in facts],
        "notices": [pretty(notice) for notice in result.notices],
        "parts": parts_data(result.parts, PartNumbers.of(result.parts)),
        "provenance": [[label.replace("_", " "), value] for label, value in result.provenance.items()],
        "run": result.provenance.get("run", ""),
    }


def parts_data(
    parts: Sequence[Part], numbers: PartNumbers, most_rows: int | None = None
) -> list[dict[str, Any]]:
    """Parts for people as JSON values, each with its kind; of longer tables the first `most_rows` rows."""
    return [_part(part, numbers, most_rows) for part in parts if is_seen(part)]


def drawings_of(parts: Sequence[Part]) -> dict[str, str]:
    """SVG of every drawing by its key."""
    return {part.key: figure_svg(part.figure) for part in flat(parts) if isinstance(part, Drawing)}


def _part(part: Part, numbers: PartNumbers, most_rows: int | None) -> dict[str, Any]:
    if isinstance(part, SeenFact):
        return {"kind": "fact", "label": part.label, "value": pretty(part.written)}
    if isinstance(part, Section):
        inside, named = parts_data(part.parts, numbers, most_rows), {"key": part.key, "title": part.title}
        return {"kind": "section", **named, "note": _lines(part.note), "parts": inside}
    if isinstance(part, Drawing):
        width = part.figure.columns * part.figure.width
        number = numbers.figures.get(part.key)
        words = {"title": pretty(part.title), "note": pretty(part.note), "label": part.figure.label}
        return {"kind": "drawing", "key": part.key, "number": number, "width": width, **words}
    if isinstance(part, Equations):
        return {
            "kind": "equations",
            "title": part.title,
            "lines": list(part.lines) if not part.formulas else [],
            "formulas": [_formula(formula) for formula in part.formulas],
            "legend": list(_TYPST.legend(part.legend)) if part.legend else [],
            "note": _lines(part.note),
        }
    assert isinstance(part, Table)  # people see no `Value`
    return _table(_shortened(part, most_rows), numbers)


def _shortened(table: Table, most_rows: int | None) -> Table:
    """The first rows of a long table, with a note that says how many are left out."""
    n_shown = table.n_rows if table.top is None else min(table.top, table.n_rows)
    if most_rows is None or n_shown <= most_rows:
        return table
    note = f"{table.note}\n{n_shown - most_rows} more rows stand in the page and in `--json`.".lstrip()
    return replace(table, top=most_rows, note=note)


def _table(table: Table, numbers: PartNumbers) -> dict[str, Any]:
    """Heads and rows of cells of a table."""
    printed = table.shown(on_page=True)
    columns = [column for column, _, _ in printed]
    cells = [_cells(column, written) for column, _, written in printed]
    lengths = [max((len(str(cell)) for cell in of_column), default=0) for of_column in cells]
    return {
        "kind": "table",
        "number": numbers.tables.get(table.key),
        "title": pretty(table.title),
        "heads": [[column.label, unit] for column, unit, _ in printed],
        "left": [column.is_text for column in columns],
        "long": [
            column.is_text and column.drawn is None and length > 40
            for column, length in zip(columns, lengths, strict=True)
        ],
        "rows": [list(row) for row in zip(*cells, strict=True)],
        "note": _lines(table.note),
    }


def _cells(column: SeenColumn, written: Sequence[str]) -> list[Any]:
    """Cells: text, mathematics ("math"), or a mark ("effect" and "text")."""
    if column.drawn is not None:
        return [
            {"effect": drawn.effect, "text": drawn.text} if isinstance(drawn, Mark) else _maths(drawn)
            for drawn in column.drawn[: len(written)]
        ]
    return [pretty(cell) if column.is_text else signed(pretty(cell)) for cell in written]


def _maths(value: Any) -> Any:
    if isinstance(value, Symbol):
        return {"math": _TYPST.symbol(value)}
    if isinstance(value, Formula):
        left = f"{_TYPST.symbol(value.left)} = " if value.left.letter else ""
        return {"math": left + _TYPST.right(value)}
    if isinstance(value, tuple | list):
        return {"math": ", ".join(_maths(entry)["math"] for entry in value)} if value else ""
    return "" if value is None else pretty(str(value))


def _formula(formula: Formula) -> dict[str, Any]:
    """Left-hand side, its letter, and pieces; one group for outer torques and D, one for h, one for c."""
    groups: dict[str, list[dict[str, str]]] = {}
    for piece in formula.pieces:
        group = groups.setdefault("inertia" if piece.quantity == "carried" else piece.quantity, [])
        group.append({"sign": "−" if piece.negative else "+", "math": _TYPST.body(piece)})
    return {
        "left": _TYPST.symbol(formula.left),
        "letter": formula.left.letter,
        "groups": [*groups.values()],
    }


def _lines(note: str) -> list[str]:
    return [pretty(line) for line in note.split("\n") if line]


def drawing_file(figure: Figure, form: Any) -> bytes:
    """A figure by itself, as "svg", "pdf" or "png" at 200 pixels per inch."""
    import typst

    svg = figure_svg(figure)
    if form == "svg":
        return svg.encode()
    page = b"#set page(width: auto, height: auto, margin: 4pt)\n#image(bytes(sys.inputs.drawing))"
    return typst.compile(page, format=form, ppi=200, sys_inputs={"drawing": svg}, ignore_system_fonts=True)


def typeset(template: str, data: Mapping[str, Any], drawings: Mapping[str, str], created: str) -> bytes:
    """Compile a template that reads data, colours and drawings (SVG by name) from `sys.inputs`."""
    import typst

    try:
        pdf = typst.compile(
            TEMPLATES / template,
            root=TEMPLATES,
            ignore_system_fonts=True,
            sys_inputs={
                "data": json.dumps(data, ensure_ascii=False, allow_nan=False),
                "colours": json.dumps(ON_PAPER),
                **{f"drawing-{name}": svg for name, svg in drawings.items()},
            },
            timestamp=datetime.datetime.fromisoformat(created),
        )
    except typst.TypstError as error:
        raise GdAnalyzeError(
            "the PDF report cannot be typeset",
            where=template,
            found=" ".join([error.message, *error.hints, error.diagnostic]),
            next_step="please report this with the arm file and the trajectory; --format html works without",
        ) from error
    return bytes(pdf)
