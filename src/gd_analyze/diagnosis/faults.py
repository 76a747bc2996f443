"""Faults that readings show by themselves: constant, copied, frozen, repeated, clipped and jumping ones."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from gd_analyze.arrays import Array, FloatArray, chunks, runs
from gd_analyze.diagnosis.remedies import another_column, leaving_out
from gd_analyze.motions.log import Log
from gd_analyze.motions.measured import directions, fastest_of
from gd_analyze.motions.smoothing import Recording
from gd_analyze.motions.trajectory import Trajectory, Whole
from gd_analyze.motions.velocities import derivative_factors
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number, percent

_CONSTANT_SHARE = 1e-6  # share of its size by which a torque that is constant varies at most
# Share of a moving joint's readings at the same value, in one run, that no motion explains.
_FROZEN_SHARE = 0.05
_SHORTEST_FROZEN_RUN = 25  # readings of the shortest such run
# A frozen run is this many times as long as the mean run, and the reading after it jumps by more than
# this many steps of the sensor. Of a smooth motion read in steps, the longest is up to twenty times the
# mean, and the next reading is the next step, but where friction changes its sign.
_FROZEN_TO_MEAN_RUN = 30.0
_FROZEN_JUMP_STEPS = 3.0
_USUAL_STEP_QUANTILE = 0.99  # quantile of a position's steps that is as long as they usually are
_STEP_QUANTILE = 0.05  # quantile of the changes between readings that is a step of the sensor
# A repeated row hides a motion of more than this many steps of a sensor of positions.
_REPEATED_STEPS = 2.0
# Share of the readings of a moving joint that equal its largest or smallest, in runs of several.
_CLIPPED_SHARE = 0.02
_SHORTEST_CLIPPED_RUN = 4  # readings of the shortest such run
# Readings at a clipped end, beside the most at one of the values next to it. A smooth peak read in steps
# has up to 1 / (sqrt(2) - 1) = 2.4 times as many in its last step as in the one before.
_CLIPPED_RATIO = 3.0
_VALUES_BESIDE = 5
# A spike differs from the median of five by this many times what readings usually do.
_SPIKE_FACTOR = 20.0
_MOST_SPIKES_SHARE = 0.2  # share of the readings above which they are no spikes
_HARMLESS_FACTOR = 0.5  # spikes below this multiple of the torque's standard deviation do no harm
_BLURRED_READINGS = 3  # readings around a fault that its filter blurs
# Factor between velocity columns and dq/dt beyond which they disagree.
_DISAGREEING_FACTOR = 1.25
_FEWEST_READINGS = 40  # least readings of a joint while it moves

VELOCITIES = "velocity column"


@dataclass(frozen=True)
class Fault:
    """A fault of one joint's readings in one log; of whole rows, the joint is the fastest."""

    name: str
    joint: int  # from 0
    what: str
    remedy: str
    share: float  # of the readings; 1 of a column that is of no use
    effect: str = "left out"

    @property
    def is_of_column(self) -> bool:
        """Whether a whole column of positions or torques is of no use."""
        return self.share == 1.0 and self.name != VELOCITIES


def without_faults(arm: RobotArm, log: Trajectory) -> tuple[list[Fault], Trajectory]:
    """Find the faults of a log with torques, and leave such readings out: their torques are nan.

    Rows in which a position is frozen become a gap, and the log is smoothed anew.
    """
    faults, frozen = _frozen_positions(log)
    if frozen.any():
        log = _smoothed_without(arm, log, frozen)
    recording = log.recording
    assert recording is not None  # callers check this
    assert recording.torque is not None
    faulty = np.zeros(recording.torque.shape, dtype=bool)
    for fault, joints in _copies(recording):
        faults.append(fault)
        faulty[:, joints] = True
    moving = directions(log) != 0
    for i in range(arm.n_joints):
        moves = moving[:, i]
        if moves.sum() < _FEWEST_READINGS or not np.isfinite(recording.torque[:, i]).any():
            continue
        for fault, rows in _of_joint(log, recording.torque[:, i], moves, i):
            faults.append(fault)
            faulty[:, i] |= rows
    # The filter makes a faulty reading part of its neighbours; one that is a row late does them no harm.
    near = np.ones(2 * _BLURRED_READINGS + 1)
    blurred = [np.convolve(rows, near, mode="same") > 0.5 for rows in faulty.T]
    repeats = _repeats(log, recording)
    if repeats.any():
        joint, share = int(fastest_of([log]).argmax()), float(repeats.mean())
        what = f"{percent(share)} of the rows repeat the row before, though the arm moves"
        faults.append(Fault("repeated rows", joint, what, "log each message once", share))
    faults += _of_velocities(log)
    if not (faulty.any() or repeats.any()):
        return faults, log
    torque, filtered = (
        None if values is None else np.where(rows | repeats[:, None], np.nan, values)
        for values, rows in (
            (recording.torque, faulty),
            (recording.torque_filtered, np.column_stack(blurred)),
        )
    )
    return faults, replace(log, recording=replace(recording, torque=torque, torque_filtered=filtered))


