"""Numbers in formulas: significant digits, written out or with a power of ten."""

from __future__ import annotations

# Powers of ten that are written out; beyond them 5.9e-5 reads better than 0.000059.
_EVERYDAY = range(-4, 6)


def rounded(value: float, digits: int) -> tuple[str, int]:
    """Mantissa and power of ten of a positive number; power 0 for everyday numbers, written out.

    Examples
    --------
    >>> rounded(0.0712, 2), rounded(1234.0, 2), rounded(5.85e-5, 2)
    (('0.071', 0), ('1200', 0), ('5.8', -5))
    """
    shown, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if exponent not in _EVERYDAY:
        return _trimmed(shown), exponent
    return _trimmed(f"{float(f'{shown}e{power}'):.{max(digits - 1 - exponent, 0)}f}"), 0


def number(value: float, digits: int) -> str:
    """Write a number in one string: -0.69, 5.85e-5."""
    mantissa, exponent = rounded(abs(value), digits)
    return f"{'-' if value < 0 else ''}{mantissa}" + (f"e{exponent}" if exponent else "")


def _trimmed(shown: str) -> str:
    return shown.rstrip("0").rstrip(".") if "." in shown else shown
