"""Cells of text tables: what is wrong with one, and where."""

from __future__ import annotations

import csv
import re

from gd_analyze.arrays import are_possible
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.text import LARGEST, in_python, number_in

WITH_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]+)?")


def split_cells(line: str, delimiter: str, where: Location) -> list[str]:
    """Split a line; a blank as delimiter stands for any white space.

    Raises
    ------
    TrajectoryError
        If a quote is left open, or a cell is far too long for a number.
    """
    if delimiter == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=delimiter, strict=True), [])
    except csv.Error as error:
        raise TrajectoryError(
            "the line is not CSV",
            where=where,
            expected="short cells between commas, every quote closed",
            found=str(error),
            next_step="check that the file is a trajectory",
        ) from None


def wrong_width(
    found: int, expected: int, where: Location, as_in: str = "as in the header"
) -> TrajectoryError:
    """Error of a line with too few or too many cells."""
    return TrajectoryError(
        f"the line has too {'few' if found < expected else 'many'} columns",
        where=where,
        expected=f"{expected} columns, {as_in}",
        found=str(found),
        next_step="complete the line, or remove it if the recording broke off there",
    )


def number_of(cell: str, name: str, where: Location) -> float:
    """Read a number, finite and of a possible size.

    Raises
    ------
    TrajectoryError
        If it is none.
    """
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
        raise TrajectoryError(
            f"{name} is not a number",
            where=where,
            expected="a number in the digits 0 to 9, such as -1.5 or 2e-3",
            found=in_python(cell) if cell else "an empty cell",
            next_step="write decimal points, not commas"
            if WITH_COMMA.fullmatch(cell)
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
