"""Numbers as a reader expects them, for display only."""

from __future__ import annotations

import math


def number(value: float) -> str:
    """Format to three significant digits."""
    if value == 0.0:
        return "0"
    return f"{value:.2e}" if abs(value) < 1e-3 or abs(value) >= 1e5 else f"{value:.3g}"


def percent(share: float) -> str:
    """Format a share as percent with two significant digits."""
    if not math.isfinite(share):
        return "∞"
    value = 100 * share
    if value == 0.0:
        return "0 %"
    return "< 0.01 %" if abs(value) < 0.01 else f"{value:.2g} %" if abs(value) < 9.95 else f"{value:.0f} %"
