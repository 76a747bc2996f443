"""The exact model's torque beside the measured one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.decomposition import torque_of
from gd_analyze.errors import UsageError
from gd_analyze.formatting import amount, number, percent
from gd_analyze.measured_torque.friction import Friction, JointFit, fit_joint
from gd_analyze.measured_torque.regimes import direction, far_from_jumps, settled
from gd_analyze.measured_torque.triangle import spread, triangle
from gd_analyze.measured_torque.verdict import Verdict, verdict_of
from gd_analyze.robots import RobotArm, arm_of
from gd_analyze.shown import html_of
from gd_analyze.states import states_of
from gd_analyze.trajectories import Trajectory, trajectory_of
from gd_analyze.trajectories.checks import require_joints
from gd_analyze.vectors import Array, FloatArray, chunks

# Readings of a moving joint from which on friction is fitted: five for each of three terms and a slope.
_FEWEST = 20


@dataclass(frozen=True, eq=False)
class TorqueComparison:
    """Measured torque beside the exact model's, at the set points where all measured joints have a reading.

    Both passed the same filter, and where that has not settled, at the ends of a recording and of its gaps,
    nothing is compared. N m (N where the joint slides), shape (n,) if not said otherwise; nan of a joint
    without a measurement.

    Parameters
    ----------
    arm
        The arm.
    model, measured
        Torque of the exact model, and as measured and filtered, shape (N, n).
    compared
        At how many set points.
    correlation
        Of both.
    slope
        What the model has to be multiplied by to come closest to the measurement, but for an offset.
    bias, rms
        Mean and RMS of measured minus model.
    peak_measured, peak_model
        Largest magnitudes.
    explained
        Share of the measurement's variance that the model explains; negative where there would be less
        variance without the model.
    slope_beside_friction, slope_error
        As slope, friction fitted beside it, and its standard error.
    friction
        Friction and offset fitted to the difference.
    verdicts
        Whether the model is what was measured.
    resembles
        Joint whose model it is instead, from 1; 0 where it is none's.
    """

    arm: RobotArm
    model: FloatArray
    measured: FloatArray
    compared: int
    correlation: FloatArray
    slope: FloatArray
    bias: FloatArray
    rms: FloatArray
    peak_measured: FloatArray
    peak_model: FloatArray
    explained: FloatArray
    slope_beside_friction: FloatArray
    slope_error: FloatArray
    friction: Friction
    verdicts: tuple[Verdict, ...]
    resembles: tuple[int, ...]

    def __repr__(self) -> str:
        return f"TorqueComparison({self.arm.name!r}, {', '.join(self.verdicts)})"

    def _repr_html_(self) -> str:
        """A row per joint, for a notebook."""
        headings = ["joint", "correlation", "slope", "bias", "RMS difference", "explained", "verdict"]
        rows = [
            [
                f"{i + 1} {joint.name}",
                *(number(float(values[i])) for values in (self.correlation, self.slope)),
                *(amount(float(values[i]), joint.effort_unit) for values in (self.bias, self.rms)),
                percent(float(self.explained[i])),
                self.verdicts[i],
            ]
            for i, joint in enumerate(self.arm.joints)
        ]
        return html_of(repr(self), headings, rows, "Measured torque beside the exact model's.")


def compare_torque(
    arm: RobotArm | str | Path, trajectory: Trajectory | str | Path, *, drives: bool | None = None
) -> TorqueComparison:
    """Hold measured torques against the exact model's, and fit friction to what is between them.

    Parameters
    ----------
    arm, trajectory
        The arm, and a motion recorded with its torques; or a shipped name, or the path of a file.
    drives
        Whether the drives' inertia is part of the model; by default where the arm describes drives.

    Raises
    ------
    UsageError
        If no torques were recorded with the motion.
    TrajectoryError
        If the trajectory is of another number of joints.
    """
    arm = arm_of(arm)
    trajectory = trajectory_of(trajectory, arm)
    require_joints(trajectory, arm)
    require_torques(trajectory)
    return compared(arm, trajectory, torque_of(arm, states_of(trajectory), drives=drives))


def require_torques(trajectory: Trajectory) -> None:
    """Check that torques were recorded with a motion.

    Raises
    ------
    UsageError
        If not.
    """
    if trajectory.recording is None or trajectory.recording.torque is None:
        raise UsageError(
            "there are no measured torques to compare with",
            where=f"trajectory {trajectory.name}",
            expected="a recording with a torque of every joint",
            found="a plan" if trajectory.recording is None else "a recording without torques",
            next_step="give a log that has columns of measured torques",
        )


def compared(arm: RobotArm, trajectory: Trajectory, model: FloatArray) -> TorqueComparison:
    """Do `compare_torque` with the exact model's torque at hand, shape (N, n)."""
    measured = torque_measured(trajectory)
    there = is_measured(measured)
    rows = settled(trajectory) & np.isfinite(measured[:, there]).all(axis=1)
    out = _as_they_are(model, measured, rows, there)
    explained_by = out.pop("explained_by")
    n = arm.n_joints
    fits: list[JointFit | None] = [
        _fit(trajectory, i, model[:, i], measured[:, i], rows) if there[i] else None for i in range(n)
    ]
    judged: list[tuple[Verdict, int]] = [
        ("not measured", 0) if fit is None else verdict_of(fit, out["explained"][i], explained_by[i], i)
        for i, fit in enumerate(fits)
    ]

    return TorqueComparison(
        arm=arm,
        model=model,
        measured=measured,
        compared=int(rows.sum()),
        **out,
        slope_beside_friction=np.array([np.nan if fit is None else fit.slope for fit in fits]),
        slope_error=np.array([np.nan if fit is None else fit.slope_error for fit in fits]),
        friction=Friction.of(fits),
        verdicts=tuple(verdict for verdict, _ in judged),
        resembles=tuple(joint for _, joint in judged),
    )


