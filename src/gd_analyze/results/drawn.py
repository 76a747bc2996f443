"""What of a long decomposition is drawn: read once, block by block, for all figures of all reports."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import elements
from gd_analyze.dynamics.long_decomposition import MOST_KEPT

if TYPE_CHECKING:
    import xarray as xr

NAMES = ("inertia", "coriolis_centrifugal", "centrifugal", "coriolis", "gravity_loading")
# Equal stretches of a long trajectory in each of which every curve keeps its extremes: twice as many as a
# page can show, as each figure may thin its curves further.
STRETCHES = 500


def drawn(dataset: xr.Dataset) -> tuple[NDArray[np.intp], xr.Dataset]:
    """Choose the set points at which the elements are drawn.

    Parameters
    ----------
    dataset
        What `decompose` or `decompose_on_demand` gave.

    Returns
    -------
    set points, dataset
        Their numbers, from 0 and increasing, first and last among them; and D, h, its shares and c there, in
        memory. All of up to `MOST_KEPT` set points; else every element, each of its parts and their sum has
        the extremes of each stretch among them.
    """
    count = dataset.sizes["time"]
    names = [*NAMES]
    if count <= MOST_KEPT:
        return np.arange(count), dataset[names].load()
    chosen = [np.array([0, count - 1])]
    length = -(-count // STRETCHES)
    for start in range(0, count, length):
        block = dataset[names].isel(time=slice(start, start + length)).load()
        curves = np.hstack([*_curves(block)])
        chosen += [start + curves.argmin(axis=0), start + curves.argmax(axis=0)]
    points = np.unique(np.concatenate(chosen))
    return points, dataset[names].isel(time=points).load()


def _curves(block: xr.Dataset) -> Iterator[FloatArray]:
    """Whatever is drawn of every element, shape (N, curves)."""
    for element in elements(block.sizes["joint"]):
        parts = element.parts(block).T
        yield parts
        if element.quantity != "gravity_loading":
            yield parts.sum(axis=1, keepdims=True)
    for share in ("centrifugal", "coriolis"):
        yield block[share].values.sum(axis=1)
