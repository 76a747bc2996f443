"""A log in a text file with commas, semicolons, tabs or blanks; only needed columns are read, in blocks."""

from __future__ import annotations

import csv
import io
import math
import re
import shlex
from codecs import BOM_UTF8
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from decimal import Decimal
from functools import partial
from itertools import chain, islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.column_units import unit_in_words
from gd_analyze.motions.names import are_of_set_points
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import (
    HEAD_ROWS,
    Columns,
    LogTable,
    Stamps,
    add_wrong,
    changed_names,
    nanoseconds_in,
)
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.text import LARGEST, in_python, number_in

# A separate line where the motion between the set points above and below is unknown.
GAP = "# gap"
_COMMENT_OR_BLANK = re.compile(rb"\n[ \t]*[#\n]")
EMPTY = frozenset({"", "nan", "-nan", "na", "n/a", "null", "none", "-"})
_NOT_GIVEN = sorted({word for empty in EMPTY for word in (empty, empty.upper(), empty.capitalize(), "NaN")})
_INFINITE = frozenset({"inf", "-inf", "infinity", "-infinity"})
_SPREADSHEETS = (".xlsx", ".xls", ".ods")
_HEADING = re.compile(r"[A-Za-z]+ ?:\s+")
_WHOLE = re.compile(r"[-+]?[0-9]+")
DECIMAL_COMMAS = "decimal commas"
_WITH_COMMA = re.compile(r"[-+]?[0-9]*,[0-9]+([eE][-+]?[0-9]+)?")


# Column names in robots' logs, topics included, are shorter, and so are numbers.
_LONGEST_NAME = 200


@dataclass(frozen=True)
class TextLayout:
    """Layout of a text table's lines."""

    delimiter: str  # comma, semicolon or tab; a blank means any white space
    decimal: str  # point or comma
    names: tuple[str, ...]  # names of the columns, empty if no line has them
    header: int  # line of the names, from 1; 0 if there is none
    first: int  # line of the first row, from 1

    def plain(self, cell: str) -> str:
        """A cell with a decimal point."""
        return cell.replace(self.decimal, ".")


def is_number(cell: str) -> bool:
    """Whether a cell holds a number, with a point or a comma."""
    short = len(cell) <= _LONGEST_NAME  # on many digits and a letter the expressions take quadratic time
    return short and (number_in(cell) is not None or bool(_WITH_COMMA.fullmatch(cell.strip())))


def _split(line: str, delimiter: str, where: Location) -> list[str]:
    """Cells of a line; TrajectoryError if a quote is left open or a cell is far too long."""
    if delimiter == " ":
        return line.split()
    try:
        return next(csv.reader([line], delimiter=delimiter, strict=True), [])
    except csv.Error as error:
        expected = "short cells between commas, every quote closed"
        raise refusal("the line is not CSV", where, expected, str(error)) from None


# First rows by which delimiters are judged.
_JUDGED_ROWS = 8


def layout_of(lines: Sequence[str], path: str | Path) -> TextLayout:
    """Detect the layout of a text table; TrajectoryError if there is no row, or a name is far too long."""
    rows = [
        (k, line) for k, line in enumerate(lines, 1) if line.strip() and not line.lstrip().startswith("#")
    ]
    if not rows:
        content = "comments only" if any(line.strip() for line in lines) else "no data"
        expected = "a line of names, such as time,q1,q2, and a line per instant"
        step = "check the recording; `gd-analyze plan --help` shows how to make a trajectory"
        raise refusal("the file is empty", Location(path), expected, content, step)
    # The delimiter occurs equally often in every line; so may a decimal comma, which is tried last.
    judged = [line for _, line in rows[:_JUDGED_ROWS]]
    even = (sign for sign in "\t;," if len({line.count(sign) for line in judged}) == 1 and sign in judged[0])
    most = max("\t;,", key=judged[0].count)
    delimiter = next(even, most if most in judged[0] else " ")
    number, first = rows[0]
    cells = [cell.strip() for cell in _split(first.lstrip("%"), delimiter, Location(path, number))]
    # Two numbers, then text: `ros2 topic echo --csv` with few joints.
    echoed = len(cells) > 4 and all(re.fullmatch("[0-9]+", cell) for cell in cells[:2])
    if sum(map(is_number, cells)) <= len(cells) / 2 and not echoed:
        if first.startswith("%") and cells:
            cells[0] = f"%{cells[0]}"
        if len(rows) == 1:
            expected, step = "one line per instant", "check the recording, or add a line for each instant"
            raise refusal("the file has only a header", Location(path, number), expected, "none", step)
        header = number
        names, (begin, row) = _with_units(cells, rows[1:3], delimiter)
    else:
        names, header = _commented_names(lines[: number - 1], delimiter, len(cells))
        begin, row = number, first
    refuse_long_names(names, Location(path, header))
    values = _split(row, delimiter, Location(path, begin))
    # Between commas a decimal comma is in quotes.
    comma = any(_WITH_COMMA.fullmatch(cell.strip()) for cell in values)
    return TextLayout(delimiter, "," if comma else ".", names, header, begin)


