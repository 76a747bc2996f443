"""Largest torque error over velocities and accelerations at one position."""

from __future__ import annotations

import itertools
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.expansion import VelocityFactor

# Most joints whose signs of velocity are all tried: 2^9 choices for ten.
_MOST_SIGNED = 10
# Most joints whose velocities -1, 0 and 1 are all tried: 3280 choices for eight.
_MOST_THIRDS = 8
# Times that every velocity moves in an ascent.
_TURNS = 3


@dataclass(frozen=True, eq=False)
class MotionFactors:
    """The factors r of an error sum_r F_r(q) r.

    Methods take values of F_r(q) max|r|; velocities and accelerations are shares of limits, -1 to 1.
    """

    n_joints: int
    factors: tuple[VelocityFactor, ...]  # one per polynomial, in their order

    @cached_property
    def _kinds(self) -> tuple[list[int], list[int], list[int], list[int]]:
        """Places of 1, of accelerations, of squares and of products of two velocities."""
        kinds = [kind if len(set(joints)) < 2 else "pair" for kind, joints in self.factors]
        still, pushed, squares, pairs = (
            [p for p, kind in enumerate(kinds) if kind == group] for group in ("1", "qdd", "qd", "pair")
        )
        return still, pushed, squares, pairs

    def _split(self, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Sum at rest, largest addition by accelerations, values of squares, values of products."""
        still, pushed, squares, pairs = (values[places] for places in self._kinds)
        return still.sum(axis=0), np.abs(pushed).sum(axis=0), squares, pairs

    def _joints(self, factors: list[int]) -> list[int]:
        return sorted({joint for p in factors for joint in self.factors[p][1]})

    def _ends(self, factors: list[int]) -> NDArray[np.int64]:
        """First and second joint of factors of velocities, shape (2, K)."""
        return np.array([self.factors[p][1] for p in factors], dtype=np.int64).reshape(-1, 2).T

    @cached_property
    def _signs(self) -> FloatArray:
        """All choices of signs of the velocities, up to a common sign, shape (choices, n)."""
        paired = self._joints(self._kinds[3])[1:]
        free = paired if len(paired) < _MOST_SIGNED else []
        out = np.ones((2 ** len(free), self.n_joints))
        out[:, free] = list(itertools.product((1.0, -1.0), repeat=len(free)))
        return out

    @cached_property
    def _pair_signs(self) -> FloatArray:
        """Sign of every product of two velocities in every choice, shape (choices, pairs)."""
        a, b = self._ends(self._kinds[3])
        return np.asarray(self._signs[:, a] * self._signs[:, b])

    def quick_bound(self, values: FloatArray) -> FloatArray:
        """Upper bound of the error over all velocities and accelerations, (K,), from values (P, K).

        Every acceleration has its worst sign. Products of two velocities share signs, all choices of which
        are tried. A square counts only if it adds to the error, as the velocity may be 0.
        """
        still, pushed, squares, pairs = self._split(values)
        if len(self._signs) < 2 ** max(0, len(self._joints(self._kinds[3])) - 1):
            return np.asarray(pushed + np.abs(still) + sum(np.abs(p).sum(axis=0) for p in (squares, pairs)))
        moved = self._pair_signs @ pairs
        up = still + np.maximum(squares, 0.0).sum(axis=0) + moved.max(axis=0)
        down = still + np.minimum(squares, 0.0).sum(axis=0) + moved.min(axis=0)
        return np.asarray(pushed + np.maximum(up, -down))

    def bound(self, values: FloatArray) -> FloatArray:
        """Upper bound not above `quick_bound`: squares that reduce the error are used as well.

        With t^2 >= 2 |t| - 1 for squares that reduce the error and t^2 <= |t| for those that increase it, the
        error is bounded by a function linear in every |velocity|, largest at velocities -1, 0 and 1.
        """
        quick = self.quick_bound(values)
        if not len(self._thirds):
            return quick
        still, pushed, squares, pairs = self._split(values)
        sides = []
        for sign in (1.0, -1.0):
            reducing = np.minimum(sign * squares, 0.0)
            linear = np.vstack([sign * squares + reducing, sign * pairs])
            sides.append(sign * still - reducing.sum(axis=0) + (self._thirds @ linear).max(axis=0))
        return np.asarray(np.minimum(quick, pushed + np.maximum(*sides)))

    @cached_property
    def _thirds(self) -> FloatArray:
        """Squares (as |velocity|) and products of velocities -1, 0, 1, shape (choices, squares + pairs).

        One of two choices with opposite signs; none for many joints.
        """
        moving = [*self._kinds[2], *self._kinds[3]]
        joints = self._joints(moving)
        if len(joints) > _MOST_THIRDS or not self._kinds[2]:
            return np.empty((0, len(moving)))
        choices = np.zeros(((3 ** len(joints) + 1) // 2, self.n_joints))
        thirds = itertools.product((1.0, 0.0, -1.0), repeat=len(joints))
        choices[:, joints] = list(itertools.islice(thirds, len(choices)))
        a, b = self._ends(moving)
        return np.where(a == b, np.abs(choices[:, a]), choices[:, a] * choices[:, b])

    def reached(self, values: FloatArray) -> FloatArray:
        """Error that velocities at their limits, or zero, reach at every position, shape (K,)."""
        return self._at_vertices(values).max(axis=0)

    def _at_vertices(self, values: FloatArray) -> FloatArray:
        still, pushed, squares, pairs = self._split(values)
        moved = still + squares.sum(axis=0) + self._pair_signs @ pairs
        return np.abs(np.vstack([still[None], moved])) + pushed

    def shares(self, values: FloatArray) -> FloatArray:
        """Factors, -1 to 1, that make the error of `reached`, shape (P, K)."""
        still, pushed, squares, pairs = self._kinds
        best = self._at_vertices(values).argmax(axis=0)
        moves = best > 0
        out = np.zeros_like(values)
        out[still] = 1.0
        out[squares] = moves
        out[pairs] = self._pair_signs[np.maximum(best - 1, 0)].T * moves
        out *= np.where((values * out).sum(axis=0) < 0.0, -1.0, 1.0)
        out[pushed] = np.where(values[pushed] < 0.0, -1.0, 1.0)
        return out

    def worst(self, values: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Search for the largest error at every position, from values (P, K).

        Returns errors (K,), velocities and accelerations (n, K). For given velocities the best accelerations
        are known. From all vertices and from rest, each velocity in turn moves to the maximum of the error,
        quadratic in it.
        """
        n, count = self.n_joints, values.shape[1]
        still, pushed, _, _ = self._split(values)
        form = np.zeros((n, n, count))
        moving = [*self._kinds[2], *self._kinds[3]]
        for p, (a, b) in zip(moving, self._ends(moving).T, strict=True):
            form[a, b] += values[p] / 2
            form[b, a] += values[p] / 2
        starts = np.vstack([np.zeros(n), self._signs])
        signs = np.array([1.0, -1.0])[:, None, None]
        velocities = np.tile(starts.T[:, None, :, None], (1, 2, 1, count))
        for joint in list(range(n)) * _TURNS:
            curve = signs * form[joint, joint]
            slope = 2 * (
                signs * np.einsum("ak,asck->sck", form[joint], velocities) - curve * velocities[joint]
            )
            with np.errstate(divide="ignore", invalid="ignore"):
                inside = np.clip(-slope / (2 * curve), -1.0, 1.0)
            velocities[joint] = np.where(curve < 0.0, inside, np.where(slope < 0.0, -1.0, 1.0))
        sums = still + np.einsum("asck,abk,bsck->sck", velocities, form, velocities)
        sizes = (signs * sums).reshape(-1, count)
        best, columns = sizes.argmax(axis=0), np.arange(count)
        pushes = np.zeros((n, count))
        for p in self._kinds[1]:
            pushes[self.factors[p][1][0]] = np.sign(values[p]) * np.where(best < len(starts), 1.0, -1.0)
        return sizes[best, columns] + pushed, velocities.reshape(n, -1, count)[:, best, columns], pushes
