"""Sines and cosines of sums from those of their summands."""

from __future__ import annotations

import itertools
from typing import Any

from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Trace

# An angle as a sum: multiple of each input; the constant under "".
_Sum = frozenset[tuple[str, float]]


def with_sums(program: Program) -> Program:
    """Compute sines and cosines of sums, differences and doubles of angles from those of the angles.

    Each takes three operations and saves an angle, as sine and cosine of one are computed together. The
    outputs are equal up to round-off.
    """
    sums = _as_sums(program)
    trace = Trace()
    values: dict[int, Any] = {}
    pairs: dict[_Sum, tuple[Any, Any]] = {}

    def of(x: Any) -> Any:
        return values[x.order] if isinstance(x, Expression) else x

    def sum_of(x: Any) -> _Sum | None:
        return sums.get(x.order) if isinstance(x, Expression) else None

    for step in program.steps:
        if step.order in sums:
            values[step.order] = trace.record(step.operation, *map(of, step.arguments))
    angles: dict[_Sum, Any] = {}
    for step in program.steps:
        angle = sum_of(step.arguments[0]) if step.operation in ("sin", "cos") else None
        if angle is not None:
            angles[angle] = of(step.arguments[0])
    # Short sums first: the others are built from them.
    ordered = sorted(angles, key=lambda angle: (sum(abs(c) for _, c in angle), angles[angle].order))
    for place, angle in enumerate(ordered):
        pairs[angle] = angles[angle].sin(), angles[angle].cos()
        for first, sign in itertools.product(ordered[:place], (1.0, -1.0)):
            second = _added(angle, first, -1.0) if sign > 0.0 else _added(first, angle, -1.0)
            if second in pairs and second != angle:
                (s, c), (sine, cosine) = pairs[first], pairs[second]
                sine = sign * sine
                pairs[angle] = s * cosine + c * sine, c * cosine - s * sine
                break
    for step in program.steps:
        angle = sum_of(step.arguments[0]) if step.operation in ("sin", "cos") else None
        if angle is not None:
            values[step.order] = pairs[angle][step.operation == "cos"]
        elif step.order not in sums:
            values[step.order] = trace.record(step.operation, *map(of, step.arguments))
    return Program.of(trace, [of(output) for output in program.outputs])


def _as_sums(program: Program) -> dict[int, _Sum]:
    """Steps that are sums of inputs and constants, by order."""
    sums: dict[int, _Sum] = {}

    def of(x: Any) -> _Sum | None:
        return sums.get(x.order) if isinstance(x, Expression) else frozenset({("", float(x))})

    for step in program.steps:
        if step.operation == "input":
            sums[step.order] = frozenset({(step.arguments[0], 1.0)})
        elif step.operation in ("add", "subtract", "negative"):
            a, b = (frozenset(), *map(of, step.arguments))[-2:]
            if a is not None and b is not None:
                sums[step.order] = _added(a, b, 1.0 if step.operation == "add" else -1.0)
    return sums


def _added(a: _Sum, b: _Sum, sign: float = 1.0) -> _Sum:
    total = dict(a)
    for x, c in b:
        total[x] = total.get(x, 0.0) + sign * c
    return frozenset((x, c) for x, c in total.items() if c)
