"""Values of joints as a user gives them: elbow=1.57, elbow=90deg, slide=20mm."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from gd_analyze.errors import UsageError
from gd_analyze.text import LARGEST, in_python, number_in

_UNITS = {"deg": math.pi / 180, "mm": 1e-3, "rad": 1.0, "m": 1.0}


def locks_of(given: Mapping[str, float] | Sequence[str] | None) -> dict[str, float]:
    """Read joints and the values they are held at, in rad or m.

    Raises
    ------
    UsageError
        If one is no joint=value, or a joint is given twice.
    """
    pairs = list(given.items()) if isinstance(given, Mapping) else [_pair(text) for text in given or ()]
    values: dict[str, float] = {}
    for joint, value in pairs:
        number = value_in(value)
        if number is None:
            raise _no_lock(f"{joint}={value}")
        if joint in values:
            raise UsageError(f"joint {joint} is locked twice", where="--lock", next_step="give one value")
        values[joint] = number
    return values


def value_in(given: object) -> float | None:
    """Value in SI of a number or of a text with or without a unit; None where it is none."""
    if isinstance(given, int | float) and not isinstance(given, bool):
        return float(given) if abs(given) <= LARGEST else None
    if not isinstance(given, str):
        return None
    text = given.strip()
    for unit, scale in _UNITS.items():
        if text.endswith(unit):
            number = number_in(text.removesuffix(unit).rstrip())
            return None if number is None or not abs(number) <= LARGEST else number * scale
    number = number_in(text)
    return number if number is not None and abs(number) <= LARGEST else None


def _pair(text: object) -> tuple[str, str]:
    name, equals, value = str(text).rpartition("=")
    if not isinstance(text, str) or not equals or not name.strip():
        raise _no_lock(in_python(text))
    return name.strip(), value


def _no_lock(found: str) -> UsageError:
    return UsageError(
        "this locks no joint",
        where="--lock",
        expected="joint=value in rad or m, or with a unit: elbow=1.57, elbow=90deg, slide=20mm",
        found=found,
    )
