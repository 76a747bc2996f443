"""The states a model shall be good for: set points of a trajectory, or states drawn from a box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gd_analyze.decomposition import decompose_states
from gd_analyze.errors import UsageError
from gd_analyze.robots import RobotArm
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray


@dataclass(frozen=True, eq=False)
class States:
    """Positions, rates and accelerations, shape (N, n), and where they come from."""

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    described: Mapping[str, str | int]

    def torque(self, arm: RobotArm, drives: bool) -> FloatArray:
        """Exact torque, N m, shape (N, n)."""
        return decompose_states(arm, self.q, self.qd, self.qdd, coupling=False, drives=drives)["torque"]


def states_of(trajectory: Trajectory) -> States:
    """Set points of a trajectory."""
    return States(
        trajectory.q,
        trajectory.qd,
        trajectory.qdd,
        {
            "trajectory": trajectory.name,
            "trajectory_fingerprint": trajectory.fingerprint,
            "set_points": trajectory.n_set_points,
        },
    )


def states_in_box(arm: RobotArm, count: int = 4000, seed: int = 0) -> States:
    """States drawn evenly from the arm's ranges and its rate and acceleration limits.

    Raises
    ------
    UsageError
        If the arm lacks a limit.
    """
    lower, upper, rate, acceleration = (
        arm.limits(what) for what in ("lower", "upper", "rate_limit", "acceleration_limit")
    )
    if not np.isfinite([lower, upper, rate, acceleration]).all():
        raise UsageError(
            f"arm {arm.name} does not state all its limits",
            where=f"arm {arm.name}",
            expected="range, rate and acceleration limits of every joint",
            next_step="add them to the arm file, or simplify along a trajectory",
        )
    random = np.random.default_rng(seed)
    shape = (count, arm.n_joints)
    return States(
        random.uniform(lower, upper, shape),
        random.uniform(-rate, rate, shape),
        random.uniform(-acceleration, acceleration, shape),
        {"box": "the arm's ranges, rate and acceleration limits", "states": count, "seed": seed},
    )
