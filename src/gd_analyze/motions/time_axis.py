"""The time of a log: which column has it, in which unit, in seconds from the log's first instant."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.roles import Meaning
from gd_analyze.motions.table import Stamps
from gd_analyze.motions.units import TIME_UNITS

SAMPLE = "sample"
# Instants since 1970 of logs between 1990 and 2100, s.
_EPOCH = (6.3e8, 4.2e9)
# Steps of logs of robots, s: from 10 kHz to 1 Hz; longer ones are taken at the user's word alone.
_STEPS = (1e-4, 1.0)
# Longer steps than this, and below 1, may be of some readings per second or of some per millisecond.
_DOUBTFUL = 0.5
# Before all else a log has the time of its rows, then the stamp of the message, then anything called time.
_ROW_TIME, _STAMP, _ANY = 0, 1, 2


@dataclass(frozen=True)
class TimeColumns:
    """The column of time, or the pair of seconds and nanoseconds; none where rows are counted."""

    columns: tuple[int, ...]
    unit: str
    why: str


def time_rank(name: str, meaning: Meaning) -> int:
    """How surely a column is the time of its rows."""
    if name.strip().startswith("__"):
        return _ROW_TIME
    if "stamp" in meaning.group and name.strip() != "stamp":
        return _STAMP
    if "duration" in meaning.group:
        return _ANY + 1
    return _ANY


def time_columns(
    names: Sequence[str], meanings: Sequence[Meaning], stand: Sequence[bool], where: Location
) -> TimeColumns | None:
    """Find the time of the rows.

    Parameters
    ----------
    names, meanings
        Of all columns.
    stand
        Whether a column's first cells are all the same, so that it tells no time.
    where
        For the message.

    Raises
    ------
    TrajectoryError
        If several columns may be it.
    """
    found = []
    for k, meaning in enumerate(meanings):
        if meaning.role == "time" and not stand[k]:
            found.append((time_rank(names[k], meaning), TimeColumns((k,), meaning.unit, "name")))
        pair = _partner(k, meanings)
        if pair is not None and not (stand[k] and stand[pair]):
            rank = min(time_rank(names[k], meaning), _STAMP)
            found.append((rank, TimeColumns((k, pair), "s", "seconds and nanoseconds")))
    if not found:
        counts = [k for k, meaning in enumerate(meanings) if meaning.role == "index" and not stand[k]]
        return TimeColumns((counts[0],), SAMPLE, "name") if len(counts) == 1 else None
    best = min(rank for rank, _ in found)
    choices = [columns for rank, columns in found if rank == best]
    if len(choices) > 1:
        listed = [names[columns.columns[0]] for columns in choices]
        raise TrajectoryError(
            "several columns may be the time",
            where=where,
            expected="one column of time",
            found=", ".join(listed),
            next_step="choose one: " + " or ".join(f"--map 'time={name}'" for name in listed[:4]),
        )
    return choices[0]


def _partner(k: int, meanings: Sequence[Meaning]) -> int | None:
    """Column of nanoseconds that belongs to one of seconds."""
    if meanings[k].role != "sec":
        return None
    prefix = meanings[k].group[:-1]
    return next(
        (i for i, other in enumerate(meanings) if other.role == "nanosec" and other.group[:-1] == prefix),
        None,
    )


def in_seconds(
    stamps: Sequence[Stamps],
    chosen: TimeColumns,
    unit: str | None,
    rate: float | None,
    name: str,
    where: Location,
    hint: str = "",
) -> tuple[FloatArray, str, str]:
    """Time in s from the first instant, the unit it was in, and why that was taken.

    Parameters
    ----------
    stamps
        The column of time, or seconds and nanoseconds.
    chosen
        Which columns these are.
    unit, rate
        What the user says.
    name, where
        The column, for messages.
    hint
        What the log's own velocities say of the unit, for the message.

    Raises
    ------
    TrajectoryError
        If the unit is not to be told.
    """
    if rate is not None and (len(stamps) == 2 or chosen.unit in TIME_UNITS):
        raise TrajectoryError(
            f"{name} is a time in {chosen.unit}, which a rate contradicts",
            where=where,
            expected="a rate where the log counts samples, or has no time",
            found=f"{rate:g} Hz",
            next_step="leave --rate out, or the column: --map time=none",
        )
    if len(stamps) == 2:
        seconds, nano = stamps
        return _from_start(seconds.rest + 1e-9 * (nano.rest + nano.base)), "s", chosen.why
    (stamp,) = stamps
    values = stamp.rest - (_first(stamp.rest))
    first = stamp.base + _first(stamp.rest)
    told = _told_unit(chosen, first)
    if rate is not None:
        if told:
            raise TrajectoryError(
                f"{name} counts no samples, so a rate does not tell its time",
                where=where,
                expected="whole numbers that count samples",
                found=f"time in {told[0]}",
                next_step="leave out --rate, or leave the column out: --map time=none",
            )
        return _by_rate(values, first, chosen, rate, name, where)
    if unit is not None:
        return values * TIME_UNITS[unit], unit, "as given"
    if told:
        return values * TIME_UNITS[told[0]], *told
    return _by_steps(values, chosen, name, where, hint)


def _by_rate(
    values: FloatArray, first: float, chosen: TimeColumns, rate: float, name: str, where: Location
) -> tuple[FloatArray, str, str]:
    """Take numbers for samples, if they may be such."""
    if not _whole(values):
        raise TrajectoryError(
            f"{name} counts no samples, so a rate does not tell its time",
            where=where,
            expected="whole numbers",
            found=f"{first:.10g} first",
            next_step="give its unit with --time-unit, or leave the column out: --map time=none",
        )
    steps = np.diff(values[np.isfinite(values)])
    step = float(steps[steps > 0].min()) if (steps > 0).any() else 1.0
    if chosen.unit != SAMPLE and step > 1.0:
        raise TrajectoryError(
            f"{name} may count samples or be a time, so a rate does not tell",
            where=where,
            expected="whole numbers in steps of 1, or a name such as sample",
            found=f"steps of {step:g} at least",
            next_step="give its unit with --time-unit, or leave the column out: --map time=none",
        )
    return values / rate, SAMPLE, f"{rate:g} Hz as given"


def _told_unit(chosen: TimeColumns, first: float) -> tuple[str, str] | None:
    """Unit that the column's name or its first instant, since 1970, tells, and which of them does."""
    if chosen.unit in TIME_UNITS:
        return chosen.unit, chosen.why
    known = (unit for unit, factor in TIME_UNITS.items() if _EPOCH[0] <= abs(first) * factor <= _EPOCH[1])
    return next(((unit, "since 1970") for unit in known), None)


