"""Inputs of functions by name: qd3 is the third of the rates qd."""

from __future__ import annotations

from gd_analyze.exporting.functions import Function


def inputs(function: Function) -> list[str]:
    """Inputs that the program needs, in their order."""
    every = [f"{kind}{j}" for kind in function.arguments for j in range(1, function.joints + 1)]
    return [name for name in every if name in function.used]


def unused(function: Function) -> list[str]:
    """Arguments that the program does not need."""
    return [each for each in function.arguments if each not in map(kind_of, function.used)]


def kind_of(name: str) -> str:
    """Say what an input is one of: of qd3, qd."""
    return name.rstrip("0123456789")


def joint_of(name: str) -> int:
    """Say of which joint it is, counted from 0: of qd3, 2."""
    return int(name.lstrip("qd")) - 1
