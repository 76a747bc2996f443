"""The log of a motion in SI units, and how a table becomes one: units, time, corrupt rows, corrections."""

from __future__ import annotations

import math
import shlex
import warnings
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, runs
from gd_analyze.errors import GdAnalyzeWarning, Location, TrajectoryError
from gd_analyze.motions.columns import Choice, ColumnUse
from gd_analyze.motions.corrections import as_options, typed
from gd_analyze.motions.families import SAMPLE, TimeColumns
from gd_analyze.motions.reading import ROLES, Reading, refusal
from gd_analyze.motions.sampling import EQUAL_STAMP_STEP_SHARE, MISSING_READING_STEPS, longest_step
from gd_analyze.motions.table import Columns, LogTable, Stamps
from gd_analyze.motions.text import TextTable
from gd_analyze.motions.words import units_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number
from gd_analyze.units import TIME_UNITS

# Most lines listed in a message.
_MOST_LISTED_LINES = 20


@dataclass(frozen=True, eq=False)
class Log:
    """The columns of an arm's motion, in SI units and in the order of the joints, untreated."""

    time: FloatArray  # s, shape (N,); in a log instants may repeat, jump or leave gaps
    q: FloatArray  # joint variables, rad (m), shape (N, n); nan where a cell is empty
    # Velocities, accelerations and torques at the joints, same shape; None if missing
    qd: FloatArray | None
    qdd: FloatArray | None
    torque: FloatArray | None
    measured: bool  # whether these are readings of sensors; a plan otherwise
    columns: tuple[ColumnUse, ...] = ()  # how every column was understood
    # Short identifier, and where it was read
    name: str = "log"
    origin: str = ""
    # For a file of set points, whose rows are used unchanged: the rows, from 0, before which it states a gap.
    # None for any other log
    gaps: tuple[int, ...] | None = None
    judged: bool = False  # whether `measured` follows from names alone, so that the numbers may contradict it

    def __repr__(self) -> str:
        quantities = [role for role in ROLES if getattr(self, role) is not None]
        size = f"{self.q.shape[1]} joints, {len(self.time)} rows of {', '.join(quantities)}"
        return f"Log({self.name!r}, {size}, {'readings' if self.measured else 'a plan'})"


def log_of(
    table: LogTable, arm: RobotArm, reading: Reading, choice: Choice, columns: Columns, name: str, origin: str
) -> Log:
    """The log in SI units, without corrupt rows, corrected as the reading says; or refuse it."""
    # A trajectory takes arrays that nobody can write to as they are: a long motion is in memory once.
    columns.numbers.flags.writeable = False
    numbers, _ = choice.wanted
    column_values = dict(zip(numbers, columns.numbers.T, strict=True))
    arrays: dict[str, FloatArray] = {}
    for role in ROLES:
        uses = ((column, use.unit) for column, use in choice.uses if use.role == role)
        paired = [*zip(uses, arm.joints, strict=False)]
        factors = np.array(
            [units_of(role, joint.kind == "revolute", True)[unit] for (_, unit), joint in paired]
        )
        values = _columns(columns.numbers, [numbers.index(column) for (column, _), _ in paired], factors)
        if paired and (role == "q" or np.isfinite(values).any()):
            arrays[role] = values
    q = arrays["q"]
    if not len(q):
        raise refusal("the file has no rows", table.where(), "a line per instant", "none")
    gaps = None
    if not choice.measured and np.isnan(columns.numbers).any():
        _require_numbers(table, column_values, choice.set_points, [*columns.wrong])
    if choice.set_points and choice.time is not None:
        unit, why = choice.time.unit, choice.time.why
        column = choice.time.columns[0]
        instants = columns.numbers[:, numbers.index(column)].copy()
        _require_increasing(table, column, instants)
        time = instants * TIME_UNITS[unit]
        gaps = columns.gaps
    elif choice.time is None:
        time, unit, why = np.arange(len(q)) / (reading.rate or 1.0), SAMPLE, f"rows at {reading.rate:g} Hz"
    else:
        column = choice.time.columns[0]
        rate = reading.rate if choice.time.unit in (SAMPLE, "") or reading.time_unit is None else None
        place = (table.label(column), table.where(None, column))
        time, unit, why = _in_seconds(columns.stamps, choice.time, reading.time_unit, rate, *place)
    jumping = _jumping_rows(time, q, arm) if choice.measured else {}
    _require_some_sound(columns.wrong, len(q))
    _require_sound(columns.wrong, jumping, table, name, reading.drop_rows)
    # Rows of other topics and rows without an instant do not describe the motion.
    usable = np.isfinite(time) & np.isfinite(q).any(axis=1)
    if not usable.any():
        expected = "numbers in the columns of time and positions"
        raise refusal("no row has a time and a position", table.where(), expected, "empty cells")
    corrupt = sorted({*columns.wrong, *jumping})
    empty = np.delete(~usable, corrupt).sum()
    if empty:
        why += f"; rows without time or positions, left out: {int(empty)}"
    usable[corrupt] = False
    if not usable.all():
        time, arrays = time[usable], {role: array[usable] for role, array in arrays.items()}
        gaps = gaps and tuple(int(usable[:gap].sum()) for gap in gaps)
    constants = reading.torque_constant or () if "torque" in arrays else ()
    if reading.corrections or constants:
        if "torque" not in arrays:
            reading.corrections.require_torques()
        correction = reading.corrections.of_arm(arm, constants)
        arrays = correction.applied(time, arrays)
        words = shlex.join(as_options(typed(correction, arm.is_revolute)))
        origin += words and f"; corrected by {words}"
    return Log(
        time=time if gaps is not None else time - time[0],
        q=arrays["q"],
        qd=arrays.get("qd"),
        qdd=arrays.get("qdd"),
        torque=arrays.get("torque"),
        measured=choice.measured,
        columns=_uses(table, choice, unit, why),
        name=name,
        origin=origin,
        gaps=gaps,
        judged=reading.measured is None,
    )


