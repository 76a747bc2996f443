"""A torque error over many small boxes of states, by Taylor's theorem about their centres.

The error is e = sum_p F_p(q) u_a u_b with u = (1, velocities, accelerations); docs/certificate.md bounds it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.error_field import ErrorField
from gd_analyze.certification.tube import Tube

# Numbers of one harmonic in all boxes treated together, which fit the cache.
_NUMBERS_AT_ONCE = 1 << 16
_SUM_ROUNDING = 1e-8  # relative rounding of a sum of some ten million numbers, more than any has
# Boxes whose bound exceeds the worst error found by less than this factor need no closer look.
_CLOSE_BOUND = 1.01
_TIGHTENING_SHARE = 0.05  # share of the effort spent on a bound that is within the limit already
_HALVED_AT_ONCE = 256  # boxes halved at a time

_EPS = float(np.finfo(float).eps)


class Bounded(NamedTuple):
    """One joint: bounds of pieces of its states (pieces,), largest error found, and its state (n,)."""

    bounds: FloatArray
    found: float
    q: FloatArray
    qd: FloatArray
    qdd: FloatArray


def bound_along(
    field: ErrorField,
    tube: Tube,
    effort: int,
    counts: FloatArray | None = None,
    limit: float | None = None,
    *,
    tighten: bool = True,
) -> Bounded:
    """Bound one joint's error in every piece of a tube by at most `effort` boxes, or one for each piece.

    Boxes are halved where the error may be largest, until the bound is close to an error found. With a
    `limit`, boxes whose bound exceeds it are halved until it is known whether the error does. To `tighten`,
    the others are then halved with a share of the effort. `counts` (pieces,) are weights of errors; errors
    found include them.
    """
    counts = np.ones(len(tube)) if counts is None else counts
    limits = np.stack([np.ones(tube.n_joints), field.box.velocity, field.box.acceleration])
    # With a limit of zero velocities are zero, for any share.
    limits = np.where(limits > 0.0, limits, 1.0)
    form = TaylorForm(field)
    lower, upper = ((x / limits).reshape(len(tube), -1).T for x in (tube.lower, tube.upper))
    # The field's round-off covers that of centres and halves, as it covers that of a grid's nodes.
    boxes = form.boxes((lower + upper) / 2, (upper - lower) / 2, np.arange(len(tube)))
    largest, state, piece = boxes.worst(counts)
    spent = len(tube)
    while True:
        # Rounding and cancelled harmonics are in every bound, however small the box.
        counting, unresolved = counts[boxes.pieces], field.omitted + 8 * field.round_off
        candidates = np.empty(0, dtype=np.intp)
        if limit is not None:
            if largest > limit:
                break
            candidates = np.flatnonzero(counting * boxes.bounds > limit)
        may_tighten = tighten and spent - len(tube) < _TIGHTENING_SHARE * effort
        if not candidates.size and (limit is None or may_tighten):
            candidates = np.flatnonzero(
                counting * boxes.bounds > _CLOSE_BOUND * largest + counting * unresolved
            )
        if not candidates.size or spent + 2 > effort:
            break
        order = np.argsort(-(counting * boxes.bounds)[candidates], kind="stable")
        candidates = candidates[order[: min(_HALVED_AT_ONCE, (effort - spent) // 2)]]
        halves = form.halved(boxes.at(candidates))
        largest, state, piece = max((largest, state, piece), halves.worst(counts), key=lambda worst: worst[0])
        boxes = Boxes.joined([boxes.at(np.delete(np.arange(len(boxes.bounds)), candidates)), halves])
        spent += 2 * candidates.size
    bounds = np.zeros(len(tube))
    np.maximum.at(bounds, boxes.pieces, boxes.bounds)
    q, qd, qdd = np.clip(state.reshape(3, -1) * limits, tube.lower[piece], tube.upper[piece])
    return Bounded(bounds, largest, q, qd, qdd)


class Boxes(NamedTuple):
    """K boxes and their errors; variables are those of `TaylorForm`."""

    centre: FloatArray  # (3 n, K)
    half: FloatArray  # half widths, (3 n, K)
    pieces: NDArray[np.intp]  # pieces of the tube that they belong to, (K,)
    bounds: FloatArray  # bounds on the error in each box, (K,)
    longest: NDArray[np.intp]  # variable whose halving promises most, (K,)
    found: FloatArray  # error at a state of the box where it is probably largest, (K,)
    states: FloatArray  # that state, (3 n, K)

    def worst(self, counts: FloatArray) -> tuple[float, FloatArray, int]:
        """Largest weighted error found, its state and its piece."""
        counting = self.found * counts[self.pieces]
        top = int(counting.argmax())
        return float(counting[top]), self.states[:, top], int(self.pieces[top])

    def at(self, chosen: NDArray[np.intp]) -> Boxes:
        """Some of the boxes."""
        return Boxes._make(x[..., chosen] for x in self)

    @classmethod
    def joined(cls, parts: list[Boxes]) -> Boxes:
        """Boxes of all parts."""
        return cls._make(np.concatenate(column, axis=-1) for column in zip(*parts, strict=True))


class TaylorForm:
    """One joint's torque error over boxes of states.

    Variables are q, then velocities, then accelerations, the latter two as shares of their limits in the
    field's box; arrays of them have shape (3 n, K).
    """

    def __init__(self, field: ErrorField) -> None:
        self.field, self.n = field, field.box.n_joints
        polynomial = field.polynomial
        self._real, self._imag = polynomial.parts
        self._sizes = (self._real**2 + self._imag**2) ** 0.5
        self._used = [k for k, degree in enumerate(polynomial.degrees) if degree]
        self._powers = [k for k in self._used if polynomial.prismatic[k]]
        self._angles = polynomial.multiples * polynomial.revolute.astype(float)
        pairs = [(k, j) for k in self._used for j in self._used if k <= j and not {k, j} & {*self._powers}]
        self._pairs = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        # Every velocity factor is a product of two of u.
        offset = {"1": 0, "qd": 1, "qdd": self.n + 1}
        factors = field.motion.factors
        ends = [([0, 0] + [joint + offset[kind] for joint in joints])[-2:] for kind, joints in factors]
        self._first, self._second = np.array(ends, dtype=np.intp).reshape(-1, 2).T
        unit = np.eye(2 * self.n + 1)
        self._firsts, self._seconds = unit[self._first].T, unit[self._second].T

    def __call__(self, x: FloatArray) -> FloatArray:
        """The error at states, shape (K,)."""
        u = self._with_one(x, 1.0)
        values = self.field.polynomial(x[: self.n])
        return np.asarray((values * u[self._first] * u[self._second]).sum(axis=0))

    def boxes(self, centre: FloatArray, half: FloatArray, pieces: NDArray[np.intp]) -> Boxes:
        """Bound the error in boxes."""
        step = max(1, _NUMBERS_AT_ONCE // max(1, len(self.field.polynomial)))
        cuts = range(step, centre.shape[1], step)
        parts = zip(*(np.split(x, cuts, axis=-1) for x in (centre, half, pieces)), strict=True)
        return Boxes.joined([self._boxes(*part) for part in parts])

    def halved(self, boxes: Boxes) -> Boxes:
        """Both halves of every box; no half's bound is larger than the whole's."""
        chosen = boxes.longest, np.arange(len(boxes.bounds))
        half, step = boxes.half.copy(), np.zeros_like(boxes.half)
        half[chosen] /= 2
        step[chosen] = half[chosen]
        centres = np.hstack([boxes.centre - step, boxes.centre + step])
        out = self.boxes(centres, np.hstack([half, half]), np.tile(boxes.pieces, 2))
        return out._replace(bounds=np.minimum(out.bounds, np.tile(boxes.bounds, 2)))

    def _boxes(self, centre: FloatArray, half: FloatArray, pieces: NDArray[np.intp]) -> Boxes:
        value, slope, curves = self._derivatives(centre)
        rows = np.arange(3 * self.n)
        diagonal, mixed = curves[rows, rows], np.abs(curves) * half[:, None] * half
        mixed[rows, rows] = 0.0
        second = mixed.sum(axis=1)
        above, whole = self._remainder(centre, half)
        # Upwards or downwards: the step of every variable, and the value there.
        steps, gains = zip(
            *(_largest(sign * slope, sign * diagonal, half) for sign in (1.0, -1.0)), strict=True
        )
        up, down = value + gains[0].sum(axis=0), gains[1].sum(axis=0) - value
        state = centre + np.where(up >= down, *steps)
        bound = np.maximum(up, down) + second.sum(axis=0) / 2 + above
        # Derivatives times half widths are no larger than the orders they belong to, and those up to the
        # second are less than four times 1 + D^3 / 6: so are their roundings.
        bound += 4.0 * self.field.round_off + _SUM_ROUNDING * above
        bound = np.minimum(bound, whole) * (1.0 + 64 * _EPS) + self.field.omitted + self.field.round_off
        turned = half[: self.n] * np.array(self.field.polynomial.degrees)[:, None]
        second[: self.n] += above * turned / np.maximum(turned.sum(axis=0), np.finfo(float).tiny)
        return Boxes(centre, half, pieces, bound, second.argmax(axis=0), np.abs(self(state)), state)

    def _with_one(self, x: FloatArray, first: float) -> FloatArray:
        """u, or its half widths, shape (2 n + 1, K)."""
        return np.vstack([np.full((1, x.shape[1]), first), x[self.n :]])

    def _derivatives(self, centre: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Value, first and second derivatives at states, shapes (K,), (3 n, K) and (3 n, 3 n, K)."""
        n, count = self.n, centre.shape[1]
        u = self._with_one(centre, 1.0)
        first, second = u[self._first], u[self._second]
        factors = first * second
        slope, curves = np.zeros((3 * n + 1, count)), np.zeros((3 * n + 1, 3 * n + 1, count))
        q = centre[:n]
        angles = self._angles @ q
        plain = np.cos(angles), np.sin(angles)
        cosine, sine = self._basis(plain, q)
        values = self._real @ cosine - self._imag @ sine
        slope[n:] = self._firsts @ (values * second) + self._seconds @ (values * first)
        curves[n + self._first, n + self._second] += values
        curves[n + self._second, n + self._first] += values
        real, imag = self._real.T @ factors, self._imag.T @ factors
        row, column = self._pairs
        by = self._angles[:, row] * self._angles[:, column]
        curves[row, column] = -by.T @ (real * cosine - imag * sine)
        for k in self._used:
            cosine, sine = self._basis(plain, q, k)
            slopes = self._real @ cosine - self._imag @ sine
            slope[k] = (slopes * factors).sum(axis=0)
            curves[k, n:] = self._firsts @ (slopes * second) + self._seconds @ (slopes * first)
            curves[n:, k] = curves[k, n:]
        for k in self._powers:
            for j in self._used:
                cosine, sine = self._basis(plain, q, k, j)
                curves[min(k, j), max(k, j)] = (real * cosine - imag * sine).sum(axis=0)
        for k in self._used:
            curves[k + 1 : n, k] = curves[k, k + 1 : n]
        moving = np.delete(np.arange(3 * n + 1), n)
        return (values * factors).sum(axis=0), slope[moving], curves[np.ix_(moving, moving)]

    def _basis(
        self, plain: tuple[FloatArray, FloatArray], q: FloatArray, *by: int
    ) -> tuple[FloatArray, FloatArray]:
        """Parts of exp(i m.q), given as `plain`, times powers, differentiated by joints, shape (W, K)."""
        cosine, sine = plain
        for k in np.flatnonzero(self.field.polynomial.prismatic).tolist():
            times, power = by.count(k), self.field.polynomial.multiples[:, k]
            falling = np.prod([power - t for t in range(times)], axis=0)[..., None]
            lowered = falling * q[k] ** np.maximum(power - times, 0)[:, None]
            cosine, sine = cosine * lowered, sine * lowered
        for k in by:
            if not self.field.polynomial.prismatic[k]:
                factor = self._angles[:, [k]]
                cosine, sine = -factor * sine, factor * cosine
        return cosine, sine

    def _remainder(self, centre: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Bound on the terms of third and higher order, and on those of all orders, shape (K,) each.

        Orders of exp(i m.q) are 1, D, D^2/2 and at most D^3/6 for the rest, with D = sum_k |m_k| h_k; those
        of a power are binomial terms; those of u_a are |u_a| and h_a.
        """
        n = self.n
        angle = np.abs(self._angles) @ half[:n]
        orders = [np.ones_like(angle), angle, angle**2 / 2, angle**3 / 6]
        total = np.ones_like(angle)
        for k in self._powers:
            power = self.field.polynomial.multiples[:, k]
            of_power = _orders_of_powers(abs(centre[k]), half[k], int(power.max()))[:, power]
            total *= sum(of_power)
            product = [np.zeros_like(angle) for _ in range(4)]
            for i, angle_order in enumerate(orders):
                for j, power_order in enumerate(of_power):
                    product[min(i + j, 3)] += angle_order * power_order
            orders = product
        first_order, second_order, higher_orders = (self._sizes @ order for order in orders[1:])
        u, h = np.abs(self._with_one(centre, 1.0)), self._with_one(half, 0.0)
        curved = h[self._first] * h[self._second]
        sloped = u[self._first] * h[self._second] + h[self._first] * u[self._second]
        factor = u[self._first] * u[self._second] + sloped + curved
        above = higher_orders * factor + second_order * (sloped + curved) + first_order * curved
        return above.sum(axis=0), ((self._sizes @ total) * factor).sum(axis=0)


def _largest(slope: FloatArray, curve: FloatArray, half: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Maximum of slope x + curve x^2 / 2 in |x| <= half: position and value."""
    inside = (curve < 0.0) & (np.abs(slope) < -curve * half)
    step = np.where(inside, slope / np.where(inside, -curve, 1.0), np.where(slope < 0.0, -half, half))
    return step, slope * step + curve * step**2 / 2


def _orders_of_powers(size: FloatArray, half: FloatArray, most: int) -> FloatArray:
    """Orders 0, 1, 2 and the rest of (size + half)^p, p = 0 .. most, shape (4, most + 1, K)."""
    table = np.zeros((4, most + 1, len(size)))
    for power in range(most + 1):
        for order in range(power + 1):
            table[min(order, 3), power] += math.comb(power, order) * size ** (power - order) * half**order
    return table
