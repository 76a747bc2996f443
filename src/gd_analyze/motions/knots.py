"""Knots of a planned motion: start, vias and goal, and when each is passed."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import FloatArray, are_possible, array_of
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.limits import ROUNDING, angle, joint_label
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST


def checked_knots(arm: RobotArm, start: ArrayLike, via: Sequence[ArrayLike], goal: ArrayLike) -> FloatArray:
    """Joint variables of start, vias and goal, shape (m, n).

    Raises
    ------
    TrajectoryError
        If a knot has the wrong number of joints, is not finite, lies outside the range of a joint or is
        the same as the one before.
    """
    labels = ["start", *(f"via {k}" for k in range(1, len(via) + 1)), "goal"]
    knots = np.array(
        [_knot(arm, label, knot) for label, knot in zip(labels, [start, *via, goal], strict=True)]
    )
    for before, after, k in zip(labels, labels[1:], range(len(knots)), strict=False):
        if np.abs(knots[k + 1] - knots[k]).max() <= ROUNDING:
            raise wrong_argument(
                f"{before} and {after} are the same",
                after,
                "another position: every stretch of a motion moves",
                "no movement",
                "leave one of the two out, or plan the motions before and after the pause separately",
            )
    return knots


def _knot(arm: RobotArm, label: str, values: ArrayLike) -> FloatArray:
    """Joint variables of a knot, the arm's number of them, finite and within the position limits."""
    try:
        knot = array_of(values, label, TrajectoryError)
    except TrajectoryError:
        raise wrong_argument(
            f"{label} is not a list of numbers", label, "numbers", repr(values)[:80]
        ) from None
    if knot.shape != (arm.n_joints,):
        found = f"{knot.size} values" if knot.ndim == 1 else f"shape {knot.shape}"
        raise wrong_argument(
            f"{label} does not fit arm {arm.name}", label, f"{arm.n_joints} joint variables", found
        )
    if not are_possible(knot):
        what = "too large for any arm" if np.isfinite(knot).all() else "not finite"
        expected = f"finite numbers up to {LARGEST:g}"
        raise wrong_argument(f"{label} is {what}", label, expected, str(knot.tolist()))
    for i, (joint, lower, upper) in enumerate(
        zip(arm.joints, arm.limits("lower"), arm.limits("upper"), strict=True)
    ):
        if not lower - ROUNDING <= knot[i] <= upper + ROUNDING:
            like_degrees = joint.kind == "revolute" and abs(knot[i]) > 2 * math.pi
            raise wrong_argument(
                f"{label} lies outside the range of {joint_label(i + 1, joint.name)}",
                label,
                f"{angle(lower, joint.unit)} .. {angle(upper, joint.unit)}",
                angle(float(knot[i]), joint.unit),
                "joint angles are radians here: convert degrees with numpy.deg2rad"
                if like_degrees
                else "choose a position within the range",
            )
    return knot


def knot_times(arm: RobotArm, knots: FloatArray, duration: float, via_times: ArrayLike | None) -> FloatArray:
    """Instants of the knots, s, shape (m,).

    Time in proportion to the square root of distance is what constant acceleration takes; splines timed
    so (centripetally) overshoot least where short and long stretches meet.
    """
    if via_times is None:
        velocity_limits = arm.limits("velocity_limit")
        weights = 1 / np.where(np.isfinite(velocity_limits), velocity_limits, 1.0)
        shares = np.sqrt((np.abs(np.diff(knots, axis=0)) * weights).max(axis=1))
        times = np.concatenate([[0.0], np.cumsum(shares) / shares.sum() * duration])
        times[-1] = duration
        return times
    inner = np.atleast_1d(np.array(via_times, dtype=float))
    times = np.array([0.0, *inner, duration])
    if len(times) != len(knots) or not (np.diff(times) > ROUNDING * duration).all():
        raise wrong_argument(
            "the instants of the vias do not fit the motion",
            "via_times",
            f"{len(knots) - 2} increasing instants between 0 and {duration:g} s",
            str(inner.tolist()),
        )
    return times


def wrong_argument(
    what: str, argument: str, expected: str, found: str, next_step: str | None = None
) -> TrajectoryError:
    """Error about an argument of a plan."""
    return TrajectoryError(what, where=argument, expected=expected, found=found, next_step=next_step)
