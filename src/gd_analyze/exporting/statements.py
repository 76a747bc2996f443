"""A program as statements of one operation each, whole or with its sines and cosines taken apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

from gd_analyze.exporting.export_input import Function, Output
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Operation, Trace, reached

if TYPE_CHECKING:
    from gd_analyze.exporting.language import Language


@dataclass(frozen=True)
class Body:
    """The inside of a function: assignments (name, value) in order, and expressions by output."""

    statements: tuple[tuple[str, str], ...]
    outputs: Mapping[str, tuple[str, ...]]


def body(function: Function, language: Language) -> Body:
    """Write a program's steps; sines and cosines of inputs are named by their angles, all else t1, t2, ..."""
    names: dict[int, str] = {}

    def written(x: Any) -> str:
        return names[x.order] if isinstance(x, Expression) else language.number(float(x))

    statements: list[tuple[str, str]] = []
    for step in function.program.steps:
        if step.operation == "input":
            names[step.order] = step.arguments[0]
            continue
        arguments = [written(x) for x in step.arguments]
        name = f"t{len(statements) + 1}"
        if step.operation in language.operators:
            value = f" {language.operators[step.operation]} ".join(arguments)
        elif step.operation == "negative":
            value = f"-{arguments[0]}"
        else:
            value = f"{language.functions[step.operation]}({arguments[0]})"
            if arguments[0].isidentifier():
                name = f"{step.operation}_{arguments[0]}"
        names[step.order] = name
        statements.append((name, value))
    expressions = iter(map(written, function.program.outputs))
    return Body(
        tuple(statements),
        {output.name: tuple(islice(expressions, output.size)) for output in function.outputs},
    )


@dataclass(frozen=True)
class Strides:
    """A function without its sines and cosines.

    Sines and cosines of several angles can then be taken at once, and each stride over many states is a loop
    without branches, so that compilers vectorise both.
    """

    # Functions that give angles, counted through: of inputs and of sines and cosines of the angles before.
    # One function, unless there are sines of sines
    angles: tuple[Function, ...]
    # The function's outputs from inputs, sines and cosines; sin1 and cos1 are those of the first angle
    rest: Function


def in_strides(function: Function, *, of_sums: bool = False) -> Strides:
    """Take a function's sines and cosines apart.

    Parameters
    ----------
    function
        The function.
    of_sums
        Compute those of a sum from those of its summands, where the function takes them anyway: six
        operations instead of forty, but others than the program has.
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
            values[step.order] = pair(step.arguments[0])[step.operation == "cos"]
        else:
            values[step.order] = trace.record(step.operation, *map(of, step.arguments))

    def part(name: str, outputs: tuple[Output, ...], values: list[Any]) -> Function:
        return Function(name, "", function.arguments, outputs, Program.of(trace, values))

    rest = part(function.name, function.outputs, list(map(of, function.program.outputs)))
    groups = _groups(trace, angles)
    return Strides(tuple(part("angles", (Output("angles", (len(x),)),), x) for x in groups), rest)


def _groups(trace: Trace, angles: list[Any]) -> list[list[Any]]:
    """Split angles where one is of a sine of an angle since the last split."""
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
    return groups


def _of_sum(operation: Operation, first: tuple[Any, Any], second: tuple[Any, Any]) -> tuple[Any, Any]:
    """Sine and cosine of a sum or difference."""
    (s, c), (sine, cosine) = first, second
    if operation == "subtract":
        sine = -sine
    return s * cosine + c * sine, c * cosine - s * sine