def _columns(numbers: FloatArray, places: Sequence[int], factors: FloatArray) -> FloatArray:
    """Take columns, each times its factor; columns side by side that need none are not copied."""
    if places and (factors == 1.0).all() and (np.diff(places) == 1).all():
        return numbers[:, places[0] : places[-1] + 1]
    values = numbers[:, places] * factors
    values.flags.writeable = False
    return values


def _require_numbers(
    table: LogTable, column_values: dict[int, FloatArray], refuse_empty: bool, corrupt: Sequence[int]
) -> None:
    """Refuse a plan with a cell nan, and a file of set points with an empty cell, but for corrupt rows."""
    for column, values in column_values.items():
        empty = np.isnan(values)
        empty[corrupt] = False
        for row in np.flatnonzero(empty)[:1].tolist():
            cell = (isinstance(table, TextTable) and table.cell(row, column)) or "an empty cell"
            if refuse_empty or cell.lower().strip("-") == "nan":
                message, step = f"{table.label(column)} is not finite", "give one, or omit the set point"
                step += "; --measured leaves out such rows of a recording"
                raise refusal(message, table.where(row, column), "a number", cell, step)


def _require_increasing(table: LogTable, column: int, time: FloatArray) -> None:
    """Refuse set points whose time does not increase."""
    for k in np.flatnonzero(np.diff(time) <= 0)[:1].tolist():
        where, expected = table.where(k + 1, column), f"more than {time[k]!s}, the time of the line before"
        step = "sort the set points by time and keep one per instant; for readings, --measured does this"
        raise refusal("time does not increase", where, expected, str(time[k + 1]), step)


def _uses(table: LogTable, choice: Choice, unit: str, why: str) -> tuple[ColumnUse, ...]:
    """Role of every column, in the order of the log."""
    times = choice.time.columns if choice.time is not None else ()
    reason = "another time" if times else "no time is needed"
    numbers = range(len(table.names))
    uses = {k: ColumnUse(table.shown(k), "unused", why=choice.unused.get(k, reason)) for k in numbers}
    uses |= {k: ColumnUse(table.shown(k), "time", unit=unit, why=why) for k in times[:1]}
    uses |= {k: ColumnUse(table.shown(k), "time", unit="ns", why=why) for k in times[1:]}
    return tuple((uses | dict(choice.uses)).values())


