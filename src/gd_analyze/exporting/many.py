"""The torque of many states in three strides: its angles, their sines and cosines, and the arithmetic of all else.

Each is a loop without branches, which compilers vectorise; sines and cosines in the midst of the rest hold them up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gd_analyze.exporting.functions import Function, Result
from gd_analyze.operations import Program, Trace
from gd_analyze.operations.trace import Operation


@dataclass(frozen=True)
class Strides:
    """What is left of a function when sines and cosines are taken apart.

    Parameters
    ----------
    angles
        A function each of which gives one angle, of inputs and of sines and cosines of angles before it.
    rest
        What the function gives, of inputs and of sines and cosines: sin1 and cos1 are those of the first angle.
    """

    angles: tuple[Function, ...]
    rest: Function


def in_strides(function: Function) -> Strides:
    """Take a function's sines and cosines apart."""
    trace = Trace()
    angles: list[Any] = []

    def applied(operation: Operation, *arguments: Any) -> Any:
        if operation not in ("sin", "cos"):
            return trace.record(operation, *arguments)
        (angle,) = arguments
        if angle not in angles:
            angles.append(angle)
        return trace.record("input", f"{operation}{angles.index(angle) + 1}")

    of = function.program.carried_out(lambda name: trace.record("input", name), applied)

    def left(name: str, results: tuple[Result, ...], outputs: list[Any]) -> Function:
        return Function(name, "", function.arguments, results, Program.of(trace, outputs))

    rest = left(function.name, function.results, [of(output) for output in function.program.outputs])
    return Strides(tuple(left("angle", (Result("angle", (1,)),), [angle]) for angle in angles), rest)
