"""Cells of the tables of a report: values of rows as text whose decimal points align."""

from __future__ import annotations

from collections.abc import Callable

from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import Row
from gd_analyze.text import aligned, figures, fitting, percent_cell, pretty

Write = Callable[[Row], str]


def formatted(rows: list[Row], *same: str, **formats: Write) -> list[Row]:
    """Rows as a template lays them out: some values as they are, others written so that points align."""
    columns = {name: aligned(map(write, rows)) for name, write in formats.items()}
    return [
        {name: row[name] for name in same} | {name: column[k] for name, column in columns.items()}
        for k, row in enumerate(rows)
    ]


def in_fitting_units(rows: list[Row], unit: str, *values: str, noise: float = 0.0) -> list[Row]:
    """Put values of every row into the prefixed unit that fits them; the unit's key has it.

    Parameters
    ----------
    rows
        Rows of a table.
    unit, values
        Keys: of the unit, and of what stands in it; None stays.
    noise
        What is no more than that is round-off, which no unit has to fit.
    """
    out = []
    for row in rows:
        factor, shown = fitting((row[key] for key in values if (row[key] or 0.0) > noise), row[unit])
        scaled = {key: None if row[key] is None else row[key] / factor for key in values}
        out.append(row | scaled | {unit: pretty(shown), "factor": factor})
    return out


def torque(name: str, noise: float = 0.0) -> Write:
    """Write three digits; a dash where nothing can be said, and whether it is nothing but round-off."""

    def write(row: Row) -> str:
        value = row[name]
        if value is None:
            return "–"
        # Round-off is told in N m, whatever the row's own unit.
        return "≈ 0" if 0 < value * row.get("factor", 1.0) <= noise else figures(value)

    return write


def share(name: str, findings: Findings, joint: str = "joint") -> Write:
    """Write percent of a joint's peak torque; a dash where nothing is known or that torque is round-off."""
    peaks = findings.model.accuracy.errors.peak_torque

    def write(row: Row) -> str:
        share = row[name]
        known = share is not None and (share == 0 or peaks[row[joint] - 1] > findings.round_off)
        return percent_cell(share) if known else "–"

    return write
