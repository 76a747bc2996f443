"""Logs in Parquet files, by the optional library pyarrow."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.reading import refusal
from gd_analyze.motions.table import (
    HEAD_ROWS,
    Columns,
    LogTable,
    Progress,
    Stamps,
    missing_library,
    no_progress,
)
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
        if not _is_instant(kind) and not str(kind).startswith(("int", "uint", "float", "double", "half")):
            return ["text"]
        return [] if self._first is None else list(self._numbers(self._first.column(column)).tolist())

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Read columns, a group of rows at a time."""
        table = np.empty((self._file.metadata.num_rows, len(numbers)))
        instants: list[list[Any]] = [[np.empty(0, dtype=np.int64)] for _ in stamps]
        columns = sorted({*numbers, *stamps})
        row, groups = 0, self._file.metadata.num_row_groups
        try:
            for group in range(groups):
                read = self._file.read_row_group(group, columns=[self._fields[k].name for k in columns])
                held = dict(zip(columns, read.columns, strict=True))
                for i, k in enumerate(numbers):
                    table[row : row + read.num_rows, i] = self._numbers(held[k], exact=False)
                for parts, k in zip(instants, stamps, strict=True):
                    parts.append(self._numbers(held[k]))
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
        return Columns(table, tuple(Stamps.of(np.concatenate(parts)) for parts in instants))

    def _numbers(self, column: Any, *, exact: bool = True) -> Any:
        """Floats, or integers where the file has such; instants in nanoseconds."""
        if _is_instant(column.type):
            kind = self._arrow.timestamp if str(column.type).startswith("timestamp") else self._arrow.duration
            column = column.cast(kind("ns")).cast(self._arrow.int64())
        whole = exact and not column.null_count and str(column.type).startswith(("int", "uint"))
        # A batch is copied only when told, a table's column knows no such word.
        told = {} if isinstance(column, self._arrow.ChunkedArray) else {"zero_copy_only": False}
        kind = self._arrow.int64() if whole else self._arrow.float64()
        return column.cast(kind, safe=whole).to_numpy(**told)

    def _broken(self, error: Exception) -> TrajectoryError:
        where, found = Location(self.path), str(error).split("\n", 1)[0]
        return refusal("the log cannot be read as Parquet", where, "a Parquet file", found, "write it anew")


def _is_instant(kind: Any) -> bool:
    return str(kind).startswith(("timestamp", "duration"))
