"""The numbers of a trajectory from a log: rows sorted, angles unwrapped, readings smoothed."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.errors import warn_caller
from gd_analyze.motions.columns import ColumnUse
from gd_analyze.motions.cutoff import Source, chosen
from gd_analyze.motions.log import Log
from gd_analyze.motions.reading import Treatment, refusal
from gd_analyze.motions.sampling import FEWEST_READINGS, Sampling, sampling_of, unwrapped
from gd_analyze.motions.spline import BLOCK_READINGS, derivatives
from gd_analyze.motions.velocities import FEWEST_SET_POINTS, are_noise, completed, contradictions
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import significant


@dataclass(frozen=True, eq=False)
class Recording:
    """The numbers of a log at the set points of its trajectory, and their treatment."""

    q: FloatArray  # joint variables as read, unwrapped, rad (m), shape (N, n)
    # Torques at the joints as read, and after the filter of the motion, N m (N), shape (N, n), or None
    torque: FloatArray | None
    torque_filtered: FloatArray | None
    # Cut-off frequency of the filter, Hz, shape (n,); None for a plan, which is not smoothed
    cutoff: FloatArray | None
    # Standard deviation of the noise in the readings, and of the noise left in the accelerations, rad (m) and
    # per s^2, shape (n,)
    noise_q: FloatArray
    noise_qdd: FloatArray
    columns: tuple[ColumnUse, ...] = ()  # how the log's columns were understood
    # Treatment: rows left out, gaps, unwrapping, filter and the rule of its cut-off
    treatment: tuple[str, ...] = ()
    qd: FloatArray | None = None  # velocities as read, whether used or not, shape (N, n)

    @property
    def measured(self) -> bool:
        """Whether these are smoothed readings; otherwise a plan in a log."""
        return self.cutoff is not None

    def at(self, points: NDArray[np.intp] | slice) -> Recording:
        """The same at some of the set points."""
        arrays = {name: getattr(self, name) for name in ("q", "torque", "torque_filtered", "qd")}
        return replace(self, **{name: x[points] for name, x in arrays.items() if x is not None})


@dataclass(frozen=True, eq=False)
class Treated:
    """Fields of a trajectory that follow from a log's numbers; see `Trajectory`."""

    time: FloatArray  # s, shape (N,)
    q: FloatArray  # rad (m), shape (N, n)
    qd: FloatArray  # per s
    qdd: FloatArray  # per s^2
    derivatives_from: str  # origin of qd and qdd
    gaps: tuple[int, ...]
    recording: Recording | None


def treated(logged: Log, arm: RobotArm | None, treatment: Treatment | None) -> Treated:
    """Make the numbers of a trajectory; see `Trajectory.from_log`."""
    if arm is not None and logged.q.shape[1] != arm.n_joints:
        message, count = f"the log does not fit arm {arm.name}", str(logged.q.shape[1])
        raise refusal(message, logged.origin or logged.name, f"{arm.n_joints} joints", count)
    if logged.gaps is not None and not logged.measured:
        arrays = (logged.time, logged.q, logged.qd, logged.qdd)
        if logged.judged and not logged.gaps and are_noise(*arrays):
            return treated(_as_readings(logged), arm, treatment)
        completed_arrays = completed(*arrays, logged.gaps, logged.name)
        return Treated(logged.time, logged.q, *completed_arrays, logged.gaps, None)
    treatment = treatment or Treatment()
    logged = _without_sparse(logged)
    needed = [x for x in (logged.q, logged.qd, logged.qdd) if x is not None]
    readable = np.logical_and.reduce([np.isfinite(x).all(axis=1) for x in needed])
    fewest_of_plan = FEWEST_SET_POINTS if len(needed) < 3 else 1
    fewest = FEWEST_READINGS if logged.measured else fewest_of_plan
    name = logged.origin or logged.name
    sampling = sampling_of(logged.time, logged.q, readable, treatment.largest_gap, name, fewest)
    q, notes = sampling.take(logged.q), sampling.notes
    if arm is not None:
        q, turns = unwrapped(q, arm, sampling.stretches)
        notes += turns
    optional = (logged.qd, logged.qdd, logged.torque)
    qd, qdd, torque = (None if x is None else sampling.take(x) for x in optional)
    sampled = replace(logged, time=sampling.time, q=q, qd=qd, qdd=qdd, torque=torque)
    if logged.measured:
        return _smoothed(sampled, sampling, treatment, notes)
    if logged.judged and are_noise(sampled.time, q, qd, qdd, sampling.gaps):
        return treated(_as_readings(logged), arm, treatment)
    qd_qdd = completed(sampled.time, q, qd, qdd, sampling.gaps, name)
    nothing = np.zeros(q.shape[1])
    recording = Recording(q, torque, torque, None, nothing, nothing, sampled.columns, notes, qd)
    return Treated(sampled.time, q, *qd_qdd, sampling.gaps, recording)


