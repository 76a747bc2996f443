"""Check a motion against an arm: extremes and limits, and warnings of implausible numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import warn_caller
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.units_by_numbers import look_like_degrees, options_of, slow_motion
from gd_analyze.motions.velocities import contradictions
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint
from gd_analyze.text import percent

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Limits are nominal numbers of a few digits; files print positions with ten or so. Exceeding a limit by less
# than this, relative to it, is rounding and no violation.
ROUNDING = 1e-9

LimitedQuantity = Literal["position", "velocity", "acceleration"]


@dataclass(frozen=True)
class Violation:
    """One limit of one joint that a motion exceeds; SI and radians."""

    joint: int  # number i, from 1
    name: str
    quantity: LimitedQuantity
    value: float  # the extreme reached; velocity and acceleration as magnitudes
    limit: float  # the limit it exceeds
    time: float  # the instant of the extreme, s
    unit: str  # of value and limit

    @property
    def excess(self) -> float:
        """Excess of the value over the limit, positive."""
        return abs(self.value - self.limit)

    def __str__(self) -> str:
        label = joint_label(self.joint, self.name)
        if self.quantity == "position":
            side = "above its upper" if self.value > self.limit else "below its lower"
            value, excess, limit = (angle(x, self.unit) for x in (self.value, self.excess, self.limit))
            return f"{label}: position {value}, {excess} {side} limit {limit}"
        digits = 4 if self.excess > 1e-3 * self.limit else 10
        value, excess = (f"{x:.{digits}g} {self.unit}" for x in (self.value, self.excess))
        share, limit = percent(self.excess / self.limit), f"{self.limit:g} {self.unit}"
        return f"{label}: {self.quantity} {value}, {excess} ({share}) above the limit {limit}"


@dataclass(frozen=True)
class JointExtremes:
    """Extremes of one joint's variable, largest magnitudes of its derivatives; SI and radians."""

    joint: Joint  # with its limits
    lowest: float
    highest: float
    velocity: float
    acceleration: float


@dataclass(frozen=True)
class LimitReport:
    """Extremes of a motion and the limits of the arm."""

    rows: tuple[JointExtremes, ...]  # one per joint
    violations: tuple[Violation, ...]  # every limit exceeded, in the order of the joints

    @property
    def least_stretch(self) -> float | None:
        """Factor on the duration with which velocities and accelerations just meet their limits.

        Stretching time by k divides velocities by k and accelerations by k^2; None without such limits.
        """
        factors = []
        for row in self.rows:
            if row.joint.velocity_limit is not None:
                factors.append(row.velocity / row.joint.velocity_limit)
            if row.joint.acceleration_limit is not None:
                factors.append(math.sqrt(row.acceleration / row.joint.acceleration_limit))
        return max(factors, default=None)


def limit_report(arm: RobotArm, motion: Trajectory | PPoly[np.float64]) -> LimitReport:
    """Compare extremes with limits: at the set points of a trajectory, or everywhere on a path."""
    rows, violations = [], []
    for i, joint in enumerate(arm.joints):
        limits: list[tuple[LimitedQuantity, float | None, str, int]] = [
            ("position", joint.lower, "", -1),
            ("position", joint.upper, "", 1),
            ("velocity", joint.velocity_limit, "/s", 1),
            ("acceleration", joint.acceleration_limit, "/s^2", 1),
        ]
        extremes = _extremes(motion, i)
        rows.append(JointExtremes(joint, *(value for value, _ in extremes)))
        violations += [
            Violation(i + 1, joint.name, quantity, value, limit, time, joint.unit + per)
            for (value, time), (quantity, limit, per, side) in zip(extremes, limits, strict=True)
            if limit is not None and side * (value - limit) > ROUNDING * max(1.0, abs(limit))
        ]
    return LimitReport(tuple(rows), tuple(violations))


def _extremes(motion: Trajectory | PPoly[np.float64], joint: int) -> list[tuple[float, float]]:
    """Smallest and largest variable, largest velocity and acceleration of a joint (from 0), with instants."""
    extremes = []
    for order in range(3):
        if isinstance(motion, Trajectory):
            instants = motion.time[motion.extreme_at[order, :, joint]]
            values = motion.extremes[order, :, joint]
        else:
            instants, values = _candidates(motion.derivative(order) if order else motion, joint)
        values = np.abs(values) if order else values
        for pick in [values.argmax()] if order else [values.argmin(), values.argmax()]:
            extremes.append((float(values[pick]), float(instants[pick])))
    return extremes


