"""Where a joint's errors lie against its budget, on one logarithmic scale for all joints."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gd_analyze.report.context import BeyondRow, JointError

# Decades that a page shows at most below and above the budget; what lies farther out stands at the edge.
_LOWEST, _HIGHEST = -2, 4


@dataclass(frozen=True)
class ErrorMarks:
    """One joint; places are percent of the axis from its left, None for what is not known.

    Parameters
    ----------
    sampled, worst_found, certified, within_limits
        Largest error along the trajectory, found and proven between its extremes, found within the limits.
    uncertainty
        What the parameters' stated uncertainties make of the torque.
    """

    joint: str
    name: str
    sampled: float
    worst_found: float | None
    certified: float | None
    within_limits: float | None
    uncertainty: float | None


@dataclass(frozen=True)
class BeyondChart:
    """All joints, the ticks of the axis as (place, label), and where the budget is."""

    marks: tuple[ErrorMarks, ...]
    ticks: tuple[tuple[float, str], ...]
    budget: float


def beyond_chart(errors: tuple[JointError, ...], beyond: tuple[BeyondRow, ...]) -> BeyondChart:
    """Put errors over what the budget allows on an axis."""
    known = [
        value / error.allowed
        for error, row in zip(errors, beyond, strict=True)
        for value in (error.largest, row.worst_found, row.certified, row.within_limits, row.uncertainty)
        if value
    ]
    decades = [math.log10(ratio) for ratio in known]
    low = max(min([math.floor(d) for d in decades] + [-1]), _LOWEST)
    high = min(max([math.ceil(d) for d in decades] + [1]), _HIGHEST)

    def place(ratio: float) -> float:
        decade = math.log10(ratio) if ratio > 0.0 else low
        return round(100 * (min(max(decade, low), high) - low) / (high - low), 2)

    def mark(value: float | None, allowed: float) -> float | None:
        return None if value is None else place(value / allowed)

    marks = tuple(
        ErrorMarks(
            error.joint,
            error.name,
            place(error.largest / error.allowed),
            mark(row.worst_found, error.allowed),
            mark(row.certified, error.allowed),
            mark(row.within_limits, error.allowed),
            mark(row.uncertainty, error.allowed),
        )
        for error, row in zip(errors, beyond, strict=True)
    )
    ticks = tuple((place(10.0**d), f"{10.0**d:g}×") for d in range(low, high + 1))
    return BeyondChart(marks, ticks, place(1.0))
