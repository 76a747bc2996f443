"""Exact and measured torque compared joint by joint, with a verdict."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray, chunks
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.friction import (
    NOT_FITTED,
    Friction,
    JointFit,
    fit_joint,
    independent,
    reduced,
    spread,
    triangle,
)
from gd_analyze.errors import UsageError
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.motions.smoothing import noise_of
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.text import amount, html_of, number, percent
from gd_analyze.threads import one_thread

Verdict = Literal[
    "follows",
    "follows but for friction",
    "too light",
    "too heavy",
    "other sign",
    "another joint's",
    "lacks drive inertia",
    "below friction",
    "stands still",
    "does not follow",
    "not measured",
]
# Verdicts caused by the robot file, or by how the log was read.
CONTRADICTING = (
    "too light", "too heavy", "other sign", "another joint's", "lacks drive inertia", "does not follow",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class _VerdictSettings:
    """Limits between the verdicts on a joint's measured torque, and which readings count."""

    # Share of the measured variance above which the model alone is enough: the residual is, as RMS, less than
    # a third (sqrt(0.1)) of the measured torque.
    followed_variance: float = 0.9
    # Correlation after friction above which the model's torque is present: it explains two thirds (0.8^2) of
    # the remaining variance.
    present_correlation: float = 0.8
    # Factor up to which model and measurement are equal: torque constants and gear efficiencies, which
    # convert currents to torques, are known to some 20 %.
    equal_factor: float = 4.0 / 3.0
    # Friction is Coulomb and viscous to within this share: it also depends on load, temperature and position.
    friction_tolerance: float = 0.2
    # The residual after friction follows the joint's acceleration if that explains this share of its
    # variance.
    inertia_variance: float = 0.3
    # Largest ratio of the variance that it then leaves to the one that a scaled model leaves.
    inertia_to_scaled_model: float = 0.8
    # Least readings to judge a joint, and to fit friction to a moving one: five per term and for a slope.
    fewest_readings: int = 20
    # A zero-phase low-pass spreads a jump over half a period of its cut-off, where a Butterworth filter
    # leaves some hundredths of it.
    settling_periods: float = 0.5
    # Noise determines the sign of a velocity beyond this many of its standard deviations in one of 1000
    # readings.
    noise_sigmas: float = 3.0
    # A joint below this share of its largest velocity does not slip yet: teeth and bearings stick and creep
    # first, so that friction grows with velocity before it is Coulomb friction. B. Armstrong-Helouvry, P.
    # Dupont, C. Canudas de Wit, A survey of models, analysis tools and compensation methods for the control
    # of machines with friction, Automatica 30 (1994).
    creeping_share: float = 0.05


_VERDICTS = _VerdictSettings()


# Standard errors that make a difference significant.
SIGMAS = 3.0


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
    correlation
        Correlation of both.
    slope
        Factor on the model that fits the measurement best, with an offset.
    bias, rms
        Mean and RMS of measured minus model.
    peak_measured, peak_model
        Largest magnitudes.
    explained
        Share of the measured variance that the model explains; negative if the model increases it.
    slope_beside_friction, slope_error
        Slope fitted together with friction, and its standard error.
    friction
        Friction and offset fitted to the difference.
    drive_inertia
        Drive inertia at the joint that fits the difference left after friction; nan if none does.
    noise
        Noise left in `measured`, standard deviation; nan for a plan.
    verdicts
        Verdict on every joint, see docs/diagnose.md, "Measured torques".
    resembles
        Joint whose model the measurement resembles, from 1; 0 if none.
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
    drive_inertia: FloatArray
    noise: FloatArray
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
        return html_of(repr(self), headings, rows, "Measured torque compared with the exact model's.")