def _by_steps(
    values: FloatArray, chosen: TimeColumns, name: str, where: Location, hint: str
) -> tuple[FloatArray, str, str]:
    """Tell the unit by the steps."""
    step = _step(values)
    if chosen.unit == SAMPLE or (_whole(values) and step == 1.0):
        raise TrajectoryError(
            f"{name} counts samples, or is in a unit that it does not tell",
            where=where,
            expected="time in s, or how long a sample is",
            found="whole numbers in steps of 1" if step == 1.0 else f"whole numbers in steps of {step:g}",
            next_step=f"--rate HZ if it counts samples, --time-unit s, ms, us or ns otherwise{hint}",
        )
    if step <= _DOUBTFUL:
        return values, "s", "no unit stated"
    likely = [unit for unit, factor in TIME_UNITS.items() if _STEPS[0] <= step * factor < _STEPS[1]]
    if len(likely) == 1:
        return values * TIME_UNITS[likely[0]], likely[0], f"steps of {step:g}"
    raise TrajectoryError(
        f"{name} does not tell its unit",
        where=where,
        expected="time in s, or a name such as time_ms",
        found=f"steps of {step:g}",
        next_step=f"--time-unit s, ms, us or ns{hint}",
    )


def unit_by_velocity(values: FloatArray, q: FloatArray, qd: FloatArray) -> str | None:
    """Unit of time in which velocities are the derivative of positions; None where none of the known is.

    Parameters
    ----------
    values
        Instants in the log's unit, shape (N,).
    q, qd
        Positions and velocities, rad (m) and per s, shape (N, n).
    """
    known = np.isfinite(values) & np.isfinite(q).all(axis=1) & np.isfinite(qd).all(axis=1)
    steps = np.diff(values[known])[:, None]
    if len(steps) < 8:
        return None
    moved = np.diff(q[known], axis=0)
    with np.errstate(over="ignore", invalid="ignore"):
        integrated = steps * (qd[known][1:] + qd[known][:-1]) / 2
        size = float((integrated * integrated).sum())
        factor = float((moved * integrated).sum()) / size if 0 < size < math.inf else 0.0
    return next((unit for unit, known in TIME_UNITS.items() if abs(factor / known - 1) < 0.1), None)


def _from_start(values: FloatArray) -> FloatArray:
    return values - _first(values)


def _first(values: FloatArray) -> float:
    finite = values[np.isfinite(values)]
    return float(finite[0]) if finite.size else 0.0


def _step(values: FloatArray) -> float:
    """Usual step, the median; 0 where time stands."""
    steps = np.diff(values[np.isfinite(values)])
    return float(np.median(steps[steps > 0])) if (steps > 0).any() else 0.0


def _whole(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return bool((known == np.round(known)).all())
