"""Long curves made short enough to draw without losing their extremes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray


def evenly(count: int, most: int) -> NDArray[np.intp]:
    """Indices of evenly spaced set points, at most so many, first and last among them."""
    return np.unique(np.linspace(0, count - 1, min(count, most)).round().astype(int))


def thinned(curves: FloatArray, most: int) -> NDArray[np.intp]:
    """Indices of the set points to draw: every curve keeps its extremes in each of equal stretches.

    Parameters
    ----------
    curves
        Curves drawn over the same set points, shape (k, N).
    most
        Largest number of set points to keep.

    Returns
    -------
    numpy.ndarray
        Increasing indices, all N of them if N is at most `most`.
    """
    k, count = curves.shape
    if count <= most:
        return np.arange(count)
    stretches = max((most - 2) // (2 * k), 1)
    length = -(-count // stretches)
    padded = np.pad(curves, ((0, 0), (0, stretches * length - count)), mode="edge")
    windows = padded.reshape(k, stretches, length)
    starts = np.arange(stretches) * length
    extremes = [(windows.argmin(axis=2) + starts).ravel(), (windows.argmax(axis=2) + starts).ravel()]
    return np.unique(np.minimum(np.concatenate([[0, count - 1], *extremes]), count - 1))


def breaks(chosen: NDArray[np.intp], gaps: Sequence[int] | NDArray[np.intp]) -> NDArray[np.intp]:
    """Places among the chosen set points, increasing, before which a curve has to break.

    Parameters
    ----------
    chosen
        Increasing indices of set points.
    gaps
        Set points before which there is a gap.

    Examples
    --------
    >>> breaks(np.array([0, 2, 4, 6]), [3, 4]).tolist()
    [2]
    """
    places = np.unique(np.searchsorted(chosen, gaps))
    return np.asarray(places[(places > 0) & (places < len(chosen))])


def broken(points: FloatArray, places: NDArray[np.intp]) -> FloatArray:
    """Points of a line, shape (N, 2), with one that is not a number where it breaks."""
    return np.insert(points, places, np.nan, axis=0) if places.size else points
