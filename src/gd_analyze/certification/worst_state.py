"""Climbing to the state of a box with the largest torque error, from several positions at once.

At every position the worst rates and accelerations are known up to a little (`motion`). With these held, the
error is one polynomial, and along one joint a polynomial of a few coefficients, whose largest value is
found at once. So joints take turns, and after each turn of all of them the rates are chosen anew.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.motion import Motion
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial

# Times that rates are chosen at most, lest a long ridge be followed for ever.
_CHOICES = 40
# Places along a joint that are looked at, and Newton's steps from the best of them.
_PLACES, _STEPS = 33, 3
# A gain less than this share is none.
_GAIN = 3e-4


def highest_position(
    waves: TrigonometricPolynomial, motion: Motion, box: Box, starts: FloatArray
) -> FloatArray:
    """Climb from every start (n, S) and return the position of the largest error reached, shape (n,)."""
    q = np.clip(starts, box.lower[:, None], box.upper[:, None])
    values = waves(q)
    reached = motion.reached(values)
    climbing = np.arange(q.shape[1])
    for _ in range(_CHOICES):
        shares = motion.shares(values[:, climbing])
        real, imaginary = (part.T @ shares for part in waves.parts)
        ridge = _Ridge(waves, real + 1j * imaginary, q[:, climbing])
        for joint in map(int, np.flatnonzero(waves.degrees)):
            ridge.climb(joint, box)
        there = waves(ridge.q)
        now = motion.reached(there)
        better = now > (1.0 + _GAIN) * reached[climbing]
        climbing = climbing[better]
        if not climbing.size:
            break
        q[:, climbing], values[:, climbing] = ridge.q[:, better], there[:, better]
        reached[climbing] = now[better]
    return q[:, int(reached.argmax())]


class _Ridge:
    """S polynomials, each at its own position: coefficients (W, S), positions q (n, S)."""

    def __init__(
        self, waves: TrigonometricPolynomial, coefficients: NDArray[np.complex128], q: FloatArray
    ) -> None:
        self.waves, self.q = waves, q.copy()
        self.turning = ~np.array(waves.sliding)
        self.turned = coefficients * np.exp(1j * (waves.multiples[:, self.turning] @ q[self.turning]))

    def climb(self, joint: int, box: Box) -> None:
        """Move every position to its best place along one joint."""
        multiples = self.waves.multiples[:, joint]
        orders = np.unique(multiples)
        waves = self._without(joint)
        along = np.stack([waves[multiples == m].sum(axis=0) for m in orders])
        turns, now = bool(self.turning[joint]), self.q[joint]
        if turns:
            along *= np.exp(-1j * np.outer(orders, now))
        places = np.linspace(box.lower[joint], box.upper[joint], _PLACES)
        best = places[_along(along, orders, places[:, None, None], turns)[0].argmax(axis=0)]
        for _ in range(_STEPS):
            _, slope, curve = _along(along, orders, best, turns)
            step = np.where(curve < 0.0, -slope / np.where(curve < 0.0, curve, 1.0), 0.0)
            best = np.clip(best + step, box.lower[joint], box.upper[joint])
        old, new = (_along(along, orders, x, turns)[0] for x in (now, best))
        gains = new > old
        self.q[joint] = np.where(gains, best, now)
        if turns:
            phases = np.exp(1j * np.outer(orders, self.q[joint] - now))
            self.turned *= phases[np.searchsorted(orders, multiples)]

    def _without(self, joint: int) -> Array:
        """Waves at the positions, but for the power of one joint if it slides, shape (W, S)."""
        out: Array = self.turned
        for k in np.flatnonzero(~self.turning):
            if k != joint:
                out = out * self.q[k] ** self.waves.multiples[:, [k]]
        return out


def _along(
    coefficients: Array, orders: NDArray[np.int64], x: FloatArray, turns: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values, slopes and curvatures of polynomials (D, S) in one joint at places (..., S)."""
    m = orders[:, None].astype(float)
    x = x[..., None, :]
    if turns:
        basis = coefficients * np.exp(1j * m * x)
        ways = basis, 1j * m * basis, -(m**2) * basis
    else:
        powers = [x ** np.maximum(m - less, 0.0) for less in range(3)]
        ways = coefficients * powers[0], coefficients * m * powers[1], coefficients * m * (m - 1) * powers[2]
    value, slope, curve = (way.real.sum(axis=-2) for way in ways)
    return value, slope, curve
