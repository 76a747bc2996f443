"""Units and numbers as a reader expects them, for display only."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np

from gd_analyze.robots import RobotArm

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def inertia_unit(arm: RobotArm, i: int, j: int) -> str:
    """Unit of D_ij, joints counted from 0: kg m^2 between turning joints, kg between sliding ones."""
    return ("kg", "kg m", "kg m^2")[arm.is_revolute[i] + arm.is_revolute[j]]


def pretty(text: str) -> str:
    """Raise the exponents of a unit or of numbers: kg m^2 to kg m², 2.1e-14 to 2.1 × 10⁻¹⁴."""
    text = re.sub(r"(?<=[a-z])\^(-?\d+)", lambda m: m[1].translate(_SUPERSCRIPTS), text)
    return re.sub(r"(?<=\d)e([+-]\d+)", lambda m: f" × 10{str(int(m[1])).translate(_SUPERSCRIPTS)}", text)


def figures(value: float) -> str:
    """Three significant digits, with the power of ten set out where there is one."""
    if not np.isfinite(value):
        return "∞"
    if value == 0.0:
        return "0"
    text = f"{value:.2e}" if abs(value) < 1e-3 or abs(value) >= 1e5 else f"{value:#.3g}"
    return pretty(text.removesuffix("."))


def hundredths(share: float) -> str:
    """Percent with two decimals and without the sign, for columns headed by it."""
    if not np.isfinite(share):
        return "∞"
    value = 100 * share
    return "< 0.01" if 0 < value < 0.005 else f"{value:.2f}"


def aligned(texts: Iterable[str]) -> list[dict[str, str]]:
    """Numbers of a column with the digits to be kept free behind each, so that their points align."""
    column = list(texts)
    decimals = [_decimals(text) for text in column]
    most = max(decimals, default="", key=len)
    return [
        {"text": text, "pad": "" if "×" in text else most[len(own) :] if own else most}
        for text, own in zip(column, decimals, strict=True)
    ]


def _decimals(text: str) -> str:
    """Point and decimals of a plain number."""
    return text[text.index(".") :] if "." in text and "×" not in text else ""
