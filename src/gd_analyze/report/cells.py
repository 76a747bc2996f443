"""Cells of the tables of a report: values of rows as text whose decimal points align."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from gd_analyze.formatting import aligned, figures, percent_cell, prefixed, pretty
from gd_analyze.results import Findings
from gd_analyze.results.rows import Row

# What is written without a power of ten, see `gd_analyze.formatting.figures`.
_SMALLEST = 1e-3

Write = Callable[[Row], str]


def formatted(rows: list[Row], *same: str, **formats: Write) -> list[Row]:
    """Rows as a template lays them out: some values as they are, others written so that points align."""
    columns = {name: aligned(map(write, rows)) for name, write in formats.items()}
    return [
        {name: row[name] for name in same} | {name: column[k] for name, column in columns.items()}
        for k, row in enumerate(rows)
    ]


def in_fitting_units(rows: list[Row], unit: str, largest: str, *others: str) -> list[Row]:
    """Put the values of every row into the prefixed unit that fits one of them; the unit's key has it.

    Parameters
    ----------
    rows
        Rows of a table.
    unit, largest, others
        Keys: of the unit, of the value that it shall fit, and of what else stands in it where it can; None
        stays.
    """
    out = []
    for row in rows:
        factor, shown = _fitting(row[unit], [row[key] for key in (largest, *others) if row[key]])
        values = {key: None if row[key] is None else row[key] / factor for key in (largest, *others)}
        out.append(row | values | {unit: pretty(shown), "factor": factor})
    return out


def _fitting(unit: str, values: list[float]) -> tuple[float, str]:
    """Unit of the largest value, or the next smaller one where the smallest would need a power of ten."""
    factor, shown = prefixed(max(values, default=0.0), unit)
    if values and min(values) < _SMALLEST * factor:
        return prefixed(5 * _SMALLEST * factor, unit)
    return factor, shown


def torque(name: str, noise: float = 0.0) -> Write:
    """Write three digits; a dash where nothing can be said, and whether it is nothing but round-off."""

    def write(row: Row) -> str:
        value = row[name]
        # Round-off is told in N m, whatever the row's own unit.
        return (
            "–" if value is None else "≈ 0" if 0 < value * row.get("factor", 1) <= noise else figures(value)
        )

    return write


def share(name: str, findings: Findings, joint: str = "joint") -> Write:
    """Write percent of a joint's peak torque; a dash where nothing is known or that torque is round-off."""
    peaks = findings.model.promise.errors.peak_torque

    def write(row: Row) -> str:
        share = row[name]
        known = share is not None and (share == 0 or peaks[row[joint] - 1] > findings.round_off)
        return percent_cell(share) if known else "–"

    return write
