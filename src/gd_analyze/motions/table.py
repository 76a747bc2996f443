"""A log as a table: named columns, read on demand, and instants in seconds."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.reading import refusal
from gd_analyze.progress import Progress
from gd_analyze.text import LARGEST, in_python, visible

# 2025-03-04T10:20:30.016Z, 04.03.2025 10:20:30,016, 10:20:30.016; not 03/04/2025, which has two meanings.
_INSTANT = re.compile(
    r"(?:(?:(?P<year>[0-9]{4})[-/](?P<month>[0-9]{1,2})[-/](?P<day>[0-9]{1,2})"
    r"|(?P<d>[0-9]{1,2})\.(?P<m>[0-9]{1,2})\.(?P<y>[0-9]{4}))[T ]+)?"
    r"(?P<hours>[0-9]{1,2}):(?P<minutes>[0-5][0-9]):(?P<seconds>[0-5][0-9])(?:[.,:](?P<fraction>[0-9]{1,12}))?"
    r" ?(?:Z|UTC|(?P<sign>[+-])(?P<zone_hours>[0-9]{2}):?(?P<zone_minutes>[0-9]{2}))?"
)
_EPOCH = date(1970, 1, 1).toordinal()

# Number of first rows by which a column is judged.
HEAD_ROWS = 200
# More wrong rows than this are another format.
_MOST_WRONG = 1000


@dataclass(frozen=True, eq=False)
class Stamps:
    """Instants relative to an integer, which may be an epoch in nanoseconds."""

    base: int
    offsets: FloatArray
    unit: str = ""  # where the cells themselves say it, as dates do

    @classmethod
    def of(cls, values: FloatArray | NDArray[np.int64]) -> Stamps:
        """Split instants that are stored exactly."""
        finite = values[np.isfinite(values)]
        base = int(finite[0]) if finite.size and abs(finite[0]) < 2.0**62 else 0
        return cls(base, (values - base).astype(float, copy=False))


def nanoseconds_in(text: str) -> int | None:
    """Instant of a date and time, since 1970, or of a time of day, since midnight; None for other text.

    Examples
    --------
    >>> nanoseconds_in("1970-01-02T00:00:00.25Z"), nanoseconds_in("0:01:00"), nanoseconds_in("12")
    (86400250000000, 60000000000, None)
    """
    match = _INSTANT.fullmatch(text.strip())
    if match is None:
        return None
    try:
        day = date(*(int(match[k]) for k in ("year", "month", "day"))) if match["year"] else None
        day = date(*(int(match[k]) for k in ("y", "m", "d"))) if match["y"] else day
    except ValueError:
        return None
    hours, minutes, seconds = (int(match[k]) for k in ("hours", "minutes", "seconds"))
    days = 0 if day is None else day.toordinal() - _EPOCH
    zone = (
        int(f"{match['sign']}{int(match['zone_hours']) * 60 + int(match['zone_minutes'])}")
        if match["sign"]
        else 0
    )
    whole = days * 86400 + hours * 3600 + (minutes - zone) * 60 + seconds
    return whole * 10**9 + int((match["fraction"] or "").ljust(9, "0")[:9])


@dataclass(frozen=True, eq=False)
class Columns:
    """Columns that were read."""

    numbers: FloatArray  # (N, k)
    stamps: tuple[Stamps, ...]
    gaps: tuple[int, ...] = ()  # rows before which the file states a gap
    # Why rows cannot be read, which are nan here
    wrong: Mapping[int, TrajectoryError] = field(default_factory=dict)


class LogTable(ABC):
    """Interface of the readers of all formats."""

    path: str | Path  # source, for messages
    names: tuple[str, ...]  # names of the columns; all empty if there is no header
    planned: bool | None = None  # whether the kind of message is a plan; None if unknown
    set_points: bool = False  # whether the file has a header of set points: time, q1, qd1_deg
    header_line: int | None = None  # line of the names

    @abstractmethod
    def head(self, column: int) -> list[str | float]:
        """First cells of a column: floats, or text if not numbers."""

    @abstractmethod
    def read(self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress) -> Columns:
        """Read columns, counted from 0; nan where a cell is empty."""

    def stands(self, column: int) -> bool:
        """Whether a column begins with several equal numbers."""
        first = self.head(column)
        return len(first) > 1 and len(set(first)) == 1

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place of a row, a column or both, counted from 0; a row of a text is found by reading it."""
        line = self.header_line if row is None else self.lines_of([row])[0]
        return Location(self.path, line, None if column is None else column + 1)

    def lines_of(self, rows: Sequence[int]) -> list[int]:
        """Line of each row, both in ascending order; in a table without lines the row's number from 1."""
        return [row + 1 for row in rows]

    def label(self, column: int) -> str:
        """Name of a column, or its number."""
        return self.names[column] or f"column {column + 1}"

    def shown(self, column: int) -> str:
        """Printable name of a column, or its number alone."""
        return visible(self.names[column]) or str(column + 1)


