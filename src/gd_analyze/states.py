"""States of an arm: set points of a trajectory, drawn from the arm's limits, or given and checked."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.errors import UsageError
from gd_analyze.given_numbers import LARGEST, are_possible
from gd_analyze.robots import RobotArm, arm_of
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import Array, FloatArray, set_points_last

# What is assumed of an arm that states no limits, where that is asked for: a full turn or half a metre, and
# brisk but ordinary rates.
_RANGE = {"revolute": np.pi, "prismatic": 0.5}
_RATE, _ACCELERATION = 2.0, 5.0


@dataclass(frozen=True, eq=False)
class States:
    """Joint variables, rates and accelerations, and where they come from.

    Parameters
    ----------
    q, qd, qdd
        rad (m) and per s, s^2, shape (..., n); mostly (N, n).
    described
        Where they come from, in plain values: "trajectory", "trajectory_fingerprint" and "set_points", or
        "box", "states" and "seed".
    """

    q: FloatArray
    qd: FloatArray
    qdd: FloatArray
    described: Mapping[str, str | int] = field(default_factory=dict)

    def __len__(self) -> int:
        return len(self.q)

    @property
    def arrays(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """q, qd and qdd."""
        return self.q, self.qd, self.qdd

    @property
    def last(self) -> tuple[Array, Array, Array]:
        """q, qd and qdd with the states last, shape (n, N): how the formulations take them."""
        q, qd, qdd = (set_points_last(np.asarray(x, dtype=float)) for x in self.arrays)
        return q, qd, qdd

    @property
    def in_words(self) -> str:
        """Where they come from, as a sentence would say it."""
        where = self.described
        return in_words(where) if where else f"{len(self)} states"

    def at(self, chosen: Any) -> States:
        """Take some of them, by a slice, numbers or a mask."""
        return States(self.q[chosen], self.qd[chosen], self.qdd[chosen], self.described)

    def joined_by(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> States:
        """Add more, shape (M, n)."""
        more = (np.vstack([self.q, q]), np.vstack([self.qd, qd]), np.vstack([self.qdd, qdd]))
        return States(*more, self.described)

    def evenly(self, most: int) -> States:
        """Take all, or `most` evenly spaced ones."""
        count = len(self)
        return self.at(np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int)))


def in_words(described: Mapping[str, str | int]) -> str:
    """Say where states come from, given `States.described`."""
    if "trajectory" in described:
        return f"{described['set_points']} set points of {described['trajectory']}"
    return f"{described['states']} states drawn from {described['box']}, seed {described['seed']}"


def states_of(trajectory: Trajectory) -> States:
    """Take the set points of a trajectory."""
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


def states_in_box(
    arm: RobotArm | str | Path, count: int = 4000, seed: int = 0, *, assumed: bool = False
) -> States:
    """Draw states evenly from the arm's ranges and its rate and acceleration limits.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    count, seed
        How many; the same seed draws the same.
    assumed
        Whether ordinary limits are assumed where the arm states none.

    Raises
    ------
    UsageError
        If the arm lacks a limit and none shall be assumed.
    """
    arm = arm_of(arm)
    lower, upper, rate, acceleration = (
        arm.limits(what) for what in ("lower", "upper", "rate_limit", "acceleration_limit")
    )
    if not arm.has_all_limits:
        if not assumed:
            raise UsageError(
                f"arm {arm.name} does not state all its limits",
                where=f"arm {arm.name}",
                expected="range, rate and acceleration limits of every joint",
                next_step="add them to the arm file, or name a trajectory",
            )
        ranges = np.array([_RANGE[joint.kind] for joint in arm.joints])
        stated = np.isfinite(lower) & np.isfinite(upper)
        lower, upper = np.where(stated, lower, -ranges), np.where(stated, upper, ranges)
        rate = np.where(np.isfinite(rate), rate, _RATE)
        acceleration = np.where(np.isfinite(acceleration), acceleration, _ACCELERATION)
    random = np.random.default_rng(seed)
    shape = (count, arm.n_joints)
    return States(
        random.uniform(lower, upper, shape),
        random.uniform(-rate, rate, shape),
        random.uniform(-acceleration, acceleration, shape),
        {"box": "the arm's ranges, rate and acceleration limits", "states": count, "seed": seed},
    )


def checked_states(arm: RobotArm, **given: ArrayLike) -> tuple[tuple[int, ...], list[FloatArray]]:
    """Leading shape and arrays of quantities that each have one finite number per joint.

    Raises
    ------
    UsageError
        If one is not of shape (..., n), is of another shape than the first, or holds a number that is not
        finite or too large.
    """
    arrays: list[FloatArray] = []
    for name, values in given.items():
        try:
            array = np.asarray(values, dtype=float)
        except (TypeError, ValueError) as error:
            raise UsageError(f"{name} is not numbers", where=name, found=str(error)) from None
        first = arrays[0].shape if arrays else (*array.shape[:-1], arm.n_joints)
        if array.shape != first:
            leading = "".join(f"{size}, " for size in first[:-1]) if arrays else "..., "
            raise UsageError(
                f"{name} does not fit arm {arm.name}",
                where=name,
                expected=f"shape ({leading}{arm.n_joints})",
                found=str(array.shape),
            )
        if not are_possible(array):
            wrong = ~(np.abs(array) <= LARGEST)
            raise UsageError(
                f"{name} is {'too large' if np.isfinite(array).all() else 'not finite'}",
                where=f"{name}{list(map(int, np.argwhere(wrong)[0]))}",
                expected=f"finite numbers up to {LARGEST:g}",
                found=str(array[wrong][0]),
            )
        arrays.append(array)
    return arrays[0].shape[:-1], arrays