# Instants since 1970 that are dates: from 1990 to 2100.
_EARLIEST_DATE_SECONDS = 6.3e8
_LATEST_DATE_SECONDS = 4.2e9
# Longest steps, s, with which such numbers are dates: those of robots' logs, as an uptime in a unit a
# thousand times smaller would have steps below 0.1 ms; and of dates with fractions, which uptimes lack.
_LONGEST_DATE_STEP_SECONDS = 0.1
_LONGEST_FRACTIONAL_STEP_SECONDS = 0.5
# Up to this step numbers without a unit are seconds; longer steps may be set points in s, or readings in ms,
# us or ns.
_LONGEST_STEP_IN_SECONDS = 0.5
# Steps of robots' logs, 10 kHz to 1 Hz, by which a unit is suggested.
_SHORTEST_LIKELY_STEP_SECONDS = 1e-4
_LONGEST_LIKELY_STEP_SECONDS = 1.0


def _in_seconds(
    stamps: Sequence[Stamps],
    chosen: TimeColumns,
    unit: str | None,
    rate: float | None,
    name: str,
    where: Location,
) -> tuple[FloatArray, str, str]:
    """Time in s from the first instant, its unit in the log, and the reason for that unit; or refuse."""
    if len(stamps) == 2 and rate is None:
        seconds, nano = stamps
        values = seconds.offsets + 1e-9 * (nano.offsets + nano.base)
        return values - _first(values), "s", chosen.why
    stamp = stamps[0]
    values, first = stamp.offsets - _first(stamp.offsets), stamp.base + _first(stamp.offsets)
    # The unit by the column's name or by its first instant, since 1970.
    stated: tuple[str, str] | None = None
    for unit_name, size in TIME_UNITS.items():
        date = abs(first) * size
        if _EARLIEST_DATE_SECONDS <= date <= _LATEST_DATE_SECONDS:
            longest = _LONGEST_DATE_STEP_SECONDS if _whole(values) else _LONGEST_FRACTIONAL_STEP_SECONDS
            if _steps(values, np.median) * size <= longest:
                stated = unit_name, "since 1970"
            break
    if chosen.unit in TIME_UNITS:
        stated = chosen.unit, chosen.why
    if stamp.unit:
        stated = stamp.unit, "dates and times"
    if stamp.unit and unit is not None:
        message, expected = f"{name} holds dates, so --time-unit does not apply to it", "numbers"
        raise refusal(message, where, expected, "dates and times", "omit --time-unit")
    if rate is not None:
        least = _steps(values, np.min)
        if stated or not _whole(values) or (chosen.unit != SAMPLE and least > 1.0):
            message = f"{name} does not count samples, so --rate does not apply to it"
            expected = "whole numbers in steps of 1, or a name such as sample"
            content = f"time in {stated[0]}" if stated else f"{first:.10g} first, steps of {least:g} at least"
            remedy = "omit --rate; or count the rows in place of this column: --map time=none"
            raise refusal(message, where, expected, content, remedy)
        return values / rate, SAMPLE, f"{rate:g} Hz as given"
    if unit is not None:
        return values * TIME_UNITS[unit], unit, "as given"
    if stated:
        return values * TIME_UNITS[stated[0]], *stated
    step = _steps(values, np.median)
    if chosen.unit == SAMPLE or (_whole(values) and step == 1.0):
        message = f"{name} counts samples, or its unit is unknown"
        content = f"whole numbers in steps of {step:g}"
        remedy = "--rate HZ if it counts samples, --time-unit s, ms, us or ns otherwise"
        raise refusal(message, where, "time in s, or the sample rate", content, remedy)
    if step <= _LONGEST_STEP_IN_SECONDS:
        return values, "s", "no unit stated"
    shortest, longest = _SHORTEST_LIKELY_STEP_SECONDS, _LONGEST_LIKELY_STEP_SECONDS
    likely = next((unit for unit, size in TIME_UNITS.items() if shortest <= step * size < longest), "s")
    expected, content = "time in s, or a name such as time_ms", f"steps of {step:g}, {len(values)} rows"
    next_step = f"--time-unit {likely} if these are readings, or another of s, ms, us, ns"
    raise refusal(f"the unit of {name} is unknown", where, expected, content, next_step)


