"""Check a motion against an arm: extremes and limits, and warnings of implausible numbers."""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.velocities import are_degrees, contradictions
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint
from gd_analyze.text import percent

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# Limits are nominal numbers of a few digits; files print positions with ten or so. Exceeding a limit by less
# than this, relative to it, is rounding and no violation.
ROUNDING = 1e-9
# Joints without limits may turn several times, but numbers beyond two turns are rarely radians.
MANY_TURNS = 4 * math.pi

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
    suspects = _degree_suspects(arm, low, high)
    messages = []
    if suspects:
        labels = ", ".join(joint_label(i + 1, arm.joints[i].name) for i in suspects)
        largest = float(np.maximum(-low, high)[suspects].max())
        reached = f"{labels} read as radians reach {largest:.4g} rad ({math.degrees(largest):.0f} deg)"
        messages.append(f"{reached}, which looks like degrees; {_in_degrees(trajectory)}")
    messages += _exceeded_limits(trajectory, arm, suspects)
    messages += _slow_velocities(trajectory, arm)
    recording = trajectory.recording
    if recording is not None and recording.measured:
        noise_span = _STILL_DEVIATIONS * recording.noise_q + ROUNDING
        if (high - low <= noise_span).all():
            messages.append("no joint moves by more than its noise: the arm stands still")
    arrays = (trajectory.time, trajectory.q, trajectory.qd, trajectory.qdd)
    messages += contradictions(*arrays, trajectory.gaps, trajectory.derived)
    for message in messages:
        warnings.warn(f"trajectory {trajectory.name}: {message}", GdAnalyzeWarning, stacklevel=3)


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
            message += f"; in another unit than m, name the column q{sliding[0]}_mm or _cm"
        yield message


# Units of time, per s.
_UNITS = {"ns": 1e9, "us": 1e6, "ms": 1e3}
# Only joints that move by more than this, rad or m, show their velocities.
_MOVING_SPAN = 0.1
# Velocities up to this share of the limits are usual.
_USUAL_VELOCITY_SHARE = 1.5
# Steps of logs, 10 kHz to 10 Hz, by which a unit of time is suggested.
_SHORTEST_STEP_SECONDS = 1e-4
_LONGEST_STEP_SECONDS = 0.1


def _slow_velocities(trajectory: Trajectory, arm: RobotArm) -> Iterator[str]:
    """A message if velocities derived from instants would be usual in another unit of time."""
    moving = np.ptp(trajectory.extremes[0], axis=0) > _MOVING_SPAN
    limits = arm.limits("velocity_limit")[moving]
    if "qd" not in trajectory.derived or not moving.any() or not ((limits > 0) & np.isfinite(limits)).all():
        return
    share = float((np.abs(trajectory.extremes[1]).max(axis=0)[moving] / limits).max())
    period = float(np.median(np.diff(trajectory.time)))
    usual_by_velocity, usual_by_step = [], []
    for unit, per_second in _UNITS.items():
        if 0.0 < per_second * share <= _USUAL_VELOCITY_SHARE:
            usual_by_velocity.append(unit)
        step = period / per_second
        if _SHORTEST_STEP_SECONDS <= step <= _LONGEST_STEP_SECONDS:
            usual_by_step.append(unit)
    if usual_by_velocity:
        # A controller's rate is better evidence than the arm's velocity limits.
        unit = (usual_by_step or usual_by_velocity)[0]
        slow = f"at most {100 * share:.2g} % of the arm's velocity limits, with time read as seconds"
        yield f"{slow}; if it is in {unit}: --map time=:{unit}"


def _in_degrees(trajectory: Trajectory) -> str:
    """How to read positions in degrees, and what was given with them."""
    states = trajectory.time, trajectory.q, trajectory.qd, trajectory.gaps
    if "qd" not in trajectory.derived and are_degrees(*states):
        return "qd, in radians, says that they are: --map q=:deg"
    roles = [role for role in ("q", "qd", "qdd") if role not in trajectory.derived]
    return f"if they are: {' '.join(f'--map {role}=:deg' for role in roles)}"


def require_trajectory_joints(trajectory: Trajectory, arm: RobotArm) -> None:
    """Raise a TrajectoryError if a trajectory has another number of joints."""
    if trajectory.n_joints != arm.n_joints:
        where = f"trajectory {trajectory.name}"
        step = "choose the right arm; `gd-analyze arms` lists the built-in ones"
        expected, count = f"{arm.n_joints} joints", f"{trajectory.n_joints} joints"
        raise refusal(f"{where} is not for arm {arm.name}", where, expected, count, step)


def warn_if_radians(name: str, degrees: FloatArray) -> None:
    """Warn when angles that a file calls degrees, shape (N, k), look like radians.

    Few motions stay within 3.15 degrees of zero in every joint; in radians, all within half a turn do.
    """
    reach = float(np.nanmax(np.abs(degrees), initial=0.0))
    if reach <= 3.15 and bool((np.ptp(degrees, axis=0) > 0).any()):
        looks = f"angles in degrees stay within {reach:.3g} of zero, which looks like radians"
        message = f"trajectory {name}: {looks}; if they are, name the columns without the unit"
        warnings.warn(message, GdAnalyzeWarning, stacklevel=3)


def doubtful_joints(arm: RobotArm, low: FloatArray, high: FloatArray) -> list[int]:
    """Joints (from 0) whose positions no such joint reaches: in another unit, or before the gears.

    They are beyond limits, and several turns or ten times a travel away from zero, or look like degrees.
    """
    lower, upper = arm.limits("lower"), arm.limits("upper")
    reach = np.maximum(np.abs(low), np.abs(high))
    travel = np.maximum(np.abs(lower), np.abs(upper))
    far = reach > np.where(arm.is_revolute, MANY_TURNS, 10.0 * travel)
    outside = (low < lower) | (high > upper)
    unlimited = ~np.isfinite(travel)
    return sorted({*_degree_suspects(arm, low, high), *np.flatnonzero(far & (outside | unlimited)).tolist()})


def _degree_suspects(arm: RobotArm, low: FloatArray, high: FloatArray) -> list[int]:
    """Joints (from 0) whose angles exceed their limits, but not if read as degrees.

    A joint without limits is suspect if it turns by more than two turns.
    """
    lower, upper = arm.limits("lower"), arm.limits("upper")
    reach = np.maximum(np.abs(low), np.abs(high))
    outside = (reach > 2 * math.pi) & ((low < lower) | (high > upper))
    inside = (lower <= np.radians(low) + ROUNDING) & (np.radians(high) <= upper + ROUNDING)
    limited = np.isfinite(lower) & np.isfinite(upper)
    suspect = np.where(limited, outside & inside, reach > MANY_TURNS)
    return np.flatnonzero(suspect & np.array(arm.is_revolute)).tolist()
