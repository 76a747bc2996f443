"""How a text table is laid out: what separates its cells, which line has the names, where rows begin."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.cells import WITH_COMMA, split_cells
from gd_analyze.motions.units import unit_in_words
from gd_analyze.text import in_python, number_in

# Names of columns in logs of robots, topics included, are shorter.
LONGEST_NAME = 200
# Lines by which a file is judged.
_JUDGED = 8
EMPTY = frozenset({"", "nan", "-nan", "na", "n/a", "null", "none", "-"})


@dataclass(frozen=True)
class Layout:
    """How the lines of a text table are to be read.

    Parameters
    ----------
    delimiter
        Comma, semicolon or tab; a blank stands for any white space.
    decimal
        Point or comma.
    names
        Names of the columns, empty ones where no line has them.
    header
        Line of the names, from 1; 0 where there is none.
    first
        Line of the first row, from 1.
    """

    delimiter: str
    decimal: str
    names: tuple[str, ...]
    header: int
    first: int

    @property
    def width(self) -> int:
        """Number of columns."""
        return len(self.names)


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with a point or a comma."""
    return number_in(cell) is not None or bool(WITH_COMMA.fullmatch(cell.strip()))


def layout_of(lines: Sequence[str], path: object) -> Layout:
    """Find out how a text table is laid out from its first lines.

    Raises
    ------
    TrajectoryError
        If there is no row, or the names cannot be.
    """
    place = Location(str(path))
    rows = [
        (k, line) for k, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        raise TrajectoryError(
            "the log is empty",
            where=place,
            expected="a line of names and a line per sample",
            found="comments only" if any(line.strip() for line in lines) else "no data",
            next_step="check the recording",
        )
    delimiter = _delimiter([line for _, line in rows[:_JUDGED]])
    number, first = rows[0]
    cells = [cell.strip() for cell in split_cells(first.lstrip("%"), delimiter, Location(str(path), number))]
    if sum(map(is_number, cells)) <= len(cells) / 2 and not _are_echoed(cells):
        if first.startswith("%") and cells:
            cells[0] = f"%{cells[0]}"
        if len(rows) == 1:
            raise TrajectoryError(
                "the log holds a header only",
                where=Location(str(path), number),
                expected="one line per sample",
                found="none",
                next_step="check the recording",
            )
        header = number
        names, (begin, row) = _with_units(cells, rows[1:3], delimiter)
    else:
        names, header = _commented_names(lines[: number - 1], delimiter, len(cells))
        begin, row = number, first
    refuse_long_names(names, Location(str(path), header))
    values = [cell.strip() for cell in split_cells(row, delimiter, Location(str(path), begin))]
    # Between commas a decimal comma stands in quotes.
    comma = any(WITH_COMMA.fullmatch(cell) for cell in values)
    return Layout(delimiter, "," if comma else ".", names, header, begin)


def _with_units(
    names: Sequence[str], following: Sequence[tuple[int, str]], delimiter: str
) -> tuple[tuple[str, ...], tuple[int, str]]:
    """Names with the units of a line below them, if it is one, and the first row."""
    units = [cell.strip().strip("[]()") for cell in following[0][1].split(delimiter)]
    said = [unit for unit in units if unit not in ("", "-", "1")]
    if len(following) < 2 or len(units) != len(names) or not said or None in map(unit_in_words, said):
        return tuple(names), following[0]
    return tuple(
        f"{n} [{unit}]" if unit in said else n for n, unit in zip(names, units, strict=True)
    ), following[1]


def _delimiter(lines: Sequence[str]) -> str:
    """The sign that stands equally often in every line; a decimal comma does so too, and comes last."""
    for sign in "\t;,":
        counts = {line.count(sign) for line in lines}
        if len(counts) == 1 and counts != {0}:
            return sign
    most = max("\t;,", key=lines[0].count)
    return most if most in lines[0] else " "


def _are_echoed(cells: Sequence[str]) -> bool:
    """Whether the cells are those of a `ros2 topic echo --csv` of few joints: two numbers, then text."""
    return len(cells) > 4 and all(re.fullmatch("[0-9]+", cell) for cell in cells[:2])


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
        if len(name) > LONGEST_NAME:
            raise TrajectoryError(
                f"the name of column {column} is far too long",
                where=Location(where.path, where.line, column),
                expected=f"a name such as time or q1, up to {LONGEST_NAME} characters",
                found=in_python(name),
                next_step="check that the file is a log",
            )
