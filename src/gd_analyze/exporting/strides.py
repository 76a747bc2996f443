"""A function in strides: its angles, their sines and cosines, and all other arithmetic.

Sines and cosines of several angles are then taken at once, and each stride over many states is a loop without
branches: compilers vectorise both. In the midst of the rest sines would hold them up.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from gd_analyze.exporting.functions import Function, Result
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Operation, Trace, reached


@dataclass(frozen=True)
class Strides:
    """What is left of a function when sines and cosines are taken apart.

    Parameters
    ----------
    angles
        Functions that give angles, counted through: of inputs and of sines and cosines of the angles of those
        before. One, unless there are sines of sines.
    rest
        What the function gives, of inputs and of sines and cosines; sin1 and cos1 are those of the first
        angle.
    """

    angles: tuple[Function, ...]
    rest: Function


def in_strides(function: Function, *, of_sums: bool = False) -> Strides:
    """Take a function's sines and cosines apart.

    Parameters
    ----------
    function
        The function.
    of_sums
        Take those of a sum from those of its summands, where the function takes them anyway: six operations
        instead of forty, but others than the program has.
    """
    trace, values = Trace(), dict[int, Any]()
    steps = function.program.steps
    taken = {step.arguments[0] for step in steps if step.operation in ("sin", "cos")} if of_sums else set()
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
    waves = [left("angles", (Result("angles", (len(wave),)),), wave) for wave in _waves(trace, angles)]
    return Strides(tuple(waves), rest)


def _waves(trace: Trace, angles: list[Any]) -> list[list[Any]]:
    """Split angles where one is of a sine of an angle since the last split."""
    waves: list[list[Any]] = []
    before = 0
    for count, angle in enumerate(angles):
        needed = (trace.expressions[k] for k in reached([angle]))
        names = [step.arguments[0] for step in needed if step.operation == "input"]
        last = max((int(name[3:]) for name in names if name[:3] in ("sin", "cos")), default=0)
        if not waves or last > before:
            waves.append([])
            before = count
        waves[-1].append(angle)
    return waves


def _of_sum(operation: Operation, first: tuple[Any, Any], second: tuple[Any, Any]) -> tuple[Any, Any]:
    """Sine and cosine of a sum or difference."""
    (s, c), (sine, cosine) = first, second
    if operation == "subtract":
        sine = -sine
    return s * cosine + c * sine, c * cosine - s * sine
