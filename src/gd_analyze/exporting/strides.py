"""A function with its sines and cosines taken apart.

Those of several angles can then be taken at once, and each stride over many states is a loop without
branches, so that compilers vectorise both.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from gd_analyze.exporting.export_input import Function, Output
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Trace, reached


class Strides(NamedTuple):
    """A function without its sines and cosines."""

    # Functions that give angles, counted through: of inputs and of sines and cosines of the angles before.
    # One function, unless there are sines of sines
    angles: list[Function]
    # The function's outputs from inputs, sines and cosines; sin1 and cos1 are those of the first angle
    rest: Function


def in_strides(function: Function, *, of_sums: bool = False) -> Strides:
    """Take a function's sines and cosines apart.

    With `of_sums` those of a sum are computed from those of its summands, where the function takes them
    anyway: six operations instead of forty, but others than the program has.
    """
    trace, values = Trace(), dict[int, Any]()
    steps = function.program.steps
    taken = {step.arguments[0] for step in steps if step.operation in ("sin", "cos")} if of_sums else set()
    pairs: dict[Expression, tuple[Any, Any]] = {}
    angles: list[Any] = []

    def of(x: Any) -> Any:
        return values[x.order] if isinstance(x, Expression) else x

    def pair(angle: Expression) -> tuple[Any, Any]:
        """Sine and cosine of an angle."""
        if angle not in pairs:
            if angle.operation in ("add", "subtract") and taken.issuperset(angle.arguments):
                (s, c), (sine, cosine) = map(pair, angle.arguments)
                sine = -sine if angle.operation == "subtract" else sine
                pairs[angle] = s * cosine + c * sine, c * cosine - s * sine
            else:
                angles.append(of(angle))
                sine, cosine = (trace.record("input", f"{name}{len(angles)}") for name in ("sin", "cos"))
                pairs[angle] = sine, cosine
        return pairs[angle]

    for step in steps:
        if step.operation in ("sin", "cos") and isinstance(step.arguments[0], Expression):
            values[step.order] = pair(step.arguments[0])[step.operation == "cos"]
        else:
            values[step.order] = trace.record(step.operation, *map(of, step.arguments))

    # One group of angles after the other: a new one where an angle is of a sine taken since the last began.
    groups: list[list[Any]] = []
    before = 0
    for count, angle in enumerate(angles):
        needed = (trace.expressions[k] for k in reached([angle]))
        names = [step.arguments[0] for step in needed if step.operation == "input"]
        last = max((int(name[3:]) for name in names if name[:3] in ("sin", "cos")), default=0)
        if not groups or last > before:
            groups.append([])
            before = count
        groups[-1].append(angle)

    def part(name: str, outputs: tuple[Output, ...], values: list[Any]) -> Function:
        return Function(name, "", function.arguments, outputs, Program.of(trace, values))

    rest = part(function.name, function.outputs, list(map(of, function.program.outputs)))
    return Strides([part("angles", (Output("angles", (len(group),)),), group) for group in groups], rest)
