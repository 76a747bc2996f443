"""How a text table is laid out, and what is wrong with a cell of it."""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from gd_analyze.arrays import are_possible
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.units import unit_in_words
from gd_analyze.text import LARGEST, in_python, number_in

# Names of columns in logs of robots, topics included, are shorter.
_LONGEST_NAME = 200
# Lines by which a file is judged.
_JUDGED = 8
EMPTY = frozenset({"", "nan", "-nan", "na", "n/a", "null", "none", "-"})
_WITH_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]+)?")


@dataclass(frozen=True)
class Layout:
    """How the lines of a text table are to be read."""

    delimiter: str  # comma, semicolon or tab; a blank stands for any white space
    decimal: str  # point or comma
    names: tuple[str, ...]  # names of the columns, empty ones where no line has them
    header: int  # line of the names, from 1; 0 where there is none
    first: int  # line of the first row, from 1

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.names)

    def plain(self, cell: str) -> str:
        """A cell with a decimal point."""
        return cell.replace(",", ".") if self.decimal == "," else cell


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with a point or a comma."""
    short = len(cell) <= _LONGEST_NAME  # of many digits and a letter, the expressions take quadratic time
    return short and (number_in(cell) is not None or bool(_WITH_COMMA.fullmatch(cell.strip())))


def layout_of(lines: Sequence[str], path: str | Path) -> Layout:
    """Find out how a text table is laid out; TrajectoryError if there is no row, or a name is no column's."""
    rows = [
        (k, line) for k, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        found = "comments only" if any(line.strip() for line in lines) else "no data"
        expected = "a line of names, such as time,q1,q2, and a line per instant"
        step = "check the recording; `gd-analyze plan --help` shows how to make a trajectory"
        raise refusal("the file is empty", Location(path), expected, found, step)
    delimiter = _delimiter([line for _, line in rows[:_JUDGED]])
    number, first = rows[0]
    cells = [cell.strip() for cell in split_cells(first.lstrip("%"), delimiter, Location(path, number))]
    # Two numbers, then text: a `ros2 topic echo --csv` of few joints.
    echoed = len(cells) > 4 and all(re.fullmatch("[0-9]+", cell) for cell in cells[:2])
    if sum(map(is_number, cells)) <= len(cells) / 2 and not echoed:
        if first.startswith("%") and cells:
            cells[0] = f"%{cells[0]}"
        if len(rows) == 1:
            expected, step = "one line per instant", "check the recording, or add a line for each instant"
            raise refusal("the file holds a header only", Location(path, number), expected, "none", step)
        header = number
        names, (begin, row) = _with_units(cells, rows[1:3], delimiter)
    else:
        names, header = _commented_names(lines[: number - 1], delimiter, len(cells))
        begin, row = number, first
    refuse_long_names(names, Location(path, header))
    values = split_cells(row, delimiter, Location(path, begin))
    # Between commas a decimal comma stands in quotes.
    comma = any(_WITH_COMMA.fullmatch(cell.strip()) for cell in values)
    return Layout(delimiter, "," if comma else ".", names, header, begin)


def _with_units(
    names: Sequence[str], following: Sequence[tuple[int, str]], delimiter: str
) -> tuple[tuple[str, ...], tuple[int, str]]:
    """Names with the units of a line below them, if it is one, and the first row."""
    units = [cell.strip().strip("[]()") for cell in following[0][1].split(delimiter)]
    said = [unit for unit in units if unit not in ("", "-", "1")]
    if len(following) < 2 or len(units) != len(names) or not said or None in map(unit_in_words, said):
        return tuple(names), following[0]
    pairs = zip(names, units, strict=True)
    return tuple(f"{name} [{unit}]" if unit in said else name for name, unit in pairs), following[1]


def _delimiter(lines: Sequence[str]) -> str:
    """The sign that stands equally often in every line; a decimal comma does so too, and comes last."""
    for sign in "\t;,":
        counts = {line.count(sign) for line in lines}
        if len(counts) == 1 and counts != {0}:
            return sign
    most = max("\t;,", key=lines[0].count)
    return most if most in lines[0] else " "


def _commented_names(before: Sequence[str], delimiter: str, width: int) -> tuple[tuple[str, ...], int]:
    """Names in the last comment above the rows, as numpy.savetxt writes them."""
    for number in range(len(before), 0, -1):
        line = before[number - 1].strip()
        if line.startswith("#"):
            text = line.lstrip("# \t")
            for sign in (delimiter, ",", "\t", " "):
                cells = text.split() if sign == " " else [cell.strip() for cell in text.split(sign)]
                if len(cells) == width and not any(map(is_number, cells)):
                    return tuple(cells), number
            break
    return ("",) * width, 0


def refuse_long_names(names: Sequence[str], where: Location) -> None:
    """Raise a TrajectoryError where a name is longer than any column's."""
    for column, name in enumerate(names, start=1):
        if len(name) > _LONGEST_NAME:
            raise refusal(
                f"the name of column {column} is far too long",
                Location(where.path, where.line, column),
                f"a name such as time or q1, up to {_LONGEST_NAME} characters",
                in_python(name),
                "check that the file is a log or a trajectory",
            )


def split_cells(line: str, delimiter: str, where: Location) -> list[str]:
    """Split a line; TrajectoryError where a quote is left open or a cell is far too long."""
    if delimiter == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=delimiter, strict=True), [])
    except csv.Error as error:
        expected = "short cells between commas, every quote closed"
        raise refusal("the line is not CSV", where, expected, str(error)) from None


def wrong_width(found: int, layout: Layout, path: str | Path, line: int) -> TrajectoryError:
    """Error of a line with too few or too many cells."""
    return refusal(
        f"the line has too {'few' if found < layout.width else 'many'} columns",
        Location(path, line, min(found, layout.width) + 1),
        f"{layout.width} columns, as in the {'header' if layout.header else 'first line'}",
        str(found),
        "complete the line, or remove it if the recording broke off there",
    )


def require_number(cell: str, name: str, where: Location) -> None:
    """Raise a TrajectoryError where a cell is no finite number of a possible size."""
    number = number_in(cell)
    if number is None and cell.lower() in EMPTY | {"inf", "-inf", "infinity", "-infinity"}:
        expected, next_step = "a finite number", "replace or remove the line; gaps are not filled in"
        raise refusal(f"{name} is no finite number", where, expected, cell or "an empty cell", next_step)
    if number is None:
        raise refusal(
            f"{name} is not a number",
            where,
            "a number in the digits 0 to 9, such as -1.5 or 2e-3",
            in_python(cell),
            "write decimal points, not commas" if _WITH_COMMA.fullmatch(cell) else "correct the cell",
        )
    if not are_possible(number):
        expected, next_step = (f"numbers up to {LARGEST:g}", "check its unit: time is in seconds")
        raise refusal(f"{name} is too large for any motion", where, expected, in_python(cell), next_step)
