"""A program as statements, one operation each, in the notation that most languages share."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

from gd_analyze.exporting.functions import Function
from gd_analyze.operations.trace import Expression, Operation

_SIGNS = {"add": "+", "subtract": "-", "multiply": "*"}


def digits(value: float) -> str:
    """Write a number so that reading gives the same; one below zero in brackets."""
    return repr(value) if value >= 0.0 else f"({value!r})"


@dataclass(frozen=True)
class Notation:
    """How a language writes what programs consist of.

    Parameters
    ----------
    number
        A constant.
    times
        The sign of a product.
    sin, cos
        Names of these functions.
    """

    number: Callable[[float], str] = digits
    times: str = "*"
    sin: str = "sin"
    cos: str = "cos"


@dataclass(frozen=True)
class Statement:
    """One step: a name, and what it is set to.

    Parameters
    ----------
    name, value
        Both sides.
    operation
        What the step is.
    angle
        Of a sine or cosine: the name of its argument.
    """

    name: str
    value: str
    operation: Operation
    angle: str = ""


@dataclass(frozen=True)
class Body:
    """A function's inside.

    Parameters
    ----------
    statements
        Steps in order.
    results
        By result's name its expressions, in the order of the program's outputs.
    """

    statements: tuple[Statement, ...]
    results: Mapping[str, tuple[str, ...]]


def body(function: Function, notation: Notation) -> Body:
    """Write a program's steps; inputs are q1, qd1, qdd1, sines and cosines are named by their angles."""
    names: dict[int, str] = {}

    def said(x: Any) -> str:
        return names[x.order] if isinstance(x, Expression) else notation.number(float(x))

    statements: list[Statement] = []
    for step in function.program.steps:
        if step.operation == "input":
            names[step.order] = step.arguments[0]
            continue
        arguments = [said(x) for x in step.arguments]
        name, angle = f"t{len(statements) + 1}", ""
        if step.operation in _SIGNS:
            sign = notation.times if step.operation == "multiply" else _SIGNS[step.operation]
            value = f" {sign} ".join(arguments)
        elif step.operation == "negative":
            value = f"-{arguments[0]}"
        else:
            (angle,) = arguments
            value = f"{getattr(notation, step.operation)}({angle})"
            if angle.isidentifier():
                name = f"{step.operation}_{angle}"
            else:
                angle = ""
        names[step.order] = name
        statements.append(Statement(name, value, step.operation, angle))
    outputs = iter(map(said, function.program.outputs))
    results = {result.name: tuple(islice(outputs, result.size)) for result in function.results}
    return Body(tuple(statements), results)
