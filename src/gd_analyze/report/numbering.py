"""Numbers of figures and tables, the same on page and PDF."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

from markupsafe import Markup

from gd_analyze.result import Drawing, Part, Section, SeenColumn, Table, Value


class PartNumbers(NamedTuple):
    """Numbers of drawings and tables by their keys, in the order in which a reader meets them."""

    figures: dict[str, int]
    tables: dict[str, int]

    @classmethod
    def of(cls, parts: Sequence[Part]) -> PartNumbers:
        """Count drawings, and tables that people see."""
        all_parts = [*flat(parts)]
        drawings = dict.fromkeys(part.key for part in all_parts if isinstance(part, Drawing))
        tables = dict.fromkeys(part.key for part in all_parts if isinstance(part, Table) and is_seen(part))
        tables.pop("", None)
        return cls(*({key: k for k, key in enumerate(keys, start=1)} for keys in (drawings, tables)))

    def of_figure(self, key: str) -> Markup:
        """Write `Figure 3.` in bold; nothing if it has no number."""
        return Markup(f"<b>Figure {self.figures[key]}.</b> ") if key in self.figures else Markup("")

    def of_table(self, key: str) -> Markup:
        """Write `Table 3.` in bold; nothing if it has no number."""
        return Markup(f"<b>Table {self.tables[key]}.</b> ") if key in self.tables else Markup("")


def flat(parts: Sequence[Part]) -> Iterator[Part]:
    """Parts and, after each section, its content."""
    for part in parts:
        yield part
        if isinstance(part, Section):
            yield from flat(part.parts)


def is_seen(part: Part) -> bool:
    """Whether people see a part: a table with rows and headings, and all else but values for JSON."""
    if isinstance(part, Table):
        return (
            part.n_rows > 0
            and part.top != 0
            and any(isinstance(column, SeenColumn) for column in part.columns)
        )
    return not isinstance(part, Value)
