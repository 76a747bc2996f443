"""Motion by motion: torque, error and verdicts of a run over several motions, as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import FloatArray, round_off_of
from gd_analyze.dynamics.dominance import rank
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.motions.motions import Motion
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import table
from gd_analyze.simplification.accuracy import Accuracy

if TYPE_CHECKING:
    import xarray as xr

# What is told of a motion besides.
_ABOUT = ("start", "origin", "rates_from", "fingerprint")
# What of the ranking of the elements is told motion by motion.
_RANKED = ("verdict", "dominant", "torque_share", "torque_joint")


def rank_by_motion(
    arm: RobotArm, dataset: xr.Dataset, trajectory: Trajectory, allowed: Sequence[FloatArray]
) -> list[xr.Dataset]:
    """Rank the elements along each motion by itself, given what the budget allows there, N m, shape (n,)."""
    alone = [_alone(arm, dataset, motion) for motion in trajectory.motions]
    return [rank(part, budget=budget) for part, budget in zip(alone, allowed, strict=True)]


def motions_table(
    arm: RobotArm,
    trajectory: Trajectory,
    dominance: xr.Dataset,
    ranked: Sequence[xr.Dataset],
    accuracy: Accuracy,
) -> xr.Dataset:
    """Tabulate what is found along each motion by itself.

    Parameters
    ----------
    arm, trajectory
        The arm, and its motions one after the other.
    dominance, ranked
        The ranking of the elements over all of them, whose order is kept, and along each.
    promise
        Of the model.
    """
    along, labels = accuracy.motions, dominance.element.values
    ranked = [one.sel(element=labels) for one in ranked]
    turning = arm.is_revolute
    columns: dict[str, Any] = {
        name: np.stack([one[name].values for one in ranked], axis=1) for name in _RANKED
    }
    times = [trajectory.time[motion.rows] for motion in trajectory.motions]
    return table(
        "motions",
        {
            "set_points": [motion.n_set_points for motion in trajectory.motions],
            "duration": [float(time[-1] - time[0]) for time in times],
            "peak_torque": np.array([one.errors.peak_torque for one in along]),
            "allowed_error": np.array([one.allowed for one in along]),
            "largest_error": np.array([one.errors.largest for one in along]),
            "rms_error": np.array([one.errors.rms for one in along]),
            **columns,
        },
        turning,
        {
            "motion": [motion.name for motion in trajectory.motions],
            **{
                f"motion_{name}": ("motion", [getattr(motion, name) for motion in trajectory.motions])
                for name in _ABOUT
            },
            "joint_name": ("joint", [joint.name for joint in arm.joints]),
            "element": labels,
            "quantity": ("element", dominance.quantity.values),
        },
    )


def motions_in(motions: xr.Dataset) -> tuple[Motion, ...]:
    """Which set points are whose, of the table."""
    ends = np.cumsum(motions.set_points.values).tolist()
    rows = zip(motions.motion.values.tolist(), [0, *ends[:-1]], ends, strict=True)
    described = zip(
        *(motions[f"motion_{name}"].values.tolist() for name in _ABOUT),
        strict=True,
    )
    return tuple(Motion(*row, *more) for row, more in zip(rows, described, strict=True))


def _alone(arm: RobotArm, dataset: xr.Dataset, motion: Motion) -> xr.Dataset:
    """The decomposition of one motion, and what is round-off there."""
    part = dataset.isel(time=motion.rows)
    states = (part[name].values for name in ("q", "qd", "qdd"))
    bound = round_off_bounds(arm, *states)["torque"]
    return part.assign_attrs(torque_round_off=round_off_of(part.torque.values, bound))
