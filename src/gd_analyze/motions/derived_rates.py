"""Derives rates and accelerations that a trajectory leaves out.

Why these splines. A quintic interpolating spline is C4, so the acceleration read off it is C2 and follows
a smooth motion with an error of order h^4 (h: time step). Its end conditions are not-a-knot: they assume
nothing, where "natural" or "at rest" ends would bend the accelerations of a recording cut out of a longer
motion. Where the rates are given, accelerations come from a spline through the *rates*: one
differentiation amplifies noise by 1/h instead of 1/h^2, and the result agrees with the rates the user
stated, which a spline through the positions would contradict.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gd_analyze.arrays import FloatArray

# A quintic with not-a-knot ends has six free coefficients before its first inner knot.
FEWEST_SET_POINTS = 6
# A joint that rests and whose position was computed at every set point differs in the last digit or two.
_LAST_DIGITS = 4 * float(np.finfo(float).eps)


def complete_rates(
    time: FloatArray,
    q: FloatArray,
    qd: FloatArray | None,
    qdd: FloatArray | None,
    gaps: Sequence[int] = (),
) -> tuple[FloatArray, FloatArray, str]:
    """Fill in the rates and accelerations that are missing.

    Parameters
    ----------
    time
        Strictly increasing, s, shape (N,); N >= 6 unless both qd and qdd are given.
    q
        Joint variables, rad (m), shape (N, n).
    qd, qdd
        Their rates and accelerations, same shape, or None.
    gaps
        Set points before which nothing is known: every stretch has a spline of its own, and N >= 6 there.

    Returns
    -------
    qd, qdd
        Given or derived, shape (N, n); not finite, or enormous, where the instants are so close, or so
        unevenly spaced, that doubles do not hold the result.
    rates_from
        "given", or what was derived and how.
    """
    if qd is not None and qdd is not None:
        return qd, qdd, "given"
    if qd is not None:
        return qd, _along(time, qd, 1, gaps), "qdd derived: C4 (quintic) spline through the given qd"
    rates = _along(time, q, 1, gaps)
    if qdd is not None:
        return rates, qdd, "qd derived: C4 (quintic) spline through the given q"
    return rates, _along(time, q, 2, gaps), "qd and qdd derived: C4 (quintic) spline through the given q"


def _along(time: FloatArray, values: FloatArray, order: int, gaps: Sequence[int]) -> FloatArray:
    """Differentiate stretch by stretch."""
    parts = zip(np.split(time, gaps), np.split(values, gaps), strict=True)
    return np.concatenate([_differentiate(*part, order) for part in parts])


def _differentiate(time: FloatArray, values: FloatArray, order: int) -> FloatArray:
    from scipy.interpolate import make_interp_spline

    with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
        try:
            derivative: FloatArray = make_interp_spline(time, values, k=5).derivative(order)(time)
        except ValueError:  # raised where the spline's equations overflow
            return np.full_like(values, np.nan)
    # A spline through a constant has slopes of its last digits over the time step, squared for accelerations.
    moved = np.ptp(values, axis=0) > _LAST_DIGITS * np.abs(values).max(axis=0)
    return np.where(moved, derivative, 0.0)
