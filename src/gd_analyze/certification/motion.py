"""What rates and accelerations can make of a torque error at one position."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gd_analyze.vectors import FloatArray

# Above it the signs of the rates are not tried all: 2^9 choices for ten joints.
_MOST_SIGNED = 10
# And above this not all of -1, 0 and 1: 3280 choices for eight joints.
_MOST_THIRDS = 8

# "1", an acceleration "qdd" (joint,) or a product of rates "qd" (joint, joint): the factor of a polynomial.
RateFactor = tuple[str, tuple[int, ...]]


@dataclass(frozen=True, eq=False)
class Motion:
    """The factors r of an error sum_r F_r(q) r.

    Values of F_r(q) max|r| at some positions are given to the methods, so that rates and accelerations are
    shares of their limits, between -1 and 1.

    Parameters
    ----------
    n_joints
        n.
    factors
        Of the polynomials, in their order.
    """

    n_joints: int
    factors: tuple[RateFactor, ...]

    @cached_property
    def _pushed(self) -> list[int]:
        return [p for p, (kind, _) in enumerate(self.factors) if kind == "qdd"]

    @cached_property
    def _still(self) -> list[int]:
        return [p for p, (kind, _) in enumerate(self.factors) if kind == "1"]

    @cached_property
    def _squares(self) -> list[int]:
        return [p for p, (kind, joints) in enumerate(self.factors) if kind == "qd" and joints[0] == joints[1]]

    @cached_property
    def _pairs(self) -> list[int]:
        return [p for p, (kind, joints) in enumerate(self.factors) if kind == "qd" and joints[0] != joints[1]]

    @cached_property
    def _signs(self) -> FloatArray:
        """Every choice of signs of the rates, up to the sign of all, shape (choices, n)."""
        paired = sorted({j for p in self._pairs for j in self.factors[p][1]})[1:]
        free = paired if len(paired) < _MOST_SIGNED else []
        out = np.ones((2 ** len(free), self.n_joints))
        for row, choice in enumerate(itertools.product((1.0, -1.0), repeat=len(free))):
            out[row, free] = choice
        return out

    @cached_property
    def _pair_signs(self) -> FloatArray:
        """Sign of every product of two rates in every choice, shape (choices, pairs)."""
        a, b = np.array([self.factors[p][1] for p in self._pairs], dtype=int).reshape(-1, 2).T
        return np.asarray(self._signs[:, a] * self._signs[:, b])

    @property
    def _all_tried(self) -> bool:
        """Whether the choices are complete."""
        return len(self._signs) == 2 ** max(0, len({j for p in self._pairs for j in self.factors[p][1]}) - 1)

    def quick_bound(self, values: FloatArray) -> FloatArray:
        """Upper bound of the error's magnitude over all rates and accelerations, shape (K,).

        Every acceleration can have the sign that is worst; the products of two rates share signs, of which
        all choices are tried; a square counts where it adds to the error, for the rate may also be 0.

        Parameters
        ----------
        values
            Shape (P, K).
        """
        pushed = np.abs(values[self._pushed]).sum(axis=0)
        still, squares, pairs = (values[p] for p in (self._still, self._squares, self._pairs))
        if not self._all_tried:
            return np.asarray(pushed + sum(np.abs(part).sum(axis=0) for part in (still, squares, pairs)))
        moved = self._pair_signs @ pairs
        up = still.sum(axis=0) + np.maximum(squares, 0.0).sum(axis=0) + moved.max(axis=0)
        down = still.sum(axis=0) + np.minimum(squares, 0.0).sum(axis=0) + moved.min(axis=0)
        return np.asarray(pushed + np.maximum(up, -down))

    def bound(self, values: FloatArray) -> FloatArray:
        """Bound as `quick_bound` does, but let a square that takes from the error count.

        From t^2 >= 2 |t| - 1 where it takes and t^2 <= |t| where it adds the error is at most a function that
        is linear in every single |rate|, and largest where all rates are -1, 0 or 1.
        """
        quick = self.quick_bound(values)
        if not len(self._thirds):
            return quick
        pushed = np.abs(values[self._pushed]).sum(axis=0)
        still, squares, pairs = (values[p] for p in (self._still, self._squares, self._pairs))
        sides = []
        for sign in (1.0, -1.0):
            taking = np.minimum(sign * squares, 0.0)
            linear = np.vstack([sign * squares + taking, sign * pairs])
            sides.append(sign * still.sum(axis=0) - taking.sum(axis=0) + (self._thirds @ linear).max(axis=0))
        return np.asarray(np.minimum(quick, pushed + np.maximum(*sides)))

    @cached_property
    def _thirds(self) -> FloatArray:
        """|rate| of every square and products of rates of every pair, all rates -1, 0 or 1; none for many.

        Shape (choices, squares + pairs); of two choices with opposite signs one.
        """
        joints = sorted({j for p in (*self._squares, *self._pairs) for j in self.factors[p][1]})
        if len(joints) > _MOST_THIRDS or not self._squares:
            return np.empty((0, len(self._squares) + len(self._pairs)))
        choices = np.zeros(((3 ** len(joints) + 1) // 2, self.n_joints))
        for row, choice in zip(
            choices, itertools.product((1.0, 0.0, -1.0), repeat=len(joints)), strict=False
        ):
            row[joints] = choice
        squares, pairs = (
            np.array([self.factors[p][1] for p in group], dtype=int).reshape(-1, 2).T
            for group in (self._squares, self._pairs)
        )
        return np.hstack([np.abs(choices[:, squares[0]]), choices[:, pairs[0]] * choices[:, pairs[1]]])

    def reached(self, values: FloatArray) -> FloatArray:
        """Error's magnitude that rates at their limits, or none, reach at every position, shape (K,)."""
        return self._at_vertices(values).max(axis=0)

    def _at_vertices(self, values: FloatArray) -> FloatArray:
        still, squares, pairs = (values[p] for p in (self._still, self._squares, self._pairs))
        moved = still.sum(axis=0) + squares.sum(axis=0) + self._pair_signs @ pairs
        at_rest = still.sum(axis=0)[None]
        return np.abs(np.vstack([at_rest, moved])) + np.abs(values[self._pushed]).sum(axis=0)

    def worst(self, values: FloatArray) -> tuple[float, FloatArray, FloatArray]:
        """Search the rates and accelerations of one position's largest error.

        From the best vertex on, one rate after the other goes where the error, a quadratic function of it,
        is largest.

        Parameters
        ----------
        values
            Shape (P,).

        Returns
        -------
        tuple
            The error's magnitude, and rates and accelerations between -1 and 1, shape (n,).
        """
        n = self.n_joints
        place = int(self._at_vertices(values[:, None])[:, 0].argmax())
        rates = self._signs[place - 1].copy() if place else np.zeros(n)
        constant = float(values[self._still].sum())
        form = np.zeros((n, n))
        for p in (*self._squares, *self._pairs):
            a, b = self.factors[p][1]
            form[a, b] += values[p] / 2
            form[b, a] += values[p] / 2
        sign = 1.0 if constant + rates @ form @ rates >= 0.0 else -1.0
        for joint in list(range(n)) * 3:
            curve, slope = sign * form[joint, joint], 2 * sign * (form[joint] @ rates)
            slope -= 2 * curve * rates[joint]
            choices = [-1.0, 1.0] + ([float(np.clip(-slope / (2 * curve), -1.0, 1.0))] if curve < 0.0 else [])
            rates[joint] = max(choices, key=lambda t: curve * t * t + slope * t)
        moving = constant + float(rates @ form @ rates)
        pushes = np.zeros(n)
        for p in self._pushed:
            pushes[self.factors[p][1][0]] = np.copysign(1.0, values[p] * moving)
        return abs(moving) + float(np.abs(values[self._pushed]).sum()), rates, pushes