def _as_readings(logged: Log) -> Log:
    """Treat a log as a recording although its names do not say so."""
    reason = "its accelerations are noise, so it is treated as a recording and smoothed"
    message = f"trajectory {logged.name}: {reason}; --planned uses its rows unchanged"
    warn_caller(message)
    return replace(logged, measured=True, gaps=None, judged=False)


def _without_sparse(logged: Log) -> Log:
    """Leave out velocities and accelerations given in fewer than half of the rows with positions."""
    has_position = np.isfinite(logged.q).all(axis=1)
    count = int(has_position.sum())
    for name in ("qd", "qdd"):
        values = getattr(logged, name)
        n_given = count if values is None else int((has_position & np.isfinite(values).all(axis=1)).sum())
        if 2 * n_given < count:
            message = f"log {logged.name}: {name} left out, given in {n_given} of {count} rows with positions"
            warn_caller(message)
            logged = replace(logged, qd=None) if name == "qd" else replace(logged, qdd=None)
    return logged


def _smoothed(sampled: Log, sampling: Sampling, treatment: Treatment, notes: tuple[str, ...]) -> Treated:
    source, cutoffs, rule = chosen(_sources(sampled, sampling, treatment), sampling, treatment)
    from_velocities = source.order == 1
    orders = (0, 1, 2) if sampled.qdd is None else (0, 1)
    if from_velocities:
        motion = [*derivatives(sampling, sampled.q, cutoffs, (0,))]
        motion += [*derivatives(sampling, source.values, cutoffs, orders[:-1])]
    else:
        motion = [*derivatives(sampling, sampled.q, cutoffs, orders)]
    if sampled.qdd is not None:
        motion += [*derivatives(sampling, sampled.qdd, cutoffs, (0,))]
    q, qd, qdd = motion
    noise_qdd = source.remaining_noise(cutoffs)
    if sampled.qdd is not None:
        noise_qdd = noise_of(sampled.qdd, qdd, sampling.step, cutoffs, remaining=True)
    torque = None
    if sampled.torque is not None:
        # Noise of one joint's acceleration enters the torques of all.
        highest = np.full(len(cutoffs), cutoffs.max())
        (bridged,) = derivatives(sampling, sampled.torque, highest, (0,))
        torque = np.where(np.isnan(sampled.torque), np.nan, bridged)  # what bridges missing readings is none
    hertz = " and ".join(dict.fromkeys(f"{significant(float(cutoff))} Hz" for cutoff in cutoffs))
    readings = f"the measured {'velocities' if from_velocities else 'positions'}"
    smoothing = f"smoothed without delay, cut-off {hertz} ({rule})"
    derived = f"{'qdd' if from_velocities else 'qd and qdd'} derived: from {readings}, {smoothing}"
    least, most = significant(float(noise_qdd.min())), significant(float(noise_qdd.max()))
    noise = f"noise left in qdd {least} to {most} per s^2"
    notes = (*notes, f"accelerations from {readings}, {smoothing}; {noise}")
    noise_q = noise_of(sampled.q, q, sampling.step, cutoffs)
    recording = Recording(
        sampled.q, sampled.torque, torque, cutoffs, noise_q, noise_qdd, sampled.columns, notes, sampled.qd
    )
    derivatives_from = derived if sampled.qdd is None else f"given: measured, {smoothing}"
    return Treated(sampled.time, q, qd, qdd, derivatives_from, sampling.gaps, recording)


def _sources(sampled: Log, sampling: Sampling, treatment: Treatment) -> list[Source]:
    """Positions, and velocities if there are any that agree with them."""
    sources = [Source.of(sampling, sampled.q, 2)]
    if sampled.qd is None or not treatment.use_velocities:
        return sources
    mistakes = contradictions(sampled.time, sampled.q, sampled.qd, None, sampling.gaps)
    if mistakes:
        message = f"log {sampled.name}: {'; '.join(mistakes)}; the measured velocities are not used"
        warn_caller(message)
        return sources
    return [*sources, Source.of(sampling, sampled.qd, 1)]


def noise_of(
    readings: FloatArray, smooth: FloatArray, step: float, cutoffs: FloatArray, *, remaining: bool = False
) -> FloatArray:
    """Standard deviation of white noise in readings, shape (n,), from the part that smoothing removed.

    H removes 1 - 7/18 w of the variance of white noise, and leaves 5/18 w, with w = 2 pi f_c dt. With
    `remaining`, the noise that remains in the smoothed readings.
    """
    blocks = chunks(len(readings), BLOCK_READINGS)
    removed = sum(np.square(readings[at] - smooth[at]).sum(axis=0) for at in blocks) / len(readings)
    passing = 2 * math.pi * cutoffs * step
    return np.asarray(np.sqrt(removed / (1 - 7 / 18 * passing) * (5 / 18 * passing if remaining else 1.0)))
