"""Several polynomials in the same variables, evaluated together in few operations."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gd_analyze.operations.extraction import extract
from gd_analyze.operations.monomials import EQUAL, Magnitudes
from gd_analyze.operations.rearrangement import rearrange
from gd_analyze.operations.sums import Sums, Terms

Polynomial = Mapping[Any, float]
Circles = Mapping[Hashable, Hashable]

# Rearrangements to try, however few operations there are.
_TRIES = 500
# Where few terms join what was rearranged before: in any case, and for each of them.
_TRIES_ANYHOW, _TRIES_EACH = 10, 3


@dataclass(frozen=True)
class SharedSums:
    """Polynomials as sums of products of variables and of one another.

    Parameters
    ----------
    variables
        What the numbers from 0 on stand for.
    definitions
        Coefficients by product of variables; -1, -2, .. are the polynomials in their order, numbers beyond
        the variables what they share.
    count
        Number of polynomials.
    operations
        Multiplications and additions; a change of sign is free.
    """

    variables: tuple[Hashable, ...]
    definitions: Mapping[int, Terms]
    count: int
    operations: int

    @classmethod
    def of(cls, sums: Sums, variables: Sequence[Hashable], count: int) -> SharedSums:
        """Take down what was found so far."""
        definitions = {v: dict(terms) for v, terms in sums.terms.items()}
        return cls(tuple(variables), definitions, count, sums.operations)

    def values(self, value: Callable[[Any], Any]) -> list[Any]:
        """Evaluate the polynomials, given a variable's value: a number, an array or an expression."""
        known: dict[int, Any] = {}

        def of(v: int) -> Any:
            if v not in known:
                known[v] = value(self.variables[v]) if 0 <= v < len(self.variables) else total(v)
            return known[v]

        def total(v: int) -> Any:
            # Positive terms first, or the sign of all at the end: a - b and b - a would be two operations.
            terms = sorted(self.definitions.get(v, {}).items(), key=lambda term: term[1] < 0.0)
            sign = 1.0 if terms and terms[0][1] > 0.0 else -1.0
            result: Any = 0.0
            for product, c in terms:
                term: Any = abs(c)
                for x in product:
                    term = of(x) * term
                result = result + term if c * sign > 0.0 else result - term
            return sign * result

        return [of(-number) for number in range(1, self.count + 1)]


def shared_sums(
    polynomials: Sequence[Polynomial],
    circles: Circles | None = None,
    rearranging: int = 6_000,
) -> Iterator[SharedSums]:
    """Find what polynomials share: what extraction finds, then what rearranging makes of it.

    Parameters
    ----------
    polynomials
        Coefficients by product: a tuple of variables, each as often as its power.
    circles
        Variables whose squares sum to 1, each with its partner. Only rearranging makes use of them.
    rearranging
        How many rearrangements to try, times the operations there are.

    Yields
    ------
    SharedSums
        Two, the second of no more operations than the first and made only when asked for.
    """
    growing = _Growing(polynomials, circles or {})
    growing.add(polynomials)
    yield growing.found()
    growing.rearrange(min(_TRIES, rearranging // max(growing.operations, 1)))
    yield growing.found()


def growing_sums(steps: Sequence[Sequence[Polynomial]], circles: Circles) -> Iterator[SharedSums]:
    """Find what polynomials share that gain terms step by step: each is written from the one before.

    Parameters
    ----------
    steps
        Polynomials as for `shared_sums`, as many in each step; the last have all products that occur.
    circles
        As for `shared_sums`.

    Yields
    ------
    SharedSums
        One for each step.
    """
    growing, before = _Growing(steps[-1], circles), 0
    for polynomials in steps:
        count = sum(map(len, polynomials))
        growing.add(polynomials)
        growing.rearrange(min(_TRIES_ANYHOW + _TRIES_EACH * (count - before), _TRIES))
        before = count
        yield growing.found()


class _Growing:
    """Polynomials that gain terms, and what was found that they share."""

    def __init__(self, largest: Sequence[Polynomial], circles: Circles) -> None:
        numbers: dict[Hashable, int] = {}
        for variables in (x for polynomial in largest for product in polynomial for x in product):
            numbers.setdefault(variables, len(numbers))
        self._circles = {
            numbers[x]: numbers.setdefault(partner, len(numbers))
            for x, partner in circles.items()
            if x in numbers
        }
        self._numbers, self._equal = numbers, Magnitudes(EQUAL)
        self._known: list[Terms] = [{} for _ in largest]
        self._sums = Sums(self._known, len(numbers))

    def add(self, polynomials: Sequence[Polynomial]) -> None:
        """Add what is new, and extract."""
        for row, (known, polynomial) in enumerate(zip(self._known, polynomials, strict=True), start=1):
            terms: Terms = {}
            for variables, c in polynomial.items():
                product = tuple(sorted(self._numbers[x] for x in variables))
                terms[product] = terms.get(product, 0.0) + c
            for product, c in terms.items():
                new = (self._equal(c) if c else 0.0) - known.get(product, 0.0)
                if new:
                    known[product] = known.get(product, 0.0) + new
                    self._sums.add(-row, product, self._sums.magnitude(new))
        extract(self._sums)

    @property
    def operations(self) -> int:
        """What it takes now."""
        return self._sums.operations

    def rearrange(self, tries: int) -> None:
        """Look for fewer operations."""
        rearrange(self._sums, tries, self._circles)

    def found(self) -> SharedSums:
        """Take down what was found so far."""
        return SharedSums.of(self._sums, tuple(self._numbers), len(self._known))
