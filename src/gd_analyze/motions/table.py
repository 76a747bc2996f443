"""A log as a table: named columns, read when they are asked for."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.reading import refusal

# Called with how much of how much has been read.
Progress = Callable[[int, int], None]

# Rows by which a column is judged.
HEAD_ROWS = 200


def no_progress(_done: int, _total: int) -> None:
    """Ignore progress."""


@dataclass(frozen=True, eq=False)
class Stamps:
    """Instants as a whole number, which may be an epoch in nanoseconds, and what is added to it."""

    base: int
    rest: FloatArray

    @classmethod
    def of(cls, values: FloatArray | NDArray[np.int64]) -> Stamps:
        """Split instants that are held exactly."""
        finite = values[np.isfinite(values)]
        base = int(finite[0]) if finite.size and abs(finite[0]) < 2.0**62 else 0
        return cls(base, (values - base).astype(float, copy=False))


@dataclass(frozen=True, eq=False)
class Columns:
    """What was read."""

    numbers: FloatArray  # (N, k)
    stamps: tuple[Stamps, ...]
    gaps: tuple[int, ...] = ()  # rows before which the file states a gap


class LogTable(ABC):
    """What the readers of all formats give."""

    path: str | Path  # where it was read, for messages
    names: tuple[str, ...]  # names of the columns; all empty where there is no header
    planned: bool | None = None  # whether the kind of message is a plan; None where it does not say
    set_points: bool = False  # whether the file's own header is that of set points: time, q1, qd1_deg

    @abstractmethod
    def head(self, column: int) -> list[str | float]:
        """First cells of a column: floats, or text where they are no numbers."""

    @abstractmethod
    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Read columns, counted from 0; nan where a cell is empty."""

    def stands(self, column: int) -> bool:
        """Whether the first numbers of a column are several, and the same."""
        first = self.head(column)
        return len(first) > 1 and len(set(first)) == 1

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place of a row, a column or both, counted from 0."""
        return Location(self.path, None if row is None else row + 1, None if column is None else column + 1)

    def label(self, column: int) -> str:
        """Name of a column, or its number."""
        return self.names[column] or f"column {column + 1}"


class ArrayTable(LogTable):
    """A table in memory: arrays of floats, or of integers such as stamps in nanoseconds, one per name."""

    def __init__(
        self,
        path: str | Path,
        names: tuple[str, ...],
        columns: tuple[FloatArray | NDArray[np.int64], ...],
        planned: bool | None = None,
    ) -> None:
        self.path, self.names, self.columns, self.planned = path, names, columns, planned

    def head(self, column: int) -> list[str | float]:
        """First numbers of a column."""
        return list(self.columns[column][:HEAD_ROWS].tolist())

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Take columns."""
        table = np.empty((len(self.columns[0]), len(numbers)))
        for k, column in enumerate(numbers):
            table[:, k] = self.columns[column]
        progress(1, 1)
        return Columns(table, tuple(Stamps.of(self.columns[column]) for column in stamps))


def missing_library(library: str, path: str | Path) -> TrajectoryError:
    """Error of a log that needs a library which is not installed."""
    what, step = f"this log needs the library {library}", f"pip install {library}"
    return refusal(what, Location(path), library, "it is not installed", step)
