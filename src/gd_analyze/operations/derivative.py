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
    >>> from gd_analyze.operations import Program, Trace
    >>> trace = Trace()
    >>> x, y = trace.inputs("x", 2)[:, 0]
    >>> derivative(Program.of(trace, [x * y]), {"x1": 1.0}).outputs
    (input('x2',),)
    """
    trace = Trace()
    value, slope = _inputs(program, trace, along, values or {})

    def both(x: Any) -> tuple[Any, Any]:
        return (value[x.order], slope[x.order]) if isinstance(x, Expression) else (x, 0.0)

    for step in program.steps:
        if step.operation == "input":
            continue
        (a, da), *rest = map(both, step.arguments)
        value[step.order] = trace.apply(step.operation, a, *(b for b, _ in rest))
        if step.operation in ("cos", "sin"):
            other = trace.apply("sin" if step.operation == "cos" else "cos", a)
            outer = trace.negative(other) if step.operation == "cos" else other
            slope[step.order] = trace.multiply(outer, da)
        elif step.operation == "multiply":
            ((b, db),) = rest
            slope[step.order] = trace.add(trace.multiply(da, b), trace.multiply(a, db))
        else:
            slope[step.order] = trace.apply(step.operation, da, *(db for _, db in rest))
    return Program.of(trace, [both(output)[1] for output in program.outputs])


def _inputs(
    program: Program, trace: Trace, along: Mapping[str, float | str], values: Mapping[str, float]
) -> tuple[dict[int, Any], dict[int, Any]]:
    """Values and slopes of the inputs."""
    value: dict[int, Any] = {}
    slope: dict[int, Any] = {}
    for step in program.steps:
        if step.operation == "input":
            name = step.arguments[0]
            value[step.order] = values[name] if name in values else trace.record("input", name)
            direction = along.get(name, 0.0)
            slope[step.order] = trace.record("input", direction) if isinstance(direction, str) else direction
    return value, slope
