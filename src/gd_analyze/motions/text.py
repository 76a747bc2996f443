"""A log in a text file with commas, semicolons, tabs or blanks; only needed columns are read, in blocks."""

from __future__ import annotations

import csv
import io
import math
import re
import shlex
import warnings
from codecs import BOM_UTF8
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from itertools import chain, islice
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from gd_analyze.arrays import are_possible
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.column_units import unit_in_words
from gd_analyze.motions.names import are_of_set_points
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import (
    HEAD_ROWS,
    MOST_WRONG,
    Columns,
    LogTable,
    Stamps,
    nanoseconds_in,
)
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.text import LARGEST, in_python, number_in

# A separate line where the motion between the set points above and below is unknown.
GAP = "# gap"
_NEEDS_LOOK = re.compile(rb"(?m)^[ \t]*(?:#|$)")
_NEWLINE, _BEFORE_NO_ROW = ord("\n"), list(b" \t#\n")
EMPTY = frozenset({"", "nan", "-nan", "na", "n/a", "null", "none", "-"})
_NOT_GIVEN = sorted({word for empty in EMPTY for word in (empty, empty.upper(), empty.capitalize(), "NaN")})
_INFINITE = frozenset({"inf", "-inf", "infinity", "-infinity"})
# Functions of pandas that read tables of other formats; not pickles, which execute code when they are read.
_PANDAS = dict.fromkeys((".xlsx", ".xls", ".ods"), "read_excel") | {
    **{".feather": "read_feather", ".orc": "read_orc", ".dta": "read_stata"}
}
_HEADING = re.compile(r"[A-Za-z]+ ?:\s+")
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


def _is_row(line: str) -> bool:
    return not line.lstrip().startswith("#") and bool(line.strip())


# First rows by which delimiters are judged.
_JUDGED_ROWS = 8


def layout_of(lines: Sequence[str], path: str | Path) -> TextLayout:
    """Detect the layout of a text table; TrajectoryError if there is no row, or a name is far too long."""
    rows = [(k, line) for k, line in enumerate(lines, 1) if _is_row(line)]
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
    if (
        len(following) < 2
        or len(units) != len(names)
        or not stated_units
        or None in map(unit_in_words, stated_units)
    ):
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


def _require_number(cell: str, name: str, where: Location) -> None:
    """Raise a TrajectoryError if a cell is not a finite number of possible size."""
    number = number_in(cell)
    if number is None and cell.lower() in EMPTY | _INFINITE:
        value, step = cell or "an empty cell", "replace or remove the line; gaps are not filled in"
        raise refusal(f"{name} is not a finite number", where, "a finite number", value, step)
    if number is None:
        expected = "a number in the digits 0 to 9, such as -1.5 or 2e-3"
        step = "write decimal points, not commas" if _WITH_COMMA.fullmatch(cell) else "correct the cell"
        raise refusal(f"{name} is not a number", where, expected, in_python(cell), step)
    if not are_possible(number):
        expected, step = f"numbers up to {LARGEST:g}", "check its unit: time is in seconds"
        raise refusal(f"{name} is too large for any motion", where, expected, in_python(cell), step)


@dataclass(frozen=True, eq=False)
class _Block:
    """A block of rows."""

    data: bytes  # lines without comments
    numbers: Sequence[int]  # their numbers in the file
    gaps: Sequence[int] = ()  # rows before which there is a gap

    @property
    def lines(self) -> list[str]:
        return self.data.decode("utf-8", errors="replace").split("\n")[:-1]


# Bytes of the beginning, where layout and names are found, and of a block of rows.
_HEAD_BYTES = 1_000_000
_BLOCK_BYTES = 2_000_000
# The array of numbers, when it is full, grows by its rows over this.
_GROWTH_DIVISOR = 8
# Doubles hold smaller instants to a few nanoseconds; from larger ones the integer part is split off.
_LARGEST_EXACT_INSTANT = 1e6


