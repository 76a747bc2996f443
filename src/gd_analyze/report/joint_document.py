"""What the PDF says of every joint: torque, errors at the set points, near the motion and beyond it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

from gd_analyze.figures.motion import motion_unit
from gd_analyze.report.cells import formatted, in_fitting_units, share, torque
from gd_analyze.results import summary
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import Row, joint_rows
from gd_analyze.robots.parts import Joint
from gd_analyze.text import amount, mass, number, percent_cell, pretty, rounded_up, share_up

_TORQUES = (
    *("peak_torque", "allowed_error", "largest_error", "rms_error", "tube_certified", "tube_worst_found"),
    *("certified", "worst_found", "within_limits", "torque_per_kg", "uncertainty"),
)
_BOUNDS = ("tube_certified", "certified")
# What a bar of the chart of errors shows of what the budget allows, at most.
_LONGEST = 3.0


def joints(findings: Findings) -> list[Row]:
    """One row per joint: numbers in the unit that fits its peak torque, shares, and the lengths of bars."""
    # A bound has the round-off of its own proof beside that of the torques.
    noise = max(findings.round_off, float(findings.decomposition.attrs["torque_round_off"]))
    raw = joint_rows(findings, "simplified_model", "tube", "beyond")
    rows = [_bounds_rounded_up(row) for row in raw]
    fitting = in_fitting_units(rows, "effort_unit", *_TORQUES, noise=noise)
    shares = ("largest_share", "rms_share", "tube_certified_share", "certified_share", "within_limits_share")
    written = formatted(
        fitting,
        "joint",
        "joint_name",
        "effort_unit",
        **{name: torque(name, noise) for name in _TORQUES},
        **{name: share(name, findings) for name in shares},
        mass_within_budget=lambda row: any_or(row["mass_within_budget"]),
    )
    wholes = findings.model.accuracy.whole
    for joint, row, exactly, shown in zip(findings.arm.joints, rows, raw, written, strict=True):
        whole = float(wholes[row["joint"] - 1])
        shown["sampled_share"] = _share_told(exactly["largest_error"], whole, noise)
        shown["bound_share"] = _share_told(exactly["tube_certified"], whole, noise, share_up)
        shown["margins"] = [_margin(row, joint, name) for name in ("q", "qd", "qdd")]
        shown["sampled"], shown["bound"] = (
            _told(row, name, noise) for name in ("largest_error", "tube_certified")
        )
        shown["used"] = _used(row["largest_error"], row, noise)
        shown["proven"] = None if row["tube_certified"] is None else _used(row["tube_certified"], row, noise)
        shown["over"] = row["largest_error"] > max(row["allowed_error"], noise)
    return written


def _bounds_rounded_up(row: Row) -> Row:
    """A bound is never shown smaller than it is."""
    names = [name for bound in _BOUNDS for name in (bound, f"{bound}_share")]
    up = {
        name: (share_up if name.endswith("share") else rounded_up)(row[name]) for name in names if row[name]
    }
    return row | up


def _told(row: Row, name: str, noise: float) -> str:
    """Write a torque with a unit of its own; nothing where nothing is known."""
    if row[name] is None:
        return ""
    return "≈ 0" if 0.0 < row[name] <= noise else pretty(amount(row[name], row["effort_unit"]))


def _share_told(
    error: float | None, whole: float, noise: float, rounded: Callable[[float], float] = float
) -> str:
    """Percent of what the budget is told in; a dash where nothing is known or the whole is round-off."""
    if error is None or (error and whole <= noise):
        return "–"
    return percent_cell(rounded(error / whole)) if error else "0"


def _used(error: float, row: Row, noise: float) -> float:
    """Part of what the budget allows that an error takes; nothing where it is round-off."""
    return min(error / row["allowed_error"], _LONGEST) if error > noise else 0.0


def longest_bar(rows: list[Row]) -> float:
    """Length of the chart of errors, in what the budget allows; `rows` are those of `joints`."""
    return max([1.25, *(row["used"] for row in rows), *(row["proven"] or 0.0 for row in rows)])


def _margin(row: Row, joint: Joint, name: str) -> str:
    """How far from the motion is proven, with the unit that plots of the motion have."""
    value = row[f"tube_margin_{name}"]
    shown = math.degrees(value) if joint.kind == "revolute" else value
    return f"{number(shown)} {pretty(motion_unit(joint, name))}"


def any_or(kilograms: float) -> str:
    """A mass, or that any will do."""
    return mass(kilograms) if kilograms < float("inf") else "any"


def beyond(findings: Findings) -> dict[str, Any]:
    """Describe what the model does away from the set points; the joints' own numbers are among theirs."""
    rows = joint_rows(findings, "simplified_model", "tube", "beyond")
    ratio = summary.bound_ratio(findings)
    payload = min(rows, key=lambda row: row["mass_within_budget"])
    limited = payload["mass_within_budget"] != float("inf")
    certified = [row for row in rows if row["certified"] is not None]
    return {
        "near": summary.tube_proven(findings) is not None,
        "certified": bool(certified),
        "within": sum(row["certified"] <= row["allowed_error"] for row in certified),
        "within_tube": sum((row["tube_certified"] or 0.0) <= row["allowed_error"] for row in rows),
        "tube": summary.tube_sentence(findings),
        "margins": summary.margins_told(findings),
        "ratio": "" if ratio is None else f"{math.ceil(100 * ratio) / 100:.2f}",
        "drawn": findings.tables["beyond"].attrs["states_drawn"],
        "uncertain": rows[0]["uncertainty"] is not None,
        "largest_mass": any_or(payload["mass_within_budget"]),
        "limiting_joint": payload["joint"] if limited else None,
    }
