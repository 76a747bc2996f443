"""The states a model shall be good for: set points of a trajectory, or states drawn from a box."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.robots import RobotArm
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class States:
    """Positions, rates and accelerations, shape (N, n), where they come from, and their exact dynamics.

    `decomposed` is what `decompose` gave for them where it is at hand, None otherwise.
    """

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    described: Mapping[str, str | int]
    decomposed: Mapping[Any, Any] | None = None

    @property
    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """q, qd and qdd."""
        return self.q, self.qd, self.qdd


def states_of(given: Trajectory | xr.Dataset) -> States:
    """Set points of a trajectory, or of its decomposition, which then need not be made again."""
    if isinstance(given, Trajectory):
        return States(
            given.q,
            given.qd,
            given.qdd,
            {
                "trajectory": given.name,
                "trajectory_fingerprint": given.fingerprint,
                "set_points": given.n_set_points,
            },
        )
    return States(
        given["q"].values,
        given["qd"].values,
        given["qdd"].values,
        {
            "trajectory": given.attrs["trajectory"],
            "trajectory_fingerprint": given.attrs["trajectory_fingerprint"],
            "set_points": given.sizes["time"],
        },
        given,
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
    if not arm.has_all_limits:
        raise UsageError(
            f"arm {arm.name} does not state all its limits",
            where=f"arm {arm.name}",
            expected="range, rate and acceleration limits of every joint",
            next_step="add them to the arm file, or name a trajectory",
        )
    random = np.random.default_rng(seed)
    shape = (count, arm.n_joints)
    return States(
        random.uniform(lower, upper, shape),
        random.uniform(-rate, rate, shape),
        random.uniform(-acceleration, acceleration, shape),
        {"box": "the arm's ranges, rate and acceleration limits", "states": count, "seed": seed},
    )
