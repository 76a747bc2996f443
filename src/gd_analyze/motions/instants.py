"""Instants of a log's rows: the column of time, its unit, and seconds from the first one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.mapping import ColumnMap, map_option
from gd_analyze.motions.names import ColumnName
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.sampling import usual_step
from gd_analyze.motions.table import LogTable, Stamps
from gd_analyze.motions.units_by_numbers import (
    LONGEST_USUAL_STEP,
    rate_of_factors,
    units_of_factors,
    usual_unit,
)
from gd_analyze.text import in_python
from gd_analyze.units import TIME_UNITS

SAMPLE = "sample"
# Why a unit that is not stated is taken.
BY_VELOCITIES = "positions against velocities"
# Preferred are the time of the rows, then the stamp of the message, then anything called time.
_ROW_TIME, _STAMP, _ANY = 0, 1, 2
# Instants since 1970 that are dates: from 2000 to 2100; what some count since 1900 or the year 1 is none.
_EARLIEST_DATE_SECONDS = 9.4e8
_LATEST_DATE_SECONDS = 4.2e9
# Longest steps, s, with which such numbers are dates: those of robots' logs, as an uptime in a unit a
# thousand times smaller would have steps below 0.1 ms; and of dates with fractions, which uptimes lack.
_LONGEST_DATE_STEP_SECONDS = 0.1
_LONGEST_FRACTIONAL_STEP_SECONDS = 0.5
# Without a unit, numbers are seconds up to the longest step of most logs: longer ones may be set points in s
# or readings in ms, us or ns. Shorter steps than this are in another unit, such as days, or velocities in one
# a thousand times smaller say so.
_SHORTEST_STEP_SECONDS = 2e-5


@dataclass(frozen=True)
class TimeColumns:
    """The column of time, or the pair of seconds and nanoseconds."""

    columns: tuple[int, ...]
    unit: str  # "" if unknown
    why: str


def time_columns(table: LogTable, names: Sequence[ColumnName], given: ColumnMap) -> TimeColumns | None:
    """Find the time of the rows; None where they are counted, as the user says."""
    if given.time is not None:
        name = names[given.time]
        unit = given.time_unit or name.unit or {"sec": "s", "nanosec": "ns"}.get(name.role, "")
        return TimeColumns((given.time,), unit if unit in TIME_UNITS else "", "as given")
    if given.counts_rows:
        return None
    stand = [
        name.role in ("time", "sec", "nanosec", "index") and table.stands(k) for k, name in enumerate(names)
    ]
    time = _best(table, names, stand)
    if time is None:
        raise _no_time(table, names, stand)
    if given.time_unit:
        return TimeColumns(time.columns, given.time_unit, "as given")
    return time


def _best(table: LogTable, names: Sequence[ColumnName], stand: Sequence[bool]) -> TimeColumns | None:
    """The preferred of the columns that may be the time and change."""
    candidates = []
    nanoseconds: dict[tuple[str, ...], int] = {}  # the first column of each topic
    for k, name in enumerate(names):
        if name.role == "nanosec":
            nanoseconds.setdefault(name.topic[:-1], k)
    for k, name in enumerate(names):
        text = name.text.strip()
        rank = _ROW_TIME if text.startswith("__") else _ANY + ("duration" in name.topic)
        if rank and "stamp" in name.topic and text != "stamp":
            rank = _STAMP
        if name.role == "time" and not stand[k] and not name.fault:
            candidates.append((rank, TimeColumns((k,), name.unit, "name")))
        pair = nanoseconds.get(name.topic[:-1]) if name.role == "sec" else None
        if pair is not None and not (stand[k] and stand[pair]):
            candidates.append((min(rank, _STAMP), TimeColumns((k, pair), "s", "seconds and nanoseconds")))
    if not candidates:
        counts = [k for k, name in enumerate(names) if name.role == "index" and not stand[k]]
        return TimeColumns((counts[0],), SAMPLE, "name") if len(counts) == 1 else None
    best = min(rank for rank, _ in candidates)
    choices = [columns for rank, columns in candidates if rank == best]
    if len(choices) > 1:
        listed = [names[columns.columns[0]].text for columns in choices]
        if len({*listed}) < len(listed):
            listed = [f"#{columns.columns[0] + 1}" for columns in choices]
        step = "choose one: " + " or ".join(map_option(f"time={name}") for name in listed[:4])
        where, expected = table.where(), "one column of time"
        raise refusal("several columns may be the time", where, expected, ", ".join(listed), step)
    return choices[0]


def _no_time(table: LogTable, names: Sequence[ColumnName], stand: Sequence[bool]) -> TrajectoryError:
    if any(stand):
        column = stand.index(True)
        cell = table.head(column)[0]
        stamp = f"{cell:.10g}" if isinstance(cell, float) else str(cell)
        message = f"all rows at one instant: {table.names[column]} does not change"
        step = "write its stamps with all digits, or give the samples per second: --map time=RATEHz"
        return refusal(message, table.where(None, column), "stamps that increase", stamp, step)
    for k, name in enumerate(names):
        cells = table.head(k)
        if name.role == "time" and name.fault:
            message = f"the time in column {name.text} is text that is not read as instants"
            expected = "numbers, or dates and times such as 2025-03-04T10:20:30.016Z or 10:20:30.016"
            return refusal(message, table.where(None, k), expected, in_python(cells[0]))
    step = "name it with --map time=COLUMN, or give the samples per second: --map time=RATEHz"
    expected = "a column such as time, timestamp or header.stamp, in numbers"
    listed = ", ".join(name for name in table.names if name) or "columns without names"
    return refusal("no column is recognized as time", table.where(), expected, listed, step)


@dataclass(frozen=True)
class _Clock:
    """A column of time: instants from the first, in the column's unit, and what is known of them."""

    values: FloatArray  # (N,)
    first: float  # the first instant
    name: str
    where: Location

    @property
    def finite(self) -> FloatArray:
        """Those of rows that have one."""
        return self.values[np.isfinite(self.values)]

    @property
    def is_whole(self) -> bool:
        """Whether all are whole numbers."""
        return bool((self.finite == np.round(self.finite)).all())

    @property
    def step(self) -> float:
        """Median of the positive steps; 0 if there are none."""
        return usual_step(self.finite)

    @property
    def date_unit(self) -> str:
        """Unit in which the first instant is a date since 1970; "" if it is none."""
        for unit, size in TIME_UNITS.items():
            if _EARLIEST_DATE_SECONDS <= abs(self.first) * size <= _LATEST_DATE_SECONDS:
                longest = _LONGEST_DATE_STEP_SECONDS if self.is_whole else _LONGEST_FRACTIONAL_STEP_SECONDS
                return unit if self.step * size <= longest else ""
        return ""


