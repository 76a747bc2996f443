"""What the founding text says its formulations cost, [FGL87] Tables 3.1, 3.4 and 3.5."""

from __future__ import annotations

import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import Any

from gd_analyze.files import data_folder
from gd_analyze.operations.program import OperationCount
from gd_analyze.studies.polynomial import Polynomial


@dataclass(frozen=True)
class TextCost:
    """One line of the founding text's tables: a whole formulation, or one row of its breakdown.

    `name` is a method of `METHODS` for a whole, the founding text's row for a part.
    """

    name: str
    table: str
    multiplications: Polynomial
    additions: Polynomial
    remark: str = ""

    def at(self, n: int) -> OperationCount:
        """Count at n joints; sines and cosines, which the founding text leaves out, as 0."""
        return OperationCount(self.multiplications(n), self.additions(n), 0)


@dataclass(frozen=True)
class TextCosts:
    """All the founding text says of costs."""

    source: str
    remark: str
    totals: tuple[TextCost, ...]
    rows: tuple[TextCost, ...]

    def of(self, method: str, table: str | None = None) -> TextCost | None:
        """What FGL87 says of a method, in its first table that does; None where it says nothing."""
        found = [c for c in self.totals if c.name == method and table in (None, c.table)]
        return found[0] if found else None

    def rows_of(self, table: str) -> tuple[TextCost, ...]:
        """Rows of a table, in its order."""
        return tuple(row for row in self.rows if row.table == table)


@cache
def text_costs() -> TextCosts:
    """Read the shipped reference."""
    with (data_folder("references") / "fgl87_costs.toml").open("rb") as file:
        data = tomllib.load(file)
    return TextCosts(
        data["source"],
        data["remark"],
        tuple(_cost(entry, entry["method"]) for entry in data["totals"]),
        tuple(_cost(entry, entry["row"]) for entry in data["rows"]),
    )


def _cost(entry: Mapping[str, Any], name: str) -> TextCost:
    multiplications, additions = (
        Polynomial(tuple(Fraction(c) for c in entry[key])) for key in ("multiplications", "additions")
    )
    return TextCost(name, entry["table"], multiplications, additions, entry.get("remark", ""))
