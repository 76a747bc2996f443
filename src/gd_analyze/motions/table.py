"""A log as a table: named columns of numbers, read when they are asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location

# Told how many bytes of how many have been read.
Progress = Callable[[int, int], None]


def no_progress(_done: int, _total: int) -> None:
    """Tell nobody."""


@dataclass(frozen=True, eq=False)
class Stamps:
    """A column of instants: a whole number, which may be an epoch in nanoseconds, and what is added to it."""

    base: int
    rest: FloatArray

    @classmethod
    def of(cls, values: FloatArray | NDArray[np.int64]) -> Stamps:
        """Split instants that are held exactly; those of a column of zeros and ones stay as they are."""
        if values.dtype.kind in "iu":
            base = int(values[0]) if len(values) else 0
            return cls(base, (values - base).astype(float))
        finite = values[np.isfinite(values)]
        base = int(finite[0]) if finite.size and abs(finite[0]) < 2.0**62 else 0
        return cls(base, (values - base).astype(float, copy=False))


@dataclass(frozen=True, eq=False)
class Columns:
    """What was read: numbers, shape (N, k), and the columns of instants that were asked for."""

    numbers: FloatArray
    stamps: tuple[Stamps, ...]


class LogTable(Protocol):
    """What the readers of all formats give."""

    @property
    def path(self) -> str | Path:
        """Where it was read, for messages."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns; empty ones, all of them, where there is no header."""

    @property
    def planned(self) -> bool | None:
        """Whether the kind of message says that this is a plan, or that it is measured; None of a table."""

    def head(self, column: int) -> list[str | float]:
        """First cells of a column: floats, or text where they are no numbers."""

    def stands(self, column: int) -> bool:
        """Whether the first cells of a column are the same to their last digit, and several."""

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Read columns, counted from 0; nan where a cell is empty.

        Raises
        ------
        TrajectoryError
            If a line is broken, or a cell no number.
        """

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place of a row, a column or both, counted from 0."""


_HEAD = 200


@dataclass(frozen=True, eq=False)
class ArrayTable:
    """A table in memory; `whole` are its columns of integers, such as stamps in nanoseconds.

    Parameters
    ----------
    path, names, planned
        As a `LogTable` has them.
    columns
        Arrays of floats or of integers, one per name.
    texts
        First cells of columns that hold text.
    row_name
        What a row is, for messages.
    """

    path: str | Path
    names: tuple[str, ...]
    columns: tuple[FloatArray | NDArray[np.int64], ...]
    planned: bool | None = None
    texts: dict[int, list[str]] = field(default_factory=dict)

    def head(self, column: int) -> list[str | float]:
        """First cells of a column."""
        if column in self.texts:
            return list(self.texts[column])
        return [float(x) for x in self.columns[column][:_HEAD]]

    def stands(self, column: int) -> bool:
        """Whether the first numbers are all the same."""
        first = self.columns[column][:_HEAD]
        return len(first) > 1 and bool((first == first[0]).all())

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Take columns."""
        count = len(self.columns[0]) if self.columns else 0
        table = np.empty((count, len(numbers)))
        for k, column in enumerate(numbers):
            table[:, k] = self.columns[column]
        progress(1, 1)
        return Columns(table, tuple(Stamps.of(self.columns[column]) for column in stamps))

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place of a row, told as if it were a line."""
        return Location(self.path, None if row is None else row + 1, None if column is None else column + 1)
