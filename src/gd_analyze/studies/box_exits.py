"""Where and when a motion leaves a box of states."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.motions.limits import ROUNDING, Quantity, Violation
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True)
class BoxExit:
    """One limit of a box that set points of one joint lie beyond; SI and radians.

    Parameters
    ----------
    farthest
        The set point farthest beyond it: joint, quantity, value, limit and instant.
    set_points
        How many lie beyond it.
    first
        Instant of the first of them, s.
    begin, end
        The longest stretch of them, s: its first and its last set point, with none within the box and no gap
        between.
    """

    farthest: Violation
    set_points: int
    first: float
    begin: float
    end: float


def box_exits(arm: RobotArm, trajectory: Trajectory, box: Box) -> tuple[tuple[BoxExit, ...], Array]:
    """Find the set points of a motion that lie outside a box.

    Less than a rounded digit beyond a limit is no exit, as for the limits of the arm.

    Returns
    -------
    exits, outside
        One per joint and limit that is exceeded, in this order; and whether each set point lies outside,
        shape (N,).
    """
    found, outside = [], np.zeros(trajectory.n_set_points, dtype=bool)
    for joint in range(arm.n_joints):
        for quantity, values, limit, side in _sides(trajectory, box, joint):
            excess = side * (values - limit)
            beyond = excess > ROUNDING * max(1.0, abs(limit))
            if not beyond.any():
                continue
            outside |= beyond
            most, about = int(excess.argmax()), arm.joints[joint]
            unit = about.unit + {"position": "", "rate": "/s", "acceleration": "/s^2"}[quantity]
            value, instant = float(values[most]), float(trajectory.time[most])
            farthest = Violation(joint + 1, about.name, quantity, value, limit, instant, unit)
            first, last = _longest(beyond, trajectory.time, trajectory.stretches)
            at = np.flatnonzero(beyond)
            found.append(
                BoxExit(farthest, len(at), *(float(trajectory.time[k]) for k in (at[0], first, last)))
            )
    return tuple(found), outside


def _sides(trajectory: Trajectory, box: Box, joint: int) -> Iterator[tuple[Quantity, FloatArray, float, int]]:
    """Values of one joint, the limit of each kind, and on which side of it outside is."""
    q, rate, acceleration = trajectory.q[:, joint], trajectory.qd[:, joint], trajectory.qdd[:, joint]
    yield "position", q, float(box.lower[joint]), -1
    yield "position", q, float(box.upper[joint]), 1
    yield "rate", np.abs(rate), float(box.velocity[joint]), 1
    yield "acceleration", np.abs(acceleration), float(box.acceleration[joint]), 1


def _longest(beyond: Array, time: FloatArray, stretches: Sequence[slice]) -> tuple[int, int]:
    """First and last set point of the longest run; the first one where several last as long."""
    runs = []
    for stretch in stretches:
        padded = np.concatenate([[False], beyond[stretch], [False]])
        edges = np.flatnonzero(padded[1:] != padded[:-1]) + stretch.start
        runs += [(first, end - 1) for first, end in list(pairwise(edges.tolist()))[::2]]
    return max(runs, key=lambda run: time[run[1]] - time[run[0]])
