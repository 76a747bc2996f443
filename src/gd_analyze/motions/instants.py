"""Instants of a log's rows: the column of time, its unit, and seconds from the first one."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location, TrajectoryError, argument
from gd_analyze.motions.mapping import NamedLog, listed_names, typed_columns
from gd_analyze.motions.names import TIMED
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.sampling import usual_step
from gd_analyze.motions.stated_rate import stated_rate
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


def time_columns(log: NamedLog) -> TimeColumns | None:
    """Find the time of the rows; None where they are counted, as the user says."""
    if log.time is not None:
        name = log.names[log.time]
        unit = log.time_unit or name.unit or {"sec": "s", "nanosec": "ns"}.get(name.role, "")
        return TimeColumns((log.time,), unit if unit in TIME_UNITS else "", "as given")
    if log.counts_rows:
        return None
    stand = [k for k, name in enumerate(log.names) if name.role in TIMED and log.table.stands(k)]
    time = _best(log, stand)
    return replace(time, unit=log.time_unit, why="as given") if log.time_unit else time


def _best(log: NamedLog, stand: Sequence[int]) -> TimeColumns:
    """The preferred of the columns that may be the time and change."""
    candidates: list[tuple[int, TimeColumns]] = []
    nanoseconds = [(name.topic[:-1], k) for k, name in enumerate(log.names) if name.role == "nanosec"]
    for k, name in enumerate(log.names):
        text = name.text.strip()
        rank = _ROW_TIME if text.startswith("__") else _ANY
        if rank and "stamp" in name.topic and text != "stamp":
            rank = _STAMP
        if name.role == "time" and k not in stand and not name.fault:
            candidates.append((rank, TimeColumns((k,), name.unit, "name")))
        pairs = [pair for topic, pair in nanoseconds if name.role == "sec" and topic == name.topic[:-1]]
        if pairs and not (k in stand and pairs[0] in stand):
            columns = TimeColumns((k, pairs[0]), "s", "seconds and nanoseconds")
            candidates.append((min(rank, _STAMP), columns))
    if not candidates:
        counts = [k for k, name in enumerate(log.names) if name.role == "index" and k not in stand]
        if len(counts) != 1:
            raise _no_time(log, stand)
        return TimeColumns((counts[0],), SAMPLE, "name")
    best = min(rank for rank, _ in candidates)
    choices = [columns for rank, columns in candidates if rank == best]
    if len(choices) > 1:
        listed = typed_columns([columns.columns[0] for columns in choices], log.table)
        step = "choose one: " + " or ".join(argument("map", f"time={name}") for name in listed[:4])
        where, expected = log.table.where(), "one column of time"
        raise refusal("several columns may be the time", where, expected, ", ".join(listed), step)
    return choices[0]


def _no_time(log: NamedLog, stand: Sequence[int]) -> TrajectoryError:
    table = log.table
    rate, words = stated_rate(table)
    by_rate = f"give the samples per second: {argument('map', f'time={rate}')}{words}"
    if stand:
        cell = table.head(stand[0])[0]
        stamp = f"{cell:.10g}" if isinstance(cell, float) else str(cell)
        message = f"all rows at one instant: {table.names[stand[0]]} does not change"
        step = f"write its stamps with all digits, or {by_rate}"
        return refusal(message, table.where(None, stand[0]), "stamps that increase", stamp, step)
    for k, name in enumerate(log.names):
        if name.role == "time" and name.fault:
            message = f"the time in column {name.text} is text that is not read as instants"
            expected = "numbers, or dates and times such as 2025-03-04T10:20:30.016Z or 10:20:30.016"
            return refusal(message, table.where(None, k), expected, in_python(table.head(k)[0]))
    step = f"name it with {argument('map', 'time=COLUMN')}, or {by_rate}"
    expected = "a column such as time, timestamp or header.stamp, in numbers"
    message = "no column is recognized as time"
    return refusal(message, table.where(), expected, listed_names(table.names), step)


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
    table: LogTable,
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
    column = chosen.columns[0]
    place = table.label(column), table.where(None, column)
    clock = _Clock(stamp.offsets - first, stamp.base + first, *place)
    unit, why = (stamp.unit, "dates and times") if stamp.unit else (chosen.unit, chosen.why)
    if stamp.unit and chosen.why == "as given" and chosen.unit:
        message, expected = f"{clock.name} holds dates, so it has no other unit", "numbers"
        raise refusal(message, clock.where, expected, "dates and times", "omit the unit of time")
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
    rate_by_velocities = "" if by_velocities else rate_of_factors(factors)
    raise _unknown_unit(clock, counts, rate_by_velocities, stated_rate(table))


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
        remedy = f"to count the rows in its place, give {argument('map', f'time={rate:g}Hz')} alone"
        raise refusal(message, clock.where, expected, content, remedy)
    return clock.values / rate, (SAMPLE, f"{rate:g} Hz as given")


def _unknown_unit(
    clock: _Clock, counts: bool, rate_by_velocities: str, stated: tuple[str, str]
) -> TrajectoryError:
    """Refusal of a unit that neither name nor numbers say, with the rate of the samples it may count."""
    mapped, content = f"time={clock.name}", f"steps of {clock.step:g}, {len(clock.values)} rows"
    if counts and rate_by_velocities:
        content += f"; positions against velocities say about {rate_by_velocities}"
        remedy = f"{argument('map', f'{mapped}:{rate_by_velocities}')} if it counts samples"
    elif counts:
        rate, words = stated
        remedy = f"{argument('map', f'{mapped}:{rate}')} if it counts samples{words}, "
        remedy += f"{argument('map', f'{mapped}:s')}, ms, us or ns otherwise"
    else:
        remedy = f"{argument('map', f'{mapped}:{usual_unit(clock.step)}')} if these are readings, "
        remedy += "or another of s, ms, us, ns"
    expected = "time in s, or a name such as time_ms"
    return refusal(f"the unit of {clock.name} is unknown", clock.where, expected, content, remedy)


def _first(values: FloatArray) -> float:
    return float(next(iter(values[np.isfinite(values)]), 0.0))
