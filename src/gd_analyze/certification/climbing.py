"""Climbing to a local maximum within a box of positions, from several places at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.motion import Motion
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial

# Of the box's width: the first step, and how often it is halved.
_FIRST_STEP, _HALVINGS = 1 / 32, 9
# Moves at most, lest a long ridge be followed for ever.
_MOST_MOVES = 40


def local_maximum(
    value: Callable[[FloatArray], FloatArray], box: Box, starts: FloatArray
) -> tuple[FloatArray, float]:
    """Climb from every start, and return the highest place reached and its value.

    Every joint is tried one step to either side; the best of these is taken, and the step halved where none
    is better.

    Parameters
    ----------
    value
        Of positions (n, K), shape (K,).
    box
        Its limits are kept.
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


# Times that velocities are chosen at most, lest a long ridge be followed for ever.
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
        self.revolute = ~np.array(waves.prismatic)
        self.turned = coefficients * np.exp(1j * (waves.multiples[:, self.revolute] @ q[self.revolute]))

    def climb(self, joint: int, box: Box) -> None:
        """Move every position to its best place along one joint."""
        multiples = self.waves.multiples[:, joint]
        orders = np.unique(multiples)
        waves = self._without(joint)
        along = np.stack([waves[multiples == m].sum(axis=0) for m in orders])
        turns, now = bool(self.revolute[joint]), self.q[joint]
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
        for k in np.flatnonzero(~self.revolute):
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
