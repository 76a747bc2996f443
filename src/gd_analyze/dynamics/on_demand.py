"""Variables whose rows along time are made when somebody reads them, so that a long one is never whole."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray
from xarray.backends import BackendArray
from xarray.core import indexing

from gd_analyze.arrays import Array, chunks

# Takes the numbers of some rows, increasing, and gives these rows, shape (rows, ...).
Read = Callable[[NDArray[np.intp]], Array]


def on_demand(shape: tuple[int, ...], read: Read) -> indexing.LazilyIndexedArray:
    """Make numbers for a variable of xarray that asks for rows whenever it is read, some thousand at a time.

    `isel` chooses without reading; `values` reads what was chosen, and keeps nothing.
    """
    return indexing.LazilyIndexedArray(_Rows(shape, read))


class _Rows(BackendArray):
    """What xarray indexes and, in the end, reads."""

    def __init__(self, shape: tuple[int, ...], read: Read) -> None:
        self.shape, self.dtype, self._read = shape, np.dtype(float), read

    def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
        return indexing.explicit_indexing_adapter(
            key, self.shape, indexing.IndexingSupport.OUTER, self._chosen
        )

    def _chosen(self, key: tuple[Any, ...]) -> Array:
        rows, rest = np.arange(self.shape[0])[key[0]], key[1:]
        every = np.atleast_1d(rows)
        shape = _at(np.empty((1, *self.shape[1:])), rest).shape[1:]
        out = np.moveaxis(np.empty((*shape, len(every))), -1, 0)  # as formulations lay out what they give
        for chunk in chunks(len(every)):
            out[chunk] = _at(self._read(every[chunk]), rest)
        return out if np.ndim(rows) else out[0]


def _at(values: Array, rest: tuple[Any, ...]) -> Array:
    """Index every axis but the first on its own, the last one first as some of them vanish."""
    for axis in range(len(rest), 0, -1):
        values = values[(*[slice(None)] * axis, rest[axis - 1])]
    return values
