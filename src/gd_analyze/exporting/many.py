"""The torque of many states in three strides: its angles, their sines and cosines, and all other arithmetic.

Each is a loop without branches, which compilers vectorise; sines in the midst of the rest hold them up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gd_analyze.exporting.functions import Function, Result
from gd_analyze.operations import Program, Trace
from gd_analyze.operations.trace import Expression, Operation


@dataclass(frozen=True)
class Strides:
    """What is left of a function when sines and cosines are taken apart.

    Parameters
    ----------
    angles
        A function each of which gives one angle, of inputs and of sines and cosines of angles before it.
    rest
        What the function gives, of inputs and of sines and cosines; sin1 and cos1 are those of the first
        angle.
    """

    angles: tuple[Function, ...]
    rest: Function


def in_strides(function: Function) -> Strides:
    """Take a function's sines and cosines apart.

    Those of a sum follow from those of its summands where the function takes them anyway: six operations
    instead of forty.
    """
    trace, values = Trace(), dict[int, Any]()
    steps = function.program.steps
    taken = {step.arguments[0] for step in steps if step.operation in ("sin", "cos")}
    pairs: dict[Expression, tuple[Any, Any]] = {}
    angles: list[Any] = []

    def of(x: Any) -> Any:
        return values[x.order] if isinstance(x, Expression) else x

    def pair(angle: Expression) -> tuple[Any, Any]:
        if angle not in pairs:
            if angle.operation in ("add", "subtract") and taken.issuperset(angle.arguments):
                pairs[angle] = _of_sum(angle.operation, *map(pair, angle.arguments))
            else:
                angles.append(of(angle))
                sine, cosine = (trace.record("input", f"{name}{len(angles)}") for name in ("sin", "cos"))
                pairs[angle] = sine, cosine
        return pairs[angle]

    for step in steps:
        if step.operation in ("sin", "cos") and isinstance(step.arguments[0], Expression):
            sine, cosine = pair(step.arguments[0])
            values[step.order] = sine if step.operation == "sin" else cosine
        else:
            values[step.order] = trace.record(step.operation, *map(of, step.arguments))

    def left(name: str, results: tuple[Result, ...], outputs: list[Any]) -> Function:
        return Function(name, "", function.arguments, results, Program.of(trace, outputs))

    rest = left(function.name, function.results, list(map(of, function.program.outputs)))
    return Strides(tuple(left("angle", (Result("angle", (1,)),), [angle]) for angle in angles), rest)


def _of_sum(operation: Operation, first: tuple[Any, Any], second: tuple[Any, Any]) -> tuple[Any, Any]:
    """Sine and cosine of a sum or difference."""
    (s, c), (sine, cosine) = first, second
    if operation == "subtract":
        sine = -sine
    return s * cosine + c * sine, c * cosine - s * sine