@strict
@one_thread()
def compare_torque(
    arm: RobotArm | str | Path, trajectory: Trajectory | str | Path, *, drives: bool | None = None
) -> TorqueComparison:
    """Compare measured torques with the exact model's, and fit friction to the difference.

    Parameters
    ----------
    arm, trajectory
        The arm, and a motion recorded with its torques; or a shipped name, or the path of a file.
    drives
        Include the drives' inertia in the model; by default if the arm describes drives.

    Returns
    -------
    TorqueComparison
        Differences, friction and a verdict by joint.

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


def require_torques(trajectory: Trajectory) -> None:
    """Check that torques were recorded with a motion."""
    if trajectory.recording is None or trajectory.recording.torque is None:
        raise UsageError(
            "there are no measured torques to compare with",
            where=f"trajectory {trajectory.name}",
            expected="a recording with a torque of every joint",
            found="a plan" if trajectory.recording is None else "a recording without torques",
            next_step="give a log with columns of measured torques",
        )


def compared(arm: RobotArm, trajectory: Trajectory, model: FloatArray) -> TorqueComparison:
    """Compare measured torques with given torques of the exact model, shape (N, n)."""
    recording = trajectory.recording
    assert recording is not None  # callers check this
    measured = recording.torque if recording.torque_filtered is None else recording.torque_filtered
    assert measured is not None
    wait = _settling(trajectory)
    inside = np.ones(trajectory.n_set_points, dtype=bool)
    for stretch in trajectory.stretches:
        time = trajectory.time[stretch]
        inside[stretch] = (time - time[0] >= wait) & (time[-1] - time >= wait)
    if not inside.any():
        inside[:] = True
    joints = [_of_joint(trajectory, i, model, measured[:, i], inside) for i in range(arm.n_joints)]
    fits = [joint["fit"] for joint in joints]
    return TorqueComparison(
        arm=arm,
        model=model,
        measured=measured,
        compared=max(joint["compared"] for joint in joints),
        **{name: np.array([joint[name] for joint in joints]) for name in _NUMBERS},
        slope_beside_friction=np.array([fit.slope for fit in fits]),
        slope_error=np.array([fit.slope_error for fit in fits]),
        friction=Friction.of(fits),
        noise=_noise(trajectory, measured),
        verdicts=tuple(joint["verdict"] for joint in joints),
        resembles=tuple(joint["resembles"] for joint in joints),
    )


_NUMBERS = (
    "correlation", "slope", "bias", "rms", "peak_measured", "peak_model", "explained", "drive_inertia",
)  # fmt: skip
# Results for a joint without measurement, except its model's peak torque.
_UNKNOWN = dict.fromkeys(_NUMBERS, np.nan) | {"compared": 0, "fit": NOT_FITTED, "resembles": 0}


def _of_joint(
    trajectory: Trajectory, joint: int, model: FloatArray, measured: FloatArray, inside: Array
) -> dict[str, Any]:
    """Compare one joint's measurement, shape (N,), with its own model and those of all joints."""
    rows = inside & np.isfinite(measured)
    count, n = int(rows.sum()), model.shape[1]
    peak_model = float(np.abs(model[inside, joint]).max(initial=0.0))
    if count < _VERDICTS.fewest_readings or not measured[rows].any():
        return _UNKNOWN | {"peak_model": peak_model, "verdict": "not measured"}

    def columns(at: slice) -> FloatArray:
        used = rows[at]
        return np.column_stack([np.ones(used.sum()), model[at][used], measured[at][used]])

    r = triangle((columns(at) for at in chunks(len(model))), n + 2)
    of_models, of_measured = r[:, 1:-1], r[:, -1:]
    difference = of_measured - of_models
    along = float(of_models[1:, joint] @ of_measured[1:, 0])
    spread_model, spread_measured = float(spread(of_models)[joint]), float(spread(of_measured)[0])
    explained_by = 1.0 - (np.linalg.norm(difference[1:], axis=0) / spread_measured) ** 2
    sign, velocity = direction(trajectory, joint), trajectory.qd[:, joint]
    moving = rows & (sign != 0.0) & _far_from_jumps(trajectory, sign)
    is_still = bool(moving.sum() < _VERDICTS.fewest_readings)
    if is_still:  # an offset alone is fitted
        sign, velocity, moving = np.zeros_like(sign), np.zeros_like(sign), rows
    fit = fit_joint(model[:, joint], measured, sign, velocity, moving, trajectory.stretches)
    inertia = _drive_inertia(model[:, joint], measured, sign, velocity, trajectory.qdd[:, joint], moving)
    verdict, resembles = _verdict(fit, explained_by, joint)
    if not np.isnan(inertia) and verdict != "follows":
        verdict, resembles = "lacks drive inertia", 0
    if is_still and verdict == "below friction":
        verdict = "stands still"
    return {
        "compared": count,
        "correlation": along / (spread_model * spread_measured),
        "slope": along / spread_model**2,
        "bias": float(difference[0, joint] / r[0, 0]),
        "rms": float(np.linalg.norm(difference[:, joint])) / np.sqrt(count),
        "peak_measured": float(np.abs(measured[rows]).max()),
        "peak_model": peak_model,
        "explained": float(explained_by[joint]),
        "fit": fit,
        "verdict": verdict,
        "resembles": resembles,
        "drive_inertia": inertia,
    }


