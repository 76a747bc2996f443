"""The result of a verb: facts, tables, figures and equations; renderers show them and compute nothing.

A `Fact` has two names: a key in JSON, and a label that people read. What JSON alone has, a `Value`, has only
a key; what people alone see, `Shown`, only a label. JSON has the values of a `Table`, people see its columns.
A table, a section or equations whose key is None are for people alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from gd_analyze.text import (
    amount,
    number,
    percent,
    prefixed,
    pretty,
    rounded_up,
    share_up,
)

# How a person reads a value; JSON has it as it is. A "bound" is rounded up, a "name" may be shortened, a
# "share" is percent with a bar on pages.
# fmt: off
ShownAs = Literal[
    "number", "percent", "times", "count", "text", "name", "flag", "bound", "bound_percent", "share",
]
# fmt: on
UNKNOWN = "–"


@dataclass(frozen=True)
class Fact:
    """One value with a name."""

    key: str  # name in JSON
    label: str  # noun phrase: "Torque error, proven near the motion"
    value: Any  # a JSON value, a NumPy number or array, or a list or mapping of these
    unit: str = ""  # of a number, such as "N m", or what follows it: "of peak torque"
    shown: ShownAs = "number"
    text: str | None = None  # how a person reads the value, where number and unit do not say it
    note: str = ""  # remark in brackets behind it: "joint 5"
    drawn: Sequence[Any] = ()  # symbols that a report may show in place of the text

    def __post_init__(self) -> None:
        _require_names(self.key, self.label)

    @property
    def written(self) -> str:
        """The value as a person reads it: "1.4 % of peak torque (joint 5)"."""
        text = value_text(self.value, self.unit, self.shown) if self.text is None else self.text
        return f"{text} ({self.note})" if self.note else text

    def seen_if(self, is_seen: bool) -> Fact | Value:
        """The fact, or what JSON alone has of it."""
        return self if is_seen else Value(self.key, self.value)


@dataclass(frozen=True)
class Value:
    """One value that JSON alone has."""

    key: str
    value: Any

    def __post_init__(self) -> None:
        _require_names(self.key)


@dataclass(frozen=True)
class Shown:
    """A line that people alone see."""

    label: str
    text: str
    note: str = ""  # remark in brackets behind it

    def __post_init__(self) -> None:
        _require_names(self.label)

    @property
    def written(self) -> str:
        """The text with its remark."""
        return f"{self.text} ({self.note})" if self.note else self.text


SeenFact = Fact | Shown
StoredFact = Fact | Value
AnyFact = Fact | Value | Shown


@dataclass(frozen=True)
class Mark:
    """A word or sign in the colour of an effect."""

    effect: str  # "translation", a quantity such as "inertia", or "none" for no colour
    text: str


@dataclass(frozen=True)
class Column:
    """One column of a table, as people see it; `gd_analyze.schema.declared_columns` makes it by name."""

    label: str  # heading
    values: Sequence[Any] | np.ndarray  # one per row; None or nan where there is none
    unit: str | Sequence[str] = ""  # of all rows, or one per row
    shown: ShownAs = "number"
    meaning: str = ""  # what the column says, in a noun phrase
    drawn: Sequence[Any] | None = None  # symbols, formulas and marks that pages show in place of the values
    pages_only: bool = False  # a terminal has no room for it
    key: str = ""  # name of the variable, if schema.csv declares it

    def __post_init__(self) -> None:
        _require_names(self.label)

    @property
    def is_text(self) -> bool:
        """Whether the cells stand on the left."""
        return self.shown in ("text", "name", "flag") or self.drawn is not None

    @property
    def is_number(self) -> bool:
        """Whether the cells are numbers whose unit may have a prefix."""
        return self.shown in ("number", "bound")

    @property
    def only_unit(self) -> str | None:
        """The unit of all rows; None where they differ."""
        units = {self.unit} if isinstance(self.unit, str) else {*self.unit}
        return units.pop() if len(units) == 1 else None if units else ""


# Values of a table by name: a sequence or an array, with one per row.
Values = Mapping[str, Any]


@dataclass(frozen=True)
class Table:
    """Columns that people see, `top` rows of them; `note` stands below. JSON has all `values`, row by row."""

    key: str | None  # name in JSON, and of its number in reports; None for neither
    title: str
    columns: tuple[Column, ...]
    note: str = ""
    top: int | None = None
    values: Values | None = None  # None for people alone

    def __post_init__(self) -> None:
        _require_key(self.key)

    @property
    def n_rows(self) -> int:
        """Number of rows that people may see."""
        return len(self.columns[0].values) if self.columns else 0

    def shown(self) -> list[tuple[Column, str, list[str]]]:
        """Columns that people see, each with the unit for its heading and its cells as text.

        The largest of all numbers in a unit chooses its prefix. Units that differ by row stand in the cells.
        """
        out = []
        for column in self.columns:
            unit, values = column.only_unit, column.values[: self.top]
            if unit is None:
                cells = [value_text(*pair, column.shown) for pair in zip(values, column.unit, strict=False)]
                out.append((column, "", cells))
                continue
            factor, unit = self._prefixed(unit) if column.is_number else (1.0, unit)
            scaled = (value / factor if factor != 1.0 and _is_number(value) else value for value in values)
            out.append((column, pretty(unit), [value_text(value, "", column.shown) for value in scaled]))
        return out

    def _prefixed(self, unit: str) -> tuple[float, str]:
        alike = (c.values[: self.top] for c in self.columns if c.is_number and c.only_unit == unit)
        sizes = [abs(value) for values in alike for value in values if _is_number(value)]
        return prefixed(max((size for size in sizes if math.isfinite(size)), default=0.0), unit)

    def rows(self) -> list[dict[str, Any]]:
        """Rows as JSON values."""
        values = self.values or {}
        return [
            {key: plain(value) for key, value in zip(values, row, strict=True)}
            for row in zip(*values.values(), strict=True)
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
    """Formulas, for pages that typeset them, and the same in plain characters, for terminal and JSON.

    `legend` and `legend_lines` explain the symbols; `note` stands above.
    `gd_analyze.formulas.languages.equation_part` makes one.
    """

    key: str | None  # name in JSON; None for people alone
    title: str
    lines: tuple[str, ...]
    formulas: tuple[Any, ...] = ()
    legend: Any = None
    legend_lines: tuple[str, ...] = ()
    note: str = ""
    most_lines: int | None = None  # a terminal only counts what takes more lines

    def __post_init__(self) -> None:
        _require_key(self.key)


@dataclass(frozen=True)
class Section:
    """Parts under a heading, with a line of text."""

    key: str | None  # JSON nests the parts under it; None for a heading for people alone
    title: str
    parts: tuple[Part, ...]
    note: str = ""

    def __post_init__(self) -> None:
        _require_key(self.key)


Part = AnyFact | Table | Drawing | Equations | Section


@dataclass(frozen=True)
class Result:
    """The answer of a verb, as a value that terminal, JSON, HTML and PDF show."""

    title: str  # what was asked
    subtitle: str = ""  # its subject
    headline: str = ""  # the answer in a line
    facts: tuple[AnyFact, ...] = ()  # the figures to begin with
    parts: tuple[Part, ...] = ()
    notices: tuple[str, ...] = ()  # what the reader must know before believing the numbers
    notes: tuple[str, ...] = ()  # what a report says at its end and a terminal counts; notices in JSON
    provenance: Mapping[str, str] = field(default_factory=dict)  # origin of the result: label and value

    def values(self) -> dict[str, Any]:
        """All of it as JSON values: facts, tables, equations and sections by their keys."""
        values = {"headline": self.headline} if self.headline else {}
        values |= values_of_parts((*self.facts, *self.parts)) | {"notices": [*self.notices, *self.notes]}
        return values | ({"provenance": dict(self.provenance)} if self.provenance else {})


def joint_values(joints: Sequence[Any]) -> dict[str, Any]:
    """Values that begin a table of an arm's joints (`arm.joints`): number, name and unit of torque."""
    return {
        "joint": range(1, len(joints) + 1),
        "joint_name": [joint.name for joint in joints],
        "effort_unit": [joint.effort_unit for joint in joints],
    }


