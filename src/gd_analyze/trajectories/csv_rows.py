"""The lines of a trajectory file: cells to numbers, blaming the exact cell."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.given_numbers import LARGEST, are_possible, number_in
from gd_analyze.vectors import FloatArray
from gd_analyze.visible import in_python

_WITH_COMMA = re.compile(r"[-+]?[0-9]+,[0-9]+([eE][-+]?[0-9]+)?")


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
        try:
            return next(csv.reader([self.lines[row]], delimiter=self.delimiter, strict=True))
        except csv.Error as error:
            raise TrajectoryError(
                "the line is not CSV",
                where=self.place(row),
                expected="short cells between commas, every quote closed",
                found=str(error),
                next_step="check that the file is a trajectory",
            ) from None

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
            raise TrajectoryError(
                f"the line has too {'few' if len(cells) < len(names) else 'many'} columns",
                where=self.place(row, min(len(cells), len(names))),
                expected=f"{len(names)} columns, as in the header",
                found=str(len(cells)),
                next_step="complete the line, or remove it if the recording broke off there",
            )
        return [
            _number(cell.strip(), name, self.place(row, column))
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


def _number(cell: str, name: str, where: Location) -> float:
    number = number_in(cell)
    if number is None:
        if cell.lower().lstrip("+-") in ("nan", "inf", "infinity"):
            raise TrajectoryError(
                f"{name} is not a finite number",
                where=where,
                expected="a finite number",
                found=cell,
                next_step="replace or remove the set point; gaps are not filled in",
            )
        comma = _WITH_COMMA.fullmatch(cell)
        raise TrajectoryError(
            f"{name} is not a number",
            where=where,
            expected="a number in the digits 0 to 9, such as -1.5 or 2e-3",
            found=in_python(cell) if cell else "an empty cell",
            next_step="write decimal points, not commas"
            if comma
            else "give a number there, or remove the set point",
        )
    if not are_possible(number):
        raise TrajectoryError(
            f"{name} is too large for any motion",
            where=where,
            expected=f"numbers up to {LARGEST:g}",
            found=in_python(cell),
            next_step="check its unit: time is in seconds, and may start at 0",
        )
    return number
