"""Corrupt rows of a log: cells that cannot be read, and readings that jump away and return."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, runs
from gd_analyze.errors import TrajectoryError, warn_caller
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.sampling import (
    EQUAL_STAMP_STEP_SHARE,
    MISSING_READING_STEPS,
    longest_step,
    usual_step,
)
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.text import DECIMAL_COMMAS
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import number

# Most lines listed in a message.
_MOST_LISTED_LINES = 20
# Garbage that jumps away from the rows around it is a few rows long; more in a row are another motion.
_MOST_STRAY_ROWS = 3


def jumping_rows(
    time: FloatArray, q: FloatArray, arm: RobotArm, table: LogTable
) -> dict[int, TrajectoryError]:
    """Rows, from 0, whose instant or position jumps away and returns, with what is wrong; q has shape (N, n).

    A row that comes late is not among them: its stamp fills a hole between the others.
    """
    rows = np.flatnonzero(np.isfinite(time))
    step = usual_step(time[rows])
    if len(rows) <= 2 * _MOST_STRAY_ROWS or not step:
        return {}
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
    message = "the row does not fit those around it"
    expected = "instants and positions near those of the rows before and after"
    return {row: refusal(message, table.where(row), expected, fault) for row, fault in faults.items()}


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


def require_sound(
    faults: Mapping[int, TrajectoryError], count: int, table: LogTable, name: str, drop: bool
) -> None:
    """Refuse corrupt rows, from 0, among `count`, all named; or warn that they are left out if told to."""
    if not faults:
        return
    rows = sorted(faults)
    error, several = faults[rows[0]], len(rows) > 1
    message, details = error.what, error.details
    expected, facts = details.get("expected", ""), [details.get("found", "")]
    if len(rows) == count:
        facts.append(f"none of {count} rows can be read")
        step = "choose other columns with `map`, or record anew"
        if DECIMAL_COMMAS in message:
            step = details["next"]
        raise refusal(message, details["where"], expected, facts, step)
    lines = _listed_lines(table.lines_of(rows[: _MOST_LISTED_LINES + 1]), len(rows))
    if drop:
        omission = f"{len(rows)} corrupt row{'s' if several else ''} left out"
        warn_caller(f"log {name}: {omission}: {lines}")
        return
    step = "; ".join(
        filter(None, (details.get("next"), f"drop_rows=True leaves {'them' if several else 'the row'} out"))
    )
    if several:
        message, facts = f"{len(rows)} rows are corrupt; in the first, {message}", [*facts, lines]
    raise refusal(message, details["where"], expected, facts, step)


def _listed_lines(lines: Sequence[int], count: int) -> str:
    numbers = ", ".join(map(str, lines[:_MOST_LISTED_LINES]))
    return f"line{'s' if count > 1 else ''} {numbers}" + (
        f", ... ({count})" if count > _MOST_LISTED_LINES else ""
    )
