"""Where a joint's errors lie against its budget, on one logarithmic scale for all joints."""

from __future__ import annotations

import math
from typing import Any

from gd_analyze.results.rows import Row

# Errors that the chart shows, by their names in the schema.
SHOWN = ("largest_error", "worst_found", "certified", "within_limits", "uncertainty")

# Decades that a page shows at most below and above the budget; what lies farther out stands at the edge.
_LOWEST, _HIGHEST = -2, 4


def beyond_chart(rows: list[Row]) -> dict[str, Any]:
    """Put errors over what the budget allows on an axis; places are percent of it from its left.

    Returns
    -------
    dict
        `marks`: of every joint the places of its errors by name, None for what is not known; `ticks`: place
        and label of each; `budget`: its place.
    """
    ratios = [
        {name: None if row[name] is None else row[name] / row["allowed_error"] for name in SHOWN}
        for row in rows
    ]
    decades = [math.log10(ratio) for row in ratios for ratio in row.values() if ratio]
    low = max(min([math.floor(d) for d in decades] + [-1]), _LOWEST)
    high = min(max([math.ceil(d) for d in decades] + [1]), _HIGHEST)

    def mark(ratio: float | None) -> float | None:
        return None if ratio is None else place(ratio, low, high)

    return {
        "marks": [{name: mark(ratio) for name, ratio in row.items()} for row in ratios],
        "ticks": [(place(10.0**d, low, high), f"{10.0**d:g}×") for d in range(low, high + 1)],
        "budget": place(1.0, low, high),
    }


def place(ratio: float, low: int, high: int) -> float:
    """Place of a ratio on a logarithmic axis between two decades, in percent from its left."""
    decade = math.log10(ratio) if ratio > 0.0 else low
    return round(100 * (min(max(decade, low), high) - low) / (high - low), 2)
