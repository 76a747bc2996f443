"""What a motion asks of each joint, beside what the arm allows."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

from gd_analyze.motions.extremes import Extreme, extremes
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

if TYPE_CHECKING:
    import numpy as np
    from scipy.interpolate import PPoly

# Limits are nominal numbers of a few digits; files print positions with ten or so. Less than this past a
# limit, relative to it, is a rounded digit and no violation.
ROUNDING = 1e-9

Quantity = Literal["position", "rate", "acceleration"]


@dataclass(frozen=True)
class Violation:
    """One limit of one joint that a motion exceeds; SI and radians.

    Parameters
    ----------
    joint
        Joint number i, from 1.
    name
        The joint's name.
    quantity
        "position", "rate" or "acceleration".
    value, limit
        The extreme reached (rate and acceleration as magnitudes) and the limit it exceeds.
    time
        The instant of the extreme, s.
    unit
        Unit of value and limit.
    """

    joint: int
    name: str
    quantity: Quantity
    value: float
    limit: float
    time: float
    unit: str

    @property
    def excess(self) -> float:
        """How far the value lies past the limit, positive."""
        return abs(self.value - self.limit)

    def __str__(self) -> str:
        label = joint_label(self.joint, self.name)
        if self.quantity != "position":
            return (
                f"{label}: {self.quantity} {_number(self.value, self.limit)} {self.unit}, "
                f"{_number(self.excess, self.limit)} {self.unit} ({_percent(self.excess / self.limit)}) "
                f"above the limit {self.limit:g} {self.unit}"
            )
        side = "above its upper" if self.value > self.limit else "below its lower"
        return (
            f"{label}: position {angle(self.value, self.unit)}, {angle(self.excess, self.unit)} {side} "
            f"limit {angle(self.limit, self.unit)}"
        )


@dataclass(frozen=True)
class JointExtremes:
    """One row of a limit report; SI and radians, a limit that the arm does not state is None.

    Parameters
    ----------
    joint
        Joint number i, from 1.
    name, unit
        The joint's name and the unit of its variable.
    lowest, highest, lower, upper
        Extremes of the joint variable and its limits.
    rate, velocity_limit
        Largest magnitude of the rate and its limit.
    acceleration, acceleration_limit
        Largest magnitude of the acceleration and its limit.
    """

    joint: int
    name: str
    unit: str
    lowest: float
    highest: float
    lower: float | None
    upper: float | None
    rate: float
    velocity_limit: float | None
    acceleration: float
    acceleration_limit: float | None


@dataclass(frozen=True)
class LimitReport:
    """Extremes of a motion beside the limits of the arm.

    Parameters
    ----------
    rows
        One per joint.
    violations
        Every limit exceeded, in the order of the joints.
    """

    rows: tuple[JointExtremes, ...]
    violations: tuple[Violation, ...]

    @property
    def unchecked(self) -> tuple[str, ...]:
        """What could not be checked because the arm states no limit, one sentence per joint."""
        sentences = []
        for row in self.rows:
            stated = {
                "position": row.lower is not None and row.upper is not None,
                "rate": row.velocity_limit is not None,
                "acceleration": row.acceleration_limit is not None,
            }
            missing = [quantity for quantity, known in stated.items() if not known]
            if missing:
                label = joint_label(row.joint, row.name)
                sentences.append(f"{label}: no limit stated for {', '.join(missing)}; not checked")
        return tuple(sentences)

    @property
    def least_stretch(self) -> float | None:
        """Factor on the duration at which rates and accelerations just meet their limits.

        Stretching time by k divides rates by k and accelerations by k^2. Below 1 the motion could be
        faster; None when the arm states no such limit.
        """
        factors = [row.rate / row.velocity_limit for row in self.rows if row.velocity_limit is not None]
        factors += [
            math.sqrt(row.acceleration / row.acceleration_limit)
            for row in self.rows
            if row.acceleration_limit is not None
        ]
        return max(factors, default=None)


def limit_report(arm: RobotArm, motion: Trajectory | PPoly[np.float64]) -> LimitReport:
    """Set a motion's extremes beside the arm's limits.

    Parameters
    ----------
    arm
        The arm.
    motion
        A trajectory, judged at its set points, or a path, judged between them too.

    Returns
    -------
    LimitReport
        Rows per joint, and the violations; limits the arm does not state are not checked.
    """
    rows, violations = [], []
    for i, joint in enumerate(arm.joints):
        lowest, highest, rate, acceleration = extremes(motion, i)
        row = JointExtremes(
            joint=i + 1,
            name=joint.name,
            unit=joint.unit,
            lowest=lowest.value,
            highest=highest.value,
            lower=joint.lower,
            upper=joint.upper,
            rate=rate.value,
            velocity_limit=joint.velocity_limit,
            acceleration=acceleration.value,
            acceleration_limit=joint.acceleration_limit,
        )
        rows.append(row)
        checks: list[tuple[Quantity, Extreme, float | None, str, int]] = [
            ("position", lowest, row.lower, "", -1),
            ("position", highest, row.upper, "", 1),
            ("rate", rate, row.velocity_limit, "/s", 1),
            ("acceleration", acceleration, row.acceleration_limit, "/s^2", 1),
        ]
        violations += [
            Violation(row.joint, row.name, quantity, extreme.value, limit, extreme.time, row.unit + per)
            for quantity, extreme, limit, per, side in checks
            if limit is not None and side * (extreme.value - limit) > ROUNDING * max(1.0, abs(limit))
        ]
    return LimitReport(tuple(rows), tuple(violations))


def joint_label(number: int, name: str) -> str:
    """Joint number with its name where that says more."""
    return f"joint {number}" if name == str(number) else f"joint {number} ({name})"


def angle(value: float, unit: str) -> str:
    """Write a joint variable as people read it: degrees beside radians, metres alone."""
    return f"{value:.4g} rad ({math.degrees(value):.4g} deg)" if unit == "rad" else f"{value:.4g} {unit}"


def _number(value: float, limit: float) -> str:
    """Digits enough to tell the value from the limit it exceeds."""
    return f"{value:.4g}" if abs(value - limit) > 1e-3 * limit else f"{value:.10g}"


def _percent(share: float) -> str:
    return f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"
