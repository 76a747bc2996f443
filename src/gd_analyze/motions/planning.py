"""Plan the set points of a motion and compare them with the arm's limits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arguments import require_word
from gd_analyze.arrays import FloatArray, array_of, require_possible
from gd_analyze.errors import TrajectoryError, warn_caller
from gd_analyze.motions.limits import ROUNDING, LimitReport, angle, joint_label, limit_report
from gd_analyze.motions.profiles import PROFILES, Profile
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.result import Fact, Result, Value, attributes_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import declared_table
from gd_analyze.text import LARGEST, rounded_up

if TYPE_CHECKING:
    from scipy.interpolate import PPoly

# A file of a million set points of six joints takes 300 MB; no motion needs more.
_MOST_SET_POINTS = 1_000_000
# No arm moves in less, and its powers stay within doubles.
_SHORTEST_SECONDS = 1e-6
# Extremes that are zero are computed with round-off.
_ROUND_OFF = 1e-12
_REACHED = ("lowest", "highest", "velocity", "acceleration")
_LIMITS = ("lower", "upper", "velocity_limit", "acceleration_limit")
# Two numbers in a column, what stands between them, and their unit by that of the joint.
_PAIRS = {
    "motion": ("lowest", "highest", " .. ", {"rad": "°"}),
    "range": ("lower", "upper", " .. ", {"rad": "°"}),
    "velocity_of_limit": ("velocity", "velocity_limit", " / ", {"rad": "rad/s", "m": "m/s"}),
    "acceleration_of_limit": ("acceleration", "acceleration_limit", " / ", {"rad": "rad/s²", "m": "m/s²"}),
}


@dataclass(frozen=True, eq=False)
class Plan:
    """A planned motion."""

    trajectory: Trajectory
    limits: LimitReport  # extremes of the whole motion, between set points too, and the arm's limits
    knot_times: FloatArray  # instants of start, vias and goal, s
    # Duration with which this motion, stretched evenly, just meets velocity and acceleration limits, s; None
    # if the arm states none
    shortest_duration: float | None


def possible_duration(value: ArrayLike) -> float:
    """Duration of a motion, s; a TrajectoryError if no arm moves in so short or so long a time."""
    duration = array_of(value, "duration", TrajectoryError)
    if duration.ndim or not _SHORTEST_SECONDS <= duration <= LARGEST:
        expected, found = f"a number from {_SHORTEST_SECONDS:g} s to {LARGEST:g} s", str(duration)
        raise refusal("the duration is out of range", "duration", expected, found)
    return float(duration)


def require_set_points(count: int) -> None:
    """Raise a TrajectoryError for a number of set points that no motion has."""
    if not 2 <= count <= _MOST_SET_POINTS:
        expected = f"2 to {_MOST_SET_POINTS}"
        raise refusal("impossible number of set points", "n_set_points", expected, str(count))


def plan_motion(
    arm: RobotArm,
    start: ArrayLike,
    goal: ArrayLike,
    duration: float,
    *,
    via: Sequence[ArrayLike] = (),
    profile: str = "4-3-4",
    n_set_points: int = 31,
    via_times: ArrayLike | None = None,
    allow_violations: bool = False,
    name: str | None = None,
) -> Plan:
    """Plan as `gd_analyze.plan` does, and compare the motion with the arm's limits."""
    require_word(profile, PROFILES, "profile")
    duration = possible_duration(duration)
    require_set_points(n_set_points)
    timing = PROFILES[profile]
    if timing.via_counts is not None and len(via) not in timing.via_counts:
        message = f"profile {profile} cannot take this number of vias"
        expected = "none, or two: lift-off, set-down"
        step = "choose the profile quintic, cubic or trapezoidal for other numbers of vias"
        raise refusal(message, "via", expected, str(len(via)), step)
    knots = _knots(arm, start, via, goal)
    times = _knot_times(arm, knots, duration, via_times)
    path = timing.path(times, knots)
    report = limit_report(arm, path)
    shortest = None if report.least_stretch is None else report.least_stretch * duration
    _judge(arm, report, f"profile {profile} over {duration:g} s", shortest, allow_violations)
    trajectory = Trajectory(
        *_sample(path, timing, knots, n_set_points),
        name=name or f"{arm.name}-{profile}",
        origin=f"planned: profile {profile}, {duration:g} s, {n_set_points} set points, {len(via)} vias",
    )
    return Plan(trajectory, report, times, shortest)


def _knots(arm: RobotArm, start: ArrayLike, via: Sequence[ArrayLike], goal: ArrayLike) -> FloatArray:
    """Joint variables of start, vias and goal, shape (m, n), each within the position limits."""
    labels = ["start", *(f"via {k}" for k in range(1, len(via) + 1)), "goal"]
    lower, upper = arm.limits("lower"), arm.limits("upper")
    knots: list[FloatArray] = []
    for label, values in zip(labels, [start, *via, goal], strict=True):
        knot = array_of(values, label, TrajectoryError)
        if knot.shape != (arm.n_joints,):
            message, expected = f"{label} does not fit arm {arm.name}", f"{arm.n_joints} joint variables"
            value = f"{knot.size} values" if knot.ndim == 1 else f"shape {knot.shape}"
            raise refusal(message, label, expected, value)
        require_possible(knot, label, TrajectoryError)
        outside = (knot < lower - ROUNDING) | (knot > upper + ROUNDING)
        for i in np.flatnonzero(outside)[:1].tolist():
            joint = arm.joints[i]
            least, most, value = (angle(float(x[i]), joint.unit) for x in (lower, upper, knot))
            message = f"{label} lies outside the range of {joint_label(i + 1, joint.name)}"
            step = "choose a position within the range"
            raise refusal(message, label, f"{least} .. {most}", value, step)
        if knots and np.abs(knot - knots[-1]).max() <= ROUNDING:
            message = f"{labels[len(knots) - 1]} and {label} are the same"
            step = "leave one out, or plan the motions around a pause separately"
            raise refusal(message, label, "another position", "no movement", step)
        knots.append(knot)
    return np.array(knots)