class TextTable(LogTable):
    """A text file, or the bytes of one; `names` are for a file without names."""

    def __init__(self, path: str | Path, data: bytes | None = None, names: tuple[str, ...] = ()) -> None:
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
        self.names = names or self.layout.names
        numbered = enumerate(self.first_lines[self.layout.first - 1 :], self.layout.first)
        rows = islice(((number, line) for number, line in numbered if _is_row(line)), HEAD_ROWS)
        self._head = [self._cells(line, number) for number, line in rows]
        self.first_cells = self._head[0]
        named = not names and all(self.names) and are_of_set_points(self.names)
        self.set_points = named and not any(self._are_dates(k) for k in range(len(self.first_cells)))

    def _cells(self, line: str, number: int) -> list[str]:
        return [cell.strip() for cell in _split(line, self.layout.delimiter, Location(self.path, number))]

    def require_constant(self, first: Mapping[int, str], *, or_empty: bool = False) -> None:
        """Raise a TrajectoryError if a text column is not constant, or is empty unless `or_empty`."""
        columns = sorted(first)
        for block in self._blocks():
            frame = self._parsed(block, columns, frozenset(columns)) if block.numbers else {}
            if frame is None:
                raise next((error for _, error in self._wrong(block, (), ())), self._no_table(block))
            for column, cells in frame.items():
                for row, cell in enumerate(cells if column in first else ()):
                    # An empty cell is read as nan.
                    differs = cell.strip() != first[column] if isinstance(cell, str) else not or_empty
                    if differs:
                        where = Location(self.path, block.numbers[row], column + 1)
                        expected, step = f"{first[column]}, as before", "write each arm's rows to a file"
                        raise refusal("the joints' names change", where, expected, str(cell), step)

    def head(self, column: int) -> list[str | float]:
        """First cells of a column; dates in seconds."""
        read: list[str | float] = []
        for row in self._head:
            cell = row[column] if column < len(row) else ""
            if cell.lower() in EMPTY:
                read.append(float("nan"))
                continue
            if cell.lower() in _INFINITE:
                read.append(math.inf)
                continue
            number, date = number_in(self.layout.plain(cell)), nanoseconds_in(cell)
            read.append(number if number is not None else cell if date is None else 1e-9 * date)
        return read

    def _are_dates(self, column: int) -> bool:
        """Whether a column begins with a date or a time of day."""
        cells = (row[column] for row in self._head if column < len(row))
        first = next((cell for cell in cells if cell.lower() not in EMPTY), "")
        return nanoseconds_in(first) is not None

    def stands(self, column: int) -> bool:
        """Whether the column begins with several cells that are equal to the last digit."""
        cells = {row[column] for row in self._head if column < len(row)}
        return len(self._head) > 1 and len(cells) == 1 and "" not in cells

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place in the file; finding a row's line takes as long as reading the file."""
        line = self.layout.header or None if row is None else self._line(row)[0]
        return Location(self.path, line, None if column is None else column + 1)

    def cell(self, row: int, column: int) -> str:
        """A cell as written."""
        number, line = self._line(row)
        return self._cells(line, number)[column]

    def rows(self) -> Iterator[tuple[int, list[str] | TrajectoryError]]:
        """Line and cells of every row, or why it cannot be read."""
        for block in self._blocks():
            wrong = dict(self._wrong(block, (), ())) if block.numbers else {}
            for row, (number, line) in enumerate(zip(block.numbers, block.lines, strict=True)):
                yield number, wrong[row] if row in wrong else self._cells(line, number)

    def _line(self, row: int) -> tuple[int, str]:
        blocks = (zip(block.numbers, block.lines, strict=True) for block in self._blocks())
        return next(islice(chain.from_iterable(blocks), row, None))

    def lines_of(self, rows: Sequence[int]) -> list[int]:
        """Line of each row, both in ascending order, in one pass through the file."""
        lines, before = list[int](), 0
        for block in self._blocks():
            end = before + len(block.numbers)
            lines += [block.numbers[row - before] for row in rows if before <= row < end]
            before = end
        return lines

    def read(self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress) -> Columns:
        """Read columns in one pass through the file."""
        values = np.empty((0, len(numbers)))
        texts: list[list[Any]] = [[np.empty(0, dtype=object)] for _ in stamps]
        gaps, rows, wrong = list[int](), 0, dict[int, TrajectoryError]()
        for block in self._blocks(progress):
            gaps += [rows + gap for gap in block.gaps]
            if block.numbers:
                frame, of_block = self._sound(block, numbers, stamps)
                wrong |= {rows + row: error for row, error in of_block.items()}
                if len(wrong) > MOST_WRONG:
                    raise wrong[min(wrong)]
                if rows + len(frame) > len(values):
                    # Grown in place: joining all blocks in the end would hold a long log twice.
                    grown = rows + len(frame) + rows // _GROWTH_DIVISOR
                    values.resize((grown, len(numbers)), refcheck=False)
                if numbers:
                    values[rows : rows + len(frame)] = frame[list(numbers)].to_numpy(dtype=float)
                for text, column in zip(texts, stamps, strict=True):
                    text.append(frame[column].to_numpy(dtype=object))
            rows += len(block.numbers)
        cells = map(np.concatenate, texts)
        instants = tuple(self._stamps(of, self._are_dates(k)) for of, k in zip(cells, stamps, strict=True))
        gaps = [gap for gap in dict.fromkeys(gaps) if 0 < gap < rows]
        values.resize((rows, len(numbers)), refcheck=False)
        return Columns(values, instants, tuple(gaps), wrong)

    def _sound(
        self, block: _Block, numbers: Sequence[int], stamps: Sequence[int]
    ) -> tuple[Any, dict[int, TrajectoryError]]:
        """Columns of a block as a frame, nan in the rows that cannot be read, and why they cannot."""
        columns, as_text = sorted({*numbers, *stamps}), frozenset(stamps)
        frame = self._parsed(block, columns, as_text)
        if frame is not None and self._are_possible(frame, numbers, stamps):
            return frame, {}
        wrong = dict(islice(self._wrong(block, numbers, stamps), MOST_WRONG + 1))
        if len(wrong) > MOST_WRONG:
            raise wrong[min(wrong)]
        lines = block.data.split(b"\n")
        for row in wrong:
            lines[row] = self.layout.delimiter.join(["nan"] * len(self.names)).encode()
        frame = self._parsed(_Block(b"\n".join(lines), block.numbers), columns, as_text)
        if frame is None or not wrong:
            raise self._no_table(block)
        return frame, wrong

    def _are_possible(self, frame: Any, numbers: Sequence[int], stamps: Sequence[int]) -> bool:
        """Whether numbers are finite and of possible size, and stamps are numbers."""
        import pandas as pd

        for column in stamps:
            cells = frame[column].dropna()
            if self._are_dates(column):
                if not all(self._is_instant(cell, True) for cell in cells):
                    return False
                continue
            plain = cells if self.layout.decimal == "." else cells.str.replace(self.layout.decimal, ".")
            if not np.isfinite(pd.to_numeric(plain, errors="coerce").to_numpy(dtype=float)).all():
                return False
        values = frame[list(numbers)].to_numpy(dtype=float) if numbers else np.empty(0)
        return not (np.abs(values) > LARGEST).any()

    def _is_instant(self, cell: str, is_date: bool) -> bool:
        if cell.strip().lower() in EMPTY:
            return True
        number = None if is_date else number_in(self.layout.plain(cell))
        return nanoseconds_in(cell) is not None if is_date else number is not None and math.isfinite(number)

    def _no_table(self, block: _Block) -> TrajectoryError:
        where, expected = Location(self.path, block.numbers[0]), f"{len(self.names)} cells in each line"
        return refusal("the file cannot be read as a table", where, expected, "lines that do not fit")

    def _parsed(self, block: _Block, columns: list[int], as_text: frozenset[int]) -> Any:
        """Columns of a block, and the last one, as a frame; None if some row does not fit."""
        import pandas as pd

        if block.data.startswith(BOM_UTF8):
            return None  # pandas would leave it out anywhere
        layout, last = self.layout, len(self.names) - 1
        used_columns = sorted({*columns, last})
        text = as_text | ({last} - set(columns))
        # Since 3.1 pandas reads every digit, and warns if told to.
        release = tuple(int(part) for part in pd.__version__.split(".")[:2])
        exact: dict[str, Any] = {} if release >= (3, 1) else {"float_precision": "round_trip"}
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("error", pd.errors.ParserWarning)
                frame = pd.read_csv(
                    io.BytesIO(block.data),
                    header=None,
                    names=range(last + 1),
                    index_col=False,
                    usecols=used_columns,
                    sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
                    decimal=layout.decimal,
                    dtype={column: object if column in text else float for column in used_columns},
                    skipinitialspace=True,
                    keep_default_na=False,
                    na_values=_NOT_GIVEN,
                    skip_blank_lines=False,
                    encoding_errors="replace",
                    low_memory=False,
                    **exact,
                )
        except (ValueError, OverflowError, pd.errors.ParserWarning):
            return None
        return frame if len(frame) == len(block.numbers) and self._widths_fit(block, frame[last]) else None

    def _widths_fit(self, block: _Block, last: Any) -> bool:
        """Whether every line has as many cells as there are names, by delimiters outside quotes."""
        sign, width = self.layout.delimiter, len(self.names)
        if sign == " ":
            return all(len(line.split()) == width for line in block.data.splitlines())
        if b'"' in block.data:
            return all(len(_split(line, sign, Location(self.path))) == width for line in block.lines)
        if block.data.count(sign.encode()) != (width - 1) * len(block.numbers):
            return False
        lines = block.data.split(b"\n") if last.isna().any() else []
        return all(line.count(sign.encode()) == width - 1 for line in lines if line)

    def _wrong(
        self, block: _Block, numbers: Sequence[int], stamps: Sequence[int]
    ) -> Iterator[tuple[int, TrajectoryError]]:
        """Rows of a block that cannot be read, and why; slow, but finds the place."""
        layout, width = self.layout, len(self.names)
        are_dates = {column: self._are_dates(column) for column in stamps}
        for row, (number, line) in enumerate(zip(block.numbers, block.lines, strict=True)):
            try:
                cells = self._cells(line, number)
                if len(cells) != width:
                    message = f"the line has too {'few' if len(cells) < width else 'many'} columns"
                    where = Location(self.path, number, min(len(cells), width) + 1)
                    expected = f"{width} columns, as in the {'header' if layout.header else 'first line'}"
                    step = "complete the line, or remove it if the recording broke off there"
                    raise refusal(message, where, expected, str(len(cells)), step)
                for column in sorted({*numbers, *stamps}):
                    # A stamp may have any size.
                    cell, is_date = cells[column], are_dates.get(column, False)
                    if cell.lower() in EMPTY or (column not in numbers and self._is_instant(cell, is_date)):
                        continue
                    where = Location(self.path, number, column + 1)
                    if is_date and column not in numbers:
                        message, step = f"{self.label(column)} is not a date", "correct the cell"
                        raise refusal(message, where, "a date and time, as before", in_python(cell), step)
                    _require_number(layout.plain(cell), self.label(column), where)
            except TrajectoryError as error:
                yield row, error

    def _stamps(self, cells: Any, are_dates: bool) -> Stamps:
        """Instants from their digits, so that an epoch in nanoseconds stays exact."""
        if are_dates:
            dates = [nanoseconds_in(cell) if isinstance(cell, str) else None for cell in cells]
            base = next((instant for instant in dates if instant is not None), 0)
            return Stamps(base, np.array([np.nan if d is None else float(d - base) for d in dates]), "ns")
        stripped = (cell.strip() if isinstance(cell, str) else "" for cell in cells)
        texts = ["nan" if cell.lower() in EMPTY else self.layout.plain(cell) for cell in stripped]
        values = np.array([float(text) for text in texts])
        finite = values[np.isfinite(values)]
        largest = np.abs(finite).max(initial=0.0)
        if largest < _LARGEST_EXACT_INSTANT or largest > 2.0**62:
            return Stamps(0, values)
        try:
            base = int(finite[0])
            offsets = [np.nan if text == "nan" else float(Decimal(text) - base) for text in texts]
        except InvalidOperation:
            return Stamps.of(values)
        return Stamps(base, np.array(offsets))

    def _blocks(self, progress: Progress = NO_PROGRESS) -> Iterator[_Block]:
        """The rows, some megabytes at a time, split between lines."""
        size = len(self.data) if self.data is not None else Path(self.path).stat().st_size
        number, tail = 1, b""
        progress.stage("reading", size or None)
        with self._opened() as file:
            while True:
                piece = file.read(_BLOCK_BYTES)
                progress.advance(len(piece))
                data = tail + piece
                cut = data.rfind(b"\n") + 1 if piece else len(data)
                tail = data[cut:]
                lines = data[:cut].replace(b"\r\n", b"\n").replace(b"\r", b"\n")
                if lines:
                    self._refuse_binary(lines)
                    lines = (lines.removeprefix(BOM_UTF8) if number == 1 else lines).removesuffix(
                        b"\n"
                    ) + b"\n"
                    yield _block_of(lines, number, self.layout.first)
                    number += lines.count(b"\n")
                if not piece:
                    return

    def _opened(self) -> BinaryIO:
        try:
            return io.BytesIO(self.data) if self.data is not None else Path(self.path).open("rb")
        except OSError as error:
            reason, step = error.strerror or str(error), "give the path of a file you may read"
            raise refusal("cannot read the file", Location(self.path), "a file", reason, step) from None

    def _refuse_binary(self, data: bytes) -> None:
        if b"\0" in data:
            expected = "text in UTF-8, or a file that ends in .db3, .mcap, .bag, .parquet, .npz or .mat"
            utf_16 = data.startswith((b"\xff\xfe", b"\xfe\xff"))
            content = "UTF-16" if utf_16 else "a binary file (zero bytes)"
            reader = _PANDAS.get(Path(self.path).suffix.lower())
            step = "save it as CSV in UTF-8"
            if utf_16:
                step = f"iconv -f UTF-16 -t UTF-8 {shlex.quote(str(self.path))} > log.csv"
            elif reader is not None:
                command = f"import pandas; pandas.{reader}({str(self.path)!r}).to_csv('log.csv', index=False)"
                step = f'python -c "{command}" writes it as CSV'
            raise refusal("the file is not a text table", Location(self.path), expected, content, step)


def _block_of(lines: bytes, number: int, begin: int) -> _Block:
    """The rows among lines from line `number` on; rows begin on line `begin`."""
    read = np.frombuffer(lines, dtype=np.uint8)
    firsts = read[np.append(0, np.flatnonzero(read[:-1] == _NEWLINE) + 1)]
    # Any other line is a row; this check takes a tenth of the pattern's time.
    if number >= begin and not (np.isin(firsts, _BEFORE_NO_ROW).any() and _NEEDS_LOOK.search(lines[:-1])):
        return _Block(lines, range(number, number + len(firsts)))
    rows: dict[int, bytes] = {}
    gaps: list[int] = []
    for k, line in enumerate(lines[:-1].split(b"\n"), number):
        if k >= begin and line.strip() and not line.lstrip().startswith(b"#"):
            rows[k] = line + b"\n"
        elif k >= begin and line.rstrip() == GAP.encode():
            gaps.append(len(rows))
    return _Block(b"".join(rows.values()), list(rows), gaps)
