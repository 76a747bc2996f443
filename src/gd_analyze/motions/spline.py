"""The smoothing spline of readings: which frequencies it passes, and how a long one is made."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.sampling import Sampling

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

# Degree of the spline.
_DEGREE = 5
# Its knots per period of the cut-off frequency.
_KNOTS_PER_PERIOD = 8
# Most of its knots per reading.
_KNOTS_PER_READING = 4
# Below this many periods in a stretch the spline is a parabola for any cut-off.
_FEWEST_PERIODS = 0.05
# Integrals of the products of two quadratic B-splines, knots 1 apart.
_SPLINE_PRODUCTS = np.array([1, 26, 66, 26, 1]) / 120
# Fewest readings of a block of a long spline; a block is not shorter than its overlap at one side.
BLOCK_READINGS = 2**15
# Overlap of a block at either side, in periods of the cut-off, and as many usual steps. The effect of a
# reading on the spline falls by exp(-pi) within a period, by 1e-22 within the overlap. Where readings are
# sparse it falls by 0.43 from one to the next; the overlap has 64 or more, as a period has four usual steps.
_OVERLAP_PERIODS = 16


def derivatives(
    sampling: Sampling, values: FloatArray, cutoffs: FloatArray, orders: Sequence[int]
) -> FloatArray:
    """Derivatives of smoothed readings, shape (N, n) each; nan in a stretch of fewer than three readings."""
    out = np.full((len(orders), *values.shape), np.nan)
    joints = [slice(i, i + 1) for i in range(len(cutoffs))]
    for stretch in sampling.stretches:
        finite = np.isfinite(values[stretch])
        # The same readings at the same cut-off have the same equations.
        alike = finite.all() and (cutoffs == cutoffs[0]).all()
        for group in [slice(None)] if alike else joints:
            rows = stretch.start + np.flatnonzero(finite[:, group].all(axis=1))
            if len(rows) >= 3:
                equations = _Equations.of(sampling.time[rows], float(cutoffs[group][0]))
                _write(equations, sampling, stretch, rows, values[:, group], orders, out[..., group])
    out.flags.writeable = False  # and a trajectory needs no copy
    return out


def _write(
    equations: _Equations,
    sampling: Sampling,
    stretch: slice,
    rows: NDArray[np.intp],
    values: FloatArray,
    orders: Sequence[int],
    out: FloatArray,
) -> None:
    """Write derivatives in a stretch, block by block; its readings are in these rows of `values`."""
    time, count = equations.time, len(rows)
    overlap = _OVERLAP_PERIODS / equations.cutoff
    fewest = math.ceil(overlap / sampling.step)
    length = max(BLOCK_READINGS, fewest)
    for first in range(0, count, length):
        end = min(first + length, count)
        begin = min(int(np.searchsorted(time, time[first] - overlap)), first - fewest)
        beyond = max(int(np.searchsorted(time, time[end - 1] + overlap, "right")), end + fewest)
        part = slice(max(begin, 0), min(beyond, count))
        spline = equations.spline(values[rows[part]], values[rows[0]], part)
        # Instants without a reading belong to the block before them, or to the first one.
        block = slice(rows[first] if first else stretch.start, rows[end] if end < count else stretch.stop)
        for array, order in zip(out, orders, strict=True):
            array[block] = spline(sampling.time[block], order)


def smoothed(time: FloatArray, values: FloatArray, cutoff: float) -> BSpline[np.float64]:
    """Smoothing spline of one stretch, shape (N,) or (N, k), N >= 3, at the cut-off f_c, Hz."""
    return _Equations.of(time, cutoff).spline(values, values[0], slice(0, len(time)))


@dataclass(frozen=True, eq=False)
class _Equations:
    """Equations of the smoothing spline of one stretch, of which parts can be solved.

    Its knots, eight per period of f_c, are dense enough to give the response H of infinitely many, and few
    enough for well-conditioned equations.
    """

    time: FloatArray  # instants of the readings, s, (N,)
    cutoff: float  # Hz
    step: float  # between knots, s
    weight: float  # mean time between readings, s

    @classmethod
    def of(cls, time: FloatArray, cutoff: float) -> _Equations:
        """The equations of a stretch."""
        span = float(time[-1] - time[0])
        cutoff = max(cutoff, _FEWEST_PERIODS / span)
        # Where readings are far apart, knots between them are useless.
        step = max(1 / (_KNOTS_PER_PERIOD * cutoff), span / (_KNOTS_PER_READING * len(time)))
        return cls(time, cutoff, step, span / (len(time) - 1))

    def spline(self, values: FloatArray, origin: FloatArray, part: slice) -> BSpline[np.float64]:
        """The spline through the readings of a part, with the knots of the whole.

        `origin` is near all values, so that a large constant causes no rounding in the derivatives.
        """
        from scipy.interpolate import BSpline
        from scipy.linalg import solveh_banded
        from scipy.sparse import csr_array, diags_array

        step = self.step
        # Time starts at zero: instants of an epoch have few digits left for their differences.
        local = self.time[part] - self.time[0]
        # One knot more than needed at either end, so that rounding leaves no reading outside.
        first, last = max(int(local[0] / step) - 1, 0), int(local[-1] / step) + 1
        knots = step * np.arange(first - _DEGREE, last + _DEGREE + 1)
        count = last - first + _DEGREE
        basis = BSpline.design_matrix(local, knots, _DEGREE)
        third = diags_array([-1.0, 3.0, -3.0, 1.0], offsets=[0, 1, 2, 3], shape=(count - 3, count))
        gram = diags_array(_SPLINE_PRODUCTS, offsets=[-2, -1, 0, 1, 2], shape=(count - 3, count - 3))
        # The third derivative is a quadratic spline of the third differences over step^3.
        rough = third.T @ (gram @ third) * (step ** (1 - 6) / (2 * math.pi * self.cutoff) ** 6)
        equations = csr_array(self.weight * (basis.T @ basis) + rough)
        banded = np.zeros((_DEGREE + 1, count))
        for k in range(_DEGREE + 1):
            banded[_DEGREE - k, k:] = equations.diagonal(k)
        right = np.asarray(self.weight * (basis.T @ (values - origin)))
        coefficients = solveh_banded(banded, right, check_finite=False)
        return BSpline(knots + self.time[0], coefficients + origin, _DEGREE)
