"""The time of a log: which column has it, in which unit, in seconds from the log's first instant."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location
from gd_analyze.motions.reading import TIME_UNITS, refusal
from gd_analyze.motions.roles import Meaning
from gd_analyze.motions.table import Stamps

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
    """The column of time, or the pair of seconds and nanoseconds."""

    columns: tuple[int, ...]
    unit: str  # "" if unknown
    why: str


def time_columns(
    names: Sequence[str], meanings: Sequence[Meaning], stand: Sequence[bool], where: Location
) -> TimeColumns | None:
    """Find the time of the rows; `stand` tells of which columns all first cells are the same."""
    found = []
    for k, meaning in enumerate(meanings):
        name = names[k].strip()
        rank = _ROW_TIME if name.startswith("__") else _ANY + ("duration" in meaning.group)
        if rank and "stamp" in meaning.group and name != "stamp":
            rank = _STAMP
        if meaning.role == "time" and not stand[k]:
            found.append((rank, TimeColumns((k,), meaning.unit, "name")))
        fits = (m.role == "nanosec" and m.group[:-1] == meaning.group[:-1] for m in meanings)
        pair = next((i for i, fit in enumerate(fits) if fit), None)
        if meaning.role == "sec" and pair is not None and not (stand[k] and stand[pair]):
            found.append((min(rank, _STAMP), TimeColumns((k, pair), "s", "seconds and nanoseconds")))
    if not found:
        counts = [k for k, meaning in enumerate(meanings) if meaning.role == "index" and not stand[k]]
        return TimeColumns((counts[0],), SAMPLE, "name") if len(counts) == 1 else None
    best = min(rank for rank, _ in found)
    choices = [columns for rank, columns in found if rank == best]
    if len(choices) > 1:
        listed = [names[columns.columns[0]] for columns in choices]
        step = "choose one: " + " or ".join(f"--map 'time={name}'" for name in listed[:4])
        raise refusal("several columns may be the time", where, "one column of time", ", ".join(listed), step)
    return choices[0]


def in_seconds(
    stamps: Sequence[Stamps],
    chosen: TimeColumns,
    unit: str | None,
    rate: float | None,
    name: str,
    where: Location,
) -> tuple[FloatArray, str, str]:
    """Time in s from the first instant, the unit it was in, and the reason for that unit, or refuse."""
    if len(stamps) == 2 and rate is None:
        seconds, nano = stamps
        values = seconds.rest + 1e-9 * (nano.rest + nano.base)
        return values - _first(values), "s", chosen.why
    stamp = stamps[0]
    values, first = stamp.rest - _first(stamp.rest), stamp.base + _first(stamp.rest)
    # The unit by the column's name or by its first instant, since 1970.
    dated = (known for known, size in TIME_UNITS.items() if _EPOCH[0] <= abs(first) * size <= _EPOCH[1])
    told = next(((known, "since 1970") for known in dated), None)
    if chosen.unit in TIME_UNITS:
        told = chosen.unit, chosen.why
    if rate is not None:
        least = _steps(values, np.min)
        if told or not _whole(values) or (chosen.unit != SAMPLE and least > 1.0):
            what = f"{name} counts no samples, so a rate does not tell its time"
            expected = "whole numbers in steps of 1, or a name such as sample"
            found = f"time in {told[0]}" if told else f"{first:.10g} first, steps of {least:g} at least"
            remedy = "leave --rate out, or the column: --map time=none; --time-unit gives a unit"
            raise refusal(what, where, expected, found, remedy)
        return values / rate, SAMPLE, f"{rate:g} Hz as given"
    if unit is not None:
        return values * TIME_UNITS[unit], unit, "as given"
    if told:
        return values * TIME_UNITS[told[0]], *told
    step = _steps(values, np.median)
    if chosen.unit == SAMPLE or (_whole(values) and step == 1.0):
        what, found = f"{name} counts samples, or its unit is unknown", f"whole numbers in steps of {step:g}"
        remedy = "--rate HZ if it counts samples, --time-unit s, ms, us or ns otherwise"
        raise refusal(what, where, "time in s, or how long a sample is", found, remedy)
    if step <= _DOUBTFUL:
        return values, "s", "no unit stated"
    likely = [known for known, size in TIME_UNITS.items() if _STEPS[0] <= step * size < _STEPS[1]]
    if len(likely) == 1:
        return values * TIME_UNITS[likely[0]], likely[0], f"steps of {step:g}"
    expected, next_step = "time in s, or a name such as time_ms", "--time-unit s, ms, us or ns"
    raise refusal(f"the unit of {name} is unknown", where, expected, f"steps of {step:g}", next_step)


def _first(values: FloatArray) -> float:
    return float(next(iter(values[np.isfinite(values)]), 0.0))


def _whole(values: FloatArray) -> bool:
    known = values[np.isfinite(values)]
    return bool((known == np.round(known)).all())


def _steps(values: FloatArray, of: Callable[[FloatArray], Any]) -> float:
    """Median or least of the steps forwards; 0 where there are none."""
    steps = np.diff(values[np.isfinite(values)])
    return float(of(steps[steps > 0])) if (steps > 0).any() else 0.0
