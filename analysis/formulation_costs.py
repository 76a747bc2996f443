"""Operations of one torque by every formulation: counted on the very code, and as [FGL87] states them."""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cache, cached_property
from pathlib import Path
from typing import Any, Literal, NamedTuple

import numpy as np

from gd_analyze.dynamics.methods import METHODS
from gd_analyze.files import data_folder
from gd_analyze.operations.program import OperationCount
from gd_analyze.studies.formulations import Cost, count_cost

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from chains import generic_chain

Counted = Literal["executed", "folded", "text"]

SIZES = tuple(range(1, 13))  # numbers of joints for which [FGL87]'s polynomials stand beside ours
_REGULAR = 3  # with one or two joints some sums are empty
_ASYMPTOTIC = 6  # below, constant and low-order terms hide the order
N_JOINTS = 6  # of the generic chain that explanations are about


@dataclass(frozen=True)
class Polynomial:
    """A polynomial in the number of joints n; coefficients from n^0 upwards."""

    coefficients: tuple[Fraction, ...]

    def __call__(self, n: int) -> int:
        """Value at n, a whole number of operations."""
        return int(sum(c * n**k for k, c in enumerate(self.coefficients)))

    def __str__(self) -> str:
        """Highest power first, e.g. "128/3 n^4 - 7 n"."""
        terms = []
        for power, factor in enumerate(self.coefficients):
            if factor:
                size = "" if abs(factor) == 1 and power else str(abs(factor))
                symbol = "" if power == 0 else "n" if power == 1 else f"n^{power}"
                terms.append(f"{'-' if factor < 0 else '+'} {f'{size} {symbol}'.strip()}")
        return " ".join(reversed(terms)).removeprefix("+ ") or "0"


def exact_polynomial(sizes: Sequence[int], counts: Sequence[int]) -> Polynomial | None:
    """Find the polynomial of lowest degree through all counts; one that uses up every point is none."""
    for degree in range(len(sizes) - 1):
        # Counts of loops nested four deep have denominators up to 24.
        fitted = [Fraction(c).limit_denominator(24) for c in np.polyfit(sizes, counts, degree)[::-1]]
        if [sum(c * n**k for k, c in enumerate(fitted)) for n in sizes] == list(counts):
            return Polynomial(tuple(fitted))
    return None


class TextCost(NamedTuple):
    """One line of [FGL87]'s tables: a method of `METHODS`, or one row of its breakdown."""

    name: str
    table: str
    multiplications: Polynomial
    additions: Polynomial
    remark: str = ""

    def at(self, n: int) -> OperationCount:
        """Count at n joints; sines and cosines, which [FGL87] leaves out, as 0."""
        return OperationCount(self.multiplications(n), self.additions(n), 0)


class TextCosts(NamedTuple):
    """All [FGL87] says of costs."""

    source: str
    remark: str
    totals: tuple[TextCost, ...]
    rows: tuple[TextCost, ...]
    differences: Mapping[str, str]  # by method, why ours differ

    def of(self, method: str, table: str | None = None) -> TextCost | None:
        """What FGL87 says of a method, in its first table that does; None where it says nothing."""
        return next((c for c in self.totals if c.name == method and table in (None, c.table)), None)


@cache
def text_costs() -> TextCosts:
    """Read the shipped reference."""

    def cost(entry: Mapping[str, Any], name: str) -> TextCost:
        products, sums = (Polynomial(tuple(map(Fraction, entry[key]))) for key in TextCost._fields[2:4])
        return TextCost(name, entry["table"], products, sums, entry.get("remark", ""))

    with (data_folder("references") / "fgl87_costs.toml").open("rb") as file:
        data = tomllib.load(file)
    totals = tuple(cost(entry, entry["method"]) for entry in data["totals"])
    rows = tuple(cost(entry, entry["row"]) for entry in data["rows"])
    return TextCosts(data["source"], data["remark"], totals, rows, data["differences"])


@dataclass(frozen=True, eq=False)
class Growth:
    """Costs on the generic chain over the number of joints."""

    costs: Mapping[str, tuple[Cost, ...]]  # by method, one for each of `SIZES`

    def counts(self, method: str, which: Counted) -> tuple[OperationCount, ...]:
        """Counts by size, ours or FGL87's; none where it has no polynomial of the method."""
        if which != "text":
            return tuple(getattr(cost, which) for cost in self.costs[method])
        stated = text_costs().of(method)
        return () if stated is None else tuple(stated.at(n) for n in SIZES)

    def slope(self, method: str, which: Counted) -> float | None:
        """Slope of log(operations) over log(n) from six joints on; None where less than two are counted."""
        counts = zip(SIZES, self.counts(method, which), strict=False)
        large = np.log([(n, count.total) for n, count in counts if n >= _ASYMPTOTIC])
        return float(np.polyfit(large[:, 0], large[:, 1], 1)[0]) if len(large) else None

    @cached_property
    def polynomials(self) -> dict[str, tuple[Polynomial, Polynomial]]:
        """Multiplications and additions as executed: the polynomials that all from three joints on obey."""
        found, sizes = {}, SIZES[_REGULAR - 1 :]
        for name, costs in self.costs.items():
            regular = [cost.executed for cost in costs[_REGULAR - 1 :]]
            columns = zip(*((count.multiplications, count.additions) for count in regular), strict=True)
            multiplications, additions = (exact_polynomial(sizes, column) for column in columns)
            if multiplications is not None and additions is not None:
                found[name] = (multiplications, additions)
        return found


def growth() -> Growth:
    """Count every method on generic chains of `SIZES` joints."""
    chains = [generic_chain(n) for n in SIZES]
    return Growth({name: tuple(count_cost(m, arm) for arm in chains) for name, m in METHODS.items()})


def explanation(method: str, grown: Growth) -> str:
    """Set a method's count beside FGL87's, and say why they differ."""
    cost = grown.costs[method][SIZES.index(N_JOINTS)]
    executed, folded = cost.executed.total, cost.folded.total
    stated, why = text_costs().of(method), text_costs().differences[method]
    if stated is None:
        ours = f"at n = {N_JOINTS} ours carries out {executed} operations, folded {folded}"
        return f"Not counted in [FGL87]; {ours}. {why}"
    total = stated.at(N_JOINTS).total
    return (
        f"At n = {N_JOINTS} [FGL87] counts {total} operations, ours carries out {executed} "
        f"({100 * executed / total:.0f} % of that), folded {folded} ({100 * folded / total:.0f} %). {why}"
    )
