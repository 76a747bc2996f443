r"""Readings of a joint at any instants, smoothed without delay by a spline of fifth degree.

The spline s is the one with the least

    dt sum_k (s(t_k) - x_k)^2  +  (2 pi f_c)^-6  integral s'''(t)^2 dt,

dt the mean time step. Away from the ends, and at even steps, it passes a frequency f by the real factor

    H(f) = 1 / (1 + (f / f_c)^6),

which is that of a Butterworth filter of third order run forwards and backwards: no delay, half the amplitude
at the cut-off f_c. Unlike such a filter it needs no even steps, and assumes nothing beyond the ends: a motion
of constant acceleration passes unchanged, ends included. Its knots are eight in a period of f_c, so dense
that H is that of knots without number, and so few that the equations are well conditioned, whatever f_c.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray

if TYPE_CHECKING:
    from scipy.interpolate import BSpline

_DEGREE = 5
_KNOTS_PER_PERIOD, _KNOTS_PER_READING = 8, 4
# Below so many periods in a stretch the spline is a parabola, whatever the cut-off.
_PARABOLA = 0.05
# Integrals of the products of two quadratic B-splines, knots 1 apart.
_GRAM = np.array([1, 26, 66, 26, 1]) / 120


def passed(frequency: FloatArray, cutoff: float) -> FloatArray:
    """Share H of the amplitude that a cut-off lets pass."""
    return np.asarray(1 / (1 + (frequency / cutoff) ** 6))


def smoothed(time: FloatArray, values: FloatArray, cutoff: float) -> BSpline[np.float64]:
    """Spline through the readings of one stretch.

    Parameters
    ----------
    time
        Increasing, s, shape (N,); N >= 3.
    values
        Shape (N,) or (N, k).
    cutoff
        f_c, Hz.
    """
    from scipy.interpolate import BSpline
    from scipy.linalg import solveh_banded
    from scipy.sparse import csr_array, diags_array

    span = float(time[-1] - time[0])
    cutoff = max(cutoff, _PARABOLA / span)
    # Where readings are far apart, knots between them would say nothing.
    step = max(1 / (_KNOTS_PER_PERIOD * cutoff), span / (_KNOTS_PER_READING * len(time)))
    # One more than it takes, so that rounding leaves no reading outside.
    pieces = int(span / step) + 1
    # From zero on: instants of an epoch have few digits left for what is between them.
    local = time - time[0]
    knots = step * np.arange(-_DEGREE, pieces + _DEGREE + 1)
    count = pieces + _DEGREE
    basis = BSpline.design_matrix(local, knots, _DEGREE)
    third = diags_array([-1.0, 3.0, -3.0, 1.0], offsets=[0, 1, 2, 3], shape=(count - 3, count))
    gram = diags_array(_GRAM, offsets=[-2, -1, 0, 1, 2], shape=(count - 3, count - 3))
    # The third derivative is a quadratic spline of the third differences over step^3.
    rough = third.T @ (gram @ third) * (step ** (1 - 6) / (2 * math.pi * cutoff) ** 6)
    weight = span / (len(time) - 1)
    equations = csr_array(weight * (basis.T @ basis) + rough)
    banded = np.zeros((_DEGREE + 1, count))
    for k in range(_DEGREE + 1):
        banded[_DEGREE - k, k:] = equations.diagonal(k)
    # Without the first reading: what is large and does not change leaves no rounding in the derivatives.
    origin = values[0]
    coefficients = solveh_banded(banded, weight * (basis.T @ (values - origin)), check_finite=False)
    return BSpline(knots + time[0], coefficients + origin, _DEGREE)


def noise_of(
    readings: FloatArray, smooth: FloatArray, step: float, cutoffs: FloatArray, *, left: bool = False
) -> FloatArray:
    r"""Standard deviation of white noise in readings, from what the smoothing took of it, shape (n,).

    Of the variance of white noise H takes 1 - 7/18 w, and leaves 5/18 w, with w = 2 pi f_c dt.

    Parameters
    ----------
    readings, smooth
        Shape (N, n).
    step
        dt, s.
    cutoffs
        f_c of every joint, Hz.
    left
        Give what is left of it in the smoothed ones instead.
    """
    taken = np.square(readings - smooth).mean(axis=0)
    passing = 2 * math.pi * cutoffs * step
    variance = taken / (1 - 7 / 18 * passing)
    return np.asarray(np.sqrt(variance * (5 / 18 * passing if left else 1.0)))