def _first(values: FloatArray) -> float:
    return float(next(iter(values[np.isfinite(values)]), 0.0))


def _whole(values: FloatArray) -> bool:
    finite = values[np.isfinite(values)]
    return bool((finite == np.round(finite)).all())


def _steps(values: FloatArray, statistic: Callable[[FloatArray], Any]) -> float:
    """Median or smallest of the positive steps; 0 if there are none."""
    steps = np.diff(values[np.isfinite(values)])
    return float(statistic(steps[steps > 0])) if (steps > 0).any() else 0.0


# Garbage that jumps away from the rows around it is a few rows long; more in a row are another motion.
_MOST_STRAY_ROWS = 3


def _jumping_rows(time: FloatArray, q: FloatArray, arm: RobotArm) -> dict[int, str]:
    """Rows, from 0, whose instant or position jumps away and returns, with what is wrong; q has shape (N, n).

    A row that comes late is not among them: its stamp fills a hole between the others.
    """
    rows = np.flatnonzero(np.isfinite(time))
    steps = np.diff(time[rows])
    if len(rows) <= 2 * _MOST_STRAY_ROWS or not (steps > 0).any():
        return {}
    step = float(np.median(steps[steps > 0]))
    gap = longest_step(step)
    strays = _stray_stamps(time[rows], q[rows], step, gap)
    faults = {int(rows[k]): f"its stamp jumps to {time[rows[k]]:.10g} s and back" for k in strays}
    rows = np.delete(rows, strays)
    for i, joint in enumerate(arm.joints):
        finite = rows[np.isfinite(q[rows, i])]
        x = q[finite, i]
        for k in _stray_positions(time[finite], x, gap, joint.kind == "revolute"):
            fault = f"q of {joint.name} jumps to {number(float(x[k]))} {joint.unit} and back"
            faults.setdefault(int(finite[k]), fault)
    return faults


def _stray_stamps(time: FloatArray, q: FloatArray, step: float, gap: float) -> list[int]:
    """At most three rows in a row whose stamps fit neither side, where the two sides fit each other."""
    begins = np.concatenate([[0], np.flatnonzero(np.abs(np.diff(time)) > gap) + 1])
    lengths = np.diff(np.append(begins, len(time)))
    is_long = np.repeat(lengths > _MOST_STRAY_ROWS, lengths)
    if not is_long.any():
        return []
    good = np.sort(time[is_long])
    span = float(good[-1] - good[0])
    strays: list[int] = []
    for first, end in runs(~is_long).tolist():
        if end - first > _MOST_STRAY_ROWS:
            continue
        if first == 0 or end == len(time):
            inner = time[end] if first == 0 else time[first - 1]
            sign = -1.0 if first == 0 else 1.0
            away = sign * (time[first:end] - inner)
            # A gap follows or precedes them, unless they are farther than the whole motion is long.
            strays += [first + int(k) for k in np.flatnonzero((away < 0) | (away > max(span, gap)))]
        elif 0.0 < time[end] - time[first - 1] <= gap:
            strays += [k for k in range(first, end) if not _is_late(k, time, q, is_long, good, step)]
    return strays


def _is_late(
    k: int, time: FloatArray, q: FloatArray, is_long: NDArray[np.bool_], good: FloatArray, step: float
) -> bool:
    """Whether a row's stamp fills a hole among the good ones, in order, or repeats a whole row."""
    after = int(np.searchsorted(good, time[k]))
    if not 0 < after < len(good):
        return False
    if good[after] - good[after - 1] >= MISSING_READING_STEPS * step:
        return True
    alike = is_long & (np.abs(time - time[k]) <= EQUAL_STAMP_STEP_SHARE * step)
    return bool((q[alike] == q[k]).all(axis=1).any())