def _knot_times(arm: RobotArm, knots: FloatArray, duration: float, via_times: ArrayLike | None) -> FloatArray:
    """Instants of the knots, s, shape (m,).

    Constant acceleration takes a time in proportion to the square root of distance; splines timed this way
    (centripetally) overshoot least where short and long stretches meet.
    """
    if via_times is None:
        limits = arm.limits("velocity_limit")
        weights = 1 / np.where(np.isfinite(limits), limits, 1.0)
        shares = np.sqrt((np.abs(np.diff(knots, axis=0)) * weights).max(axis=1))
        times = np.concatenate([[0.0], np.cumsum(shares) / shares.sum() * duration])
        times[-1] = duration
        return times
    inner = np.atleast_1d(np.array(via_times, dtype=float))
    times = np.array([0.0, *inner, duration])
    if len(times) != len(knots) or not (np.diff(times) > ROUNDING * duration).all():
        message = "the instants of the vias do not fit the motion"
        expected = f"{len(knots) - 2} increasing instants between 0 and {duration:g} s"
        raise refusal(message, "via_times", expected, str(inner.tolist()))
    return times


def _judge(
    arm: RobotArm, report: LimitReport, where: str, shortest: float | None, allow_violations: bool
) -> None:
    overshoots = [f"{v}, at {v.time:.3g} s" for v in report.violations if v.quantity == "position"]
    if overshoots:
        message = "the motion leaves the joints' range between its knots"
        step = "move or add a via there, or choose the profile trapezoidal, which never overshoots"
        raise refusal(message, where, "every joint within its range all the time", overshoots, step)
    if not report.violations or shortest is None:
        return
    remedy = f"a duration of {rounded_up(shortest * (1 - ROUNDING), 2):.10g} s meets all limits"
    message, violations = f"the motion is too fast for {arm.name}", list(map(str, report.violations))
    if not allow_violations:
        expected = "velocities and accelerations within the limits of every joint"
        raise refusal(
            message, where, expected, violations, f"{remedy}; allow_violations=True plans it anyway"
        )
    warn_caller(f"{message}: {'; '.join(violations)}; {remedy}")


def _sample(
    path: PPoly[np.float64], profile: Profile, knots: FloatArray, n_set_points: int
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    """Set points evenly spaced in time: time, q, qd, qdd."""
    time = np.linspace(path.x[0], path.x[-1], n_set_points)
    # A set point on a break misses it by round-off, which must not decide its side: an acceleration that
    # jumps there would depend on the machine.
    nearest = path.x[np.abs(time[:, None] - path.x).argmin(axis=1)]
    instants = np.where(np.abs(time - nearest) < ROUNDING * path.x[-1], nearest, time)
    q, qd, qdd = (path(instants, order) for order in range(3))
    # At the ends the profile's conditions hold by definition, not just to round-off.
    q[0], q[-1] = knots[0], knots[-1]
    for derivative in (qd, qdd)[: profile.rest_orders]:
        derivative[[0, -1]] = 0.0
    return time, q, qd, qdd


def plan_result(planned: Plan) -> Result:
    """Facts of a plan; people see angles in degrees."""
    motion, rows, shortest = planned.trajectory, planned.limits.rows, planned.shortest_duration
    joints = [row.joint for row in rows]
    values = {
        "joint": range(1, len(joints) + 1),
        **attributes_of(joints, "name", "unit"),
        **attributes_of(rows, *_REACHED),
        **attributes_of(joints, *_LIMITS),
    }
    seen = {}
    for name, (first, second, between, units) in _PAIRS.items():
        shown_in = [units.get(joint.unit, joint.unit) for joint in joints]
        seen[f"{name}_unit"] = shown_in
        seen[name] = [
            between.join(_cell(value, unit) for value in pair)
            for *pair, unit in zip(values[first], values[second], shown_in, strict=True)
        ]
    title = "Extremes, between the set points too"
    table = declared_table("plan", "joints", title, values, ["joint", "name", *_PAIRS], seen=seen)
    return Result(
        title=f"Plan {motion.name}",
        facts=(
            Value("trajectory", motion.name),
            Fact("set_points", "Set points", motion.n_set_points, shown="count"),
            Value("knot_times", planned.knot_times),
            Value("shortest_duration", None)
            if shortest is None
            else Fact("shortest_duration", "Shortest duration", shortest, "s"),
            *(Value(name, getattr(motion, name)) for name in ("time", "q", "qd", "qdd")),
        ),
        parts=(table,),
    )


def _cell(value: float | None, unit: str) -> str:
    if value is None:
        return "?"
    scale = math.degrees(1.0) if unit == "°" else 1.0
    return f"{value * scale if abs(value) > _ROUND_OFF else 0.0:.3g}"