@dataclass(frozen=True, eq=False)
class ArrayTable(LogTable):
    """A table in memory: arrays of floats, or of integers such as stamps in nanoseconds, one per name."""

    path: str | Path
    names: tuple[str, ...]
    columns: tuple[FloatArray | NDArray[np.int64], ...]
    planned: bool | None = None
    lines: tuple[int, ...] = ()  # of the rows, if they were read from lines of text
    wrong: Mapping[int, TrajectoryError] = field(default_factory=dict)  # why rows could not be read

    def lines_of(self, rows: Sequence[int]) -> list[int]:
        """Line of each row."""
        return [self.lines[row] for row in rows] if self.lines else super().lines_of(rows)

    def head(self, column: int) -> list[str | float]:
        """First numbers of a column."""
        return list(self.columns[column][:HEAD_ROWS].tolist())

    def read(self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress) -> Columns:
        """Take columns."""
        table = np.empty((len(self.columns[0]), len(numbers)))
        for k, column in enumerate(numbers):
            table[:, k] = self.columns[column]
        wrong = {**too_large(self, table, numbers), **self.wrong}
        return Columns(table, tuple(Stamps.of(self.columns[column]) for column in stamps), wrong=wrong)


def too_large(table: LogTable, values: FloatArray, numbers: Sequence[int]) -> dict[int, TrajectoryError]:
    """Rows, made nan, with numbers that no motion has, shape (N, k), and why; `numbers` are the columns."""
    wrong: dict[int, TrajectoryError] = {}
    for row, k in np.argwhere(np.isinf(values) | (np.abs(values) > LARGEST)).tolist():
        if row not in wrong:
            message = f"{table.label(numbers[k])} is too large for any motion"
            where, expected = table.where(row, numbers[k]), f"numbers up to {LARGEST:g}"
            add_wrong(wrong, row, refusal(message, where, expected, str(values[row, k]), "check its unit"))
    values[list(wrong)] = np.nan
    return wrong


def add_wrong(wrong: dict[int, TrajectoryError], row: int, error: TrajectoryError) -> None:
    """Add a row that cannot be read; raise the first error where there are too many."""
    wrong[row] = error
    if len(wrong) > _MOST_WRONG:
        raise wrong[min(wrong)]


def missing_library(library: str, path: str | Path) -> TrajectoryError:
    """Error for a log that needs a missing library."""
    message, step = f"this log needs the library {library}", f"pip install {library}"
    return refusal(message, Location(path), library, "it is not installed", step)


