r"""A torque error over many small boxes of states at once, by Taylor's theorem about their centres.

The error is e = sum_p F_p(q) u_a u_b, (a, b) = (a, b)(p), u = (1, velocities, accelerations) and F_p a sum of
waves Re(C b(q)). In a box of centre x and half widths h, all variables taken together,

    |e(x + d)| <= max_s ( s e + sum_k max over |d_k| <= h_k of (s e_k d_k + s e_kk d_k^2 / 2) )
                  + sum_{k<l} |e_kl| h_k h_l + R,            s = 1, -1,

with the derivatives at the centre, which are exact. A wave's part of R, what is of third order, follows from
the sizes of its factors' orders: of exp(i m.q) they are 1, D, D^2/2 and at most D^3/6 for the rest,
D = sum_k |m_k| h_k; of a power of a prismatic variable the terms of the binomial; of u_a |u_a| and h_a.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.tube import Tube

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

    Variables are q, then velocities, then accelerations, the latter two as shares of their limits in the
    field's box; in arrays of shape (3 n, K).
    """

    def __init__(self, field: ErrorField) -> None:
        self.field, self.n = field, field.motion.n_joints
        self._real, self._imag = field.waves.parts
        self._sizes = (self._real**2 + self._imag**2) ** 0.5
        self._sliding = [k for k, slides in enumerate(field.waves.prismatic) if slides]
        revolute = [k for k, slides in enumerate(field.waves.prismatic) if not slides]
        self._used = [k for k, degree in enumerate(field.waves.degrees) if degree]
        self._turns = field.waves.multiples.astype(float)
        self._turns[:, self._sliding] = 0.0
        pairs = [(k, j) for k in self._used for j in self._used if k <= j and {k, j} <= {*revolute}]
        self._pairs = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        self._first, self._second = self._ends()
        one = np.eye(2 * self.n + 1)
        self._firsts, self._seconds = one[self._first].T, one[self._second].T

    def _ends(self) -> NDArray[np.intp]:
        """Every factor of velocities as a product of two of u, shape (2, P)."""
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
        self, turns: FloatArray, prismatic: list[int], multiples: NDArray[np.int64], q: FloatArray
    ) -> None:
        self._turns, self._sliding, self._multiples, self._q = turns, prismatic, multiples, q
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


# Where no state can be worse than the worst found by more than this, there is nothing left to look for.
_CLOSE = 1.01
# Boxes halved at a time.
_AT_A_TIME = 256


class Bounded(NamedTuple):
    """One joint: bounds of pieces of its states (pieces,), largest error found, and its state (n,)."""

    bounds: FloatArray
    found: float
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray


def bound_along(field: ErrorField, tube: Tube, effort: int) -> Bounded:
    """Bound one joint's error in every piece of a tube.

    Parameters
    ----------
    field
        The error, over the box that encloses the tube.
    tube
        The states.
    effort
        Boxes that may be looked at. Every piece is looked at once, however many there are.
    """
    box = tube.enclosing
    limits = np.stack([np.ones(tube.n_joints), box.velocity, box.acceleration])
    # Where a limit is zero so are all velocities, and any share of it will do.
    limits = np.where(limits > 0.0, limits, 1.0)
    form = TaylorForm(field)
    lower, upper = ((x / limits).reshape(len(tube), -1).T for x in (tube.lower, tube.upper))
    # Rounding of middles and halves is that of the places of nodes, which the field's round-off has in it.
    boxes = _Boxes.of(form, (lower + upper) / 2, (upper - lower) / 2, np.arange(len(tube)))
    worst = boxes.worst
    spent = len(tube)
    while True:
        # What rounding and what cancels amount to is in every bound, however small the box.
        near = np.flatnonzero(boxes.bounds > _CLOSE * worst.found + field.rest + 8 * field.round_off)
        if not near.size or spent + 2 > effort:
            break
        near = near[np.argsort(-boxes.bounds[near], kind="stable")[: min(_AT_A_TIME, (effort - spent) // 2)]]
        halves = boxes.at(near).halved(form)
        worst = max(worst, halves.worst, key=lambda found: found.found)
        boxes = boxes.at(np.delete(np.arange(len(boxes.bounds)), near)).joined_by(halves)
        spent += 2 * near.size
    bounds = np.zeros(len(tube))
    np.maximum.at(bounds, boxes.pieces, boxes.bounds)
    state = worst.state.reshape(3, -1) * limits
    q, qd, qdd = np.clip(state, tube.lower[worst.piece], tube.upper[worst.piece])
    return Bounded(bounds, worst.found, q, qd, qdd)


class _Worst(NamedTuple):
    """Largest error found, where, and in which piece."""

    found: float
    state: FloatArray
    piece: int


@dataclass(frozen=True, eq=False)
class _Boxes:
    """Boxes, the pieces of the tube they are of, and what is known of the error in each."""

    centre: FloatArray
    half: FloatArray
    pieces: NDArray[np.intp]
    bounds: FloatArray
    longest: NDArray[np.intp]
    found: FloatArray
    states: FloatArray

    @classmethod
    def of(cls, form: TaylorForm, centre: FloatArray, half: FloatArray, pieces: NDArray[np.intp]) -> _Boxes:
        known = form.bounds(centre, half)
        return cls(centre, half, pieces, known.bound, known.longest, known.found, known.state)

    @property
    def worst(self) -> _Worst:
        top = int(self.found.argmax())
        return _Worst(float(self.found[top]), self.states[:, top], int(self.pieces[top]))

    def at(self, chosen: NDArray[np.intp]) -> _Boxes:
        return _Boxes(*(x[..., chosen] for x in self._arrays))

    def joined_by(self, other: _Boxes) -> _Boxes:
        pairs = zip(self._arrays, other._arrays, strict=True)
        return _Boxes(*(np.concatenate(pair, axis=-1) for pair in pairs))

    def halved(self, form: TaylorForm) -> _Boxes:
        """Both halves of every box; no half's bound is larger than the whole's."""
        numbers = np.arange(len(self.bounds))
        half = self.half.copy()
        half[self.longest, numbers] /= 2
        step = np.zeros_like(half)
        step[self.longest, numbers] = half[self.longest, numbers]
        centres = np.hstack([self.centre - step, self.centre + step])
        out = _Boxes.of(form, centres, np.hstack([half, half]), np.tile(self.pieces, 2))
        return replace(out, bounds=np.minimum(out.bounds, np.tile(self.bounds, 2)))

    @property
    def _arrays(self) -> list[Any]:
        return [getattr(self, field.name) for field in fields(self)]