def in_seconds(
    stamps: Sequence[Stamps],
    chosen: TimeColumns,
    rate: float | None,
    place: tuple[str, Location],
    factors_of: Callable[[FloatArray], FloatArray],
    unstated: Collection[str],
) -> tuple[FloatArray, tuple[str, str]]:
    """Time in s from the first instant, and its unit in the log with the reason for it; or refuse.

    `factors_of` gives the factors by which velocities are too large with instants read in s; `unstated` are
    the roles whose angles may be in degrees.
    """
    if len(stamps) == 2 and rate is None:
        seconds, nano = stamps
        values = seconds.offsets + 1e-9 * (nano.offsets + nano.base)
        return values - _first(values), ("s", chosen.why)
    stamp = stamps[0]
    first = _first(stamp.offsets)
    clock = _Clock(stamp.offsets - first, stamp.base + first, *place)
    unit, why = (stamp.unit, "dates and times") if stamp.unit else (chosen.unit, chosen.why)
    if stamp.unit and chosen.why == "as given" and chosen.unit:
        message, expected = f"{clock.name} holds dates, so it has no other unit", "numbers"
        raise refusal(message, clock.where, expected, "dates and times", "omit --map time")
    if unit not in TIME_UNITS:
        unit, why = (clock.date_unit, "since 1970") if clock.date_unit else (unit, why)
    if rate is not None:
        return _at_rate(clock, unit, rate)
    if unit in TIME_UNITS:
        return clock.values * TIME_UNITS[unit], (unit, why)
    step, factors = clock.step, factors_of(clock.values)
    by_velocities = units_of_factors(factors, unstated={"time", *unstated}) or {}
    second = by_velocities.get("time", "s")
    is_long_enough = step * TIME_UNITS[second] >= _SHORTEST_STEP_SECONDS
    if by_velocities and is_long_enough and (second != "s" or step > LONGEST_USUAL_STEP):
        return clock.values * TIME_UNITS[second], (second, BY_VELOCITIES)
    counts = unit == SAMPLE or (clock.is_whole and step == 1.0)
    if not counts and (step == 0.0 or _SHORTEST_STEP_SECONDS <= step <= LONGEST_USUAL_STEP):
        return clock.values, ("s", "no unit stated")
    raise _unknown_unit(clock, counts, "" if by_velocities else rate_of_factors(factors))


def _at_rate(clock: _Clock, unit: str, rate: float) -> tuple[FloatArray, tuple[str, str]]:
    least = float(np.diff(np.unique(clock.finite)).min(initial=np.inf))
    if unit in TIME_UNITS or not clock.is_whole or (unit != SAMPLE and least > 1.0):
        message = f"{clock.name} does not count samples, so no rate applies to it"
        expected = "whole numbers in steps of 1, or a name such as sample"
        content = (
            f"time in {unit}"
            if unit in TIME_UNITS
            else f"{clock.first:.10g} first, steps of {least:g} at least"
        )
        remedy = f"to count the rows in its place, give --map time={rate:g}Hz alone"
        raise refusal(message, clock.where, expected, content, remedy)
    return clock.values / rate, (SAMPLE, f"{rate:g} Hz as given")


def _unknown_unit(clock: _Clock, counts: bool, rate: str) -> TrajectoryError:
    """Refusal of a unit that neither name nor numbers say; `rate` is that of the samples it may count."""
    option, content = f"time={clock.name}", f"steps of {clock.step:g}, {len(clock.values)} rows"
    if counts and rate:
        content += f"; positions against velocities say about {rate}"
        remedy = f"{map_option(f'{option}:{rate}')} if it counts samples"
    elif counts:
        remedy = f"{map_option(f'{option}:RATEHz')} if it counts samples, "
        remedy += f"{map_option(f'{option}:s')}, ms, us or ns otherwise"
    else:
        remedy = f"{map_option(f'{option}:{usual_unit(clock.step)}')} if these are readings, "
        remedy += "or another of s, ms, us, ns"
    expected = "time in s, or a name such as time_ms"
    return refusal(f"the unit of {clock.name} is unknown", clock.where, expected, content, remedy)


def _first(values: FloatArray) -> float:
    return float(next(iter(values[np.isfinite(values)]), 0.0))
