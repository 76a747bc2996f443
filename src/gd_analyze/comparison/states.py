"""States to compare at: a trajectory's, or random ones within the arm's limits."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.errors import TrajectoryError
from gd_analyze.robots import RobotArm
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray

# Where an arm states no limits: a full turn or half a metre, and brisk but ordinary rates.
_RANGE = {"revolute": np.pi, "prismatic": 0.5}
_RATE, _ACCELERATION = 2.0, 5.0
_SEED = 1987


@dataclass(frozen=True, eq=False)
class States:
    """States of one arm, each of shape (N, n), and where they come from."""

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    origin: str


def states_of(arm: RobotArm, trajectory: Trajectory, most: int) -> States:
    """Take a trajectory's set points; of more than `most`, that many evenly spaced ones.

    Raises
    ------
    TrajectoryError
        If the trajectory is of another number of joints.
    """
    if trajectory.n_joints != arm.n_joints:
        raise TrajectoryError(
            "the trajectory is of another arm",
            where=trajectory.name,
            expected=f"{arm.n_joints} joints ({arm.name})",
            found=f"{trajectory.n_joints} joints",
        )
    count = trajectory.n_set_points
    chosen = np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))
    origin = f"{count} set points of {trajectory.name}"
    if len(chosen) < count:
        origin = f"{len(chosen)} of the {origin}"
    return States(trajectory.q[chosen], trajectory.qd[chosen], trajectory.qdd[chosen], origin)


def random_states(arm: RobotArm, count: int) -> States:
    """Draw states within the arm's limits, the same ones every time."""
    random = np.random.default_rng(_SEED)
    ranges = np.array([_RANGE[joint.kind] for joint in arm.joints])
    lower, upper = arm.limits("lower"), arm.limits("upper")
    stated = np.isfinite(lower) & np.isfinite(upper)
    rates, accelerations = arm.limits("rate_limit"), arm.limits("acceleration_limit")
    rates = np.where(np.isfinite(rates), rates, _RATE)
    accelerations = np.where(np.isfinite(accelerations), accelerations, _ACCELERATION)
    shape = (count, arm.n_joints)
    return States(
        random.uniform(np.where(stated, lower, -ranges), np.where(stated, upper, ranges), shape),
        random.uniform(-rates, rates, shape),
        random.uniform(-accelerations, accelerations, shape),
        f"{count} random states within the arm's limits",
    )