def _verdict(fit: JointFit, explained_by: FloatArray, joint: int) -> tuple[Verdict, int]:
    """Judge a joint (from 0); also return the joint, from 1, whose model it resembles, or 0.

    `explained_by` is the share of the measured variance that every joint's model explains.
    """
    if explained_by[joint] >= _VERDICTS.followed_variance:
        return "follows", 0
    best = float(np.delete(explained_by, joint).max(initial=-np.inf))
    if best >= max(_VERDICTS.followed_variance, fit.explained):
        return "another joint's", int(np.flatnonzero(explained_by == best)[0]) + 1
    if np.isfinite(fit.slope) and abs(fit.slope) > SIGMAS * fit.slope_error:
        if fit.partial <= -_VERDICTS.present_correlation:
            return "other sign", 0
        if fit.partial >= _VERDICTS.present_correlation:
            is_significant = abs(fit.slope - 1.0) > SIGMAS * fit.slope_error
            if fit.slope > _VERDICTS.equal_factor and is_significant:
                return "too light", 0
            is_too_heavy = fit.slope < 1.0 / _VERDICTS.equal_factor and is_significant
            return ("too heavy" if is_too_heavy else "follows but for friction"), 0
    # If the model were right, at least its own torque would remain after friction.
    is_hidden = fit.model_rms <= max(fit.measured_rms, _VERDICTS.friction_tolerance * fit.like_friction)
    return ("below friction" if is_hidden else "does not follow"), 0


def _drive_inertia(
    model: FloatArray,
    measured: FloatArray,
    sign: FloatArray,
    velocity: FloatArray,
    qdd: FloatArray,
    used: Array,
) -> float:
    """Factor of qdd that explains the residual clearly better than scaling the model; or nan."""

    def columns(at: slice) -> FloatArray:
        model_torque = model[at]
        return np.column_stack(
            [
                np.ones(len(model_torque)),
                sign[at],
                velocity[at],
                qdd[at],
                model_torque,
                measured[at] - model_torque,
            ]
        )[used[at]]

    r = triangle((columns(at) for at in chunks(len(model))), 6)
    terms = independent(r, (0, 1, 2))
    if independent(r, [*terms, 3])[-1:] != [3]:
        return np.nan
    before, after, heavier = (
        float(reduced(r[:, [*regressors, 5]])[-1, -1]) ** 2
        for regressors in (terms, [*terms, 3], [*terms, 4])
    )
    inertia = float(np.linalg.lstsq(r[:, [*terms, 3]], r[:, 5], rcond=None)[0][-1])
    most = min((1.0 - _VERDICTS.inertia_variance) * before, _VERDICTS.inertia_to_scaled_model * heavier)
    return inertia if inertia > 0.0 and after <= most else np.nan


def _noise(trajectory: Trajectory, filtered: FloatArray) -> FloatArray:
    """Standard deviation of the noise that the filter leaves in measured torques, (n,)."""
    recording, out = trajectory.recording, np.full(filtered.shape[1], np.nan)
    if recording is None or recording.torque is None or recording.cutoff is None:
        return out
    step, fastest = float(np.median(np.diff(trajectory.time))), recording.cutoff.max(keepdims=True)
    for joint, (raw, smooth) in enumerate(zip(recording.torque.T, filtered.T, strict=True)):
        is_known = np.isfinite(raw) & np.isfinite(smooth)
        if is_known.any():
            out[joint] = noise_of(raw[is_known], smooth[is_known], step, fastest, remaining=True).item()
    return out


def direction(trajectory: Trajectory, joint: int, fastest: float | None = None) -> FloatArray:
    """1 where the joint moves forwards, -1 backwards, 0 where it hardly moves, (N,).

    `fastest` is its largest velocity, by default along this trajectory.
    """
    velocity, recording = trajectory.qd[:, joint], trajectory.recording
    assert recording is not None
    # Noise of spectrum S gives positions, velocities and accelerations variances that sum S, w^2 S and w^4 S
    # over frequencies w; by Cauchy-Schwarz that of the velocity is at most the root of the product of the
    # other two, for any filter.
    noise = float(np.sqrt(recording.noise_q[joint] * recording.noise_qdd[joint]))
    fastest = float(np.abs(velocity).max()) if fastest is None else fastest
    still = max(_VERDICTS.noise_sigmas * np.nan_to_num(noise), _VERDICTS.creeping_share * fastest)
    return np.where(np.abs(velocity) > still, np.sign(velocity), 0.0)


def _far_from_jumps(trajectory: Trajectory, sign: FloatArray) -> Array:
    """Set points far enough from changes of direction that the jump of friction has settled, (N,)."""
    time, wait = trajectory.time, _settling(trajectory)
    after = np.flatnonzero(np.diff(sign) != 0.0)
    jumps = np.concatenate([[-np.inf], (time[after] + time[after + 1]) / 2.0, [np.inf]])
    following = np.searchsorted(jumps, time)
    return np.asarray(np.minimum(time - jumps[following - 1], jumps[following] - time) >= wait)


def _settling(trajectory: Trajectory) -> float:
    """Settling time of the torques' filter, the fastest of all joints, s; 0 without a filter."""
    recording = trajectory.recording
    if recording is None or recording.cutoff is None:
        return 0.0
    cutoffs = recording.cutoff[np.isfinite(recording.cutoff) & (recording.cutoff > 0.0)]
    return _VERDICTS.settling_periods / float(cutoffs.max()) if len(cutoffs) else 0.0
