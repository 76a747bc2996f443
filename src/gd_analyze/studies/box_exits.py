"""Where a motion leaves a box of states, and which states lie outside."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, runs
from gd_analyze.certification.box import Box
from gd_analyze.motions.limits import ROUNDING, LimitedQuantity, Violation
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True)
class BoxExit:
    """A limit of a box exceeded by set points of one joint; SI and radians."""

    farthest: Violation  # at the set point farthest beyond it
    set_points: int  # number beyond it
    first: float  # instant of the first one, s
    begin: float  # start of the longest uninterrupted stretch beyond it, s
    end: float  # end of that stretch, s


class _Side(NamedTuple):
    """One limit of a box, and states beyond it by more than a rounded digit."""

    joint: int  # from 0
    quantity: LimitedQuantity
    unit: str
    limit: float
    values: FloatArray
    excess: FloatArray
    beyond: NDArray[np.bool_]


def _sides(arm: RobotArm, box: Box, *states: FloatArray) -> Iterator[_Side]:
    """Limits that some of the states q, qd, qdd (N, n) exceed."""
    for i, joint in enumerate(arm.joints):
        q, qd, qdd = (array[:, i] for array in states)
        # Values, limit, sign of the outside, and the power of time in the joint's unit.
        limits: tuple[tuple[LimitedQuantity, FloatArray, float, int, str], ...] = (
            ("position", q, float(box.lower[i]), -1, ""),
            ("position", q, float(box.upper[i]), 1, ""),
            ("velocity", np.abs(qd), float(box.velocity[i]), 1, "/s"),
            ("acceleration", np.abs(qdd), float(box.acceleration[i]), 1, "/s^2"),
        )
        for quantity, values, limit, sign, per in limits:
            excess = sign * (values - limit)
            beyond = excess > ROUNDING * max(1.0, abs(limit))
            if beyond.any():
                yield _Side(i, quantity, joint.unit + per, limit, values, excess, beyond)


def outside_of(arm: RobotArm, box: Box, states: States) -> NDArray[np.bool_]:
    """Whether each state lies outside a box, shape (N,)."""
    sides = (side.beyond for side in _sides(arm, box, *states.arrays))
    return np.logical_or.reduce([np.zeros(len(states), dtype=bool), *sides])


def box_exits(arm: RobotArm, trajectory: Trajectory, box: Box) -> tuple[BoxExit, ...]:
    """Find where a motion leaves a box, by joint and limit."""
    exits, time = [], trajectory.time
    for side in _sides(arm, box, trajectory.q, trajectory.qd, trajectory.qdd):
        index, name = int(side.excess.argmax()), arm.joints[side.joint].name
        values = float(side.values[index]), side.limit, float(time[index]), side.unit
        farthest = Violation(side.joint + 1, name, side.quantity, *values)
        spans: list[tuple[float, float]] = []
        for stretch in trajectory.stretches:
            outside = runs(side.beyond[stretch]) + stretch.start
            spans += [(float(time[first]), float(time[end - 1])) for first, end in outside]
        longest = max(spans, key=lambda span: span[1] - span[0])
        exits.append(BoxExit(farthest, int(side.beyond.sum()), spans[0][0], *longest))
    return tuple(exits)
