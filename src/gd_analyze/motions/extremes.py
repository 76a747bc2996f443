"""Extreme positions, rates and accelerations of a motion, joint by joint."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.trajectory import Trajectory

if TYPE_CHECKING:
    from scipy.interpolate import PPoly


class Extreme(NamedTuple):
    """An extreme value and the instant it is taken."""

    value: float
    time: float


def extremes(motion: Trajectory | PPoly[np.float64], joint: int) -> tuple[Extreme, Extreme, Extreme, Extreme]:
    """Lowest and highest variable, largest magnitude of rate and of acceleration of a joint (from 0).

    Of a trajectory over its set points, of a path exactly; SI and radians.
    """
    taken = []
    for order in range(3):
        if isinstance(motion, Trajectory):
            instants, values = motion.time, (motion.q, motion.qd, motion.qdd)[order][:, joint]
        else:
            instants, values = _candidates(motion.derivative(order) if order else motion, joint)
        picks = [np.abs(values).argmax()] if order else [values.argmin(), values.argmax()]
        taken += [
            Extreme(float(abs(values[pick]) if order else values[pick]), float(instants[pick]))
            for pick in picks
        ]
    lowest, highest, rate, acceleration = taken
    return lowest, highest, rate, acceleration


def _candidates(path: PPoly[np.float64], joint: int) -> tuple[FloatArray, FloatArray]:
    """Instants and values of possible extremes: ends of each piece, and where its derivative is 0."""
    instants, values = [], []
    for piece, (begin, width) in enumerate(zip(path.x, np.diff(path.x), strict=False)):
        coefficients = path.c[:, piece, joint]
        local = np.concatenate([[0.0, width], _stationary(coefficients, width)])
        instants.append(begin + local)
        values.append(np.polyval(coefficients, local))
    return np.concatenate(instants), np.concatenate(values)


def _stationary(coefficients: FloatArray, width: float) -> FloatArray:
    """Where a polynomial, highest power first, may be stationary inside (0, width)."""
    slope = np.polyder(coefficients) * width ** np.arange(len(coefficients) - 2, -1, -1)
    size = np.abs(slope).max(initial=0.0)
    # Below this the joint stands still; the quotients of its coefficients would overflow.
    if size < np.finfo(float).tiny / np.finfo(float).eps:
        return np.empty(0)
    slope = np.where(np.abs(slope) < np.finfo(float).eps * size, 0.0, slope)
    roots = np.roots(slope).real.astype(float)
    return roots[(roots > 0) & (roots < 1)] * width
