"""Numbers and units as a reader expects them; terminal, HTML and PDF show the same digits."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from decimal import ROUND_CEILING, Decimal

from markupsafe import Markup, escape

_SUPERSCRIPTS = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float) -> str:
    """Format to three significant digits.

    Examples
    --------
    >>> number(41.0), number(2.1e-14)
    ('41', '2.10e-14')
    """
    if value == 0.0:
        return "0"
    return f"{value:.2e}" if abs(value) < 1e-3 or abs(value) >= 1e5 else f"{value:.3g}"


def figures(value: float) -> str:
    """Format to three significant digits, trailing zeros included, with the power of ten set out."""
    if not math.isfinite(value):
        return "∞"
    if value == 0.0:
        return "0"
    digits = f"{value:.2e}" if abs(value) < 1e-3 or abs(value) >= 1e5 else f"{value:#.3g}"
    return pretty(digits.removesuffix("."))


def given(value: float | None) -> str:
    """Format data as given: up to six digits, no trailing zeros; a dash where unknown."""
    if value is None:
        return "–"
    return pretty(f"{value + 0.0:.6g}").replace("-", "−") if math.isfinite(value) else "∞"


def percent(share: float) -> str:
    """Format a share as percent with two significant digits."""
    if not math.isfinite(share):
        return "∞"
    value = 100 * share
    if value == 0.0:
        return "0 %"
    return "< 0.01 %" if abs(value) < 0.01 else f"{value:.2g} %" if abs(value) < 9.95 else f"{value:.0f} %"


def rounded_up(value: float, digits: int = 3) -> float:
    """Round to significant digits, never down: a bound is never shown smaller than it is.

    Examples
    --------
    >>> rounded_up(0.00931001), rounded_up(158.2, 2)
    (0.00932, 160.0)
    """
    if value == 0.0 or not math.isfinite(value):
        return value
    exact = Decimal(value)
    step = Decimal(1).scaleb(exact.adjusted() - digits + 1)
    return float(exact.quantize(step, rounding=ROUND_CEILING))


def at_most(share: float) -> str:
    """Format a share that something does not exceed: "below 0.01 %" needs no sign there."""
    return percent(share).removeprefix("< ")


def hundredths(share: float) -> str:
    """Format a share as percent with two decimals and without the sign, for columns headed by it."""
    if not math.isfinite(share):
        return "∞"
    value = 100 * share
    return "< 0.01" if 0 < value < 0.005 else f"{value:.2f}"


def mass(kilograms: float) -> str:
    """Format kilograms, or grams below a tenth of one."""
    return f"{number(kilograms)} kg" if kilograms >= 0.1 else f"{number(1000 * kilograms)} g"


def named_joints(numbers: Sequence[int], of: int) -> str:
    """Name joints.

    Examples
    --------
    >>> named_joints([3], 6), named_joints([1, 4, 5], 6), named_joints([1, 2], 2)
    ('joint 3', 'joints 1, 4 and 5', 'every joint')
    """
    if len(numbers) == of > 1:
        return "every joint"
    *first, last = map(str, numbers)
    return f"joints {', '.join(first)} and {last}" if first else f"joint {last}"


def pretty(text: str) -> str:
    """Raise the exponents of a unit or of numbers: kg m^2 to kg m², 2.1e-14 to 2.1 × 10⁻¹⁴."""
    text = re.sub(r"(?<=[a-z])\^(-?\d+)", lambda m: m[1].translate(_SUPERSCRIPTS), text)
    return re.sub(r"(?<=\d)e([+-]\d+)", lambda m: f" × 10{str(int(m[1])).translate(_SUPERSCRIPTS)}", text)


def aligned(cells: Iterable[str]) -> list[dict[str, str]]:
    """Numbers of a column with the digits to be kept free behind each, so that their points align."""
    column = list(cells)
    decimals = [_decimals(cell) for cell in column]
    most = max(decimals, default="", key=len)
    return [
        {"text": cell, "pad": "" if "×" in cell else most[len(own) :] if own else most}
        for cell, own in zip(column, decimals, strict=True)
    ]


def _decimals(cell: str) -> str:
    """Point and decimals of a plain number."""
    return cell[cell.index(".") :] if "." in cell and "×" not in cell else ""


def markup(text: str) -> Markup:
    """HTML of a text with numbers: 1.42e-14 as a power of ten, a hyphen before digits as a minus sign."""
    escaped = str(escape(text))
    powers = re.sub(
        r"(\d)e([+-])0*(\d+)",
        lambda found: f"{found[1]}\u202f×\u202f10<sup>{'−' if found[2] == '-' else ''}{found[3]}</sup>",
        escaped,
    )
    return Markup(re.sub(r"(^|\s)-(?=\d)", r"\1−", powers))


def markup_of_powers(text: str) -> Markup:
    """HTML of a polynomial: what follows a caret is raised."""
    typeset = str(markup(text)).replace(" - ", " − ")
    return Markup(re.sub(r"\^([\d.]+)", r"<sup>\1</sup>", typeset))
