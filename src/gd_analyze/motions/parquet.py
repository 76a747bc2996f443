"""Logs in Parquet files, by the extra library pyarrow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.extra import required
from gd_analyze.motions.table import Columns, Progress, Stamps, no_progress
from gd_analyze.text import LARGEST

_HEAD_ROWS = 200


@dataclass(frozen=True, eq=False)
class ParquetTable:
    """A Parquet file; instants that it marks as such are read in nanoseconds, and said so in their names."""

    path: str | Path
    planned: bool | None = field(default=None, init=False)

    @cached_property
    def _file(self) -> Any:
        parquet = required("pyarrow.parquet", "pyarrow", self.path)
        try:
            return parquet.ParquetFile(self.path)
        except (OSError, ValueError) as error:
            raise self._broken(error) from None

    @cached_property
    def _fields(self) -> list[Any]:
        return list(self._file.schema_arrow)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the columns."""
        return tuple(f"{f.name} [ns]" if _is_instant(f.type) else f.name for f in self._fields)

    def head(self, column: int) -> list[str | float]:
        """First cells of a column."""
        if not _is_number(self._fields[column].type):
            return ["text"]
        return [float(x) for x in self._first[:, column]]

    def stands(self, column: int) -> bool:
        """Whether the first numbers are all the same; of whole numbers all digits count."""
        batch = (
            next(self._file.iter_batches(_HEAD_ROWS), None) if _is_number(self._fields[column].type) else None
        )
        first = np.empty(0) if batch is None else _instants(batch.column(column))
        return len(first) > 1 and bool((first == first[0]).all())

    @cached_property
    def _first(self) -> Any:
        batch = next(self._file.iter_batches(_HEAD_ROWS), None)
        first = np.full((0 if batch is None else batch.num_rows, len(self._fields)), np.nan)
        for k, of in enumerate(self._fields):
            if batch is not None and _is_number(of.type):
                first[:, k] = _floats(batch.column(k))
        return first

    def read(
        self, numbers: Sequence[int], stamps: Sequence[int], progress: Progress = no_progress
    ) -> Columns:
        """Read columns, a group of rows at a time."""
        table = np.empty((self._file.metadata.num_rows, len(numbers)))
        instants: list[list[Any]] = [[] for _ in stamps]
        row, groups = 0, self._file.metadata.num_row_groups
        try:
            for group in range(groups):
                columns = sorted({*numbers, *stamps})
                read = self._file.read_row_group(group, columns=[self._fields[k].name for k in columns])
                place = {k: i for i, k in enumerate(columns)}
                for i, k in enumerate(numbers):
                    table[row : row + read.num_rows, i] = _floats(read.column(place[k]))
                for i, k in enumerate(stamps):
                    instants[i].append(_instants(read.column(place[k])))
                row += read.num_rows
                progress(group + 1, groups)
        except (OSError, ValueError) as error:
            raise self._broken(error) from None
        wrong = np.isinf(table) | (np.abs(table) > LARGEST)
        if wrong.any():
            at, k = map(int, np.argwhere(wrong)[0])
            raise TrajectoryError(
                f"{self.names[numbers[k]]} is too large for any motion",
                where=self.where(at, numbers[k]),
                expected=f"numbers up to {LARGEST:g}",
                found=str(table[at, k]),
                next_step="check its unit",
            )
        return Columns(table, tuple(Stamps.of(np.concatenate(parts or [np.empty(0)])) for parts in instants))

    def where(self, row: int | None = None, column: int | None = None) -> Location:
        """Place of a row or a column, from 1."""
        return Location(self.path, None if row is None else row + 1, None if column is None else column + 1)

    def _broken(self, error: Exception) -> TrajectoryError:
        return TrajectoryError(
            "the log cannot be read as Parquet",
            where=Location(self.path),
            found=str(error).split("\n", 1)[0],
            next_step="write it anew",
        )


def _is_instant(kind: Any) -> bool:
    return str(kind).startswith(("timestamp", "duration"))


def _is_number(kind: Any) -> bool:
    return _is_instant(kind) or str(kind).startswith(("int", "uint", "float", "double", "halffloat"))


def _floats(column: Any) -> Any:
    import pyarrow as pa

    if _is_instant(column.type):
        column = column.cast(
            pa.timestamp("ns") if str(column.type).startswith("timestamp") else pa.duration("ns")
        )
        column = column.cast(pa.int64())
    return column.cast(pa.float64(), safe=False).to_numpy(**_copied(column))


def _instants(column: Any) -> Any:
    """Instants as integers where the file has such, without a loss of digits."""
    import pyarrow as pa

    if _is_instant(column.type):
        kind = pa.timestamp("ns") if str(column.type).startswith("timestamp") else pa.duration("ns")
        column = column.cast(kind).cast(pa.int64())
    if column.null_count or not str(column.type).startswith(("int", "uint")):
        return _floats(column)
    return column.cast(pa.int64()).to_numpy(**_copied(column))


def _copied(column: Any) -> dict[str, bool]:
    """Arrays of a batch may refuse to be copied unless told; chunks of a table know no such word."""
    import pyarrow as pa

    return {} if isinstance(column, pa.ChunkedArray) else {"zero_copy_only": False}
