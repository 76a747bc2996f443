"""Climbing to a local maximum within a box of positions, from several positions at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.motion import Motion
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial

# First step, of the box's width, and the number of times that it is halved.
_FIRST_STEP, _HALVINGS = 1 / 32, 9
# Most moves, and most choices of velocities, so that a long ridge is not followed forever.
_MOST_MOVES, _MOST_CHOICES = 40, 40
# Places tried along a joint, and Newton's steps from the best of them.
_PLACES, _STEPS = 33, 3
# A smaller relative gain does not count.
_GAIN = 3e-4


def local_maximum(
    value: Callable[[FloatArray], FloatArray], box: Box, starts: FloatArray
) -> tuple[FloatArray, float]:
    """Climb from every start; return the highest position reached and its value.

    One step to either side is tried for every joint. The best is taken; if none is better the step is halved.

    Parameters
    ----------
    value
        Function of positions (n, K), shape (K,).
    box
        Limits of the positions.
    starts
        Positions, shape (n, S).
    """
    lower, upper = box.lower[:, None], box.upper[:, None]
    width = box.upper - box.lower
    moves = np.vstack([np.diag(width), -np.diag(width)])[np.tile(width > 0.0, 2)].T
    q = np.clip(starts, lower, upper)
    reached = value(q)
    step = np.full(q.shape[1], _FIRST_STEP)
    for _ in range(_MOST_MOVES if moves.size else 0):
        places = np.flatnonzero(step > _FIRST_STEP / 2**_HALVINGS)
        if not places.size:
            break
        tried = q[:, places, None] + step[places, None] * moves[:, None]
        tried = np.clip(tried, lower[..., None], upper[..., None])
        values = value(tried.reshape(len(q), -1)).reshape(tried.shape[1:])
        best = values.argmax(axis=1)
        rows = np.arange(len(best))
        better = values[rows, best] > reached[places]
        q[:, places[better]] = tried[:, rows[better], best[better]]
        reached[places[better]] = values[rows[better], best[better]]
        step[places[~better]] /= 2
    top = int(reached.argmax())
    return q[:, top], float(reached[top])


def highest_position(
    polynomial: TrigonometricPolynomial, motion: Motion, box: Box, starts: FloatArray
) -> FloatArray:
    """Climb from every start (n, S); return the position of the largest error reached, shape (n,).

    With velocities and accelerations held at the worst, the error is one polynomial, and along one joint a
    polynomial with few coefficients, whose largest value is found at once. So joints take turns, and after
    all of them the velocities are chosen anew.
    """
    q = np.clip(starts, box.lower[:, None], box.upper[:, None])
    values = polynomial(q)
    reached = motion.reached(values)
    climbing = np.arange(q.shape[1])
    for _ in range(_MOST_CHOICES):
        shares = motion.shares(values[:, climbing])
        real, imaginary = (part.T @ shares for part in polynomial.parts)
        ridge = _Ridge(polynomial, real + 1j * imaginary, q[:, climbing])
        for joint in map(int, np.flatnonzero(polynomial.degrees)):
            ridge.climb(joint, box)
        there = polynomial(ridge.q)
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
        self, polynomial: TrigonometricPolynomial, coefficients: NDArray[np.complex128], q: FloatArray
    ) -> None:
        self.multiples, self.revolute, self.q = polynomial.multiples, polynomial.revolute, q.copy()
        angles = self.multiples[:, self.revolute] @ q[self.revolute]
        self.harmonics = coefficients * np.exp(1j * angles)

    def climb(self, joint: int, box: Box) -> None:
        """Move every position to its best place along one joint."""
        multiples = self.multiples[:, joint]
        orders = np.unique(multiples)
        values = self._without_power(joint)
        along = np.stack([values[multiples == m].sum(axis=0) for m in orders])
        revolute, now = bool(self.revolute[joint]), self.q[joint]
        if revolute:
            along *= np.exp(-1j * np.outer(orders, now))
        places = np.linspace(box.lower[joint], box.upper[joint], _PLACES)
        best = places[_along(along, orders, places[:, None, None], revolute)[0].argmax(axis=0)]
        for _ in range(_STEPS):
            _, slope, curve = _along(along, orders, best, revolute)
            step = np.where(curve < 0.0, -slope / np.where(curve < 0.0, curve, 1.0), 0.0)
            best = np.clip(best + step, box.lower[joint], box.upper[joint])
        old, new = (_along(along, orders, x, revolute)[0] for x in (now, best))
        self.q[joint] = np.where(new > old, best, now)
        if revolute:
            phases = np.exp(1j * np.outer(orders, self.q[joint] - now))
            self.harmonics *= phases[np.searchsorted(orders, multiples)]

    def _without_power(self, joint: int) -> Array:
        """Harmonics at the positions, without the power of one joint if it is prismatic, shape (W, S)."""
        out: Array = self.harmonics
        for k in np.flatnonzero(~self.revolute):
            if k != joint:
                out = out * self.q[k] ** self.multiples[:, [k]]
        return out


def _along(
    coefficients: Array, orders: NDArray[np.int64], x: FloatArray, revolute: bool
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Values, slopes and curvatures of polynomials (D, S) in one joint at places (..., S)."""
    m = orders[:, None].astype(float)
    x = x[..., None, :]
    if revolute:
        basis = coefficients * np.exp(1j * m * x)
        three = basis, 1j * m * basis, -(m**2) * basis
    else:
        powers = [x ** np.maximum(m - less, 0.0) for less in range(3)]
        three = coefficients * powers[0], coefficients * m * powers[1], coefficients * m * (m - 1) * powers[2]
    value, slope, curve = (one.real.sum(axis=-2) for one in three)
    return value, slope, curve
