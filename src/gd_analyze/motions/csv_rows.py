"""The lines of a trajectory file: cells to numbers, blaming the exact cell."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gd_analyze.arrays import FloatArray, are_possible
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.cells import number_of, split_cells, wrong_width


@dataclass(frozen=True)
class Rows:
    """Lines of cells, the header first, and where in the file they stand, from 1."""

    path: str | Path
    lines: Sequence[str]
    line_numbers: Sequence[int]

    @property
    def delimiter(self) -> str:
        """What separates cells."""
        return max(",;\t", key=self.lines[0].count)

    def place(self, row: int, column: int | None = None) -> Location:
        """Place of a row, or of a column of it; both count from 0."""
        return Location(self.path, self.line_numbers[row], None if column is None else int(column) + 1)

    def cells(self, row: int) -> list[str]:
        """Split one row into its cells.

        Raises
        ------
        TrajectoryError
            If a quote is left open, or a cell is far too long for a number.
        """
        return split_cells(self.lines[row], self.delimiter, self.place(row))

    def numbers(self, names: Sequence[str], time: int) -> FloatArray:
        """All numbers below the header, finite and in time, shape (rows, columns).

        Parameters
        ----------
        names
            What the columns are called.
        time
            Column of the time, from 0.

        Raises
        ------
        TrajectoryError
            If a line has too few or too many cells, a cell is no finite number or time does not increase.
        """
        below = self.lines[1:]
        try:
            # As lines: a text in memory would take four bytes a character once more.
            table = np.loadtxt(iter(below), delimiter=self.delimiter, comments=None, quotechar='"', ndmin=2)
            sound = table.shape == (len(below), len(names)) and are_possible(table)
        except ValueError:
            sound = False
        if not sound:  # slower, but knows where it is when something is wrong
            table = np.array([self._numbers_of(row, names) for row in range(1, len(self.lines))])
        self._check_time(table[:, time], time)
        return table

    def _numbers_of(self, row: int, names: Sequence[str]) -> list[float]:
        cells = self.cells(row)
        if len(cells) != len(names):
            raise wrong_width(len(cells), len(names), self.place(row, min(len(cells), len(names))))
        return [
            number_of(cell.strip(), name, self.place(row, column))
            for column, (cell, name) in enumerate(zip(cells, names, strict=True))
        ]

    def _check_time(self, time: FloatArray, column: int) -> None:
        wrong = np.flatnonzero(np.diff(time) <= 0)
        if wrong.size:
            k = int(wrong[0])
            raise TrajectoryError(
                "time does not increase",
                where=self.place(k + 2, column),
                expected=f"more than {time[k]!s} s, the time of the line before",
                found=f"{time[k + 1]!s} s",
                next_step="sort the set points by time and keep one for each instant",
            )
