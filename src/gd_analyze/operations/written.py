"""Programs as plain values, and back: what a model file holds of the arithmetic.

A step is its operation and its arguments: "s0", "s1" .. for earlier steps, numbers for constants; an input is
its name. Reading only records operations, it never carries any out.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Sequence
from typing import Any, cast

from gd_analyze.operations.program import UFUNCS, Program
from gd_analyze.operations.trace import Expression, Operation, Trace
from gd_analyze.text import LARGEST_COEFFICIENT

_ARGUMENTS: dict[str, int] = {"input": 1} | {name: ufunc.nin for name, ufunc in UFUNCS.items()}


def written(program: Program) -> tuple[list[list[str | float]], list[str | float]]:
    """Steps and outputs of a program as plain values."""
    number = {step.order: f"s{k}" for k, step in enumerate(program.steps)}

    def value(x: Any) -> str | float:
        if isinstance(x, Expression):
            return number[x.order]
        return x if isinstance(x, str) else float(x)

    steps: list[list[str | float]] = [
        [step.operation, *(value(argument) for argument in step.arguments)] for step in program.steps
    ]
    return steps, [value(output) for output in program.outputs]


def read_back(
    steps: Sequence[Sequence[str | float]], outputs: Sequence[str | float], inputs: Collection[str]
) -> Program:
    """Rebuild a program from what `written` gave.

    Parameters
    ----------
    steps, outputs
        As `written` gave them.
    inputs
        Names an input may have.

    Raises
    ------
    ValueError
        If a step is no operation, refers to a later step, or an input or a number is none.
    """
    trace = Trace()
    made: list[Expression] = []

    def value(x: str | float) -> Any:
        if not isinstance(x, str):
            if not abs(x) <= LARGEST_COEFFICIENT:
                raise ValueError(f"{x} is no number of a torque")
            return float(x)
        match = re.fullmatch(r"s(0|[1-9][0-9]{0,8})", x)
        if match is None or int(match[1]) >= len(made):
            raise ValueError(f"{x!r} is no earlier step")
        return made[int(match[1])]

    for k, (operation, *arguments) in enumerate(steps):
        if _ARGUMENTS.get(str(operation)) != len(arguments):
            raise ValueError(f"step s{k}, {operation} of {len(arguments)}, is no operation")
        if operation == "input":
            if arguments[0] not in inputs:
                raise ValueError(f"step s{k}: there is no input {arguments[0]!r}")
            made.append(trace.record("input", arguments[0]))
        else:
            made.append(trace.record(cast("Operation", operation), *(value(x) for x in arguments)))
        if len(trace.expressions) != len(made):
            raise ValueError(f"step s{k} is there twice")
    return Program(tuple(made), tuple(value(output) for output in outputs))
