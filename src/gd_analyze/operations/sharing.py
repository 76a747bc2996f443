"""Several polynomials in the same variables, evaluated together in few operations."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from gd_analyze.operations.extraction import extract
from gd_analyze.operations.monomials import EQUAL, Magnitudes
from gd_analyze.operations.rearrangement import rearrange
from gd_analyze.operations.sums import Sums, Terms


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


def usual_tries(operations: int) -> int:
    """Rearrangements to try: fifteen per operation, fewer for many, so that it takes about a second."""
    return min(15 * operations, 120_000 // max(operations, 1))


def shared_sums(
    polynomials: Sequence[Mapping[Any, float]],
    circles: Mapping[Hashable, Hashable] | None = None,
    tries: Callable[[int], int] = usual_tries,
) -> Iterator[SharedSums]:
    """Find what polynomials share: what extraction finds, then what rearranging makes of it.

    Parameters
    ----------
    polynomials
        Coefficients by product: a tuple of variables, each as often as its power.
    circles
        Variables whose squares sum to 1, each with its partner. Only rearranging makes use of them.
    tries
        How many rearrangements to try, given the number of operations.

    Yields
    ------
    SharedSums
        Two, the second of no more operations than the first and made only when asked for.
    """
    numbers: dict[Hashable, int] = {}
    equal = Magnitudes(EQUAL)
    outputs: list[Terms] = []
    for polynomial in polynomials:
        terms: Terms = {}
        for variables, c in polynomial.items():
            product = tuple(sorted(numbers.setdefault(x, len(numbers)) for x in variables))
            terms[product] = terms.get(product, 0.0) + c
        outputs.append({product: equal(c) for product, c in terms.items() if c != 0.0})
    partners = {
        numbers[x]: numbers.setdefault(partner, len(numbers))
        for x, partner in (circles or {}).items()
        if x in numbers
    }
    sums = Sums(outputs, len(numbers))
    extract(sums)
    yield SharedSums.of(sums, tuple(numbers), len(outputs))
    rearrange(sums, tries(sums.operations), partners)
    yield SharedSums.of(sums, tuple(numbers), len(outputs))