class ParquetTable(LogTable):
    """A Parquet file; columns of instants are read in nanoseconds, and [ns] is added to their names.

    A column of lists, as LeRobot's `observation.state`, gives a column per element, `observation.state_1`.
    """

    def __init__(self, path: str | Path) -> None:
        self.path = path
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise missing_library("pyarrow", path) from None
        self._arrow = pyarrow
        # Errors raised by a damaged file.
        self._errors = (OSError, ValueError, pyarrow.lib.ArrowException)
        try:
            self._file = pyarrow.parquet.ParquetFile(path)
            self._first = next(self._file.iter_batches(HEAD_ROWS), None)
            self._fields = [element for field in self._file.schema_arrow for element in self._elements(field)]
        except self._errors as error:
            raise self._broken(error) from None
        self.names = tuple(
            f"{name} [ns]" if _is_instant(kind) else f"{name}_{at + 1}" if at is not None else name
            for name, kind, at in self._fields
        )

    def head(self, column: int) -> list[str | float]:
        """First cells of a column."""
        kind = self._fields[column][1]
        if not _is_instant(kind) and not str(kind).startswith(("int", "uint", "float", "double", "half")):
            return ["text"]
        try:
            return [] if self._first is None else list(self._numbers(self._of(self._first, column)).tolist())
        except self._errors as error:  # also for numbers beyond signed 64 bits
            raise self._broken(error) from None

    def read(self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress) -> Columns:
        """Read columns, one row group at a time."""
        table = np.empty((self._file.metadata.num_rows, len(numbers)))
        instants: list[list[Any]] = [[np.empty(0, dtype=np.int64)] for _ in stamps]
        columns = sorted({*numbers, *stamps})
        row, groups = 0, self._file.metadata.num_row_groups
        progress.stage("reading", groups)
        try:
            for group in range(groups):
                names = dict.fromkeys(self._fields[k][0] for k in columns)
                read = self._file.read_row_group(group, columns=list(names))
                arrays = {k: self._of(read, k) for k in columns}
                for i, k in enumerate(numbers):
                    table[row : row + read.num_rows, i] = self._numbers(arrays[k], exact=False)
                for parts, k in zip(instants, stamps, strict=True):
                    parts.append(self._numbers(arrays[k]))
                row += read.num_rows
                progress.advance()
        except self._errors as error:
            raise self._broken(error) from None
        wrong = too_large(self, table, numbers)
        return Columns(table, tuple(Stamps.of(np.concatenate(parts)) for parts in instants), wrong=wrong)

    def _elements(self, field: Any) -> list[tuple[str, Any, int | None]]:
        """Name, type and index in the list, from 0, of a field's columns."""
        if self._arrow.types.is_string(field.type) and self._first is not None:
            cells = (cell for cell in self._first.column(field.name).to_pylist() if cell)
            is_date = nanoseconds_in(next(cells, "")) is not None
            return [(field.name, self._arrow.duration("ns") if is_date else field.type, None)]
        if not self._arrow.types.is_list(field.type) and not self._arrow.types.is_fixed_size_list(field.type):
            return [(field.name, field.type, None)]
        first = self._first.column(field.name)[0].as_py() if self._first else None
        return [(field.name, field.type.value_type, k) for k in range(len(first or ()))]

    def _of(self, rows: Any, column: int) -> Any:
        """A column of some rows."""
        name, _, at = self._fields[column]
        values = rows.column(name)
        if self._arrow.types.is_string(values.type):
            return self._arrow.array(map(self._date, values.to_pylist()), self._arrow.duration("ns"))
        if at is None:
            return values
        import pyarrow.compute

        return pyarrow.compute.list_element(values, at)

    def _date(self, cell: str | None) -> int | None:
        instant = nanoseconds_in(cell) if cell else None
        if cell and instant is None:
            raise ValueError(f"{in_python(cell)} is no date and time, as the first cell is")
        return instant

    def _numbers(self, column: Any, *, exact: bool = True) -> Any:
        """Floats, or integers if the file has them; instants in nanoseconds."""
        if _is_instant(column.type):
            kind = self._arrow.timestamp if str(column.type).startswith("timestamp") else self._arrow.duration
            column = column.cast(kind("ns")).cast(self._arrow.int64())
        is_whole = exact and not column.null_count and str(column.type).startswith(("int", "uint"))
        # A batch must be told to copy, a table's column has no such argument.
        options = {} if isinstance(column, self._arrow.ChunkedArray) else {"zero_copy_only": False}
        kind = self._arrow.int64() if is_whole else self._arrow.float64()
        return column.cast(kind, safe=is_whole).to_numpy(**options)

    def _broken(self, error: Exception) -> TrajectoryError:
        where, fault = Location(self.path), str(error).split("\n", 1)[0]
        return refusal("the log cannot be read as Parquet", where, "a Parquet file", fault, "write it again")


def _is_instant(kind: Any) -> bool:
    return str(kind).startswith(("timestamp", "duration"))
