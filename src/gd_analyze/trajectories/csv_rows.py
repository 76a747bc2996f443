"""The data lines of a trajectory file: text to numbers, blaming the exact cell."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.trajectories.csv_columns import Columns
from gd_analyze.vectors import FloatArray


def split_cells(line: str, delimiter: str, where: Location) -> list[str]:
    """Split one line into its cells.

    Raises
    ------
    TrajectoryError
        If a quote is left open, or a cell is far too long for a number.
    """
    try:
        return next(csv.reader([line], delimiter=delimiter, strict=True))
    except csv.Error as error:
        raise TrajectoryError(
            "the line is not CSV",
            where=where,
            expected="short cells between commas, every quote closed",
            found=str(error),
            next_step="check that the file is a trajectory",
        ) from None


@dataclass(frozen=True)
class Rows:
    """Data lines, parsed fast when sound and slowly, cell by cell, when not.

    Parameters
    ----------
    path
        Their file, for messages.
    columns
        What the columns mean.
    lines, line_numbers
        The lines and where in the file they stand, from 1.
    delimiter
        What separates cells.
    """

    path: str | Path
    columns: Columns
    lines: Sequence[str]
    line_numbers: Sequence[int]
    delimiter: str

    def parse(self) -> FloatArray:
        """All numbers, shape (rows, columns), finite, time increasing."""
        width = len(self.columns.names)
        try:
            table = np.loadtxt(
                io.StringIO("\n".join(self.lines)),
                delimiter=self.delimiter,
                comments=None,
                quotechar='"',
                ndmin=2,
            )
        except ValueError:
            table = self._parse_cells()
        if table.shape != (len(self.lines), width):
            table = self._parse_cells()
        if not np.isfinite(table).all():
            row, column = np.argwhere(~np.isfinite(table))[0]
            raise TrajectoryError(
                f"{self.columns.names[column]} is not a finite number",
                where=self._place(row, column),
                expected="a finite number",
                found=self._cells(row)[column].strip(),
                next_step="replace or remove the set point; gaps are not filled in",
            )
        self._check_time(table[:, self.columns.time])
        return table

    def _parse_cells(self) -> FloatArray:
        """Parse cell by cell; slow, but knows where it is when something is wrong."""
        names = self.columns.names
        values = []
        for row in range(len(self.lines)):
            cells = self._cells(row)
            if len(cells) != len(names):
                raise TrajectoryError(
                    f"the line has too {'few' if len(cells) < len(names) else 'many'} columns",
                    where=self._place(row, min(len(cells), len(names))),
                    expected=f"{len(names)} columns, as in the header",
                    found=str(len(cells)),
                    next_step="complete the line, or remove it if the recording broke off there",
                )
            values.append([self._number(row, column, cell) for column, cell in enumerate(cells)])
        return np.array(values)

    def _number(self, row: int, column: int, cell: str) -> float:
        try:
            return float(cell)
        except ValueError:
            pass
        next_step = "give a number there, or remove the set point"
        if re.fullmatch(r"\s*[-+]?\d+,\d+([eE][-+]?\d+)?\s*", cell):
            next_step = "write decimal points, not commas"
        raise TrajectoryError(
            f"{self.columns.names[column]} is not a number",
            where=self._place(row, column),
            expected="a number",
            found=repr(cell.strip()) if cell.strip() else "an empty cell",
            next_step=next_step,
        )

    def _check_time(self, time: FloatArray) -> None:
        wrong = np.flatnonzero(np.diff(time) <= 0)
        if wrong.size:
            row = int(wrong[0]) + 1
            raise TrajectoryError(
                "time does not increase",
                where=self._place(row, self.columns.time),
                expected=f"more than {time[row - 1]!s} s, the time of the line before",
                found=f"{time[row]!s} s",
                next_step="sort the set points by time and keep one for each instant",
            )

    def _cells(self, row: int) -> list[str]:
        return split_cells(self.lines[row], self.delimiter, Location(self.path, self.line_numbers[row]))

    def _place(self, row: int, column: int) -> Location:
        return Location(self.path, self.line_numbers[row], int(column) + 1)
