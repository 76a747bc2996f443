"""What a verb answers: facts, tables, figures and equations, which every renderer shows and none computes."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

# How a person reads a column's values; JSON keeps them as they are.
Shown = Literal["number", "percent", "times", "count", "text", "flag", "bound", "bound_percent"]


@dataclass(frozen=True)
class Fact:
    """One value with a name.

    Parameters
    ----------
    key
        Name in JSON.
    label
        Noun phrase: "Torque error, proven near the motion". "" keeps the fact to JSON.
    value
        A JSON value or a NumPy number.
    unit
        Unit of a number, in words that pint reads.
    shown
        How a number is written.
    text
        How a person reads the value, where number and unit do not say it.
    note
        What stands behind it: "joint 5".
    """

    key: str
    label: str
    value: Any
    unit: str = ""
    shown: Shown = "number"
    text: str | None = None
    note: str = ""


@dataclass(frozen=True)
class Column:
    """One column of a table.

    Parameters
    ----------
    key
        Name in JSON.
    label
        Heading. "" keeps the column to JSON.
    values
        One per row; None or nan where there is none.
    unit
        Of all rows, or one per row.
    shown
        How values are written.
    meaning
        What the column says, in a noun phrase.
    """

    key: str
    label: str
    values: Sequence[Any]
    unit: str | Sequence[str] = ""
    shown: Shown = "number"
    meaning: str = ""


@dataclass(frozen=True)
class Table:
    """Rows of named columns; `note` stands below. JSON has a list of rows under `key`."""

    key: str
    title: str
    columns: tuple[Column, ...]
    note: str = ""

    def rows(self) -> list[dict[str, Any]]:
        """Rows as JSON values; units that differ by row stand beside their column, as `KEY_unit`."""
        named = {column.key: column.values for column in self.columns}
        named |= {f"{c.key}_unit": c.unit for c in self.columns if not isinstance(c.unit, str)}
        return [
            {key: plain(value) for key, value in zip(named, row, strict=True)}
            for row in zip(*named.values(), strict=True)
        ]


@dataclass(frozen=True)
class Drawing:
    """A figure (`gd_analyze.figures`) with its caption; not part of JSON."""

    key: str
    title: str
    figure: Any
    note: str = ""


@dataclass(frozen=True)
class Equations:
    """Formulas (`gd_analyze.formulas`), and the legend of the symbols that they introduce."""

    key: str
    title: str
    formulas: tuple[Any, ...]
    legend: Any = None
    note: str = ""


@dataclass(frozen=True)
class Section:
    """Parts under a heading, with a line of text."""

    key: str
    title: str
    parts: tuple[Part, ...]
    note: str = ""


Part = Fact | Table | Drawing | Equations | Section


@dataclass(frozen=True)
class Result:
    """The answer of a verb, as a value that terminal, JSON, HTML and PDF show.

    Parameters
    ----------
    title, subtitle
        What was asked, of what.
    headline
        The answer in a line.
    facts
        The figures to begin with.
    parts
        Tables, drawings, equations and sections, in order.
    notices
        What the reader must know before believing the numbers.
    provenance
        What it comes from: label and value.
    """

    title: str
    subtitle: str = ""
    headline: str = ""
    facts: tuple[Fact, ...] = ()
    parts: tuple[Part, ...] = ()
    notices: tuple[str, ...] = ()
    provenance: Mapping[str, str] = field(default_factory=dict)

    def document(self) -> dict[str, Any]:
        """All of it as JSON values: facts and tables by their keys."""
        found: dict[str, Any] = {}
        for part in _flat((*self.facts, *self.parts)):
            if isinstance(part, Fact):
                found[part.key] = plain(part.value)
            elif isinstance(part, Table):
                found[part.key] = part.rows()
            elif isinstance(part, Equations):
                found[part.key] = [str(formula) for formula in part.formulas]
        found["notices"] = list(self.notices)
        return found | ({"provenance": dict(self.provenance)} if self.provenance else {})


def _flat(parts: Sequence[Part]) -> Iterator[Part]:
    for part in parts:
        if isinstance(part, Section):
            yield from _flat(part.parts)
        else:
            yield part


def plain(value: Any) -> Any:
    """Make a JSON value of what NumPy gives; nan is None."""
    if isinstance(value, np.ndarray | list | tuple):
        return [plain(entry) for entry in value]
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and value != value else value
