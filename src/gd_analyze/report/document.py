"""A result as one document of JSON values, with its figures beside it: all that terminal, page and PDF show.

Texts are as a terminal shows them; page and PDF raise exponents and typeset symbols. Numbers of figures and
tables follow the order of the document.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from itertools import groupby
from typing import TYPE_CHECKING, Any, Literal, NamedTuple

from gd_analyze.formulas.formula import Formula, Legend, Symbol
from gd_analyze.formulas.languages import PageMathML, Typst
from gd_analyze.result import (
    AnyFact,
    Column,
    Drawing,
    Equations,
    Fact,
    Mark,
    Part,
    Result,
    Section,
    SeenFact,
    Table,
    plain,
)

if TYPE_CHECKING:
    from gd_analyze.figures.figure import Figure

_MATHS, _TYPST = PageMathML(), Typst()


class Document(NamedTuple):
    """What is shown of a result."""

    content: dict[str, Any]  # JSON values; "values" is what --json prints
    figures: dict[str, Figure]  # by the key of their part
    form: Literal["result", "main"] = "result"  # the template of page and PDF; the main report has its own


def result_document(result: Result) -> Document:
    """Make the document of a result."""
    parts = PartWriter()
    content = opening_of(result) | {"parts": parts.of(result.parts), "values": result.values()}
    return Document(content, parts.figures)


def opening_of(result: Result) -> dict[str, Any]:
    """All of a result but its parts."""
    return {
        "title": result.title,
        "subtitle": result.subtitle,
        "lead": "",
        "headline": result.headline,
        "facts": _facts(result.facts),
        "notices": [*result.notices],
        "notes": [*result.notes],
        "provenance": [
            [label.replace("_", " "), value or "not stated"] for label, value in result.provenance.items()
        ],
        "run": result.provenance.get("run", ""),
        "created": result.provenance.get("created", ""),
    }


@dataclass
class PartWriter:
    """Writes parts as JSON values, numbers their figures and tables and collects the figures."""

    most_on_paper: int | None = None  # rows of a table; None for all that people see
    figures: dict[str, Figure] = field(default_factory=dict)
    tables: list[str] = field(default_factory=list)  # keys of those numbered

    def of(self, parts: Iterable[Part]) -> list[dict[str, Any]]:
        """Write what people see of parts; facts that follow each other are one part.

        Parts of a section without a heading stand by themselves.
        """
        out: list[dict[str, Any]] = []
        for are_facts, alike in groupby(parts, lambda part: isinstance(part, AnyFact)):
            if are_facts:
                facts = _facts(alike)
                out += [{"kind": "facts", "facts": facts}] if facts else []
                continue
            for part in alike:
                if isinstance(part, Section):
                    inside = self.of(part.parts)
                    out += [_section(part, inside)] if part.title or part.note else inside
                elif isinstance(part, Drawing):
                    out.append(self._figure(part))
                elif isinstance(part, Equations):
                    out.append(_equations(part))
                elif isinstance(part, Table) and _is_seen(part):
                    out.append(self._table(part))
        return out

    def _figure(self, drawing: Drawing) -> dict[str, Any]:
        figure = drawing.figure
        self.figures[drawing.key] = figure
        return {
            "kind": "figure",
            "key": drawing.key,
            "number": [*self.figures].index(drawing.key) + 1,
            "title": drawing.title,
            "note": drawing.note,
            "label": figure.label,
            "width": figure.columns * figure.width,
        }

    def _table(self, table: Table) -> dict[str, Any]:
        n_rows = table.n_rows if table.top is None else min(table.top, table.n_rows)
        on_paper = n_rows if self.most_on_paper is None else min(n_rows, self.most_on_paper)
        more = f"{n_rows - on_paper} more rows stand in the page and in `--json`."
        number, key = None, table.key
        if key is not None:
            number = len(self.tables) + 1
            key = f"{key}-{number}" if key in self.tables else key  # the place of one table on a page
            self.tables.append(key)
        return {
            "kind": "table",
            "key": key,
            "number": number,
            "title": table.title,
            "columns": [_column(*shown) for shown in table.shown()],
            "rows": n_rows,
            "of": table.n_rows,
            "note": _lines(table.note),
            "rows_on_paper": on_paper,
            "note_on_paper": [more] if on_paper < n_rows else [],
        }


def _is_seen(table: Table) -> bool:
    """Whether a table has rows and headings for people."""
    return table.n_rows > 0 and table.top != 0


def _section(section: Section, parts: Sequence[Any]) -> dict[str, Any]:
    return {
        "kind": "section",
        "key": section.key,
        "title": section.title,
        "note": _lines(section.note),
        "parts": parts,
    }


def _facts(parts: Iterable[Part]) -> list[dict[str, Any]]:
    return [_fact(part) for part in parts if isinstance(part, SeenFact)]


def _fact(fact: SeenFact) -> dict[str, Any]:
    out: dict[str, Any] = {"label": fact.label, "text": fact.written, "note": fact.note}
    if isinstance(fact, Fact):
        out |= {"key": fact.key, "drawn": [typeset_value(value) for value in fact.drawn]}
    return out


def _column(column: Column, unit: str, cells: Sequence[str]) -> dict[str, Any]:
    """A column: its cells as text, their numbers, for sorting, and what is drawn in place of the text."""
    out: dict[str, Any] = {
        "key": column.key,
        "label": column.label,
        "unit": unit,
        "meaning": column.meaning,
        "shown": column.shown,
        "is_text": column.is_text,
        "is_number": column.is_number,
        "pages_only": column.pages_only,
        "cells": [*cells],
    }
    if column.drawn is not None:
        return out | {"drawn": [typeset_value(value) for value in column.drawn[: len(cells)]]}
    values = column.values[: len(cells)]
    if column.shown == "share":
        out["bars"] = [0.0 if value is None else min(max(float(value), 0.0), 1.0) for value in values]
    numbers = [plain(value) for value in values]
    return out | {"numbers": [value if isinstance(value, int | float) else None for value in numbers]}


def _equations(part: Equations) -> dict[str, Any]:
    return {
        "kind": "equations",
        "key": part.key,
        "title": part.title,
        "note": _lines(part.note),
        "lines": [*part.lines],
        "formulas": [formula_of(formula) for formula in part.formulas],
        "legend": legend_of(part.legend) | {"lines": [*part.legend_lines]},
        "most_lines": part.most_lines,
    }


def formula_of(formula: Formula) -> dict[str, Any]:
    """A formula for pages, and for paper in pieces, between which lines break.

    Pieces stand in groups: one for outer torques and D, one for h, one for c.
    """
    groups: dict[str, list[dict[str, str]]] = {}
    for piece in formula.pieces:
        group = groups.setdefault("inertia" if piece.quantity == "carried" else piece.quantity, [])
        group.append({"sign": "−" if piece.negative else "+", "typst": _TYPST.body(piece)})
    return {
        "mathml": typeset_value(formula)["mathml"],
        "left": _TYPST.symbol(formula.left),
        "letter": formula.left.letter,
        "groups": [*groups.values()],
    }


def legend_of(legend: Legend | None) -> dict[str, list[str]]:
    """The meaning of the letters in formulas, for pages and for paper."""
    languages = {"mathml": _MATHS, "typst": _TYPST}
    return {name: [*language.legend(legend)] if legend else [] for name, language in languages.items()}


def typeset_value(value: Any) -> dict[str, str]:
    """A symbol, a formula or several, for pages and paper; a mark with its effect; anything else as text."""
    if isinstance(value, Symbol):
        return {"mathml": f"<math>{_MATHS.symbol(value)}</math>", "typst": _TYPST.symbol(value)}
    if isinstance(value, Formula):
        pieces = "".join(f"<span>{piece}</span> " for piece in _MATHS.elements(value))
        right = {"mathml": f" {pieces}", "typst": _TYPST.right(value)}
        if not value.left.letter:
            return right
        left = {"mathml": _MATHS.left(value), "typst": f"{_TYPST.symbol(value.left)} = "}
        return {name: left[name] + right[name] for name in left}
    if isinstance(value, tuple | list):
        written = [typeset_value(entry) for entry in value]
        return {name: ", ".join(entry[name] for entry in written) for name in ("mathml", "typst")}
    if isinstance(value, Mark):
        return {"effect": value.effect, "text": value.text}
    return {"text": "" if value is None else str(value)}


def _lines(note: str) -> list[str]:
    return [line for line in note.split("\n") if line]
