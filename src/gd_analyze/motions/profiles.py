"""Time profiles: piecewise polynomials of time from one knot to the next."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from types import MappingProxyType
from typing import Any

import numpy as np
from scipy.interpolate import CubicSpline, PPoly, make_interp_spline

from gd_analyze.arrays import FloatArray

# Without vias, lift-off and set-down lie on the straight line to the goal, where the minimum-jerk quintic 10
# x^3 - 15 x^4 + 6 x^5 passes at a quarter and three quarters of the time: no joint overshoots.
LIFT_OFF_TIME = 0.25
LIFT_OFF_SHARE = 53 / 512

# [FGL87] chapter 4: position, velocity and acceleration are prescribed at start and goal, and continuous.
_PRESCRIBED_ORDERS = 3


@dataclass(frozen=True)
class Profile:
    """One way to time a motion."""

    name: str  # as on the command line
    via_counts: tuple[int, ...] | None  # numbers of vias it takes; None for any
    # number of derivatives of q that are zero at start and goal: 1 velocities, 2 accelerations too
    rest_orders: int
    # Makes the motion q(t) from the knots' instants (m,) and joint variables (m, n)
    path: Callable[[FloatArray, FloatArray], PPoly[np.float64]]


def _three_segments(degrees: tuple[int, int, int], times: FloatArray, knots: FloatArray) -> PPoly[np.float64]:
    """Three polynomials of given degrees through four knots, C2, at rest at both ends ([FGL87] chapter 4)."""
    if len(knots) == 2:
        shares = np.array([0.0, LIFT_OFF_TIME, 1 - LIFT_OFF_TIME, 1.0])
        passed = np.array([0.0, LIFT_OFF_SHARE, 1 - LIFT_OFF_SHARE, 1.0])
        times = times[0] + shares * (times[1] - times[0])
        knots = knots[0] + passed[:, None] * (knots[1] - knots[0])
    # Per segment x runs from 0 to 1; a condition on derivatives is multiplied by the shorter of its
    # segments' durations, to the power of the order, which keeps short segments from spoiling the system.
    widths = np.diff(times)
    first = np.concatenate([[0], np.cumsum(np.array(degrees) + 1)])
    rows: list[FloatArray] = []
    values: list[FloatArray] = []

    def derivative(segment: int, x: float, order: int, unit: float) -> FloatArray:
        row = np.zeros(first[-1])
        for power in range(order, degrees[segment] + 1):
            falling = math.perm(power, order)
            row[first[segment] + power] = falling * x ** (power - order) * (unit / widths[segment]) ** order
        return row

    moved = knots - knots[0]
    still = np.zeros(knots.shape[1])
    for order in range(_PRESCRIBED_ORDERS):
        rows += [derivative(0, 0.0, order, widths[0]), derivative(2, 1.0, order, widths[2])]
        values += [still, moved[3] if order == 0 else still]
    for left, right in ((0, 1), (1, 2)):
        unit = min(widths[left], widths[right])
        rows += [derivative(left, 1.0, 0, unit), derivative(right, 0.0, 0, unit)]
        values += [moved[right], moved[right]]
        for order in range(1, _PRESCRIBED_ORDERS):
            rows.append(derivative(left, 1.0, order, unit) - derivative(right, 0.0, order, unit))
            values.append(still)
    solved = np.linalg.solve(np.array(rows), np.array(values))

    highest = max(degrees)
    coefficients = np.zeros((highest + 1, 3, knots.shape[1]))
    for segment, degree in enumerate(degrees):
        for power in range(degree + 1):
            coefficients[highest - power, segment] = solved[first[segment] + power] / widths[segment] ** power
    return _shifted(coefficients, times, knots[0])


def _quintic(times: FloatArray, knots: FloatArray) -> PPoly[np.float64]:
    """Quintic spline through the knots, C4, at rest with zero acceleration at both ends."""
    still = np.zeros(knots.shape[1])
    # One condition for every joint; scipy-stubs know those of a single curve only.
    end_conditions: Any = [(1, still), (2, still)]
    spline = make_interp_spline(times, knots - knots[0], k=5, bc_type=(end_conditions, end_conditions))
    breaks = np.unique(spline.t)
    taylor = [spline(breaks[:-1], order) / math.factorial(order) for order in range(5, -1, -1)]
    return _shifted(np.array(taylor), breaks, knots[0])


def _cubic(times: FloatArray, knots: FloatArray) -> PPoly[np.float64]:
    """Cubic spline through the knots, C2, at rest at both ends."""
    spline = CubicSpline(times, knots - knots[0], bc_type="clamped")
    return _shifted(spline.c, spline.x, knots[0])


def _trapezoidal(times: FloatArray, knots: FloatArray) -> PPoly[np.float64]:
    """Straight lines in joint space, a third each accelerating, cruising and braking; stops at vias.

    Of all trapezoids of a given distance and time, thirds heat the drives' windings least.
    """
    widths, steps = np.diff(times)[:, None], np.diff(knots, axis=0)
    cruise, acceleration = 1.5 * steps / widths, 4.5 * steps / widths**2
    begin = knots[:-1] - knots[0]
    nothing = np.zeros_like(steps)
    thirds = [
        (acceleration / 2, nothing, begin),
        (nothing, cruise, begin + steps / 4),
        (-acceleration / 2, cruise, begin + 3 * steps / 4),
    ]
    # (power, segment, third, joint) -> (power, piece, joint)
    coefficients = np.stack([np.stack(third) for third in thirds], axis=2)
    pieces = coefficients.reshape(3, -1, knots.shape[1])
    breaks = np.append((times[:-1, None] + widths * np.arange(3) / 3).ravel(), times[-1])
    return _shifted(pieces, breaks, knots[0])


def _shifted(coefficients: FloatArray, breaks: FloatArray, start: FloatArray) -> PPoly[np.float64]:
    """Motion from displacements, solved without the start so that a joint at rest stays exactly at rest."""
    moved = np.array(coefficients)
    moved[-1] += start
    return PPoly(moved, breaks)


PROFILES = MappingProxyType(
    {
        profile.name: profile
        for profile in (
            Profile("4-3-4", (0, 2), 2, partial(_three_segments, (4, 3, 4))),
            Profile("3-5-3", (0, 2), 2, partial(_three_segments, (3, 5, 3))),
            Profile("quintic", None, 2, _quintic),
            Profile("cubic", None, 1, _cubic),
            Profile("trapezoidal", None, 1, _trapezoidal),
        )
    }
)
