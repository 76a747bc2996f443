"""Very many rows of numbers: in memory, or in a memory-mapped temporary file."""

from __future__ import annotations

import ctypes
import mmap
import tempfile
from collections.abc import Iterator
from contextlib import suppress
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import CHUNK, FloatArray, chunks

# Most numbers kept in memory: 32 MB.
_MOST = 2**22
# Rows of mapped numbers after which their memory is released.
_ROWS = 8 * CHUNK
# Scattered rows after which memory is released: the system maps 64 kB with each.
_GATHERED = 256


class Spool:
    """Collects rows of `width` numbers; beyond `_MOST` numbers they go to an unnamed file."""

    def __init__(self, width: int) -> None:
        self._width, self._rows = width, 0
        self._parts: list[FloatArray] = []
        self._file: Any = None

    def add(self, rows: FloatArray) -> None:
        """Take rows, shape (N, width)."""
        self._rows += len(rows)
        self._parts.append(rows)
        if self._file is None and self._rows * self._width > _MOST:
            # The mapping outlives the open file.
            self._file = tempfile.TemporaryFile()  # noqa: SIM115  open from block to block
        if self._file is not None:
            for part in self._parts:
                np.ascontiguousarray(part).tofile(self._file)
            self._parts.clear()

    def array(self) -> FloatArray:
        """All rows, shape (N, width); read-only if mapped."""
        if self._file is None:
            return np.concatenate([np.empty((0, self._width)), *self._parts])
        self._file.flush()
        shape = (self._rows, self._width)
        return cast("FloatArray", np.memmap(self._file, dtype=float, mode="r", shape=shape))


def _map_of(array: FloatArray) -> mmap.mmap | None:
    """The map behind an array, if any."""
    base: Any = array
    while isinstance(base, np.ndarray):
        base = base.base
    return base if isinstance(base, mmap.mmap) else None


def is_mapped(array: FloatArray) -> bool:
    """Whether an array is mapped from a file."""
    return _map_of(array) is not None


def release(*arrays: FloatArray) -> None:
    """Release the memory of mapped arrays, which are read from their file again on access."""
    for array in arrays:
        mapping = _map_of(array)
        if mapping is not None and hasattr(mmap, "MADV_DONTNEED"):
            mapping.madvise(mmap.MADV_DONTNEED)


def gathered(array: FloatArray, rows: NDArray[np.intp]) -> FloatArray:
    """Take some rows, releasing memory on the way, as each row read loads its neighbours."""
    out = np.empty((len(rows), *array.shape[1:]))
    for start in range(0, len(rows), _GATHERED):
        part = slice(start, start + _GATHERED)
        out[part] = array[rows[part]]
        release(array)
    return out


def blocks(*arrays: FloatArray) -> Iterator[slice]:
    """Cut rows into slices of `CHUNK`, releasing memory on the way."""
    for chunk in chunks(len(arrays[0])):
        yield chunk
        if chunk.stop % _ROWS == 0:
            release(*arrays)
    release(*arrays)


def trim() -> None:
    """Return freed memory that glibc keeps, some 100 MB after a search, to the system."""
    with suppress(OSError, AttributeError, TypeError):
        ctypes.CDLL(None).malloc_trim(0)