def _frozen_positions(log: Trajectory) -> tuple[list[Fault], Array]:
    """Joints whose position is frozen for a while, and the rows, (N,)."""
    faults: list[Fault] = []
    rows, recording = np.zeros(log.n_set_points, dtype=bool), log.recording
    # Several motions in one recording would be smoothed as one.
    if recording is None or not recording.measured or log.motions:
        return faults, rows
    for i, q in enumerate(recording.q.T):
        frozen = _frozen_runs(q)
        # A joint that rested goes on in usual steps; one that was frozen is elsewhere by then.
        steps = np.abs(np.diff(q))
        usual = float(np.quantile(steps, _USUAL_STEP_QUANTILE))
        for begin, end in runs(frozen).tolist():
            jumps = end < len(q) and steps[end - 1] > _FROZEN_JUMP_STEPS * usual
            frozen[begin:end] = jumps
        if frozen.any():
            faults.append(_frozen(log.time, frozen, f"position of joint {i + 1}", i))
            rows |= frozen
    return faults, rows


def _smoothed_without(arm: RobotArm, log: Trajectory, rows: Array) -> Trajectory:
    """The log without some of its rows, which become a gap."""
    recording = log.recording
    assert recording is not None  # callers check this
    q = np.where(rows[:, None], np.nan, recording.q)
    logged = Log(
        log.time, q, recording.qd, None, recording.torque, True, recording.columns, log.name, log.origin
    )
    whole = log.whole or Whole(log.n_set_points, log.fingerprint)
    return replace(Trajectory.from_log(logged, arm), whole=whole)


def _repeats(log: Trajectory, recording: Recording) -> Array:
    """Rows that repeat the one before though a joint moves by several steps of its sensor, (N,)."""
    assert recording.torque is not None  # callers check this
    repeats = np.zeros(log.n_set_points, dtype=bool)
    repeats[1:] = True
    for readings in (recording.q, recording.torque):
        repeats[1:] &= (readings[1:] == readings[:-1]).all(axis=1)
    if repeats.any():
        steps = np.array([_sensor_step(q) for q in recording.q.T])
        moved = np.abs(log.qd) * float(np.median(np.diff(log.time)))
        repeats &= ((moved > _REPEATED_STEPS * steps) & (steps > 0.0)).any(axis=1)
    return repeats


def _of_joint(log: Trajectory, torque: FloatArray, moves: Array, joint: int) -> Iterator[tuple[Fault, Array]]:
    """Faults of a joint's torque, and the readings of each, (N,)."""
    column = f"torque of joint {joint + 1}"
    values = torque[moves & np.isfinite(torque)]
    if not len(values) or np.ptp(values) <= _CONSTANT_SHARE * np.abs(values).max(initial=0.0):
        what = f"The {column} is {'constant' if values.any() else '0'} while it moves"
        remedy = f"name another column with {another_column('torque', joint)}"
        yield Fault("dead column", joint, what, remedy, 1.0), np.ones(len(torque), dtype=bool)
        return
    at_end = _at_clipped_end(torque, moves)
    clipped = at_end & (_runs(torque) >= _SHORTEST_CLIPPED_RUN) & moves
    share = float(clipped.sum() / moves.sum())
    if share > _CLIPPED_SHARE:
        ends = [end for end in (np.nanmin(torque), np.nanmax(torque)) if end in torque[clipped]]
        what = (
            f"The {column} is clipped at {', '.join(map(number, ends))} in {percent(share)} of its readings"
        )
        remedy = "record with a wider range, or more slowly, if the rest is too little"
        yield Fault("clipped torque", joint, what, remedy, share), at_end
    frozen = _frozen_runs(torque) & moves & ~at_end
    if frozen.any():
        yield _frozen(log.time, frozen, column, joint), frozen
    spikes = _spikes(torque, moves)
    if 0 < spikes.sum() <= _MOST_SPIKES_SHARE * len(torque):
        count = f"{int(spikes.sum())} times" if spikes.sum() > 1 else "once"
        first = ", ".join(map(number, log.time[spikes][:3].tolist()))
        what = f"The {column} jumps away and back {count} (first at {first} s)"
        remedy = "record without lost messages, if they are many"
        yield Fault("spikes", joint, what, remedy, float(spikes.mean())), spikes


def _at_clipped_end(values: FloatArray, moves: Array) -> Array:
    """Readings at the largest or smallest value, where these are far more than at the values next to it."""
    levels, counts = np.unique(values[moves & np.isfinite(values)], return_counts=True)
    at_end, beside = np.zeros(len(values), dtype=bool), _VALUES_BESIDE
    # For this share of its period a sine read in steps stays within the last one.
    step = min(2.0 * _sensor_step(values) / float(levels[-1] - levels[0]), 1.0)
    least = np.arccos(1.0 - step) / np.pi * counts.sum()
    for end, most in ((0, counts[1 : 1 + beside].max()), (-1, counts[-1 - beside : -1].max())):
        if counts[end] > max(_CLIPPED_RATIO * most, least):
            at_end |= values == levels[end]
    return at_end