def torque_measured(trajectory: Trajectory) -> FloatArray:
    """Torque as recorded, through the filter where there was one, N m, shape (N, n)."""
    recording = trajectory.recording
    assert recording is not None  # who calls has asked for it
    assert recording.torque is not None
    return recording.torque if recording.torque_filtered is None else recording.torque_filtered


def is_measured(measured: FloatArray) -> Array:
    """Which joints have readings that are not all zero, or not there at all, shape (n,)."""
    there = np.zeros(measured.shape[1], dtype=bool)
    for at in chunks(len(measured)):
        there |= (np.nan_to_num(measured[at]) != 0.0).any(axis=0)
    return there


def _as_they_are(model: FloatArray, measured: FloatArray, rows: Array, there: Array) -> dict[str, Any]:
    """Compare every joint's measurement with every joint's model."""
    count, n = int(rows.sum()), model.shape[1]
    # What is not measured is not looked at, but keeps its place.
    measured = np.where(there, measured, 0.0)

    def columns(at: slice) -> FloatArray:
        used = rows[at]
        return np.column_stack([np.ones(used.sum()), model[at][used], measured[at][used]])

    r = triangle((columns(at) for at in chunks(len(model))), 2 * n + 1)
    of_model, of_measured = r[:, 1 : n + 1], r[:, n + 1 :]
    apart = of_measured[:, :, None] - of_model[:, None, :]
    along, wide = (of_model[1:] * of_measured[1:]).sum(axis=0), spread(of_model)
    by = 1.0 - (np.linalg.norm(apart[1:], axis=0) / spread(of_measured)[:, None]) ** 2
    out = {
        "correlation": along / (wide * spread(of_measured)),
        "slope": along / wide**2,
        "bias": np.diagonal(apart[0]) / r[0, 0],
        "rms": np.diagonal(np.linalg.norm(apart, axis=0)) / np.sqrt(count),
        "peak_measured": _peak(measured, rows),
        "explained": np.diagonal(by),
    }
    out = {name: np.where(there, values, np.nan) for name, values in out.items()}
    return out | {"peak_model": _peak(model, rows), "explained_by": by}


def _peak(torque: FloatArray, rows: Array) -> FloatArray:
    peaks = [np.abs(torque[at][rows[at]]).max(axis=0, initial=0.0) for at in chunks(len(torque))]
    return np.max(peaks, axis=0)


def _fit(
    trajectory: Trajectory, joint: int, model: FloatArray, measured: FloatArray, rows: Array
) -> JointFit:
    """Fit friction to a joint where it moves; where it never does, an offset alone."""
    way = direction(trajectory, joint)
    moving = rows & (way != 0.0) & far_from_jumps(trajectory, way)
    # Three terms and a slope need more readings than their number; ten for each are few, too.
    used = moving if moving.sum() >= _FEWEST else rows
    still = used is rows
    rate = np.zeros_like(way) if still else trajectory.qd[:, joint]
    way = np.zeros_like(way) if still else way
    return fit_joint(model, measured, way, rate, used, trajectory.stretches)
