r"""A torque error over many small boxes of states at once, by Taylor's theorem about their centres.

The error is e = sum_p F_p(q) u_a u_b, (a, b) = (a, b)(p), u = (1, rates, accelerations) and F_p a sum of
waves Re(C b(q)). In a box of centre x and half widths h, all variables taken together,

    |e(x + d)| <= max_s ( s e + sum_k max over |d_k| <= h_k of (s e_k d_k + s e_kk d_k^2 / 2) )
                  + sum_{k<l} |e_kl| h_k h_l + R,            s = 1, -1,

with the derivatives at the centre, which are exact. A wave's part of R, what is of third order, follows from
the sizes of its factors' orders: of exp(i m.q) they are 1, D, D^2/2 and at most D^3/6 for the rest,
D = sum_k |m_k| h_k; of a power of a sliding variable the terms of the binomial; of u_a |u_a| and h_a.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.error_field import ErrorField

# Numbers of one wave in all boxes looked at together: they fit the cache.
_AT_ONCE = 1 << 16
_EPS = float(np.finfo(float).eps)
# What all roundings of a sum amount to: some ten million, more than there are numbers in any.
_ROUNDINGS = 1e-8


@dataclass(frozen=True, eq=False)
class Bounds:
    """What is known of an error in K boxes.

    Parameters
    ----------
    bound
        Nowhere in the box is its magnitude larger, shape (K,).
    found
        Its magnitude at a state of the box where it is likely to be largest, shape (K,).
    state
        That state, variables as those of the boxes, shape (3 n, K).
    longest
        The variable whose halving promises most, shape (K,).
    """

    bound: FloatArray
    found: FloatArray
    state: FloatArray
    longest: NDArray[np.intp]

    @classmethod
    def joined(cls, parts: list[Bounds]) -> Bounds:
        """Bounds of boxes one after the other."""
        names = [entry.name for entry in fields(cls)]
        return cls(*(np.concatenate([getattr(part, name) for part in parts], axis=-1) for name in names))


class TaylorForm:
    """One joint's torque error over boxes of states.

    Variables are q, then rates, then accelerations, the latter two as shares of their limits in the field's
    box; in arrays of shape (3 n, K).
    """

    def __init__(self, field: ErrorField) -> None:
        self.field, self.n = field, field.motion.n_joints
        self._real, self._imag = field.waves.parts
        self._sizes = (self._real**2 + self._imag**2) ** 0.5
        self._sliding = [k for k, slides in enumerate(field.waves.sliding) if slides]
        turning = [k for k, slides in enumerate(field.waves.sliding) if not slides]
        self._used = [k for k, degree in enumerate(field.waves.degrees) if degree]
        self._turns = field.waves.multiples.astype(float)
        self._turns[:, self._sliding] = 0.0
        pairs = [(k, j) for k in self._used for j in self._used if k <= j and {k, j} <= {*turning}]
        self._pairs = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        self._first, self._second = self._ends()
        one = np.eye(2 * self.n + 1)
        self._firsts, self._seconds = one[self._first].T, one[self._second].T

    def _ends(self) -> NDArray[np.intp]:
        """Every factor of rates as a product of two of u, shape (2, P)."""
        places = []
        for kind, joints in self.field.motion.factors:
            offset = 1 if kind == "qd" else self.n + 1
            places.append(([0, 0] + [joint + offset for joint in joints])[-2:])
        return np.array(places, dtype=np.intp).reshape(-1, 2).T

    def __call__(self, x: FloatArray) -> FloatArray:
        """The error at states, shape (K,)."""
        u = self._with_one(x, 1.0)
        return np.asarray((self.field.waves(x[: self.n]) * u[self._first] * u[self._second]).sum(axis=0))

    def bounds(self, centre: FloatArray, half: FloatArray) -> Bounds:
        """Bound the error in boxes."""
        step = max(1, _AT_ONCE // max(1, len(self.field.waves)))
        cuts = range(step, centre.shape[1], step)
        parts = zip(np.split(centre, cuts, axis=1), np.split(half, cuts, axis=1), strict=True)
        return Bounds.joined([self._bounds(*part) for part in parts])

    def _bounds(self, centre: FloatArray, half: FloatArray) -> Bounds:
        value, slope, curves = self._derivatives(centre)
        rows = np.arange(3 * self.n)
        own, mixed = curves[rows, rows], np.abs(curves) * half[:, None] * half
        mixed[rows, rows] = 0.0
        second = mixed.sum(axis=1)
        above, whole = self._remainder(centre, half)
        # Up or down: how far every variable goes, and what is reached then.
        steps, gains = zip(*(_largest(sign * slope, sign * own, half) for sign in (1.0, -1.0)), strict=True)
        up, down = value + gains[0].sum(axis=0), gains[1].sum(axis=0) - value
        state = centre + np.where(up >= down, *steps)
        bound = np.maximum(up, down) + second.sum(axis=0) / 2 + above
        # Derivatives times half widths are no larger than the orders they belong to, of which those up to
        # the second are less than four times 1 + D^3 / 6: so are their roundings.
        bound += 4.0 * self.field.round_off + _ROUNDINGS * above
        bound = np.minimum(bound, whole) * (1.0 + 64 * _EPS) + self.field.rest + self.field.round_off
        turned = half[: self.n] * np.array(self.field.waves.degrees)[:, None]
        second[: self.n] += above * turned / np.maximum(turned.sum(axis=0), np.finfo(float).tiny)
        return Bounds(bound, np.abs(self(state)), state, second.argmax(axis=0))

    def _with_one(self, x: FloatArray, one: float) -> FloatArray:
        """u, or its half widths, shape (2 n + 1, K)."""
        return np.vstack([np.full((1, x.shape[1]), one), x[self.n :]])

    def _derivatives(self, centre: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Value, first and second derivatives at states, shapes (K,), (3 n, K) and (3 n, 3 n, K)."""
        n, count = self.n, centre.shape[1]
        u = self._with_one(centre, 1.0)
        first, second = u[self._first], u[self._second]
        factors = first * second
        slope, curves = np.zeros((3 * n + 1, count)), np.zeros((3 * n + 1, 3 * n + 1, count))
        basis = _Basis(self._turns, self._sliding, self.field.waves.multiples, centre[:n])
        values = self._summed(*basis())
        slope[n:] = self._firsts @ (values * second) + self._seconds @ (values * first)
        curves[n + self._first, n + self._second] += values
        curves[n + self._second, n + self._first] += values
        for k in self._used:
            slopes = self._summed(*basis(k))
            slope[k] = (slopes * factors).sum(axis=0)
            curves[k, n:] = self._firsts @ (slopes * second) + self._seconds @ (slopes * first)
            curves[n:, k] = curves[k, n:]
        real, imag = self._real.T @ factors, self._imag.T @ factors
        cosine, sine = basis()
        one, other = self._pairs
        by = self._turns[:, one] * self._turns[:, other]
        curves[one, other] = -by.T @ (real * cosine - imag * sine)
        for k in set(self._used) & set(self._sliding):
            for j in self._used:
                cosine, sine = basis(k, j)
                curves[min(k, j), max(k, j)] = (real * cosine - imag * sine).sum(axis=0)
        for k in self._used:
            curves[k + 1 : n, k] = curves[k, k + 1 : n]
        moving = np.delete(np.arange(3 * n + 1), n)
        return (values * factors).sum(axis=0), slope[moving], curves[np.ix_(moving, moving)]

    def _summed(self, cosine: FloatArray, sine: FloatArray) -> FloatArray:
        """Every polynomial, given the waves' basis functions, shape (P, K)."""
        return np.asarray(self._real @ cosine - self._imag @ sine)

    def _remainder(self, centre: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Largest sum of what is of third order or higher, and of all orders, shape (K,) each."""
        n = self.n
        angle = np.abs(self._turns) @ half[:n]
        orders = [np.ones_like(angle), angle, angle**2 / 2, angle**3 / 6]
        total = np.ones_like(angle)
        for k in set(self._used) & set(self._sliding):
            power = self.field.waves.multiples[:, k]
            of_power = [
                order[power] for order in _orders_of_powers(abs(centre[k]), half[k], int(power.max()))
            ]
            total *= sum(of_power)
            orders = _product(orders, of_power)
        one, two, more = (self._sizes @ order for order in orders[1:])
        u, h = np.abs(self._with_one(centre, 1.0)), self._with_one(half, 0.0)
        curved = h[self._first] * h[self._second]
        sloped = u[self._first] * h[self._second] + h[self._first] * u[self._second]
        factor = u[self._first] * u[self._second] + sloped + curved
        above = more * factor + two * (sloped + curved) + one * curved
        return above.sum(axis=0), ((self._sizes @ total) * factor).sum(axis=0)


class _Basis:
    """Basis functions of waves at positions, exp(i m.q) times powers, and their derivatives."""

    def __init__(
        self, turns: FloatArray, sliding: list[int], multiples: NDArray[np.int64], q: FloatArray
    ) -> None:
        self._turns, self._sliding, self._multiples, self._q = turns, sliding, multiples, q
        angles = turns @ q
        self._plain = np.cos(angles), np.sin(angles)

    def __call__(self, *joints: int) -> tuple[FloatArray, FloatArray]:
        """Real and imaginary part of the derivative by some joints' variables, shape (W, K) each."""
        cosine, sine = self._plain
        for k in self._sliding:
            times, power = joints.count(k), self._multiples[:, k]
            falling = np.prod([power - t for t in range(times)], axis=0)[..., None]
            lowered = falling * self._q[k] ** np.maximum(power - times, 0)[:, None]
            cosine, sine = cosine * lowered, sine * lowered
        for k in joints:
            if k not in self._sliding:
                by = self._turns[:, [k]]
                cosine, sine = -by * sine, by * cosine
        return cosine, sine


def _largest(slope: FloatArray, curve: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where slope x + curve x^2 / 2 is largest in |x| <= half, and its value there."""
    inside = (curve < 0.0) & (np.abs(slope) < -curve * half)
    step = np.where(inside, slope / np.where(inside, -curve, 1.0), np.where(slope < 0.0, -half, half))
    return step, slope * step + curve * step**2 / 2


def _orders_of_powers(size: FloatArray, half: FloatArray, most: int) -> list[FloatArray]:
    """Orders of (size + half)^p, p = 0 ... most, shape (most + 1, K) each."""
    table = np.zeros((4, most + 1, len(size)))
    for power in range(most + 1):
        for order in range(power + 1):
            table[min(order, 3), power] += math.comb(power, order) * size ** (power - order) * half**order
    return list(table)


def _product(a: list[FloatArray], b: list[FloatArray]) -> list[FloatArray]:
    """Orders of a product."""
    out = [np.zeros_like(a[0]) for _ in range(4)]
    for i, one in enumerate(a):
        for j, other in enumerate(b):
            out[min(i + j, 3)] += one * other
    return out
