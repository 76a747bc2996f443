"""Numbers that record their arithmetic.

Array code runs on these numbers unchanged and leaves a graph of its operations. Equal subexpressions are one
node, constants are folded, products with 0 and 1 vanish: the graph is the formula, not the loop.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np

from gd_analyze.arrays import Array

Operation = Literal["input", "add", "subtract", "multiply", "divide", "negative", "sign", "cos", "sin"]


class Expression:
    """One node of a trace: an operation on earlier nodes and constants."""

    __slots__ = ("arguments", "operation", "order", "trace")

    def __init__(self, trace: Trace, order: int, operation: Operation, arguments: tuple[Any, ...]) -> None:
        self.trace = trace
        self.order = order
        self.operation: Operation = operation
        self.arguments = arguments

    def __add__(self, other: Any) -> Any:
        return self.trace.add(self, other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self.trace.subtract(self, other)

    def __rsub__(self, other: Any) -> Any:
        return self.trace.subtract(other, self)

    def __mul__(self, other: Any) -> Any:
        return self.trace.multiply(self, other)

    __rmul__ = __mul__

    def __neg__(self) -> Any:
        return self.trace.negative(self)

    def cos(self) -> Any:
        """Cosine, as `numpy.cos` takes it of objects."""
        return self.trace.apply("cos", self)

    def sin(self) -> Any:
        """Sine, as `numpy.sin` takes it of objects."""
        return self.trace.apply("sin", self)

    def __repr__(self) -> str:
        return f"{self.operation}{self.arguments!r}"


class Trace:
    """The arithmetic of one computation, as expressions in the order of their creation."""

    def __init__(self) -> None:
        self.expressions: list[Expression] = []
        self._known: dict[tuple[Any, ...], Expression] = {}

    def inputs(self, name: str, count: int) -> Array:
        """Make named inputs for one set point, shape (count, 1)."""
        expressions = [self.record("input", f"{name}{i + 1}") for i in range(count)]
        return np.array(expressions, dtype=object).reshape(count, 1)

    def add(self, a: Any, b: Any) -> Any:
        """Sum; zeros are left out, and adding a negative is a difference."""
        if not isinstance(a, Expression) and not isinstance(b, Expression):
            return float(a) + float(b)
        if is_constant(a, 0.0):
            return b
        if is_constant(b, 0.0):
            return a
        if _is_negative(b):
            return self._difference(a, b.arguments[0])
        if _is_negative(a):
            return self._difference(b, a.arguments[0])
        return self.record("add", *_sorted(a, b))

    def subtract(self, a: Any, b: Any) -> Any:
        """Difference; negating b first could be a separate operation."""
        if isinstance(b, Expression) and not _is_negative(b) and not is_constant(a, 0.0):
            return self._difference(a, b)
        return self.add(a, self.negative(b))

    def multiply(self, a: Any, b: Any) -> Any:
        """Product; zeros and ones are folded, and signs moved outside."""
        if not isinstance(a, Expression) and not isinstance(b, Expression):
            return float(a) * float(b)
        for x, y in ((a, b), (b, a)):
            if not isinstance(x, Expression):
                if x == 0.0:
                    return 0.0
                if x == 1.0:
                    return y
                if x < 0.0:
                    return self.negative(self.multiply(-float(x), y))
            elif _is_negative(x):
                return self.negative(self.multiply(x.arguments[0], y))
        return self.record("multiply", *_sorted(a, b))

    def divide(self, a: Any, b: Any) -> Any:
        """Quotient; torque programs have none, only those that solve for accelerations."""
        if isinstance(b, Expression):
            return 0.0 if is_constant(a, 0.0) else self.record("divide", a, b)
        return self.multiply(1.0 / float(b), a)

    def sign(self, a: Any) -> Any:
        """Sign (1, 0 or -1), for friction; torque programs have none."""
        return self.record("sign", a)

    def negative(self, a: Any) -> Any:
        """Change of sign; two cancel."""
        if not isinstance(a, Expression):
            return -float(a)
        if _is_negative(a):
            return a.arguments[0]
        if a.operation == "subtract":
            return self.record("subtract", a.arguments[1], a.arguments[0])
        return self.record("negative", a)

    def apply(self, operation: Operation, *arguments: Any) -> Any:
        """Carry an operation out, and fold constants."""
        if operation in ("cos", "sin"):
            (x,) = arguments
            constant = math.cos if operation == "cos" else math.sin
            return self.record(operation, x) if isinstance(x, Expression) else constant(x)
        # Each other operation has a method of its name.
        return getattr(self, operation)(*arguments)

    def _difference(self, a: Any, b: Any) -> Any:
        if a is b:
            return 0.0
        if _is_negative(a):
            return self.negative(self.add(a.arguments[0], b))
        return self.record("subtract", a, b)

    def record(self, operation: Operation, *arguments: Any) -> Expression:
        """Record an operation without folding, as for a program read from a file."""
        key = (operation, *arguments)
        expression = self._known.get(key)
        if expression is None:
            arguments = tuple(a if isinstance(a, _SYMBOLIC) else float(a) for a in arguments)
            expression = self._known[key] = Expression(self, len(self.expressions), operation, arguments)
            self.expressions.append(expression)
        return expression


_SYMBOLIC = (Expression, str)


def reached(outputs: Sequence[Any]) -> list[int]:
    """Orders of the expressions that the outputs need, ascending."""
    roots = [x for x in outputs if isinstance(x, Expression)]
    if not roots:
        return []
    needed = bytearray(max(root.order for root in roots) + 1)
    for root in roots:
        needed[root.order] = True
    expressions = roots[0].trace.expressions
    for order in range(len(needed) - 1, -1, -1):
        if needed[order]:
            for argument in expressions[order].arguments:
                if isinstance(argument, Expression):
                    needed[argument.order] = True
    return [order for order, is_needed in enumerate(needed) if is_needed]


def is_constant(x: Any, value: float) -> bool:
    """Whether x is this number rather than an expression."""
    return not isinstance(x, Expression) and x == value


def _is_negative(x: Any) -> bool:
    return isinstance(x, Expression) and x.operation == "negative"


def _sorted(a: Any, b: Any) -> tuple[Any, Any]:
    """Constants first, then by age, so that equal sums and products are one node."""
    if not isinstance(b, Expression) or (isinstance(a, Expression) and a.order > b.order):
        return (b, a)
    return (a, b)
