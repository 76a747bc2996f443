"""Products of variables as sorted tuples, and coefficients of which equal ones are one number."""

from __future__ import annotations

import bisect
from functools import lru_cache
from typing import TypeVar

_V = TypeVar("_V")

# A product of variables, each as often as its power, in ascending order; variables are numbers.
Monomial = tuple[int, ...]

# Given coefficients that are equal in mathematics and differ by the round-off of whatever computed them.
EQUAL = 1e-9


@lru_cache(maxsize=1 << 17)
def split(a: Monomial, b: Monomial) -> tuple[Monomial, Monomial, Monomial]:
    """Greatest common divisor of two products, and what is left of each."""
    common: list[int] = []
    rest_a: list[int] = []
    rest_b: list[int] = []
    i = j = 0
    while i < len(a) and j < len(b):
        if a[i] == b[j]:
            common.append(a[i])
            i, j = i + 1, j + 1
        elif a[i] < b[j]:
            rest_a.append(a[i])
            i += 1
        else:
            rest_b.append(b[j])
            j += 1
    return tuple(common), (*rest_a, *a[i:]), (*rest_b, *b[j:])


def times(a: Monomial, b: Monomial) -> Monomial:
    """Multiply two products."""
    return tuple(sorted(a + b)) if a and b else a or b


def over(a: Monomial, b: Monomial) -> Monomial | None:
    """Divide a by b; None where b is no divisor."""
    _, quotient, missing = split(a, b)
    return None if missing else quotient


def multiplications(monomial: Monomial, coefficient: float) -> int:
    """Multiplications in coefficient times product; a change of sign is free."""
    if not monomial:
        return 0
    return len(monomial) - (coefficient == 1.0 or coefficient == -1.0)


class Magnitudes:
    """Gives numbers that are equal within a relative tolerance one and the same magnitude: the first seen.

    Parameters
    ----------
    tolerance
        Largest relative difference of numbers that are taken as equal.

    Attributes
    ----------
    known
        Magnitudes by the numbers, above 0, that were looked up.
    """

    def __init__(self, tolerance: float) -> None:
        self.tolerance = tolerance
        self._sorted = [1.0]
        self.known = {1.0: 1.0}

    def __call__(self, x: float) -> float:
        """Look a number other than 0 up, keeping its sign."""
        magnitude = abs(x)
        found = self.known.get(magnitude)
        if found is None:
            found = self.known[magnitude] = self._nearest(magnitude)
        return found if x > 0.0 else -found

    def _nearest(self, magnitude: float) -> float:
        place = bisect.bisect_left(self._sorted, magnitude)
        for known in self._sorted[max(place - 1, 0) : place + 1]:
            if abs(known - magnitude) <= self.tolerance * magnitude:
                return known
        self._sorted.insert(place, magnitude)
        return magnitude


def without(monomial: tuple[_V, ...], v: _V) -> tuple[_V, ...]:
    """Take one factor v away."""
    place = monomial.index(v)
    return monomial[:place] + monomial[place + 1 :]
