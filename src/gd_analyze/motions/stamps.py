"""The instants of a log: put in order, one reading each, and cut where the log has gaps."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import TrajectoryError
from gd_analyze.text import figures

# Readings of a stretch that is kept: two in a row say nothing of accelerations, nor do a few.
FEWEST = 16
# A gap is longer than so many of the log's usual steps, and than this, s: a logger that stumbles is no gap.
_GAP_STEPS, _GAP = 5.0, 0.05
# Closer than this share of the usual step, stamps are the same.
_SAME = 0.01
# Time that starts farther from zero than this, s, is a date.
_DATE = 1e6


@dataclass(frozen=True, eq=False)
class Stamps:
    """Which rows of a log are set points, and when.

    Parameters
    ----------
    rows
        Numbers of the rows, from 0, in the order of time, shape (N,).
    time
        s, strictly increasing, shape (N,).
    gaps
        Set points before which there is a gap.
    step
        The usual time between two readings (median), s.
    told
        What was done, a sentence each.
    """

    rows: NDArray[np.intp]
    time: FloatArray
    gaps: tuple[int, ...]
    step: float
    told: tuple[str, ...]

    @property
    def stretches(self) -> list[slice]:
        """Set points of each stretch."""
        ends = [0, *self.gaps, len(self.time)]
        return [slice(a, b) for a, b in pairwise(ends)]

    @classmethod
    def of(
        cls, time: FloatArray, readable: NDArray[np.bool_], largest_gap: float | None, name: str, fewest: int
    ) -> Stamps:
        """Put instants in order.

        Parameters
        ----------
        time
            As logged, s, shape (M,).
        readable
            Rows that hold all that is needed.
        largest_gap
            Longest step that is no gap, s; None: five usual steps, and 0.05 s at least.
        name
            Of the log, for messages.
        fewest
            Readings of a stretch that is kept.

        Raises
        ------
        TrajectoryError
            If no stretch has enough readings.
        """
        told: list[str] = []
        rows = np.flatnonzero(readable & np.isfinite(time))
        if len(rows) < len(time):
            told.append(f"{_rows(len(time) - len(rows))} with empty cells left out")
        times = time[rows]
        forward = np.diff(times)
        if not (forward > 0).any():
            raise _too_few(name, f"{len(rows)} at one instant" if len(rows) else "none", fewest)
        step = float(np.median(forward[forward > 0]))
        gap = max(_GAP_STEPS * step, _GAP) if largest_gap is None else max(largest_gap, 1.5 * step)
        rows, times = _in_order(rows, times, gap, told)
        # Of the same stamps the last: a message sent again holds what is newest.
        kept = np.append(np.diff(times) > _SAME * step, True)
        if not kept.all():
            told.append(f"{_rows(int((~kept).sum()))} left out whose stamp the next one repeats")
        rows, times = rows[kept], times[kept]
        return cls._cut(rows, times, gap, step, told, name, fewest)

    @classmethod
    def _cut(
        cls,
        rows: NDArray[np.intp],
        times: FloatArray,
        gap: float,
        step: float,
        told: list[str],
        name: str,
        fewest: int,
    ) -> Stamps:
        """Cut at gaps, and leave short stretches out."""
        begins = np.concatenate([[0], np.flatnonzero(np.diff(times) > gap) + 1])
        lengths = np.diff(np.append(begins, len(times)))
        long_enough = lengths >= fewest
        if not long_enough.any():
            among = f" at most, in {len(begins)} stretches between gaps" if len(begins) > 1 else ""
            raise _too_few(name, f"{lengths.max()}{among}", fewest)
        if not long_enough.all():
            short = int((~long_enough).sum())
            told.append(
                f"{short} stretch{'es' * (short > 1)} of fewer than {fewest} readings between gaps left out "
                f"({_rows(int(lengths[~long_enough].sum()))})"
            )
        kept = np.repeat(long_enough, lengths)
        gaps = tuple(np.cumsum(lengths[long_enough])[:-1].tolist())
        if gaps:
            told.append(
                f"{len(gaps)} gap{'s' * (len(gaps) > 1)} longer than {figures(gap)} s: nothing is "
                "differentiated, smoothed or bounded across"
            )
        return cls(rows[kept], _from_first(times[kept], told), gaps, step, tuple(told))


def _from_first(times: FloatArray, told: list[str]) -> FloatArray:
    """Count from the first reading where stamps are dates, unless that takes digits that tell them apart."""
    since = times - times[0]
    if abs(times[0]) <= _DATE or not (np.diff(since) > 0).all():
        return times
    told.append("time counts from the first reading")
    return since


def _in_order(
    rows: NDArray[np.intp], times: FloatArray, gap: float, told: list[str]
) -> tuple[NDArray[np.intp], FloatArray]:
    """Sort by time; where a clock starts again, what follows comes after what was before."""
    begins = np.concatenate([[0], np.flatnonzero(np.diff(times) < -gap) + 1])
    parts = np.split(times, begins[1:])
    spans = sorted((float(part.min()), float(part.max())) for part in parts)
    overlap = any(after[0] <= before[1] for before, after in pairwise(spans))
    if len(parts) > 1 and overlap and len(parts) * FEWEST <= len(times):
        moved, end = [], -np.inf
        for part in parts:
            shift = max(0.0, end + 2 * gap - float(part.min()))
            moved.append(part + shift)
            end = float(moved[-1].max())
        times = np.concatenate(moved)
        again = len(parts) - 1
        told.append(
            f"time starts again {again} time{'s' * (again > 1)}, first at row {rows[begins[1]] + 1}: what "
            "follows is taken for a motion after the one before, behind a gap"
        )
    unsorted = int((np.diff(times) < 0).sum())
    if unsorted:
        told.append(f"stamps put in order: {unsorted} stood after a later one")
        order = np.argsort(times, kind="stable")
        rows, times = rows[order], times[order]
    return rows, times


def _rows(count: int) -> str:
    return f"{count} row{'s' * (count > 1)}"


def _too_few(name: str, found: str, fewest: int) -> TrajectoryError:
    return TrajectoryError(
        "the log has too few readings in a row",
        where=name,
        expected=f"a stretch of at least {fewest} readings at different instants without a gap",
        found=found,
        next_step="check the unit of time, or give a larger --largest-gap" if "gaps" in found else None,
    )