def _candidates(path: PPoly[np.float64], joint: int) -> tuple[FloatArray, FloatArray]:
    """Instants and values of possible extremes: ends of each piece, and zeros of its derivative."""
    instants, values = [], []
    for piece, (begin, width) in enumerate(zip(path.x, np.diff(path.x), strict=False)):
        coefficients = path.c[:, piece, joint]
        slope = np.polyder(coefficients) * width ** np.arange(len(coefficients) - 2, -1, -1)
        size, local = np.abs(slope).max(initial=0.0), np.array([0.0, width])
        # Below this the joint stands still; the quotients of its coefficients would overflow.
        if size >= np.finfo(float).tiny / np.finfo(float).eps:
            roots = np.roots(np.where(np.abs(slope) < np.finfo(float).eps * size, 0.0, slope)).real
            local = np.append(local, roots[(roots > 0) & (roots < 1)] * width)
        instants.append(begin + local)
        values.append(np.polyval(coefficients, local))
    return np.concatenate(instants), np.concatenate(values)


def joint_label(number: int, name: str) -> str:
    """Joint number with its name where that says more."""
    return f"joint {number}" if name == str(number) else f"joint {number} ({name})"


def angle(value: float, unit: str) -> str:
    """Write a joint variable as people read it: degrees beside radians, metres alone."""
    return f"{value:.4g} rad ({math.degrees(value):.4g} deg)" if unit == "rad" else f"{value:.4g} {unit}"


# An arm stands still if its joints keep within this many standard deviations of their noise.
_STILL_DEVIATIONS = 6.0


def check_against_arm(trajectory: Trajectory, arm: RobotArm) -> None:
    """Refuse a trajectory with another number of joints; warn of exceeded limits and implausible numbers."""
    require_trajectory_joints(trajectory, arm)
    low, high = trajectory.extremes[0]
    reach = np.maximum(-low, high)
    suspects = np.flatnonzero(look_like_degrees(arm, reach)).tolist()
    arrays = (trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd)
    mistakes = contradictions(*arrays, trajectory.gaps, trajectory.derived)
    messages = []
    if suspects:
        labels = ", ".join(joint_label(i + 1, arm.joints[i].name) for i in suspects)
        largest = float(reach[suspects].max())
        reached = f"{labels} read as radians reach {largest:.4g} rad ({math.degrees(largest):.0f} deg)"
        # What contradicts the positions is in another unit than they are.
        given = [role for role in ("q", "qd", "qdd") if role not in trajectory.derived]
        advice = options_of(dict.fromkeys(["q"] if mistakes else given, "deg"))
        are = "they are" if len(suspects) == arm.n_joints else "all joints are"
        messages.append(f"{reached}, which looks like degrees; if {are}: {advice}")
    messages += _exceeded_limits(trajectory, arm, suspects)
    if "qd" in trajectory.derived:
        speed = np.abs(trajectory.extremes[1]).max(axis=0)
        messages += slow_motion(arm, trajectory.time, high - low, speed)
    recording = trajectory.recording
    if recording is not None and recording.measured:
        noise_span = _STILL_DEVIATIONS * recording.noise_q + ROUNDING
        if (high - low <= noise_span).all():
            messages.append("no joint moves by more than its noise: the arm stands still")
    for message in [*messages, *mistakes]:
        warn_caller(f"trajectory {trajectory.name}: {message}")


def _exceeded_limits(trajectory: Trajectory, arm: RobotArm, suspects: Sequence[int]) -> Iterator[str]:
    """One message for each quantity that exceeds limits, but for joints (from 0) suspected of degrees."""
    smoothed = trajectory.recording is not None and trajectory.recording.measured
    report = limit_report(arm, trajectory)
    violations = [violation for violation in report.violations if violation.joint - 1 not in suspects]
    for quantity in dict.fromkeys(violation.quantity for violation in violations):
        alike = [violation for violation in violations if violation.quantity == quantity]
        points = np.searchsorted(trajectory.time, [violation.time for violation in alike]) + 1
        message = "; ".join(
            f"{violation}, at set point {point} ({violation.time:.4g} s)"
            for violation, point in zip(alike, points, strict=True)
        )
        derived = {"velocity": "qd", "acceleration": "qdd"}.get(quantity)
        if smoothed and derived:
            message += "; from smoothed readings: a lower --cutoff smooths more"
        elif derived in trajectory.derived:
            message += f"; {derived} is derived, which amplifies rounding: smooth q or add {derived}"
        sliding = [violation.joint for violation in alike if quantity == "position" and violation.unit == "m"]
        if sliding:
            message += f"; if joint {sliding[0]} is in another unit than m: --map q=:mm"
        yield message


def require_trajectory_joints(trajectory: Trajectory, arm: RobotArm) -> None:
    """Raise a TrajectoryError if a trajectory has another number of joints."""
    if trajectory.n_joints != arm.n_joints:
        where = f"trajectory {trajectory.name}"
        step = "choose the right arm; `gd-analyze arms` lists the built-in ones"
        expected, count = f"{arm.n_joints} joints", f"{trajectory.n_joints} joints"
        raise refusal(f"{where} is not for arm {arm.name}", where, expected, count, step)