def _with_units(
    names: Sequence[str], following: Sequence[tuple[int, str]], delimiter: str
) -> tuple[tuple[str, ...], tuple[int, str]]:
    """Names with units from the line below, if it has them, and the first row."""
    units = [cell.strip().strip("[]()") for cell in following[0][1].split(delimiter)]
    stated_units = [unit for unit in units if unit not in ("", "-", "1")]
    are_units = stated_units and None not in map(unit_in_words, stated_units)
    if len(following) < 2 or len(units) != len(names) or not are_units:
        return tuple(names), following[0]
    pairs = zip(names, units, strict=True)
    return tuple(f"{name} [{unit}]" if unit in stated_units else name for name, unit in pairs), following[1]


def _commented_names(before: Sequence[str], delimiter: str, width: int) -> tuple[tuple[str, ...], int]:
    """Names in the last comment above the rows, as written by numpy.savetxt, and its line."""
    comments = (k for k in range(len(before), 0, -1) if before[k - 1].strip().startswith("#"))
    number = next(comments, 0)
    # "# columns: time,q1,q2" and "# fields: ..." name the names.
    text = _HEADING.sub("", before[number - 1].strip().lstrip("# \t")) if number else ""
    for sign in (delimiter, ",", "\t", " "):
        cells = text.split() if sign == " " else [cell.strip() for cell in text.split(sign)]
        if len(cells) == width and text and not any(map(is_number, cells)):
            return tuple(cells), number
    return ("",) * width, 0


def refuse_long_names(names: Sequence[str], where: Location) -> None:
    """Raise a TrajectoryError if a name is too long for a column."""
    for column, name in enumerate(names, start=1):
        if len(name) > _LONGEST_NAME:
            message, place = f"name {column} is far too long", Location(where.path, where.line, column)
            expected = f"a name such as time or q1, up to {_LONGEST_NAME} characters"
            raise refusal(message, place, expected, in_python(name), "check that the file is a log")


@dataclass(frozen=True, eq=False)
class _Block:
    """A block of rows."""

    data: bytes  # lines without comments
    numbers: Sequence[int]  # their numbers in the file
    gaps: Sequence[int] = ()  # rows before which there is a gap

    @property
    def lines(self) -> Iterator[tuple[int, str]]:
        """Number and text of each line."""
        texts = self.data.decode("utf-8", errors="replace").split("\n")[:-1]
        return zip(self.numbers, texts, strict=True)


# Bytes of the beginning, where layout and names are found, and of a block of rows.
_HEAD_BYTES = 1_000_000
_BLOCK_BYTES = 2_000_000
# The array of numbers, when it is full, grows by its rows over this.
_GROWTH_DIVISOR = 8
# Doubles hold smaller instants to a few nanoseconds; from larger ones the integer part is split off, which a
# signed integer of 64 bits holds.
_LARGEST_EXACT_INSTANT = 1e6
_LARGEST_BASE = 2.0**62


