"""Derivatives of programs: forward differentiation that leaves nothing superfluous behind."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Trace


def derivative(
    program: Program, along: Mapping[str, float | str], values: Mapping[str, float] | None = None
) -> Program:
    """Differentiate a program's outputs along a direction in its inputs.

    Parameters
    ----------
    program
        The program.
    along
        Direction: a number by input, or another input's name; 0 for inputs that are not named.
    values
        Numbers that inputs have; the others remain inputs.

    Returns
    -------
    Program
        The derivatives of the outputs, with constants folded.

    Examples
    --------
    >>> from gd_analyze.operations.program import Program
    >>> from gd_analyze.operations.trace import Trace
    >>> trace = Trace()
    >>> x, y = trace.inputs("x", 2)[:, 0]
    >>> derivative(Program.of(trace, [x * y]), {"x1": 1.0}).outputs
    (input('x2',),)
    """
    trace = Trace()
    value = program.folded(trace, values or {})
    slopes: dict[int, Any] = {}

    def slope(x: Any) -> Any:
        return slopes[x.order] if isinstance(x, Expression) else 0.0

    for step in program.steps:
        if step.operation == "input":
            direction = along.get(step.arguments[0], 0.0)
            slopes[step.order] = trace.record("input", direction) if isinstance(direction, str) else direction
        elif step.operation in ("cos", "sin"):
            (x,) = step.arguments
            other = trace.apply("sin" if step.operation == "cos" else "cos", value(x))
            outer = trace.negative(other) if step.operation == "cos" else other
            slopes[step.order] = trace.multiply(outer, slope(x))
        elif step.operation == "multiply":
            x, y = step.arguments
            slopes[step.order] = trace.add(
                trace.multiply(slope(x), value(y)), trace.multiply(value(x), slope(y))
            )
        else:
            slopes[step.order] = trace.apply(step.operation, *map(slope, step.arguments))
    return Program.of(trace, [slope(output) for output in program.outputs])