def values_of(rows: Sequence[Mapping[str, Any]], *names: str) -> dict[str, list[Any]]:
    """Values of a table from its rows; by default all that the first row has."""
    return {name: [row[name] for row in rows] for name in names or (rows[0] if rows else ())}


def attributes_of(rows: Sequence[Any], *names: str) -> dict[str, list[Any]]:
    """Values of a table by the names of attributes that its rows have."""
    return {name: [getattr(row, name) for row in rows] for name in names}


def value_text(value: Any, unit: str = "", shown: ShownAs = "number") -> str:
    """Write one value as a person reads it, with its unit."""
    if _is_unknown(value):
        return UNKNOWN
    if isinstance(value, str) or shown in ("text", "name"):
        return str(value)
    if shown == "flag" or isinstance(value, bool | np.bool_):
        return "yes" if value else "no"
    if isinstance(value, Sequence | np.ndarray):
        return ", ".join(value_text(entry, unit, shown) for entry in value)
    if shown in ("number", "bound"):
        return amount(rounded_up(value) if shown == "bound" else value, pretty(unit)).rstrip()
    if shown in ("percent", "share", "bound_percent"):
        text = percent(share_up(value) if shown == "bound_percent" else value)
    else:
        text = f"{value:.0f}" if shown == "count" else f"{number(value)} times"
    return f"{text} {pretty(unit)}".rstrip()


def plain(value: Any) -> Any:
    """Make a JSON value of what NumPy gives; nan and infinity are None."""
    if isinstance(value, Mapping):
        return {key: plain(entry) for key, entry in value.items()}
    if isinstance(value, np.ndarray | list | tuple | range):
        return [plain(entry) for entry in value]
    if isinstance(value, np.generic):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _require_names(*names: str) -> None:
    if not all(names):
        raise ValueError("a fact or a column has no key or no label")


def _require_key(key: str | None) -> None:
    if key == "":
        raise ValueError("a part has no key: None says that it is for people alone")


def _is_unknown(value: Any) -> bool:
    return value is None or (isinstance(value, float) and value != value)


def _is_number(value: Any) -> bool:
    return not isinstance(value, str) and not _is_unknown(value)


def values_of_parts(parts: Sequence[Part]) -> dict[str, Any]:
    """Parts as JSON values by their keys."""
    values: dict[str, Any] = {}
    for key, value in _entries(parts):
        if key in values:
            raise ValueError(f"two parts of a result are called {key!r}")
        values[key] = value
    return values


def _entries(parts: Sequence[Part]) -> Iterator[tuple[str, Any]]:
    for part in parts:
        if isinstance(part, Section):
            yield from _entries(part.parts) if part.key is None else [(part.key, values_of_parts(part.parts))]
        elif isinstance(part, StoredFact):
            yield part.key, plain(part.value)
        elif isinstance(part, Table) and part.key is not None and part.values is not None:
            yield part.key, part.rows()
        elif isinstance(part, Equations) and part.key is not None:
            yield part.key, list(part.lines)
