"""Velocities and accelerations of a file: derived if missing, compared with its positions if given."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray, are_possible
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.units_by_numbers import (
    FACTOR_TOLERANCE,
    factor_of_units,
    options_of,
    units_of_factors,
)
from gd_analyze.text import LARGEST, named_joints, number

# A quintic with not-a-knot ends has six free coefficients before its first inner knot.
FEWEST_SET_POINTS = 6
# Fewer set points are not compared.
_FEWEST_COMPARED = 8
# Movements are noise below this share of the largest movement of a joint, and below this size, rad or m
# (per s, s^2).
_STILL_SHARE = 0.05
_STILL_SIZE = 1e-3


# A long motion is judged by so many windows of so many set points: mistakes affect the whole motion.
_WINDOWS = 16
_WINDOW_SET_POINTS = 8192


def _windows(count: int, gaps: Sequence[int]) -> tuple[slice | NDArray[np.intp], Sequence[int]]:
    """Rows of evenly spaced windows of a long motion, with gaps between; all rows of a short one."""
    length = _WINDOW_SET_POINTS
    if count <= _WINDOWS * length:
        return slice(None), gaps
    starts = np.linspace(0, count - length, _WINDOWS).astype(int)
    rows = (starts[:, None] + np.arange(length)).ravel()
    window_gaps = {int(gap) for gap in np.searchsorted(rows, gaps)}
    window_gaps |= {k * length for k in range(1, _WINDOWS)}
    return rows, sorted(window_gaps - {0, len(rows)})


# Accelerations are noise if the mean square of their changes exceeds this share of their own mean square.
# From one set point to the next those of planned motions change by a fifth, those of real arms, derived from
# positions, threefold.
_NOISY_CHANGE = 0.5
# Shorter stretches are not judged.
_FEWEST_JUDGED = 32
# A set point farther than this from the middle of its neighbours, rad or m, is not a reading.
_LARGEST_BEND = 0.01
# Number of largest changes that are left out as jumps, and one more per so many changes.
_JUMPS = 4
_CHANGES_PER_JUMP = 50


def are_noise(
    time: FloatArray, q: FloatArray, qd: FloatArray | None, qdd: FloatArray | None, gaps: Sequence[int] = ()
) -> bool:
    """Whether accelerations, given or derived, are noise: then the motion consists of readings.

    Judged by the mean square of their changes over their own (von Neumann): 2 for white noise, 3 or more for
    differentiated noise, 0 for a smooth motion.
    """
    if qd is None:
        values, order = q, 2
    elif qdd is None:
        values, order = qd, 1
    else:
        values, order = qdd, 0
    rows, gaps = _windows(len(time), gaps)
    time, q, values = time[rows], q[rows], values[rows]
    ends = pairwise([0, *gaps, len(time)])
    parts = [slice(start, end) for start, end in ends if end - start >= _FEWEST_JUDGED]
    derivatives, bends = [], []
    for part in parts:
        accelerations, instants = values[part], time[part]
        for _ in range(order):
            accelerations = np.diff(accelerations, axis=0) / np.diff(instants)[:, None]
            instants = (instants[1:] + instants[:-1]) / 2
        derivatives.append(accelerations)
        bends.append(np.abs(np.diff(q[part], 2, axis=0)))
    if not derivatives or np.median(np.concatenate(bends), axis=0).max() > _LARGEST_BEND:
        return False
    changes = np.concatenate([np.diff(part, axis=0) for part in derivatives])
    jumps = _JUMPS + len(changes) // _CHANGES_PER_JUMP
    pair = (changes, np.concatenate(derivatives))
    changed, size = (np.partition(np.square(x), -jumps, axis=0)[:-jumps].mean(axis=0) for x in pair)
    moves = size > max(_STILL_SHARE**2 * float(size.max()), _STILL_SIZE**2)
    return bool((changed > _NOISY_CHANGE * size)[moves].any())


def completed(
    time: FloatArray,
    q: FloatArray,
    qd: FloatArray | None,
    qdd: FloatArray | None,
    gaps: Sequence[int] = (),
    where: str = "",
) -> tuple[FloatArray, FloatArray, str]:
    """Derive missing velocities and accelerations by a spline per stretch; state which and how."""
    if qd is not None and qdd is not None:
        return qd, qdd, "given"
    given = {name: x for name, x in (("qd", qd), ("qdd", qdd)) if x is not None}
    absent = [name for name in ("qd", "qdd") if name not in given]
    lacking = " and ".join(absent)
    shortest = int(np.diff([0, *gaps, len(time)]).min())
    if shortest < FEWEST_SET_POINTS:
        message, step = f"too few set points to derive {lacking}", "add them, or set points"
        expected = f"at least {FEWEST_SET_POINTS} set points between gaps, or columns for {lacking}"
        raise refusal(message, where, expected, str(shortest), step)
    source, samples = ("q", q) if qd is None else ("qd", qd)
    derived = np.empty((len(absent), *samples.shape))
    for start, end in pairwise([0, *gaps, len(time)]):
        _differentiate(time[start:end], samples[start:end], derived[:, start:end])
    derived.flags.writeable = False  # and a trajectory needs no copy
    for name, values in zip(absent, derived, strict=True):
        if not are_possible(values):
            message, steps = f"{name} cannot be derived: it is too large for any motion", np.diff(time)
            expected = f"time steps in s, even enough that {name} stays below {LARGEST:g}"
            span, step = f"{steps.min():g} s to {steps.max():g} s", f"check the instants, or add {name}"
            raise refusal(message, where, expected, span, step)
        given[name] = values
    return given["qd"], given["qdd"], f"{lacking} derived: C4 (quintic) spline through the given {source}"


# Set points of a block of the spline, and of its overlap at either side. The effect of a value on the spline
# shrinks by 0.43 from each set point to the next: beyond the overlap 1e-47 of it remain.
_BLOCK_SET_POINTS = 32_000
_OVERLAP_SET_POINTS = 128
# A joint that rests and whose position was computed at every set point differs in the last digit or two.
_LAST_DIGITS = 4 * float(np.finfo(float).eps)


def _differentiate(time: FloatArray, values: FloatArray, out: FloatArray) -> None:
    """Write the first derivatives of the quintic spline through values (N, n) into `out`, (orders, N, n).

    A long spline is made block by block: what lies beyond the overlap changes nothing. nan where doubles
    overflow.
    """
    from scipy.interpolate import make_interp_spline

    count = len(time)
    block, overlap = _BLOCK_SET_POINTS, _OVERLAP_SET_POINTS
    for start in range(0, count, block):
        end = min(start + block, count)
        begin, beyond = max(0, start - overlap), min(end + overlap, count)
        instants = time[begin:beyond]
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            try:
                spline = make_interp_spline(instants, values[begin:beyond], k=5)
                for order, row in enumerate(out, start=1):
                    row[start:end] = spline.derivative(order)(time[start:end])
            except ValueError:  # raised where the spline's equations overflow
                out[:, start:end] = np.nan
    # A spline through a constant has slopes of its last digits over the time step, squared for accelerations.
    moved = np.ptp(values, axis=0) > _LAST_DIGITS * np.abs(values).max(axis=0)
    out[:, :, ~moved] = 0.0


# Share of the movement that v may miss beyond what the time steps explain. Velocities of real arms, filtered
# or from their own sensor, miss up to 0.1 of it; the mistakes named here at least 0.9.
_MISSED_SHARE = 0.25
# Largest share of a movement that a factor may not explain.
_UNEXPLAINED_SHARE = 0.2
# An arm may stop, turn or jerk between two set points: this many intervals prove nothing. Planned motions of
# any profile with up to four vias then show no contradiction.
_EXCLUDED_INTERVALS = 3


def derivative_factors(
    time: FloatArray, x: FloatArray, v: FloatArray, gaps: Sequence[int] = ()
) -> tuple[FloatArray, Array]:
    """Factor by which each joint's v is too large to be the derivative of x, and whether v contradicts x.

    Integrals are compared, as differences of x would be mostly noise. Factors, (n,), are nan where a joint
    hardly moves, or where v is no multiple of the derivative.
    """
    n = x.shape[1]
    if len(time) < _FEWEST_COMPARED:
        return np.full(n, np.nan), np.zeros(n, dtype=bool)
    rows, gaps = _windows(len(time), gaps)
    time, x, v = time[rows], x[rows], v[rows]
    steps = np.diff(time)[:, None]
    changes, integrals = np.diff(x, axis=0), steps * (v[1:] + v[:-1]) / 2
    # Between set points v lies between its values there: the trapezoidal rule errs by at most this.
    unsure = steps * np.abs(np.diff(v, axis=0)) / 2
    for array in (changes, integrals, unsure):
        array[np.array(gaps, dtype=int) - 1] = 0.0
    worst = np.argsort(np.abs(changes - integrals), axis=0)[-_EXCLUDED_INTERVALS:]
    for array in (changes, integrals, unsure):
        np.put_along_axis(array, worst, 0.0, axis=0)
    start = np.zeros((1, n))
    moved, integrated = (np.cumsum(np.vstack([start, array]), axis=0) for array in (changes, integrals))
    # Each compared with its own largest: the two may be in different units.
    spans = np.stack([np.ptp(moved, axis=0), np.ptp(integrated, axis=0)])
    size = spans.max(axis=0)
    moves = (spans > np.maximum(_STILL_SIZE, _STILL_SHARE * spans.max(axis=1, keepdims=True))).any(axis=0)
    missed = np.ptp(moved - integrated, axis=0) - unsure.sum(axis=0)
    moved, integrated = moved - moved.mean(axis=0), integrated - integrated.mean(axis=0)
    squares = np.square(moved).sum(axis=0)
    factors = (moved * integrated).sum(axis=0) / np.where(squares > 0.0, squares, np.nan)
    unexplained = np.ptp(integrated - factors * moved, axis=0)
    is_multiple = moves & (unexplained <= _UNEXPLAINED_SHARE * np.ptp(integrated, axis=0))
    return np.where(is_multiple, factors, np.nan), moves & (missed > _MISSED_SHARE * size)


def contradictions(
    time: FloatArray,
    q: FloatArray,
    qd: FloatArray,
    qdd: FloatArray | None,
    gaps: Sequence[int] = (),
    derived: Sequence[str] = (),
) -> list[str]:
    """One line per likely mistake in given velocities, or else accelerations, that are not derivatives."""
    is_time_right = False
    for v, derivative, x, values in (("qd", qd, "q", q), ("qdd", qdd, "qd", qd)):
        if derivative is None or v in derived:
            continue
        factors, contradicts = derivative_factors(time, values, derivative, gaps)
        doubtful = {v} if is_time_right else {x, v, "time"}
        joints_of: dict[str, list[int]] = {}
        for joint in np.flatnonzero(contradicts).tolist():
            joints_of.setdefault(_mistake(float(factors[joint]), x, v, doubtful), []).append(joint + 1)
        if joints_of:
            n = q.shape[1]
            return [f"{v} of {named_joints(joints, n)} is {mistake}" for mistake, joints in joints_of.items()]
        # Velocities that are the derivative of positions show it.
        is_time_right = bool(np.isfinite(factors).any())
    return []


def _mistake(factor: float, x: str, v: str, doubtful: Collection[str]) -> str:
    """What a column v is, instead of the derivative of x, too large by a factor; some units are doubtful."""
    if factor == 0.0:
        return f"0 throughout while {x} changes: if unknown, leave the {v} columns out and they are derived"
    if abs(factor + 1.0) < FACTOR_TOLERANCE:
        return f"the derivative of {x} with the other sign"
    units = units_of_factors(np.array([factor]), x, v, unstated=doubtful) or {}
    units = {role: unit for role, unit in units.items() if unit != "s"}
    if not units:
        return f"not the derivative of {x}: check the units, and the order of the columns"
    facts = " and ".join(f"{role} were in {unit}" for role, unit in units.items())
    size = number(factor_of_units(units, v))
    return f"{size} times the derivative of {x}, as if {facts}: if so, give {options_of(units)}"
