"""Multiplications and additions that array code carries out.

Unlike in a program nothing is folded or shared: a product with zero counts, and a repeated intermediate
result counts again. The tables of [FGL87] count this way, and so does the time of the code.
"""

from __future__ import annotations

from collections import Counter
from typing import Any

from gd_analyze.operations.program import OperationCount
from gd_analyze.operations.trace import Expression, Operation, Trace


class Tally(Trace):
    """A trace that keeps nothing but the number of operations of each kind."""

    def __init__(self) -> None:
        super().__init__()
        self.kinds: Counter[Operation] = Counter()

    @property
    def count(self) -> OperationCount:
        """Operations so far."""
        return OperationCount.of(self.kinds)

    def record(self, operation: Operation, *arguments: Any) -> Expression:
        """Count an operation."""
        self.kinds[operation] += 1
        return Expression(self, 0, operation, ())

    def add(self, a: Any, b: Any) -> Any:
        """Sum."""
        # NumPy's sums start from an integer zero; that addition is not part of the code.
        return a if isinstance(b, int) and b == 0 else self.record("add")

    def subtract(self, a: Any, b: Any) -> Any:
        """Difference."""
        return self.record("subtract")

    def multiply(self, a: Any, b: Any) -> Any:
        """Product."""
        return self.record("multiply")

    def negative(self, a: Any) -> Any:
        """Change of sign."""
        return self.record("negative")
