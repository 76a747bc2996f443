"""Long curves made short enough to draw without losing their extremes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from gd_analyze.vectors import FloatArray

BINS = 250


def thinned(values: FloatArray, bins: int = BINS) -> NDArray[np.intp]:
    """Set points to draw: all of them, or the lowest and highest of every bin, in order.

    Parameters
    ----------
    values
        One curve, shape (N,).
    bins
        Number of bins of equal numbers of set points.

    Returns
    -------
    numpy.ndarray
        Indices; first and last set point are among them, so is every bin's minimum and maximum.
    """
    count = len(values)
    if not is_thinned(count, bins):
        return np.arange(count)
    edges = np.linspace(0, count, bins + 1).astype(int)
    chosen = [0, count - 1]
    for start, stop in pairwise(edges):
        part = values[start:stop]
        chosen += [start + int(part.argmin()), start + int(part.argmax())]
    return np.unique(np.array(chosen))


def is_thinned(count: int, bins: int = BINS) -> bool:
    """Whether curves of so many set points are thinned."""
    return count > 4 * bins
