"""Where a joint's errors lie against its budget, on one logarithmic scale for all joints."""

from __future__ import annotations

import math
from dataclasses import dataclass

from gd_analyze.results.rows import Row

# Errors that the chart shows, by their names in the schema.
SHOWN = ("largest_error", "worst_found", "certified", "within_limits", "uncertainty")

# Decades that a page shows at most below and above the budget; what lies farther out stands at the edge.
_LOWEST, _HIGHEST = -2, 4


@dataclass(frozen=True)
class BeyondChart:
    """Places are percent of the axis from its left.

    Parameters
    ----------
    marks
        Of every joint the places of its errors, None for what is not known.
    ticks
        Of the axis, as (place, label).
    budget
        Where it is.
    """

    marks: list[dict[str, float | None]]
    ticks: list[tuple[float, str]]
    budget: float


def beyond_chart(rows: list[Row]) -> BeyondChart:
    """Put errors over what the budget allows on an axis."""
    ratios = [
        {name: None if row[name] is None else row[name] / row["allowed_error"] for name in SHOWN}
        for row in rows
    ]
    decades = [math.log10(ratio) for row in ratios for ratio in row.values() if ratio]
    low = max(min([math.floor(d) for d in decades] + [-1]), _LOWEST)
    high = min(max([math.ceil(d) for d in decades] + [1]), _HIGHEST)

    def place(ratio: float | None) -> float | None:
        return None if ratio is None else _placed(ratio, low, high)

    return BeyondChart(
        [{name: place(ratio) for name, ratio in row.items()} for row in ratios],
        [(_placed(10.0**d, low, high), f"{10.0**d:g}×") for d in range(low, high + 1)],
        _placed(1.0, low, high),
    )


def _placed(ratio: float, low: int, high: int) -> float:
    decade = math.log10(ratio) if ratio > 0.0 else low
    return round(100 * (min(max(decade, low), high) - low) / (high - low), 2)
