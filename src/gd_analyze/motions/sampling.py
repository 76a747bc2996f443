"""The rows of a log as set points: ordered by time, one per instant, cut at gaps, angles unwrapped."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, frozen
from gd_analyze.errors import TrajectoryError, warn_caller
from gd_analyze.motions.reading import refusal
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import named_joints, significant

# Shorter stretches of readings are left out: they do not show accelerations.
FEWEST_READINGS = 16
# A step of this many usual ones lacks a reading.
MISSING_READING_STEPS = 1.5
# Stamps closer than this share of the usual step are equal.
EQUAL_STAMP_STEP_SHARE = 0.01


@dataclass(frozen=True, eq=False)
class Sampling:
    """The rows of a log that are set points, and their instants."""

    rows: NDArray[np.intp]  # numbers of the rows, from 0, in the order of time, shape (N,)
    time: FloatArray  # s, strictly increasing, shape (N,)
    gaps: tuple[int, ...]  # set points before which there is a gap
    step: float  # the usual time between two readings (median), s
    notes: tuple[str, ...]  # steps taken

    @property
    def stretches(self) -> list[slice]:
        """Set points of each stretch."""
        return [slice(start, end) for start, end in pairwise([0, *self.gaps, len(self.time)])]

    def take(self, values: FloatArray) -> FloatArray:
        """The set points among a log's rows, read-only; all of them in order are not copied."""
        if len(self.rows) == len(values) and (np.diff(self.rows) == 1).all():
            return frozen(values)
        taken = values[self.rows]
        taken.flags.writeable = False
        return taken


# A gap is longer than this many usual steps of the log, and longer than a pause of a slow logger.
_GAP_STEPS = 5.0
_GAP_SECONDS = 0.05


def longest_step(step: float) -> float:
    """Longest time between two readings that is not a gap, by the usual one, s."""
    return max(_GAP_STEPS * step, _GAP_SECONDS)


def usual_step(time: FloatArray) -> float:
    """Median of the positive steps between instants; 0 if there are none."""
    steps = np.diff(time)
    return float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0


# A larger share of equal stamps is warned of.
_WARNED_EQUAL_SHARE = 0.01
# Times that start beyond this are dates.
_DATE_SECONDS = 1e6


def sampling_of(
    time: FloatArray, q: FloatArray, readable: NDArray[np.bool_], gap: float | None, name: str, fewest: int
) -> Sampling:
    """Put the `readable` rows of a log in order; TrajectoryError if no stretch between gaps has `fewest`.

    Warns if many rows repeat a stamp.
    """
    notes: list[str] = []
    rows = np.flatnonzero(readable & np.isfinite(time))
    if len(rows) < len(time):
        notes.append(f"rows with empty cells, left out: {len(time) - len(rows)}")
    times = time[rows]
    step = usual_step(times)
    if not step:
        raise _too_few(name, f"{len(rows)} at one instant" if len(rows) else "none", fewest)
    gap = longest_step(step) if gap is None else max(gap, MISSING_READING_STEPS * step)
    rows, times = _in_order(rows, times, gap, notes)
    equal = EQUAL_STAMP_STEP_SHARE * step
    same = int((np.diff(times) <= equal).sum())
    times = _apart(times, q, rows, step)
    # Of equal stamps the last is kept: a message sent again is the newest.
    is_kept = np.append(np.diff(times) > equal, True)
    if same:
        left_out = int((~is_kept).sum())
        remedy = f"put between their neighbours: {same - left_out}, left out: {left_out}"
        notes.append(f"rows with the stamp of the next one, {remedy}")
        if same > _WARNED_EQUAL_SHARE * len(rows):
            message = f"log {name}: {same} of {len(rows)} stamps are repeated; rows {remedy}"
            warn_caller(message)
    rows, times = rows[is_kept], times[is_kept]
    begins = np.concatenate([[0], np.flatnonzero(np.diff(times) > gap) + 1])
    lengths = np.diff(np.append(begins, len(times)))
    is_long = lengths >= fewest
    if not is_long.any():
        among = f" at most, in {len(begins)} stretches between gaps" if len(begins) > 1 else ""
        raise _too_few(name, f"{lengths.max()}{among}", fewest)
    if not is_long.all():
        short = f"{int((~is_long).sum())} (rows: {int(lengths[~is_long].sum())})"
        notes.append(f"stretches of fewer than {fewest} readings between gaps, left out: {short}")
    is_kept = np.repeat(is_long, lengths)
    gaps = tuple(np.cumsum(lengths[is_long])[:-1].tolist())
    if gaps:
        across = "nothing is differentiated, smoothed or bounded across them"
        notes.append(f"gaps longer than {significant(gap)} s: {len(gaps)}; {across}")
    times = times[is_kept]
    since = times - times[0]
    # If stamps are dates, unless this loses digits that distinguish them.
    if abs(times[0]) > _DATE_SECONDS and (np.diff(since) > 0).all():
        notes.append("time counts from the first reading")
        times = since
    return Sampling(rows[is_kept], times, gaps, step, tuple(notes))


