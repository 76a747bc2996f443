"""Faults that readings show by themselves: constant, frozen and clipped torques, spikes, other velocities."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics.measured_torque import direction
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.velocities import velocity_factors
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number, percent


@dataclass(frozen=True, kw_only=True)
class _FaultSettings:
    """Which readings are faulty."""

    # Share of a moving joint's readings at the same value, in one run, that no motion explains.
    frozen_share: float = 0.05
    shortest_frozen_run: int = 25  # readings of the shortest such run
    # Share of the readings of a moving joint that equal its largest or smallest, in runs of several.
    clipped_share: float = 0.02
    shortest_clipped_run: int = 4  # readings of the shortest such run
    # A spike differs from the median of five by this many times what readings usually do.
    spike_factor: float = 20.0
    most_spikes_share: float = 0.05  # share of the readings above which they are no spikes
    harmless_factor: float = 1.5  # spikes below this multiple of the torque's standard deviation do no harm
    blurred_readings: int = 3  # readings around a fault that its filter blurs
    # Factor between velocity columns and dq/dt beyond which they disagree.
    disagreeing_factor: float = 1.25
    fewest_readings: int = 40  # least readings of a joint while it moves


_SETTINGS = _FaultSettings()


VELOCITIES = "velocity column"


@dataclass(frozen=True)
class Fault:
    """A fault of one joint's torque, or velocity, in one log."""

    name: str
    joint: int  # from 0
    what: str
    remedy: str
    share: float  # of the readings
    effect: str = "not compared"


def faults_of(arm: RobotArm, logs: Sequence[Trajectory]) -> tuple[list[Fault], list[Array]]:
    """Faults, and the readings that remain usable, (N, n) per log."""
    faults, usable = [], []
    for log in logs:
        recording = log.recording
        assert recording is not None  # callers check this
        assert recording.torque is not None
        good = np.ones(recording.torque.shape, dtype=bool)
        for i in range(arm.n_joints):
            moves = direction(log, i) != 0.0
            if moves.sum() < _SETTINGS.fewest_readings or not np.isfinite(recording.torque[:, i]).any():
                continue
            for fault, rows in _of_joint(log, recording.torque[:, i], moves, i):
                faults.append(fault)
                good[:, i] &= ~_blurred(rows)
        faults += _of_velocities(log)
        usable.append(good)
    return faults, usable


def _of_joint(log: Trajectory, torque: FloatArray, moves: Array, joint: int) -> Iterator[tuple[Fault, Array]]:
    """Faults of a joint's torque, and the readings of each, (N,)."""
    values = torque[moves & np.isfinite(torque)]
    if not len(values) or np.ptp(values) <= 1e-9 * np.abs(values).max(initial=0.0):
        yield _dead(values, joint), np.ones(len(torque), dtype=bool)
        return
    runs = _runs(torque)
    at_end = (torque == np.nanmax(torque)) | (torque == np.nanmin(torque))
    clipped = at_end & (runs >= _SETTINGS.shortest_clipped_run) & moves
    if clipped.sum() > _SETTINGS.clipped_share * moves.sum():
        yield _clipped(torque, clipped, float(clipped.sum() / moves.sum()), joint), at_end
    shortest_run = max(_SETTINGS.frozen_share * len(torque), _SETTINGS.shortest_frozen_run)
    frozen = (runs >= shortest_run) & moves & ~at_end
    if frozen.sum() >= shortest_run:
        yield _frozen(log.time, frozen, joint), frozen
    spikes = _spikes(torque)
    if 0 < spikes.sum() <= _SETTINGS.most_spikes_share * len(torque):
        yield _jumping(log.time, spikes, joint), spikes


def _dead(values: FloatArray, joint: int) -> Fault:
    level = "constant" if values.any() else "0"
    return Fault(
        "dead column",
        joint,
        f"The torque of joint {joint + 1} is {level} while it moves",
        f"name another column with --map torque:JOINT=COLUMN, or leave joint {joint + 1} out",
        1.0,
    )


def _clipped(torque: FloatArray, clipped: Array, share: float, joint: int) -> Fault:
    values = torque[clipped]
    ends = ", ".join(number(float(end)) for end in (np.nanmin(torque), np.nanmax(torque)) if end in values)
    return Fault(
        "clipped torque",
        joint,
        f"The torque of joint {joint + 1} is clipped at {ends} in {percent(share)} of its readings",
        "record with a wider range, or more slowly; identify with what is not clipped",
        share,
    )


def _frozen(time: FloatArray, frozen: Array, joint: int) -> Fault:
    begin, end = time[np.flatnonzero(frozen)[[0, -1]]].tolist()
    rows = f"{number(begin)} to {number(end)} s"
    return Fault(
        "frozen column",
        joint,
        f"The torque of joint {joint + 1} is frozen from {rows}",
        f"leave these rows out, {rows}",
        float(frozen.mean()),
    )


def _jumping(time: FloatArray, spikes: Array, joint: int) -> Fault:
    count = f"{int(spikes.sum())} times" if spikes.sum() > 1 else "once"
    instants = ", ".join(number(float(t)) for t in time[np.flatnonzero(spikes)[:3]])
    return Fault(
        "spikes",
        joint,
        f"The torque of joint {joint + 1} jumps away and back {count} (first at {instants} s)",
        "leave these rows out, or log without lost messages",
        float(spikes.mean()),
    )


def _of_velocities(log: Trajectory) -> Iterator[Fault]:
    """Velocity columns that are another multiple of dq/dt: positions alone are used then."""
    recording = log.recording
    if recording is None or recording.qd is None:
        return
    largest = _SETTINGS.disagreeing_factor
    for i, factor in enumerate(velocity_factors(log.time, recording.q, recording.qd, log.gaps).tolist()):
        if np.isfinite(factor) and not 1.0 / largest < factor < largest:
            yield Fault(
                VELOCITIES,
                i,
                f"The velocity column of joint {i + 1} is {number(factor)} times dq/dt",
                "check its unit and sign, or leave such columns out: --map qd=none",
                1.0,
                "not used",
            )


def _runs(values: FloatArray) -> Array:
    """Length of the run of equal values that each belongs to."""
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    ends = np.concatenate([[0], changes, [len(values)]])
    return np.repeat(np.diff(ends), np.diff(ends))


def _spikes(values: FloatArray) -> Array:
    """Readings far from their neighbours on both sides."""
    filled = np.nan_to_num(values, nan=float(np.nanmedian(values)))
    padded = np.pad(filled, 2, mode="edge")
    around = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    deviation = np.abs(filled - around)
    # Readings of few values, and slow ones, are equal to their median: a typical difference is more than 0.
    usual = max(float(np.quantile(deviation, 0.9)), float(np.mean(np.abs(np.diff(filled)))), 1e-12)
    size = float(np.sqrt(np.mean((around - around.mean()) ** 2)))
    return deviation > max(_SETTINGS.spike_factor * usual, _SETTINGS.harmless_factor * size)


def _blurred(rows: Array) -> Array:
    """Rows and their neighbours."""
    wide = np.convolve(rows.astype(float), np.ones(2 * _SETTINGS.blurred_readings + 1), mode="same")
    return wide > 0.5
