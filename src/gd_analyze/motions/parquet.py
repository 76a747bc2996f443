"""Logs in Parquet files, by the optional library pyarrow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.bags import missing_library
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import HEAD_ROWS, Columns, LogTable, Progress, Stamps, no_progress
from gd_analyze.text import LARGEST


class ParquetTable(LogTable):
    """A Parquet file; columns of instants are read in nanoseconds, and named so."""

    def __init__(self, path: str | Path) -> None:
        self.path = path
        try:
            import pyarrow
            import pyarrow.parquet
        except ImportError:
            raise missing_library("pyarrow", path) from None
        self._arrow = pyarrow
        try:
            self._file = pyarrow.parquet.ParquetFile(path)
            self._first = next(self._file.iter_batches(HEAD_ROWS), None)
        except (OSError, ValueError) as error:
            raise self._broken(error) from None
        self._fields = list(self._file.schema_arrow)
        self.names = tuple(f"{f.name} [ns]" if _is_instant(f.type) else f.name for f in self._fields)

    def head(self, column: int) -> list[str | float]:
        """First cells of a column."""
        kind = self._fields[column].type
        if not _is_instant(kind) and not str(kind).startswith(
            ("int", "uint", "float", "double", "halffloat")
        ):
            return ["text"]
        return [] if self._first is None else [float(x) for x in self._floats(self._first.column(column))]

    def stands(self, column: int) -> bool:
        """Whether the first numbers are all the same; of whole numbers all digits count."""
        if self._first is None or self.head(column) == ["text"]:
            return False
        first = self._instants(self._first.column(column))
        return len(first) > 1 and bool((first == first[0]).all())

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Read columns, a group of rows at a time."""
        table = np.empty((self._file.metadata.num_rows, len(numbers)))
        instants: list[list[Any]] = [[] for _ in stamps]
        columns = sorted({*numbers, *stamps})
        place = {k: i for i, k in enumerate(columns)}
        row, groups = 0, self._file.metadata.num_row_groups
        try:
            for group in range(groups):
                read = self._file.read_row_group(group, columns=[self._fields[k].name for k in columns])
                for i, k in enumerate(numbers):
                    table[row : row + read.num_rows, i] = self._floats(read.column(place[k]))
                for i, k in enumerate(stamps):
                    instants[i].append(self._instants(read.column(place[k])))
                row += read.num_rows
                progress(group + 1, groups)
        except (OSError, ValueError) as error:
            raise self._broken(error) from None
        wrong = np.isinf(table) | (np.abs(table) > LARGEST)
        if wrong.any():
            at, k = map(int, np.argwhere(wrong)[0])
            what = f"{self.names[numbers[k]]} is too large for any motion"
            where, expected = self.where(at, numbers[k]), f"numbers up to {LARGEST:g}"
            raise refusal(what, where, expected, str(table[at, k]), "check its unit")
        return Columns(table, tuple(Stamps.of(np.concatenate(parts or [np.empty(0)])) for parts in instants))

    def _whole(self, column: Any) -> Any:
        """A column, instants as integers in nanoseconds."""
        if not _is_instant(column.type):
            return column
        kind = self._arrow.timestamp if str(column.type).startswith("timestamp") else self._arrow.duration
        return column.cast(kind("ns")).cast(self._arrow.int64())

    def _floats(self, column: Any) -> Any:
        return self._array(self._whole(column).cast(self._arrow.float64(), safe=False))

    def _instants(self, column: Any) -> Any:
        """Instants as integers where the file has such, without a loss of digits."""
        whole = self._whole(column)
        if whole.null_count or not str(whole.type).startswith(("int", "uint")):
            return self._floats(column)
        return self._array(whole.cast(self._arrow.int64()))

    def _array(self, column: Any) -> Any:
        """A NumPy array; one of a batch is copied only when told, one of a table knows no such word."""
        chunked = isinstance(column, self._arrow.ChunkedArray)
        return column.to_numpy() if chunked else column.to_numpy(zero_copy_only=False)

    def _broken(self, error: Exception) -> TrajectoryError:
        where, found = Location(self.path), str(error).split("\n", 1)[0]
        return refusal("the log cannot be read as Parquet", where, "a Parquet file", found, "write it anew")


def _is_instant(kind: Any) -> bool:
    return str(kind).startswith(("timestamp", "duration"))
