"""Extremes of a motion joint by joint, beside the limits of the arm."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Limits are nominal numbers of a few digits; files print positions with ten or so. Less than this past a
# limit, relative to it, is a rounded digit and no violation.
ROUNDING = 1e-9

Quantity = Literal["position", "velocity", "acceleration"]


@dataclass(frozen=True)
class Violation:
    """One limit of one joint that a motion exceeds; SI and radians."""

    # Joint number i, from 1, and the joint's name
    joint: int
    name: str
    quantity: Quantity  # "position", "velocity" or "acceleration"
    # The extreme reached (velocity and acceleration as magnitudes) and the limit it exceeds
    value: float
    limit: float
    time: float  # the instant of the extreme, s
    unit: str  # unit of value and limit

    @property
    def excess(self) -> float:
        """Distance of the value past the limit, positive."""
        return abs(self.value - self.limit)

    def __str__(self) -> str:
        label = joint_label(self.joint, self.name)
        if self.quantity == "position":
            side = "above its upper" if self.value > self.limit else "below its lower"
            value, excess, limit = (angle(x, self.unit) for x in (self.value, self.excess, self.limit))
            return f"{label}: position {value}, {excess} {side} limit {limit}"
        value, excess = (_number(x, self.limit) for x in (self.value, self.excess))
        share = self.excess / self.limit
        percent = f"{100 * share:.2g} %" if share < 0.1 else f"{100 * share:.0f} %"
        return (
            f"{label}: {self.quantity} {value} {self.unit}, {excess} {self.unit} ({percent}) above the limit "
            f"{self.limit:g} {self.unit}"
        )


@dataclass(frozen=True)
class JointExtremes:
    """One row of a limit report; SI and radians, None of a limit that the arm does not state."""

    # Joint number i, from 1, the joint's name, and the unit of its variable
    joint: int
    name: str
    unit: str
    # Extremes of the joint variable and its limits
    lowest: float
    highest: float
    lower: float | None
    upper: float | None
    # Largest magnitudes and their limits
    velocity: float
    velocity_limit: float | None
    acceleration: float
    acceleration_limit: float | None


@dataclass(frozen=True)
class LimitReport:
    """Extremes of a motion beside the limits of the arm."""

    rows: tuple[JointExtremes, ...]  # one per joint
    violations: tuple[Violation, ...]  # every limit exceeded, in the order of the joints

    @property
    def least_stretch(self) -> float | None:
        """Factor on the duration at which velocities and accelerations just meet their limits.

        Stretching time by k divides velocities by k and accelerations by k^2. Below 1 the motion could be
        faster; None when the arm states no such limit.
        """
        factors = [row.velocity / row.velocity_limit for row in self.rows if row.velocity_limit is not None]
        factors += [
            math.sqrt(row.acceleration / row.acceleration_limit)
            for row in self.rows
            if row.acceleration_limit is not None
        ]
        return max(factors, default=None)


def limit_report(arm: RobotArm, motion: Trajectory | PPoly[np.float64]) -> LimitReport:
    """Compare extremes with limits: of a trajectory at its set points, of a path between them too."""
    rows, violations = [], []
    for i, joint in enumerate(arm.joints):
        lowest, highest, velocity, acceleration = _extremes(motion, i)
        rows.append(
            JointExtremes(
                i + 1,
                joint.name,
                joint.unit,
                lowest.value,
                highest.value,
                joint.lower,
                joint.upper,
                velocity.value,
                joint.velocity_limit,
                acceleration.value,
                joint.acceleration_limit,
            )
        )
        checks: list[tuple[Quantity, _Extreme, float | None, str, int]] = [
            ("position", lowest, joint.lower, "", -1),
            ("position", highest, joint.upper, "", 1),
            ("velocity", velocity, joint.velocity_limit, "/s", 1),
            ("acceleration", acceleration, joint.acceleration_limit, "/s^2", 1),
        ]
        violations += [
            Violation(i + 1, joint.name, quantity, extreme.value, limit, extreme.time, joint.unit + per)
            for quantity, extreme, limit, per, side in checks
            if limit is not None and side * (extreme.value - limit) > ROUNDING * max(1.0, abs(limit))
        ]
    return LimitReport(tuple(rows), tuple(violations))


class _Extreme(NamedTuple):
    value: float
    time: float


def _extremes(motion: Trajectory | PPoly[np.float64], joint: int) -> list[_Extreme]:
    """Lowest and highest variable, largest magnitudes of velocity and acceleration of a joint (from 0)."""
    found = []
    for order in range(3):
        if isinstance(motion, Trajectory):
            instants, values = motion.time, (motion.q, motion.qd, motion.qdd)[order][:, joint]
        else:
            instants, values = _candidates(motion.derivative(order) if order else motion, joint)
        values = np.abs(values) if order else values
        for pick in [values.argmax()] if order else [values.argmin(), values.argmax()]:
            found.append(_Extreme(float(values[pick]), float(instants[pick])))
    return found


def _candidates(path: PPoly[np.float64], joint: int) -> tuple[FloatArray, FloatArray]:
    """Instants and values of possible extremes: ends of each piece, and where its derivative is 0."""
    instants, values = [], []
    for piece, (begin, width) in enumerate(zip(path.x, np.diff(path.x), strict=False)):
        coefficients = path.c[:, piece, joint]
        local = np.concatenate([[0.0, width], _stationary(coefficients, width)])
        instants.append(begin + local)
        values.append(np.polyval(coefficients, local))
    return np.concatenate(instants), np.concatenate(values)


def _stationary(coefficients: FloatArray, width: float) -> FloatArray:
    """Where a polynomial, highest power first, may be stationary inside (0, width)."""
    slope = np.polyder(coefficients) * width ** np.arange(len(coefficients) - 2, -1, -1)
    size = np.abs(slope).max(initial=0.0)
    # Below this the joint stands still; the quotients of its coefficients would overflow.
    if size < np.finfo(float).tiny / np.finfo(float).eps:
        return np.empty(0)
    slope = np.where(np.abs(slope) < np.finfo(float).eps * size, 0.0, slope)
    roots = np.roots(slope).real.astype(float)
    return roots[(roots > 0) & (roots < 1)] * width


def joint_label(number: int, name: str) -> str:
    """Joint number with its name where that says more."""
    return f"joint {number}" if name == str(number) else f"joint {number} ({name})"


def angle(value: float, unit: str) -> str:
    """Write a joint variable as people read it: degrees beside radians, metres alone."""
    return f"{value:.4g} rad ({math.degrees(value):.4g} deg)" if unit == "rad" else f"{value:.4g} {unit}"


def _number(value: float, limit: float) -> str:
    """Digits enough to tell the value from the limit it exceeds."""
    return f"{value:.4g}" if abs(value - limit) > 1e-3 * limit else f"{value:.10g}"
