"""What measured torques say of the model, in words: for every joint, and of all of them in a sentence."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, NamedTuple

from gd_analyze.dynamics.measured_torque import CONTRADICTING
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.rows import Row
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import UNITS
from gd_analyze.text import named_joints, number, percent, prefixed, with_error

if TYPE_CHECKING:
    import xarray as xr

# What is said of joints of one verdict.
_SAID: dict[str, str] = {
    "follows": "the model holds at {}",
    "follows but for friction": "the model holds but for friction at {}",
    "too light": "the model is too light at {}",
    "too heavy": "the model is too heavy at {}",
    "other sign": "the measurement has the other sign at {}",
    "another joint's": "another joint's torque was measured at {}",
    "does not follow": "the measurement does not follow the model at {}",
    "below friction": "nothing can be told at {}, where the model's torque is below friction",
    "not measured": "no torque was measured at {}",
}
# And where to look for the reason.
_CHECK = {
    "too light": ("masses", "payload", "the unit of the torques"),
    "too heavy": ("masses", "the unit of the torques"),
    "other sign": ("the directions of the axes",),
    "another joint's": ("the order of the columns",),
    "does not follow": ("the columns of the torques", "the units of the motion"),
}


def measured_rows(findings: Findings) -> list[Row]:
    """One row per joint of the table "measured_torque", with its verdict `told`; none without one."""
    found = findings.tables.get("measured_torque")
    return [] if found is None else rows_told(found, findings.arm)


def rows_told(table: xr.Dataset, arm: RobotArm) -> list[Row]:
    """Do `measured_rows` with the table at hand."""
    return [
        row | {"effort_unit": joint.effort_unit, "told": verdict_told(row)}
        for row, joint in zip(rows_of(table, "joint"), arm.joints, strict=True)
    ]


def verdict_told(row: Row) -> str:
    """Say how a joint's measurement and model go together: "too light by a factor 1.9"."""
    verdict: str = row["verdict"]
    if verdict == "another joint's":
        return f"follows the model of joint {row['resembles']}"
    factor = _factor(row)
    return f"{verdict} by a factor {factor}" if factor else verdict


def is_described(table: xr.Dataset) -> bool:
    """Whether no measured torque speaks against the model."""
    return not {*table.verdict.values.tolist()} & {*CONTRADICTING}


def torque_sentence(table: xr.Dataset) -> str:
    """Say of which joints the measured torques are the model's, of which not, and of which nobody knows."""
    return f"Measured torques: {'; '.join(_phrases(table, _SAID))}."


def torque_warning(table: xr.Dataset, arm: str) -> str:
    """Say where a model is not what was measured, and what to look at."""
    verdicts = {*table.verdict.values.tolist()}
    places = dict.fromkeys(place for verdict, them in _CHECK.items() if verdict in verdicts for place in them)
    return (
        f"measured torques speak against {arm}: {'; '.join(_phrases(table, CONTRADICTING))}. What is said of "
        f"the model there need not hold for the robot; check {', '.join(places)}"
    )


def _phrases(table: xr.Dataset, verdicts: Iterable[str]) -> list[str]:
    """What is said of the joints of each of some verdicts."""
    rows = rows_of(table, "joint")
    of_verdict = {verdict: [row for row in rows if row["verdict"] == verdict] for verdict in verdicts}
    return [
        _SAID[verdict].format(named_joints([row["joint"] for row in found], len(rows))) + _detail(found)
        for verdict, found in of_verdict.items()
        if found
    ]


def _detail(rows: Sequence[Row]) -> str:
    """Factors, or the joints that were measured instead."""
    if rows[0]["verdict"] == "another joint's":
        return f" (that of {', '.join(str(row['resembles']) for row in rows)})"
    *first, last = [factor for row in rows if (factor := _factor(row))] or [""]
    if first:
        return f" (by factors {', '.join(first)} and {last})"
    return f" (by a factor {last})" if last else ""


def _factor(row: Row) -> str:
    """How many times too light or too heavy a model is; "" where it is not that."""
    slope = row["slope_beside_friction"]
    if row["verdict"] == "too light" and slope:
        return f"{slope:.2g}" if slope < 99.5 else f"{slope:.0f}"
    if row["verdict"] == "too heavy" and slope:
        return f"{1 / slope:.2g}" if slope > 1 / 99.5 else f"{1 / slope:.0f}"
    return ""


class FrictionCells(NamedTuple):
    """Friction of a joint and what it leaves, with standard errors, as text; dashes where nothing is known.

    Parameters
    ----------
    coulomb, offset, rms
        In `unit`.
    viscous
        In `viscous_unit`.
    explained
        Percent.
    """

    coulomb: str
    offset: str
    rms: str
    unit: str
    viscous: str
    viscous_unit: str
    explained: str


def friction_cells(row: Row, digits: int = 2) -> FrictionCells:
    """Write what was fitted to one joint, errors with so many digits.

    `row` is one of `measured_rows`, of a run that fits friction.
    """

    def value(name: str) -> float:
        return math.nan if row[name] is None else float(row[name])

    def written(name: str, factor: float) -> str:
        return with_error(value(name) / factor, value(f"{name}_error") / factor, digits)

    def scale(unit: str, *names: str) -> tuple[float, str]:
        told = (abs(value(f"{name}{of}")) for name in names for of in ("", "_error"))
        return prefixed(max(filter(math.isfinite, told), default=0.0), unit)

    factor, unit = scale(row["effort_unit"], "coulomb", "offset")
    slower, viscous_unit = scale(UNITS["viscous"][row["effort_unit"] == "N m"], "viscous")
    rms, explained = value("rms_beside_friction"), value("explained_beside_friction")
    return FrictionCells(
        written("coulomb", factor),
        written("offset", factor),
        number(rms / factor) if math.isfinite(rms) else "–",
        unit,
        written("viscous", slower),
        viscous_unit,
        share_told(explained),
    )


def share_told(explained: float | None) -> str:
    """Percent of a variance that is explained; "none" where there would be less of it without the model."""
    if explained is None or not math.isfinite(explained):
        return "–"
    return percent(explained) if explained >= 0.0 else "none"
