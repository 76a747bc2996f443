"""A log as a table: named columns, read on demand, and instants in seconds."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field
from datetime import date
from itertools import islice
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
    r"(?:([0-9]{4}[-/][0-9]{1,2}[-/][0-9]{1,2}|[0-9]{1,2}\.[0-9]{1,2}\.[0-9]{4})[T ]+)?"
    r"([0-9]{1,2}):([0-5][0-9]):([0-5][0-9])(?:[.,:]([0-9]{1,12}))?"
    r" ?(?:Z|UTC|([+-])([0-9]{2}):?([0-9]{2}))?"
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
    day, hours, minutes, seconds, fraction, sign, *zone = match.groups()
    days = 0
    if day:
        parts = [int(part) for part in re.split("[-/.]", day)]
        try:
            days = date(*(parts[::-1] if "." in day else parts)).toordinal() - _EPOCH
        except ValueError:
            return None
    ahead = int(zone[0]) * 60 + int(zone[1]) if sign else 0
    whole_minutes = days * 1440 + int(hours) * 60 + int(minutes) - (-ahead if sign == "-" else ahead)
    return (whole_minutes * 60 + int(seconds)) * 10**9 + int((fraction or "").ljust(9, "0")[:9])


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
    about: tuple[str, ...] = ()  # texts beside the columns that describe the log
    planned: bool | None = None  # whether the kind of message is a plan; None if unknown
    set_points: bool = False  # whether the file has a header of set points: time, q1, qd1_deg
    header_line: int | None = None  # line of the names
    lines: tuple[int, ...] = ()  # of the rows, if they are known before they are read

    @abstractmethod
    def head(self, column: int) -> list[str | float]:
        """First cells of a column: floats, or text if not numbers."""

    @abstractmethod
    def read(self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress) -> Columns:
        """Read columns, counted from 0; nan where a cell is empty."""

    def stands(self, column: int) -> bool:
        """Whether a column begins with several equal numbers."""
        first = self.head(column)
        return len(first) > 1 and all(cell == first[0] for cell in first)

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place of a row, a column or both, counted from 0; a row of a text is found by reading it."""
        line = self.header_line if row is None else self.lines_of([row])[0]
        return Location(self.path, line, None if column is None else column + 1)

    def lines_of(self, rows: Sequence[int]) -> list[int]:
        """Line of each row, both in ascending order; in a table without lines the row's number from 1."""
        return [self.lines[row] if self.lines else row + 1 for row in rows]

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
    lines: tuple[int, ...] = ()
    wrong: Mapping[int, TrajectoryError] = field(default_factory=dict)  # why rows could not be read
    about: tuple[str, ...] = ()

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


def gathered(rows: Iterable[Mapping[str, float]]) -> dict[str, NDArray[Any]]:
    """Columns by name of rows that hold numbers by name; nan where a row has none."""
    columns: dict[str, list[float]] = {}
    count = 0
    for row in rows:
        for name, value in row.items():
            column = columns.setdefault(name, [])
            column.extend([math.nan] * (count - len(column)))
            column.append(value)
        count += 1
    return {name: np.array(column + [math.nan] * (count - len(column))) for name, column in columns.items()}


@contextmanager
def refusing_damage(path: str | Path, message: str, expected: str, next_step: str) -> Iterator[None]:
    """Turn what a library raises on a damaged file into a TrajectoryError."""
    try:
        yield
    except TrajectoryError:
        raise
    # Every part of these libraries fails in its own way: zip, struct, SQLite, HDF5, assertions, memory.
    except Exception as error:
        fault = str(error).split("\n", 1)[0] or type(error).__name__
        raise refusal(message, Location(path), expected, fault, next_step) from None


def changed_names(where: Location, before: str, now: str) -> TrajectoryError:
    """Error for rows of several arms."""
    message, step = "the joints' names change", "write each arm's rows to a file"
    return refusal(message, where, f"{before}, as before", now, step)


def missing_library(library: str, path: str | Path) -> TrajectoryError:
    """Error for a log that needs a missing library."""
    message, step = f"this log needs the library {library}", f"pip install {library}"
    return refusal(message, Location(path), library, "it is not installed", step)