def _in_order(
    rows: NDArray[np.intp], times: FloatArray, gap: float, notes: list[str]
) -> tuple[NDArray[np.intp], FloatArray]:
    """Sort by time; rows after a restart of the clock follow those before it."""
    begins = np.concatenate([[0], np.flatnonzero(np.diff(times) < -gap) + 1])
    parts = np.split(times, begins[1:])
    spans = sorted((float(part.min()), float(part.max())) for part in parts)
    overlap = any(after[0] <= before[1] for before, after in pairwise(spans))
    if len(parts) > 1 and overlap and len(parts) * FEWEST_READINGS <= len(times):
        moved, end = [], -np.inf
        for part in parts:
            moved.append(part + max(0.0, end + 2 * gap - float(part.min())))
            end = float(moved[-1].max())
        times = np.concatenate(moved)
        first = f"{len(parts) - 1}, first at row {rows[begins[1]] + 1}"
        notes.append(f"restarts of time: {first}; each begins a new motion behind a gap")
    unsorted = int((np.diff(times) < 0).sum())
    if unsorted:
        notes.append(f"stamps after a later one, sorted: {unsorted}")
        order = np.argsort(times, kind="stable")
        rows, times = rows[order], times[order]
    return rows, times


def _apart(times: FloatArray, q: FloatArray, rows: NDArray[np.intp], step: float) -> FloatArray:
    """Give rows that move but share a stamp distinct instants, where a step is missing beside them."""
    times, steps = times.copy(), np.diff(times)
    equal, missing = EQUAL_STAMP_STEP_SHARE * step, MISSING_READING_STEPS * step
    shared = np.flatnonzero(steps[1:-1] <= equal) + 1
    moves = (q[rows[shared]] != q[rows[shared + 1]]).any(axis=1)
    for k in shared[moves]:
        if steps[k - 1] >= missing:
            times[k] = (times[k - 1] + times[k + 1]) / 2
        elif steps[k + 1] >= missing:
            times[k + 1] = (times[k] + times[k + 2]) / 2
    return times


def _too_few(name: str, readings: str, fewest: int) -> TrajectoryError:
    expected = f"a stretch of at least {fewest} readings at different instants without a gap"
    next_step = "check the unit of time, or give a larger `largest_gap`" if "gaps" in readings else None
    return refusal("the log has too few readings in a row", name, expected, readings, next_step)


_TURN = 2 * math.pi
# A jump that differs from full turns by more than this, rad, is not an angle's wrap-around.
_TURN_TOLERANCE = math.pi / 2
# An angle that wraps stays within so many turns, -360 to 360 degrees at most; one farther away is in another
# unit, or counts its turns.
_MOST_WRAPPED_TURNS = 2


def unwrapped(q: FloatArray, arm: RobotArm, stretches: Sequence[slice]) -> tuple[FloatArray, tuple[str, ...]]:
    """Undo jumps of full turns of revolute joints, shape (N, n), within each stretch; return notes, too.

    Across a gap angles stay as logged, unless full turns bring a stretch back within limits.
    """
    out, farthest = q, _MOST_WRAPPED_TURNS * _TURN + _TURN_TOLERANCE
    jumped: dict[int, int] = {}  # number of jumps by number of the joint, from 1
    for i in np.flatnonzero(arm.is_revolute).tolist():
        lower, upper = arm.limits("lower")[i], arm.limits("upper")[i]
        angles = q[:, i].copy()
        for stretch in stretches:
            steps = np.diff(angles[stretch])
            turns = np.round(steps / _TURN)
            turns[np.abs(steps - _TURN * turns) > _TURN_TOLERANCE] = 0.0
            if turns.any() and np.ptp(angles[stretch]) <= farthest:
                jumped[i + 1] = jumped.get(i + 1, 0) + int(np.count_nonzero(turns))
                angles[stretch.start + 1 : stretch.stop] -= _TURN * np.cumsum(turns)
            low, high = float(angles[stretch].min()), float(angles[stretch].max())
            if math.isfinite(upper - lower) and (low < lower or high > upper):
                into = math.ceil((lower - low) / _TURN) if low < lower else -math.ceil((high - upper) / _TURN)
                is_near = abs(into) <= _MOST_WRAPPED_TURNS
                if is_near and lower <= low + _TURN * into and high + _TURN * into <= upper:
                    angles[stretch] += _TURN * into
        if not np.array_equal(angles, q[:, i]):
            out = q.copy() if out is q else out
            out[:, i] = angles
    if out is not q:
        out.flags.writeable = False  # and a trajectory needs no copy
    if not jumped:
        return out, ()
    joints = named_joints([*jumped], arm.n_joints)
    return out, (f"jumps of full turns undone: {sum(jumped.values())} ({joints})",)
