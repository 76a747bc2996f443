"""Splines through the numbers of a joint, smoothing or interpolating, and spectra: docs/trajectories.md."""

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
# Steps that differ by less than this share are even.
_EVEN = 1e-3
# A joint that rests and whose position was computed at every set point differs in the last digit or two.
_LAST_DIGITS = 4 * float(np.finfo(float).eps)


def passed(frequency: FloatArray, cutoff: float) -> FloatArray:
    """Share H of the amplitude that a cut-off lets pass."""
    return np.asarray(1 / (1 + (frequency / cutoff) ** 6))


def smoothed(time: FloatArray, values: FloatArray, cutoff: float) -> BSpline[np.float64]:
    """Smoothing spline of one stretch, shape (N,) or (N, k), N >= 3, at the cut-off f_c, Hz.

    Its knots, eight in a period of f_c, are dense enough for the H of infinitely many, and few enough for
    well-conditioned equations.
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
    """Standard deviation of white noise in readings, shape (n,), from the part that smoothing removed.

    Of the variance of white noise H removes 1 - 7/18 w, and leaves 5/18 w, with w = 2 pi f_c dt. `left` asks
    for what is left of the noise in the smoothed readings instead.
    """
    removed = np.square(readings - smooth).mean(axis=0)
    passing = 2 * math.pi * cutoffs * step
    return np.asarray(np.sqrt(removed / (1 - 7 / 18 * passing) * (5 / 18 * passing if left else 1.0)))


def differentiated(time: FloatArray, values: FloatArray, order: int) -> FloatArray:
    """Derivative of the quintic spline through values, shape (N, n); nan where doubles overflow."""
    from scipy.interpolate import make_interp_spline

    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        try:
            derivative: FloatArray = make_interp_spline(time, values, k=5).derivative(order)(time)
        except ValueError:  # raised where the spline's equations overflow
            return np.full_like(values, np.nan)
    # A spline through a constant has slopes of its last digits over the time step, squared for accelerations.
    moved = np.ptp(values, axis=0) > _LAST_DIGITS * np.abs(values).max(axis=0)
    return np.where(moved, derivative, 0.0)


def power(time: FloatArray, readings: FloatArray, rate: float, order: int, piece: int) -> FloatArray:
    """Power spectral density of the derivative of readings, by Welch's method on their differences.

    Unlike positions, differences have no trend that would leak into all frequencies; what they lack of a
    derivative at high frequencies is made up for.
    """
    from scipy.interpolate import PchipInterpolator
    from scipy.signal import welch

    if np.abs(np.diff(time) * rate - 1).max(initial=0.0) >= _EVEN:
        even = np.linspace(time[0], time[-1], len(time))
        readings = np.asarray(PchipInterpolator(time, readings)(even))
    differences = np.diff(readings, order) * rate**order
    frequency, density = welch(differences, rate, "hann", nperseg=piece, detrend="constant")
    return np.asarray(density / np.sinc(frequency / rate) ** (2 * order))