_TURN = 2 * math.pi
# A position's ordinary step is this quantile of its steps.
_ORDINARY_STEP_QUANTILE = 0.99
# A jump is longer than this many ordinary steps, and faster than this, per s: ten times as fast as arms move.
_JUMP_ORDINARY_STEPS = 30.0
_JUMP_SPEED = 30.0
# A position has returned if it is nearer to where it was than this share of the jump.
_RETURNED_SHARE = 0.1
# A step of fewer turns may be an angle that wraps at the end of its range.
_MOST_WRAPPED_TURNS = 1.5


def _stray_positions(time: FloatArray, x: FloatArray, gap: float, revolute: bool) -> list[int]:
    """At most three readings in a row that are far from those on both sides, which are near each other."""
    if len(x) <= 2 * _MOST_STRAY_ROWS:
        return []
    steps, seconds = np.diff(x), np.diff(time)
    ordinary = float(np.quantile(np.abs(steps), _ORDINARY_STEP_QUANTILE))
    if revolute:
        # An angle at the end of its range wraps there and back.
        remainders = steps - _TURN * np.round(steps / _TURN)
        is_near = np.abs(steps) < _MOST_WRAPPED_TURNS * _TURN
        wraps = is_near & (np.abs(remainders) <= _JUMP_ORDINARY_STEPS * ordinary)
        steps = np.where(wraps, remainders, steps)
    is_adjacent = (seconds > 0) & (seconds <= gap)
    least_jumps = np.maximum(_JUMP_ORDINARY_STEPS * ordinary, _JUMP_SPEED * seconds)
    jumps = is_adjacent & (np.abs(steps) > least_jumps)
    strays = list[int]()
    for away, back in pairwise(np.flatnonzero(jumps).tolist()):
        is_short = back - away <= _MOST_STRAY_ROWS and is_adjacent[away:back].all()
        has_returned = abs(steps[away : back + 1].sum()) <= _RETURNED_SHARE * abs(steps[away])
        if is_short and has_returned and steps[away] * steps[back] < 0:
            strays += range(away + 1, back + 1)
    return strays


def _require_some_sound(wrong: Mapping[int, TrajectoryError], count: int) -> None:
    """Refuse a log without a row that can be read, by the first."""
    if len(wrong) == count:
        error = wrong[min(wrong)]
        expected, step = error.details.get("expected", ""), "choose other columns with --map, or record anew"
        facts = [error.details.get("found", ""), f"none of {count} rows can be read"]
        raise refusal(error.what, error.details["where"], expected, facts, step)


def _require_sound(
    wrong: Mapping[int, TrajectoryError], jumping: Mapping[int, str], table: LogTable, name: str, drop: bool
) -> None:
    """Refuse corrupt rows, all named; or warn that they are left out if they are to be dropped."""
    rows = sorted({*wrong, *jumping})
    if not rows:
        return
    lines = _listed_lines(table.lines_of(rows[: _MOST_LISTED_LINES + 1]), len(rows))
    first = rows[0]
    if drop:
        omission = f"{len(rows)} corrupt row{'s' if len(rows) > 1 else ''} left out"
        warnings.warn(f"log {name}: {omission}: {lines}", GdAnalyzeWarning, stacklevel=4)
        return
    remedy = f"--drop-rows leaves {'them' if len(rows) > 1 else 'the row'} out"
    if first not in wrong:
        message = f"{len(rows)} rows are corrupt" if len(rows) > 1 else "a row is corrupt"
        expected = "instants and positions near those of the rows before and after"
        facts = [jumping[first], *([lines] if len(rows) > 1 else [])]
        raise refusal(message, table.where(first), expected, facts, remedy)
    error = wrong[first]
    details = error.details
    message = f"{len(rows)} rows are corrupt; in the first, {error.what}" if len(rows) > 1 else error.what
    facts = [details.get("found", ""), *([lines] if len(rows) > 1 else [])]
    step = "; ".join(filter(None, (details.get("next"), remedy)))
    raise refusal(message, details["where"], details.get("expected", ""), facts, step)


def _listed_lines(lines: Sequence[int], count: int) -> str:
    numbers = ", ".join(map(str, lines[:_MOST_LISTED_LINES]))
    return f"line{'s' if count > 1 else ''} {numbers}" + (
        f", ... ({count})" if count > _MOST_LISTED_LINES else ""
    )