def _frozen_runs(values: FloatArray) -> Array:
    """Readings in long runs of one value, from which the next one jumps, (N,)."""
    lengths, step = _runs(values), _sensor_step(values)
    mean_run = len(values) / float((1.0 / lengths).sum())
    shortest = max(
        _FROZEN_SHARE * len(values),
        _SHORTEST_FROZEN_RUN,
        _FROZEN_TO_MEAN_RUN * mean_run,
    )
    frozen = np.zeros(len(values), dtype=bool)
    for begin, end in runs(lengths >= shortest):
        # Runs of different values may follow each other.
        starts = begin + np.concatenate([[0], np.flatnonzero(np.diff(values[begin:end])) + 1])
        for first, last in zip(starts, [*starts[1:], end], strict=True):
            jump = abs(values[last] - values[first]) if last < len(values) else np.inf
            frozen[first:last] = jump > _FROZEN_JUMP_STEPS * step
    return frozen


def _sensor_step(values: FloatArray) -> float:
    """Size of a step of the sensor, or of a small change between readings."""
    changes = np.abs(np.diff(values))
    changes = changes[changes > 0.0]
    return float(np.quantile(changes, _STEP_QUANTILE)) if len(changes) else 0.0


def _copies(recording: Recording) -> Iterator[tuple[Fault, list[int]]]:
    """Columns that are another joint's, reading by reading, and the joints whose torques are of no use."""
    joints = range(recording.q.shape[1])
    for role, word, values in (("torque", "torques", recording.torque), ("q", "positions", recording.q)):
        for i, j in combinations(joints, 2):
            if values is not None and _are_copies(values[:, i], values[:, j]):
                what = f"The {word} of joints {i + 1} and {j + 1} are the same, reading by reading"
                remedy = f"name another column with {another_column(role, j)}"
                # Positions enter the torques of all joints.
                of_no_use = [i, j] if role == "torque" else list(joints)
                yield Fault("copied column", i, what, remedy, 1.0), of_no_use


def _are_copies(first: FloatArray, second: FloatArray) -> bool:
    """Whether two columns that vary are equal, or one is the other's negative."""
    if not np.isfinite(first).any() or not np.nanmax(first) > np.nanmin(first):
        return False
    return any(np.array_equal(first, other, equal_nan=True) for other in (second, -second))


def _frozen(time: FloatArray, frozen: Array, column: str, joint: int) -> Fault:
    begin, end = map(number, time[frozen][[0, -1]].tolist())
    what = f"The {column} is frozen from {begin} to {end} s"
    remedy = "record without lost messages, if the rest is too little"
    return Fault("frozen column", joint, what, remedy, float(frozen.mean()))


def _of_velocities(log: Trajectory) -> Iterator[Fault]:
    """Velocity columns that are another multiple of dq/dt: positions alone are used then."""
    recording = log.recording
    if recording is None or recording.qd is None:
        return
    largest = _DISAGREEING_FACTOR
    factors, _ = derivative_factors(log.time, recording.q, recording.qd, log.gaps)
    for i, factor in enumerate(factors.tolist()):
        if np.isfinite(factor) and not 1.0 / largest < factor < largest:
            yield Fault(
                VELOCITIES,
                i,
                f"The velocity column of joint {i + 1} is {number(factor)} times dq/dt",
                f"check its unit and sign, or leave such columns out: {leaving_out('qd')}",
                1.0,
                "not used",
            )


def _runs(values: FloatArray) -> Array:
    """Length of the run of equal values that each belongs to."""
    changes = np.flatnonzero(np.diff(values) != 0.0) + 1
    ends = np.concatenate([[0], changes, [len(values)]])
    return np.repeat(np.diff(ends), np.diff(ends))


def _spikes(values: FloatArray, moves: Array) -> Array:
    """Readings far from their neighbours on both sides."""
    is_read, places = np.isfinite(values), np.arange(len(values))
    filled = np.interp(places, places[is_read], values[is_read])
    padded = np.pad(filled, 2, mode="edge")
    fives = np.lib.stride_tricks.sliding_window_view(padded, 5)
    around = np.concatenate([np.median(fives[at], axis=1) for at in chunks(len(fives))])
    deviation = np.abs(filled - around)
    # What readings usually do, by medians that spikes do not move. Slow readings of few values equal their
    # neighbours: a step of the sensor is the least.
    changes = np.abs(np.diff(around))[moves[1:]]
    usual = max(float(np.median(deviation[moves])), float(np.mean(changes)), _sensor_step(filled))
    size = float(np.sqrt(np.mean((around - around.mean()) ** 2)))
    return deviation > max(_SPIKE_FACTOR * usual, _HARMLESS_FACTOR * size)