class ParquetTable(LogTable):
    """A Parquet file; columns of instants are read in nanoseconds, and [ns] is added to their names.

    A column of lists, as LeRobot's `observation.state`, gives a column per element, `observation.state_1`.
    """

    def __init__(self, path: str | Path) -> None:
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise missing_library("pyarrow", path) from None
        self.path, self._arrow = path, pyarrow
        # Of each column: its name, the field that holds it, and its index in a list, from 0
        columns: list[tuple[str, str, int | None]] = []
        with self._refusing_damage():
            self._file = pyarrow.parquet.ParquetFile(path)
            batches, schema = self._file.iter_batches(HEAD_ROWS), self._file.schema_arrow
            self._first = pyarrow.Table.from_batches(islice(batches, 1), schema)
            for field in schema:
                name, cells = field.name, self._first.column(field.name)
                if pyarrow.types.is_list(field.type) or pyarrow.types.is_fixed_size_list(field.type):
                    width = len(cells[0].as_py() or ()) if len(cells) else 0
                    columns += [(f"{name}_{k + 1}", name, k) for k in range(width)]
                else:
                    columns.append((f"{name} [ns]" if self._are_instants(cells) else name, name, None))
        self.names, self._fields = tuple(name for name, *_ in columns), [field for _, *field in columns]

    def _refusing_damage(self) -> AbstractContextManager[None]:
        message = "the log cannot be read as Parquet"
        return refusing_damage(self.path, message, "a Parquet file", "write it again")

    def _are_instants(self, cells: Any) -> bool:
        """Whether cells are instants, or texts of which the first is a date."""
        types = self._arrow.types
        if types.is_string(cells.type):
            return nanoseconds_in(next(filter(None, cells.to_pylist()), "")) is not None
        return bool(types.is_timestamp(cells.type) or types.is_duration(cells.type))

    def head(self, column: int) -> list[str | float]:
        """First cells of a column."""
        with self._refusing_damage():  # also for numbers beyond signed 64 bits
            cells = self._cells(self._first, column)
            return ["text"] if cells is None else list(cells.tolist())

    def read(self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress) -> Columns:
        """Read columns, one row group at a time."""
        table = np.empty((self._file.metadata.num_rows, len(numbers)))
        instants: list[list[Any]] = [[np.empty(0, dtype=np.int64)] for _ in stamps]
        fields = list(dict.fromkeys(self._fields[k][0] for k in sorted({*numbers, *stamps})))
        row, groups = 0, self._file.metadata.num_row_groups
        progress.stage("reading", groups)
        with self._refusing_damage():
            for group in range(groups):
                rows = self._file.read_row_group(group, columns=fields)
                for i, k in enumerate(numbers):
                    table[row : row + rows.num_rows, i] = self._cells(rows, k)
                for parts, k in zip(instants, stamps, strict=True):
                    parts.append(self._cells(rows, k))
                row += rows.num_rows
                progress.advance()
        wrong = too_large(self, table, numbers)
        return Columns(table, tuple(Stamps.of(np.concatenate(parts)) for parts in instants), wrong=wrong)

    def _cells(self, rows: Any, column: int) -> NDArray[Any] | None:
        """Cells of a column in some rows: whole numbers or floats, instants in nanoseconds; None for text."""
        import pyarrow.compute

        types, (field, element) = self._arrow.types, self._fields[column]
        cells = rows.column(field)
        if self.names[column] == f"{field} [ns]":
            cells = self._nanoseconds(cells)
        elif element is not None:
            cells = pyarrow.compute.list_element(cells, element)
        if not types.is_integer(cells.type) and not types.is_floating(cells.type):
            return None
        is_whole = types.is_integer(cells.type) and not cells.null_count
        kind = self._arrow.int64() if is_whole else self._arrow.float64()
        return np.asarray(cells.cast(kind, safe=is_whole))

    def _nanoseconds(self, cells: Any) -> Any:
        """Instants as whole numbers."""
        if not self._arrow.types.is_string(cells.type):
            kind = (
                self._arrow.timestamp if self._arrow.types.is_timestamp(cells.type) else self._arrow.duration
            )
            return cells.cast(kind("ns")).cast(self._arrow.int64())
        texts = cells.to_pylist()
        dates = [nanoseconds_in(text) if text else None for text in texts]
        for text, date_ns in zip(texts, dates, strict=True):
            if text and date_ns is None:
                raise ValueError(f"{in_python(text)} is no date and time, as the first cell is")
        return self._arrow.array(dates, self._arrow.int64())
