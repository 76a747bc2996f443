"""Numbers by which figures and tables are cited: one count for page and paper."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markupsafe import Markup

from gd_analyze.result import Drawing, Part, Section, Table


@dataclass(frozen=True)
class Numbers:
    """Numbers of drawings and tables by their keys, in the order in which a reader meets them."""

    figures: dict[str, int]
    tables: dict[str, int]

    @classmethod
    def of(cls, parts: Sequence[Part]) -> Numbers:
        """Count drawings and tables."""
        every = [*_flat(parts)]
        drawings = dict.fromkeys(part.key for part in every if isinstance(part, Drawing))
        tables = dict.fromkeys(part.key for part in every if isinstance(part, Table) and _is_shown(part))
        return cls(*({key: k for k, key in enumerate(keys, start=1)} for keys in (drawings, tables)))

    def of_figure(self, key: str) -> Markup:
        """Write `Figure 3.` in bold; nothing where it has no number."""
        return Markup(f"<b>Figure {self.figures[key]}.</b> ") if key in self.figures else Markup("")

    def of_table(self, key: str) -> Markup:
        """Write `Table 3.` in bold; nothing where it has no number."""
        return Markup(f"<b>Table {self.tables[key]}.</b> ") if key in self.tables else Markup("")


def _flat(parts: Sequence[Part]) -> Iterator[Part]:
    for part in parts:
        yield part
        if isinstance(part, Section):
            yield from _flat(part.parts)


def _is_shown(table: Table) -> bool:
    return bool(table.n_rows and table.key and any(column.label for column in table.columns))
