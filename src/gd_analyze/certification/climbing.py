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
    """Climb from every start (n, S) of a function of positions; return the highest position and its value.

    One step to either side is tried for every joint. The best is taken; if none is better the step is halved.
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
        higher = _higher(polynomial, real + 1j * imaginary, q[:, climbing], box)
        there = polynomial(higher)
        now = motion.reached(there)
        better = now > (1.0 + _GAIN) * reached[climbing]
        climbing = climbing[better]
        if not climbing.size:
            break
        q[:, climbing], values[:, climbing] = higher[:, better], there[:, better]
        reached[climbing] = now[better]
    return q[:, int(reached.argmax())]


def _higher(
    polynomial: TrigonometricPolynomial, coefficients: NDArray[np.complex128], start: FloatArray, box: Box
) -> FloatArray:
    """Move S positions (n, S), each with coefficients of its own (W, S), joint after joint."""
    q, every, revolute = start.copy(), polynomial.multiples, polynomial.revolute
    harmonics = coefficients * np.exp(1j * (every[:, revolute] @ q[revolute]))
    for joint in map(int, np.flatnonzero(polynomial.degrees)):
        multiples, now, turns = every[:, joint], q[joint].copy(), bool(revolute[joint])
        values: Array = harmonics
        for k in np.flatnonzero(~revolute):
            if k != joint:
                values = values * q[k] ** every[:, [k]]
        orders = np.unique(multiples)
        along = np.stack([values[multiples == m].sum(axis=0) for m in orders])
        if turns:
            along *= np.exp(-1j * np.outer(orders, now))
        places = np.linspace(box.lower[joint], box.upper[joint], _PLACES)
        best = places[_along(along, orders, places[:, None, None], turns)[0].argmax(axis=0)]
        for _ in range(_STEPS):
            _, slope, curve = _along(along, orders, best, turns)
            step = np.where(curve < 0.0, -slope / np.where(curve < 0.0, curve, 1.0), 0.0)
            best = np.clip(best + step, box.lower[joint], box.upper[joint])
        old, new = (_along(along, orders, x, turns)[0] for x in (now, best))
        q[joint] = np.where(new > old, best, now)
        if turns:
            phases = np.exp(1j * np.outer(orders, q[joint] - now))
            harmonics *= phases[np.searchsorted(orders, multiples)]
    return q


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
