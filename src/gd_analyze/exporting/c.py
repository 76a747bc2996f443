"""C99: a header and a source that need a compiler and its libm, no memory and no system."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.exporting.export_input import ExportInput
from gd_analyze.exporting.functions import Function
from gd_analyze.exporting.inputs import kind_of
from gd_analyze.exporting.rounding import float_errors_told
from gd_analyze.exporting.sine_cosine import DOUBLE, FLOAT
from gd_analyze.exporting.statements import Body, Notation, body, digits
from gd_analyze.exporting.strides import Strides, in_strides
from gd_analyze.exporting.templating import filled
from gd_analyze.exporting.told import told

# Angles, and states of many, that are taken at once: whole vectors of any processor, little memory.
_LANES = 8


def c_texts(subject: ExportInput, scalar: str) -> tuple[str, ...]:
    """Print a header and a source.

    Parameters
    ----------
    subject
        What is taken away.
    scalar
        Type of all numbers: double or float.
    """
    single = scalar == "float"
    number = float_digits if single else digits
    notation = Notation(number, sin="sinf" if single else "sin", cos="cosf" if single else "cos")
    torque, constants = subject.torque, subject.constants
    functions = [(each, inside(in_strides(each), notation)) for each in subject.functions]
    if single:
        constants = {key: each.in_single for key, each in constants.items()}
    values = {
        "subject": subject,
        "name": subject.name,
        "scalar": scalar,
        "constants": constants,
        "lines": told(subject, float_errors_told(subject) if single else ()),
        "functions": functions,
        "turns": any(each.angles for _, each in functions),
        "number": number,
        "declared": partial(declared, scalar),
        "listed": lambda values: ", ".join(map(number, values)),
        "lanes": _LANES,
        "torque": torque,
        "many": None if torque is None else inside(in_strides(torque, of_sums=True), notation),
        "read": read,
        "turn": FLOAT if single else DOUBLE,
        "suffix": "f" if single else "",
    }
    return filled("model.h.jinja", **values), filled("model.c.jinja", **values)


def float_digits(value: float) -> str:
    """Write a number of single precision in as many digits as it needs.

    Raises
    ------
    UsageError
        If there is none so large.
    """
    if abs(value) > float(np.finfo(np.float32).max):
        raise UsageError(
            "a number of the model is beyond single precision",
            where="scalar",
            expected="magnitudes below 3.4e38",
            found=f"{value:g}",
            next_step="take double",
        )
    text = repr(float(str(np.float32(value))))
    return f"{text}f" if value >= 0.0 else f"({text}f)"


def declared(scalar: str, name: str, function: Function) -> str:
    """Write the head of a function: what it reads, and where it writes."""
    n = function.joints
    given = [f"const {scalar} {each}[{n}]" for each in function.arguments]
    written = [f"{scalar} {result.name}[{result.size}]" for result in function.results]
    return f"void {name}_{function.name}({', '.join([*given, *written])})"


@dataclass(frozen=True)
class Inside:
    """A function's inside, in strides.

    Parameters
    ----------
    waves
        Number of the first angle, and a function that gives it and others, with its body.
    rest, body
        All but sines and cosines.
    angles
        How many angles there are.
    """

    waves: tuple[tuple[int, Function, Body], ...]
    rest: Function
    body: Body
    angles: int


def inside(strides: Strides, notation: Notation) -> Inside:
    """Write the strides of a function."""
    bodies = [body(each, notation) for each in strides.angles]
    sizes = [each.results[0].size for each in strides.angles]
    firsts = [sum(sizes[:k]) for k in range(len(sizes))]
    waves = tuple(zip(firsts, strides.angles, bodies, strict=True))
    return Inside(waves, strides.rest, body(strides.rest, notation), sum(sizes))


def read(function: Function, *, many: bool) -> list[tuple[str, str]]:
    """Inputs, and what holds them, for state l where there are many: sin2 is the second of the sines."""
    places = []
    for name in sorted(function.used):
        kind = kind_of(name)
        index = int(name.removeprefix(kind)) - 1
        array = {"sin": "sine", "cos": "cosine"}.get(kind)
        if many:
            place = f"{array}[{index}][l]" if array else f"{kind}[{index} * stride + l]"
        else:
            place = f"{array or kind}[{index}]"
        places.append((name, place))
    return places