class TextTable(LogTable):
    """A text file, or the bytes of one."""

    def __init__(self, path: str | Path, data: bytes | None = None) -> None:
        self.path, self.data = path, data
        with self._opened() as file:
            head = file.read(_HEAD_BYTES)
        self._refuse_binary(head)
        try:
            text = head.decode("utf-8-sig")
        except UnicodeDecodeError:
            text = head.decode("latin-1")
        lines = text.replace("\r\n", "\n").replace("\r", "\n").split("\n")
        self.first_lines = lines if len(head) < _HEAD_BYTES else lines[:-1] or lines
        self.layout: TextLayout = layout_of(self.first_lines, path)
        self.names, self.header_line = self.layout.names, self.layout.header or None
        self.about = tuple(lines[: self.layout.first - 1])
        self._head = [self._cells(number, line) for number, line in islice(self._lines(), HEAD_ROWS)]
        self.first_cells = self._head[0]
        self._dates = [k for k in range(len(self.names)) if nanoseconds_in(self._first(k)) is not None]
        self.set_points = all(self.names) and are_of_set_points(self.names) and not self._dates

    def _cells(self, number: int, line: str) -> list[str]:
        return [cell.strip() for cell in _split(line, self.layout.delimiter, Location(self.path, number))]

    def _first(self, column: int) -> str:
        """First cell of a column that is not empty."""
        cells = (row[column] for row in self._head if column < len(row))
        return next((cell for cell in cells if cell.lower() not in EMPTY), "")

    def require_constant(self, first: Mapping[int, str], *, or_empty: bool = False) -> None:
        """Raise a TrajectoryError if a text column is not constant, or is empty unless `or_empty`."""
        for number, cells in self.rows():
            if isinstance(cells, TrajectoryError):
                continue
            for column, expected in first.items():
                cell = cells[column]
                if cell != expected and not (or_empty and cell.lower() in EMPTY):
                    raise changed_names(Location(self.path, number, column + 1), expected, cell or "nothing")

    def head(self, column: int) -> list[str | float]:
        """First cells of a column; dates in seconds."""
        return [self.value(row[column] if column < len(row) else "") for row in self._head]

    def value(self, cell: str) -> str | float:
        """Number in a cell, seconds of a date, nan where it is empty; or any other text as it is."""
        if cell.lower() in EMPTY | _INFINITE:
            return math.nan
        number, date = number_in(self.layout.plain(cell)), nanoseconds_in(cell)
        return number if number is not None else cell if date is None else 1e-9 * date

    def stands(self, column: int) -> bool:
        """Whether the column begins with several cells that are equal to the last digit."""
        cells = {row[column] for row in self._head if column < len(row)}
        return len(self._head) > 1 and len(cells) == 1 and "" not in cells

    def cell(self, row: int, column: int) -> str:
        """A cell as written."""
        return self._cells(*next(islice(self._lines(), row, None)))[column]

    def _lines(self) -> Iterator[tuple[int, str]]:
        """Number and text of each row's line."""
        return chain.from_iterable(block.lines for block in self._blocks())

    def lines_of(self, rows: Sequence[int]) -> list[int]:
        """Line of each row, both in ascending order, in one pass through the file."""
        numbers = chain.from_iterable(block.numbers for block in self._blocks())
        wanted = {*rows}
        return [number for row, number in enumerate(numbers) if row in wanted]

    def rows(self) -> Iterator[tuple[int, list[str] | TrajectoryError]]:
        """Line and cells of every row, or why it cannot be read."""
        for number, line in self._lines():
            try:
                yield number, self._row(number, line)
            except TrajectoryError as error:
                yield number, error

    def _row(self, number: int, line: str) -> list[str]:
        """Cells of a line; TrajectoryError if there is not one per column."""
        cells, width = self._cells(number, line), len(self.names)
        if len(cells) != width:
            message = f"the line has too {'few' if len(cells) < width else 'many'} columns"
            where = Location(self.path, number, min(len(cells), width) + 1)
            expected = f"{width} columns, as in the {'header' if self.layout.header else 'first line'}"
            step = "complete the line, or remove it if the recording broke off there"
            # Most numbers take two cells then; one cell too many is a slip.
            are_halves = 2 * len(cells) >= 3 * width and all(map(_WHOLE.fullmatch, cells))
            if are_halves and self.layout.delimiter == ",":
                message = f"{message}: its numbers have {DECIMAL_COMMAS}"
                step = "write decimal points, or separate the columns by semicolons"
            raise refusal(message, where, expected, str(len(cells)), step)
        return cells

    def read(self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress) -> Columns:
        """Read columns in one pass through the file."""
        bases = {column: self._base(column) for column in stamps}
        values, count, width = np.empty((0, len(numbers))), 0, len(numbers)
        offsets = [np.empty((0, len(stamps)))]
        gaps, wrong = list[int](), dict[int, TrajectoryError]()
        for block in self._blocks(progress):
            gaps += [count + gap for gap in block.gaps]
            table = self._by_pandas(block, numbers, bases) if block.numbers else None
            if table is None:
                table, of_block = self._by_lines(block, numbers, bases)
                for row, error in of_block.items():
                    add_wrong(wrong, count + row, error)
            end = count + len(table)
            if end > len(values):
                # Grown in place: joining all blocks in the end would hold a long log twice.
                values.resize((end + count // _GROWTH_DIVISOR, width), refcheck=False)
            values[count:end] = table[:, :width]
            offsets.append(table[:, width:].copy())
            count = end
        values.resize((count, width), refcheck=False)
        instants = tuple(
            Stamps(bases[column] or 0, of_column, "ns" if column in self._dates else "")
            for column, of_column in zip(stamps, np.concatenate(offsets).T, strict=True)
        )
        gaps = [gap for gap in dict.fromkeys(gaps) if 0 < gap < count]
        return Columns(values, instants, tuple(gaps), wrong)

    def _base(self, column: int) -> int | None:
        """Integer by which a column's instants are lessened, by the first; None where doubles hold them."""
        first = self._first(column)
        number = number_in(self.layout.plain(first))
        is_large = number is not None and _LARGEST_EXACT_INSTANT <= abs(number) < _LARGEST_BASE
        return int(number) if number is not None and is_large else nanoseconds_in(first)

    def _offset(self, cell: str, column: int, base: int) -> float:
        """Instant in a cell from the base, by its digits; ValueError or ArithmeticError if it is none."""
        plain = self.layout.plain(cell)
        if column in self._dates:
            instant: int | Decimal | None = nanoseconds_in(cell)
        else:  # Decimal also takes 1_000 and digits of other scripts
            instant = Decimal(plain) if plain.isascii() and "_" not in plain else None
        offset = math.nan if instant is None else float(instant - base)
        if not math.isfinite(offset):
            raise ValueError
        return offset

    def _by_pandas(
        self, block: _Block, numbers: Sequence[int], bases: Mapping[int, int | None]
    ) -> FloatArray | None:
        """Columns of numbers, then of instants, of a block; None if a row may be wrong."""
        import pandas as pd

        layout, columns = self.layout, [*numbers, *bases]
        as_text = {column: base for column, base in bases.items() if base is not None}
        # Since 3.1 pandas reads every digit, and warns if told to.
        release = tuple(int(part) for part in pd.__version__.split(".")[:2])
        options: dict[str, Any] = {} if release >= (3, 1) else {"float_precision": "round_trip"}
        try:
            # Pandas would leave out a byte order mark anywhere, and take lines of any width.
            if block.data.startswith(BOM_UTF8) or {*self._widths(block)} != {len(self.names)}:
                return None
            frame = pd.read_csv(
                io.BytesIO(block.data),
                header=None,
                names=range(len(self.names)),
                index_col=False,
                usecols=sorted({*columns}),
                sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
                decimal=layout.decimal,
                dtype={column: object if column in as_text else float for column in columns},
                skipinitialspace=True,
                keep_default_na=False,
                na_values=_NOT_GIVEN,
                skip_blank_lines=False,
                encoding_errors="replace",
                low_memory=False,
                **options,
            )
            for column, base in as_text.items():
                offset = partial(self._offset, column=column, base=base)
                frame[column] = frame[column].map(offset, na_action="ignore")
        except (ValueError, ArithmeticError, csv.Error):
            return None
        table, width = frame[columns].to_numpy(dtype=float), len(numbers)
        is_large = (np.abs(table[:, :width]) > LARGEST).any() or np.isinf(table[:, width:]).any()
        return None if is_large or len(table) != len(block.numbers) else table

    def _widths(self, block: _Block) -> list[int]:
        """Number of cells in each line; csv.Error if a quote is left open."""
        sign, lines = self.layout.delimiter, block.data.split(b"\n")[:-1]
        if sign == " ":
            return [len(line.split()) for line in lines]
        if b'"' not in block.data:
            return [line.count(sign.encode()) + 1 for line in lines]
        texts = (text for _, text in block.lines)
        return [len(cells) for cells in csv.reader(texts, delimiter=sign, strict=True)]

    def _by_lines(
        self, block: _Block, numbers: Sequence[int], bases: Mapping[int, int | None]
    ) -> tuple[FloatArray, dict[int, TrajectoryError]]:
        """The same, nan in rows that are wrong, and why they are; slow, but finds the place."""
        columns = [*numbers, *bases]
        table = np.full((len(block.numbers), len(columns)), np.nan)
        wrong: dict[int, TrajectoryError] = {}
        for row, (line, text) in enumerate(block.lines):
            try:
                cells = self._row(line, text)
                values = {k: self._number(cells[k], k, line, bases) for k in sorted(columns)}
            except TrajectoryError as error:
                add_wrong(wrong, row, error.with_traceback(None))  # which holds the block
            else:
                table[row] = [values[column] for column in columns]
        return table, wrong

    def _number(self, cell: str, column: int, line: int, bases: Mapping[int, int | None]) -> float:
        """Number in a cell, or time from the base; nan where it is empty, TrajectoryError for words."""
        if cell.lower() in EMPTY:
            return math.nan
        where, base = Location(self.path, line, column + 1), bases.get(column)
        name, plain = self.label(column), self.layout.plain(cell)
        if base is not None:
            with suppress(ValueError, ArithmeticError):
                return self._offset(cell, column, base)
            if column in self._dates:
                message, expected = f"{name} is not a date", "a date and time, as before"
                raise refusal(message, where, expected, in_python(cell), "correct the cell")
        if cell.lower() in _INFINITE:
            step = "replace or remove the line; gaps are not filled in"
            raise refusal(f"{name} is not a finite number", where, "a finite number", cell, step)
        number = number_in(plain)
        if number is None:
            expected = "a number in the digits 0 to 9, such as -1.5 or 2e-3"
            step = "write decimal points, not commas" if _WITH_COMMA.fullmatch(plain) else "correct the cell"
            raise refusal(f"{name} is not a number", where, expected, in_python(plain), step)
        # A stamp may have any size.
        if abs(number) > (math.nextafter(math.inf, 0) if column in bases else LARGEST):
            expected, step = f"numbers up to {LARGEST:g}", "check its unit: time is in seconds"
            raise refusal(f"{name} is too large for any motion", where, expected, in_python(plain), step)
        return number - (base or 0)

    def _blocks(self, progress: Progress = NO_PROGRESS) -> Iterator[_Block]:
        """The rows, some megabytes at a time."""
        size = len(self.data) if self.data is not None else Path(self.path).stat().st_size
        number = 1
        progress.stage("reading", size or None)
        with self._opened() as file:
            while lines := file.read(_BLOCK_BYTES) + file.readline():
                progress.advance(len(lines))
                self._refuse_binary(lines)
                lines = lines.replace(b"\r\n", b"\n").replace(b"\r", b"\n").removesuffix(b"\n") + b"\n"
                lines = lines.removeprefix(BOM_UTF8) if number == 1 else lines
                yield _block_of(lines, number, self.layout.first)
                number += lines.count(b"\n")

    def _opened(self) -> BinaryIO:
        return Path(self.path).open("rb") if self.data is None else io.BytesIO(self.data)

    def _refuse_binary(self, data: bytes) -> None:
        if b"\0" in data:
            expected = "text in UTF-8, or a file that ends in .db3, .mcap, .bag, .parquet, .npz or .mat"
            content, step = "a binary file (zero bytes)", "save it as CSV in UTF-8"
            if data.startswith((b"\xff\xfe", b"\xfe\xff")):
                content = "UTF-16"
                step = f"iconv -f UTF-16 -t UTF-8 {shlex.quote(str(self.path))} > log.csv"
            elif Path(self.path).suffix.lower() in _SPREADSHEETS:
                read = f"pandas.read_excel({str(self.path)!r})"
                step = f"python -c \"import pandas; {read}.to_csv('log.csv', index=False)\" writes it as CSV"
            raise refusal("the file is not a text table", Location(self.path), expected, content, step)


def _block_of(lines: bytes, number: int, begin: int) -> _Block:
    """The rows among lines from line `number` on; rows begin on line `begin`."""
    if number >= begin and not _COMMENT_OR_BLANK.search(b"\n" + lines):
        return _Block(lines, range(number, number + lines.count(b"\n")))
    rows: dict[int, bytes] = {}
    gaps: list[int] = []
    for k, line in enumerate(lines[:-1].split(b"\n"), number):
        if k >= begin and line.strip() and not line.lstrip().startswith(b"#"):
            rows[k] = line + b"\n"
        elif k >= begin and line.rstrip() == GAP.encode():
            gaps.append(len(rows))
    return _Block(b"".join(rows.values()), list(rows), gaps)
