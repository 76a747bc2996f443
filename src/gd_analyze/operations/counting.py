"""Numbers that count the multiplications and additions of the code that uses them.

Unlike in a trace nothing is folded or shared: a product with zero counts, and a repeated intermediate result
counts again. The tables of [FGL87] count this way, and so does the time of the code.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import Array
from gd_analyze.operations.program import OperationCount


@dataclass
class Tally:
    """Operations carried out so far by the numbers that share this tally."""

    multiplications: int = 0
    additions: int = 0
    sines_cosines: int = 0

    @property
    def count(self) -> OperationCount:
        """The present count."""
        return OperationCount(self.multiplications, self.additions, self.sines_cosines)


class CountingNumber:
    """A real number whose arithmetic is tallied."""

    __slots__ = ("tally", "value")

    def __init__(self, value: float, tally: Tally) -> None:
        self.value, self.tally = value, tally

    def __float__(self) -> float:
        return self.value

    def __add__(self, other: Any) -> CountingNumber:
        # NumPy's sums start from an integer zero; that addition is not part of the code.
        if not (isinstance(other, int) and other == 0):
            self.tally.additions += 1
        return CountingNumber(self.value + float(other), self.tally)

    __radd__ = __add__

    def __sub__(self, other: Any) -> CountingNumber:
        self.tally.additions += 1
        return CountingNumber(self.value - float(other), self.tally)

    def __rsub__(self, other: Any) -> CountingNumber:
        self.tally.additions += 1
        return CountingNumber(float(other) - self.value, self.tally)

    def __mul__(self, other: Any) -> CountingNumber:
        self.tally.multiplications += 1
        return CountingNumber(self.value * float(other), self.tally)

    __rmul__ = __mul__

    def __neg__(self) -> CountingNumber:
        return CountingNumber(-self.value, self.tally)

    def cos(self) -> CountingNumber:
        """Cosine, as `numpy.cos` takes it of objects."""
        self.tally.sines_cosines += 1
        return CountingNumber(math.cos(self.value), self.tally)

    def sin(self) -> CountingNumber:
        """Sine, as `numpy.sin` takes it of objects."""
        self.tally.sines_cosines += 1
        return CountingNumber(math.sin(self.value), self.tally)


def counting_array(values: Array, tally: Tally) -> Array:
    """Counting numbers of one set point, shape (n, 1)."""
    return np.array([[CountingNumber(float(value), tally)] for value in values], dtype=object)


def count_operations(code: Callable[..., Any], *states: Array) -> OperationCount:
    """Count the operations of code, called with states of shape (n, 1) made from those given, shape (n,)."""
    tally = Tally()
    code(*(counting_array(state, tally) for state in states))
    return tally.count
