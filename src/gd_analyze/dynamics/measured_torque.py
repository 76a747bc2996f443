"""Exact and measured torque compared joint by joint; `diagnose` says why they differ."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.friction import NOT_FITTED, Friction, JointFriction, fit_joint
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.measured import (
    directions,
    far_from_jumps,
    filtered_torque,
    require_torques,
    settled,
)
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.text import amount, html_of, percent
from gd_analyze.threads import one_thread

# Least readings to compare a joint, and to fit friction to a moving one: five per term and for the spread.
_FEWEST_READINGS = 20
# A torque that varies by less than this share of its size is constant: round-off of a million terms.
_CONSTANT_SHARE = 1e-12


@dataclass(frozen=True, eq=False)
class TorqueComparison:
    """Measured torque compared with the exact model's, at the set points where a joint has a reading.

    Both passed the same filter; where it has not settled, at the ends of a recording and of its gaps,
    nothing is compared. N m (N for a prismatic joint), shape (n,) unless stated otherwise; nan for a joint
    without a measurement: fewer than twenty readings, or only zeros.

    Parameters
    ----------
    arm
        The arm.
    model, measured
        Torque of the exact model, and torque as measured and filtered, shape (N, n).
    compared
        Largest number of set points compared; fewer at joints that lack readings.
    bias, rms
        Mean and RMS of measured minus model.
    peak_measured, rms_measured
        Largest measured magnitude, and RMS measured.
    explained
        Share of the measured variance that the model explains; negative if the model increases it.
    friction
        Friction and offset fitted to the difference.
    """

    arm: RobotArm
    model: FloatArray
    measured: FloatArray
    compared: int
    bias: FloatArray
    rms: FloatArray
    peak_measured: FloatArray
    rms_measured: FloatArray
    explained: FloatArray
    friction: Friction

    def __repr__(self) -> str:
        return f"TorqueComparison({self.arm.name!r}, {self.compared} set points)"

    def _repr_html_(self) -> str:
        """A row per joint, for a notebook."""
        headings = ["joint", "bias", "RMS difference", "beside friction", "explained"]
        rows = [
            [
                f"{i + 1} {joint.name}",
                *(
                    amount(float(values[i]), joint.effort_unit)
                    for values in (self.bias, self.rms, self.friction.rms)
                ),
                percent(float(self.explained[i])),
            ]
            for i, joint in enumerate(self.arm.joints)
        ]
        return html_of(repr(self), headings, rows, "Measured torque compared with the exact model's.")


@strict
@one_thread()
def compare_torque(
    arm: RobotArm | str | Path, trajectory: Trajectory | str | Path, *, drives: bool | None = None
) -> TorqueComparison:
    """Compare measured torques with the exact model's, and fit friction to the difference.

    `diagnose` says whether they agree, and why not.

    Parameters
    ----------
    arm, trajectory
        The arm, and a motion recorded with its torques; or a shipped name, or the path of a file.
    drives
        Include the drives' inertia in the model; by default if the arm describes drives.

    Returns
    -------
    TorqueComparison
        Differences and friction by joint.

    Raises
    ------
    UsageError
        If no torques were recorded with the motion.
    TrajectoryError
        If the trajectory has another number of joints.
    """
    arm = arm_with_masses(arm)
    trajectory = trajectory_of(trajectory, arm)
    require_trajectory_joints(trajectory, arm)
    require_torques(trajectory)
    return compared(arm, trajectory, torque_of(arm, states_of(trajectory), drives=drives))


def compared(arm: RobotArm, trajectory: Trajectory, model: FloatArray) -> TorqueComparison:
    """Compare measured torques with given torques of the exact model, shape (N, n)."""
    measured, n = filtered_torque(trajectory), arm.n_joints
    used = settled(trajectory)[:, None] & np.isfinite(measured)
    counts = used.sum(axis=0)
    is_measured = (counts >= _FEWEST_READINGS) & (used & (measured != 0.0)).any(axis=0)
    numbers = np.full((5, n), np.nan)
    fits, signs = [NOT_FITTED] * n, directions(trajectory)
    for i in np.flatnonzero(is_measured).tolist():
        readings = measured[used[:, i], i]
        difference = readings - model[used[:, i], i]
        size, spread = np.abs(readings).max(), readings.std()
        explained = 1.0 - difference.var() / spread**2 if spread > _CONSTANT_SHARE * size else np.nan
        rms, rms_measured = (float(np.sqrt(np.mean(x**2))) for x in (difference, readings))
        numbers[:, i] = difference.mean(), rms, size, rms_measured, explained
        fits[i] = _friction(trajectory, i, signs[:, i], model[:, i], measured[:, i], used[:, i])
    biases, rms_differences, peaks, rms_readings, explained_shares = numbers
    return TorqueComparison(
        arm=arm,
        model=model,
        measured=measured,
        compared=int(counts[is_measured].max(initial=0)),
        bias=biases,
        rms=rms_differences,
        peak_measured=peaks,
        rms_measured=rms_readings,
        explained=explained_shares,
        friction=Friction.of(fits),
    )


def with_friction_fitted(comparison: TorqueComparison, trajectory: Trajectory) -> FloatArray:
    """Torque of the model and the friction fitted beside it, (N, n); nan where a joint rests or creeps."""
    sign, friction = directions(trajectory), np.nan_to_num(comparison.friction.terms)
    coulomb, viscous, offset = friction.T
    torque = comparison.model + coulomb * sign + viscous * trajectory.qd + offset
    return np.where(sign != 0, torque, np.nan)


def _friction(
    trajectory: Trajectory,
    joint: int,
    sign: Array,
    model: FloatArray,
    measured: FloatArray,
    used: Array,
) -> JointFriction:
    """Friction of one joint, from 0; an offset alone where it stands still."""
    velocity = trajectory.qd[:, joint]
    moving = used & (sign != 0) & far_from_jumps(trajectory, sign)
    if moving.sum() < _FEWEST_READINGS:
        sign, velocity, moving = np.zeros_like(sign), np.zeros_like(sign), used
    return fit_joint(model, measured, sign, velocity, moving, trajectory.stretches)
