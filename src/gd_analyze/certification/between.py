r"""Possible motions between two neighbouring set points: three through both, in powers of s = 0 ... 1.

The polynomial of fifth degree through all six numbers of a joint; that of third degree through q and qd,
whose acceleration may jump at a set point, as in a trapezoidal profile; and straight lines through q, qd and
qdd separately. They differ only by what a linear acceleration does not explain,

    D_v = qd_1 - qd_0 - T (qdd_0 + qdd_1) / 2,
    D_q = q_1 - q_0 - T (qd_0 + qd_1) / 2 + T^2 (qdd_1 - qdd_0) / 12.

Numbers in a file are rounded, and over a short T the accelerations that explain the last digit are enormous:
D_v and D_q below the caller's rounding are set to zero.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.trajectory import Trajectory

_DEGREE = 5
_POWERS = np.arange(_DEGREE + 1)
# Largest s - s^k, by k.
_OFF_LINE = (0.0, 0.0, 0.25, 0.3850, 0.4725, 0.5350)
# Instants of an interval at which the motions are compared, including its ends.
_COMPARED = np.linspace(0.0, 1.0, 9)


@dataclass(frozen=True, eq=False)
class Between:
    """Motions between consecutive set points."""

    # Coefficients of s^0 ... s^5, shape (intervals, 6, 3, 3, n): by motion, q, qd and qdd, and joint
    coefficients: FloatArray

    @classmethod
    def of(cls, motion: Trajectory, rounding: FloatArray, chosen: slice | NDArray[np.intp]) -> Between:
        """Take some intervals, from 0; D_q and D_v up to `rounding`, shape (2, n), are round-off."""
        width, ((q0, q1), (v0, v1), (a0, a1)), off_q, off_v = _unexplained(motion, rounding, chosen)
        rise = off_q + off_v / 2
        # Linear acceleration, and what it does not explain.
        begin, second, third = [q0, v0 * width], a0 * width**2 / 2, (a1 - a0) * width**2 / 6
        higher = [third + 10 * rise - 4 * off_v, 7 * off_v - 15 * rise, 6 * rise - 3 * off_v]
        quintic = [*begin, second, *higher]
        moved, turned = second + third + rise, 2 * second + 3 * third + off_v
        zeros = np.zeros_like(q0)
        cubic = [*begin, 3 * moved - turned, turned - 2 * moved, zeros, zeros]
        out = np.zeros((len(q0), _DEGREE + 1, 3, 3, q0.shape[1]))
        for place, position in enumerate((quintic, cubic)):
            rows = np.stack(position, axis=1)
            for order in range(3):
                out[:, : _DEGREE + 1 - order, place, order] = rows / width[:, None] ** order
                rows = rows[:, 1:] * _POWERS[1 : rows.shape[1], None]
        for order, (first, last) in enumerate(((q0, q1), (v0, v1), (a0, a1))):
            out[:, 0, 2, order], out[:, 1, 2, order] = first, last - first
        return cls(out)

    def ranges(self, begin: FloatArray, end: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Limits in s = begin ... end of each interval, shape (intervals, 3, n), by the Bernstein hull."""
        values = self._combined(_bernstein(begin, end))
        return values.min(axis=(1, 2)), values.max(axis=(1, 2))

    @staticmethod
    def along_lines(
        motion: Trajectory, rounding: FloatArray, chosen: slice
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Limits of intervals, and bounds on the motions' distance, (intervals, 3, n), in few operations.

        A motion with powers c_k s^k deviates from the straight line between its ends by at most sum_k
        abs(c_k) max_s (s - s^k); the limits are wider than those of `ranges`.
        """
        width, ends, off_q, off_v = _unexplained(motion, rounding, chosen)
        (q0, q1), (v0, v1), (a0, a1) = ends
        rise, second, third = off_q + off_v / 2, a0 * width**2 / 2, (a1 - a0) * width**2 / 6
        # The quintic and the cubic together.
        bend = (
            abs(second) + abs(3 * rise - off_v),
            abs(third) + abs(10 * rise - 4 * off_v) + abs(2 * rise - off_v),
            abs(7 * off_v - 15 * rise),
            abs(6 * rise - 3 * off_v),
        )
        moved = abs(q0 + v0 * width + second + third + rise - q1)
        turned = abs(v0 * width + 2 * second + 3 * third + off_v - v1 * width)
        slack = np.zeros((len(q0), 3, q0.shape[1]))
        for order, unexplained in enumerate(
            (moved, turned, np.maximum(abs(6 * rise - 2 * off_v), abs(6 * rise - 4 * off_v)))
        ):
            slack[:, order] = unexplained
            for k, x in enumerate(bend, start=2):
                power = k - order
                if power > 1:
                    slack[:, order] += math.perm(k, order) * _OFF_LINE[power] * x
            slack[:, order] /= width**order
        first, last = (np.stack(x, axis=1) for x in ((q0, v0, a0), (q1, v1, a1)))
        return np.minimum(first, last) - slack, np.maximum(first, last) + slack, 2 * slack

    @property
    def differences(self) -> FloatArray:
        """Largest distance between the motions at some instants, shape (intervals, 3, n)."""
        values = self._combined(_COMPARED[:, None] ** _POWERS)
        return np.asarray(np.ptp(values, axis=2).max(axis=1))

    def _combined(self, weights: FloatArray) -> FloatArray:
        """Sums of coefficients with weights (.., S, 6), shape (intervals, S, 3, 3, n)."""
        count, powers, *trailing = self.coefficients.shape
        flat = weights @ self.coefficients.reshape(count, powers, -1)
        return np.asarray(flat).reshape(count, -1, *trailing)


def _bernstein(begin: FloatArray, end: FloatArray) -> FloatArray:
    """Matrices from coefficients of powers to Bernstein coefficients on begin ... end, shape (K, 6, 6)."""
    binomial = np.array([[math.comb(j, i) for j in _POWERS] for i in _POWERS], dtype=float)
    width = (end - begin)[:, None, None]
    shift = np.maximum(_POWERS[None, :] - _POWERS[:, None], 0)
    # s = begin + width u: the coefficient of u^i.
    local = binomial * begin[:, None, None] ** shift * width ** _POWERS[:, None]
    control = np.array([[math.comb(i, j) / math.comb(_DEGREE, j) for j in _POWERS] for i in _POWERS])
    return np.asarray(control @ local)


def _unexplained(
    motion: Trajectory, rounding: FloatArray, chosen: slice | NDArray[np.intp]
) -> tuple[FloatArray, tuple[tuple[FloatArray, FloatArray], ...], FloatArray, FloatArray]:
    """T, shape (intervals, 1), q, qd and qdd at both ends, and D_q and T D_v without rounding."""
    if isinstance(chosen, slice):
        chosen = np.arange(*chosen.indices(motion.n_set_points - 1))
    width = (motion.time[chosen + 1] - motion.time[chosen])[:, None]
    ends = tuple((x[chosen], x[chosen + 1]) for x in (motion.q, motion.qd, motion.qdd))
    (q0, q1), (v0, v1), (a0, a1) = ends
    off_v = v1 - v0 - width * (a0 + a1) / 2
    off_v = np.where(np.abs(off_v) > rounding[1], off_v, 0.0) * width
    off_q = q1 - q0 - width * (v0 + v1) / 2 + width**2 * (a1 - a0) / 12
    return width, ends, np.where(np.abs(off_q) > rounding[0], off_q, 0.0), off_v
