"""The exact model's torque beside the measured one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gd_analyze.arrays import Array, FloatArray, chunks
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.friction import Friction, JointFit, fit_joint
from gd_analyze.dynamics.regimes import direction, far_from_jumps, settled
from gd_analyze.dynamics.torque_verdict import Verdict, verdict_of
from gd_analyze.dynamics.triangle import spread, triangle
from gd_analyze.errors import UsageError
from gd_analyze.motions.checks import require_joints
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.text import amount, html_of, number, percent

# Readings from which on a joint is judged, and friction fitted to a moving one: five for each of three terms
# and a slope.
_FEWEST = 20


@dataclass(frozen=True, eq=False)
class TorqueComparison:
    """Measured torque beside the exact model's, at the set points where a joint has a reading.

    Both passed the same filter, and where that has not settled, at the ends of a recording and of its gaps,
    nothing is compared. N m (N where the joint slides), shape (n,) if not said otherwise; nan of a joint
    without a measurement: with fewer than twenty readings, or none but zeros.

    Parameters
    ----------
    arm
        The arm.
    model, measured
        Torque of the exact model, and as measured and filtered, shape (N, n).
    compared
        At how many set points, at most: at fewer where a joint lacks readings.
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
    measured, inside = torque_measured(trajectory), settled(trajectory)
    joints = [_of_joint(trajectory, i, model, measured[:, i], inside) for i in range(arm.n_joints)]

    def each(name: str) -> FloatArray:
        return np.array([getattr(joint, name) for joint in joints])

    return TorqueComparison(
        arm=arm,
        model=model,
        measured=measured,
        compared=max(joint.compared for joint in joints),
        **{name: each(name) for name in _NUMBERS},
        slope_beside_friction=np.array([np.nan if one.fit is None else one.fit.slope for one in joints]),
        slope_error=np.array([np.nan if one.fit is None else one.fit.slope_error for one in joints]),
        friction=Friction.of([joint.fit for joint in joints]),
        verdicts=tuple(joint.verdict for joint in joints),
        resembles=tuple(joint.resembles for joint in joints),
    )


def torque_measured(trajectory: Trajectory) -> FloatArray:
    """Torque as recorded, through the filter where there was one, N m, shape (N, n)."""
    recording = trajectory.recording
    assert recording is not None  # who calls has asked for it
    assert recording.torque is not None
    return recording.torque if recording.torque_filtered is None else recording.torque_filtered


@dataclass(frozen=True, eq=False)
class _Joint:
    """One joint's part of a `TorqueComparison`; None in place of a fit where nothing was measured."""

    peak_model: float
    compared: int = 0
    correlation: float = np.nan
    slope: float = np.nan
    bias: float = np.nan
    rms: float = np.nan
    peak_measured: float = np.nan
    explained: float = np.nan
    fit: JointFit | None = None
    verdict: Verdict = "not measured"
    resembles: int = 0


_NUMBERS = ("correlation", "slope", "bias", "rms", "peak_measured", "peak_model", "explained")


def _of_joint(
    trajectory: Trajectory, joint: int, model: FloatArray, measured: FloatArray, inside: Array
) -> _Joint:
    """Compare one joint's measurement, shape (N,), with its own model and, to judge it, with all."""
    rows = inside & np.isfinite(measured)
    count, n = int(rows.sum()), model.shape[1]
    peak = _peak(model[:, joint], inside)
    if count < _FEWEST or not measured[rows].any():
        return _Joint(peak)

    def columns(at: slice) -> FloatArray:
        used = rows[at]
        return np.column_stack([np.ones(used.sum()), model[at][used], measured[at][used]])

    r = triangle((columns(at) for at in chunks(len(model))), n + 2)
    of_models, of_measured = r[:, 1:-1], r[:, -1:]
    apart = of_measured - of_models
    along = float(of_models[1:, joint] @ of_measured[1:, 0])
    wide, spread_measured = float(spread(of_models)[joint]), float(spread(of_measured)[0])
    explained_by = 1.0 - (np.linalg.norm(apart[1:], axis=0) / spread_measured) ** 2
    fit = _fit(trajectory, joint, model[:, joint], measured, rows)
    verdict, resembles = verdict_of(fit, float(explained_by[joint]), explained_by, joint)
    return _Joint(
        peak,
        count,
        correlation=along / (wide * spread_measured),
        slope=along / wide**2,
        bias=float(apart[0, joint] / r[0, 0]),
        rms=float(np.linalg.norm(apart[:, joint])) / np.sqrt(count),
        peak_measured=_peak(measured, rows),
        explained=float(explained_by[joint]),
        fit=fit,
        verdict=verdict,
        resembles=resembles,
    )


def _peak(torque: FloatArray, rows: Array) -> float:
    return float(np.abs(torque[rows]).max(initial=0.0))


def _fit(
    trajectory: Trajectory, joint: int, model: FloatArray, measured: FloatArray, rows: Array
) -> JointFit:
    """Fit friction to a joint where it moves; where it never does, an offset alone."""
    way = direction(trajectory, joint)
    moving = rows & (way != 0.0) & far_from_jumps(trajectory, way)
    used = moving if moving.sum() >= _FEWEST else rows
    still = used is rows
    rate = np.zeros_like(way) if still else trajectory.qd[:, joint]
    way = np.zeros_like(way) if still else way
    return fit_joint(model, measured, way, rate, used, trajectory.stretches)
