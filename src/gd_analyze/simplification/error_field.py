"""The torque error of a model: polynomials in the positions times accelerations and products of rates."""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import Monomial, TorqueTerm
from gd_analyze.simplification.box import Box
from gd_analyze.simplification.waves import Expansion, Polynomial, Waves
from gd_analyze.vectors import FloatArray

# Above it the signs of the rates are not tried all: 2^9 choices for ten joints.
_MOST_SIGNED = 10

# "1", an acceleration "qdd" (joint,) or a product of rates "qd" (joint, joint): the factor of a polynomial.
RateFactor = tuple[str, tuple[int, ...]]
ErrorRow = dict[RateFactor, dict[Monomial, float]]


def error_rows(
    basis: Basis, exact: Mapping[TorqueTerm, float], simplified: Mapping[TorqueTerm, float]
) -> list[ErrorRow]:
    """Error of every joint's torque by rates and accelerations of the joints themselves."""
    inboard = {joint: run.joints[: k + 1] for run in basis.runs for k, joint in enumerate(run.joints)}
    rows: list[dict[RateFactor, dict[Monomial, float]]] = [
        defaultdict(lambda: defaultdict(float)) for _ in range(basis.n_joints)
    ]
    for term in {**exact, **simplified}:
        weight = simplified.get(term, 0.0) - exact.get(term, 0.0)
        if weight == 0.0:
            continue
        factors: dict[RateFactor, float] = defaultdict(float)
        if not term.rates:
            factors["1", ()] = 1.0
        elif term.rates[0].order == 2:
            for a in inboard[term.rates[0].joint]:
                factors["qdd", (a,)] += 1.0
        else:
            for a in inboard[term.rates[0].joint]:
                for b in inboard[term.rates[1].joint]:
                    factors["qd", (min(a, b), max(a, b))] += 1.0
        for joint in inboard[term.row]:
            for factor, times in factors.items():
                rows[joint][factor][term.monomial] += times * weight
    return [
        {
            factor: kept
            for factor, polynomial in row.items()
            if (kept := {m: w for m, w in polynomial.items() if w != 0.0})
        }
        for row in rows
    ]


@dataclass(frozen=True, eq=False)
class Motion:
    """What the rates and accelerations of a box can make of the polynomials' values at one position.

    The values are those of F_r(q) max|r|; the rates and accelerations then lie between -1 and 1.
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

    def bound(self, values: FloatArray) -> FloatArray:
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


@dataclass(frozen=True, eq=False)
class ErrorField:
    """One joint's torque error over a box.

    Parameters
    ----------
    waves
        F_r(q) max|r| of every factor r.
    motion
        The factors.
    round_off
        What evaluating it, at any position of the box, can be off by.
    """

    waves: Waves
    motion: Motion
    round_off: float

    @classmethod
    def of(cls, row: ErrorRow, box: Box, expansion: Expansion) -> ErrorField:
        """Prepare a joint's row of the error."""
        largest = np.array([_largest(factor, box) for factor in row])
        waves = Waves.of(list(row.values()), expansion).times(largest)
        reach = sum(
            size * magnitude(polynomial, box.farthest)
            for size, polynomial in zip(largest, row.values(), strict=True)
        )
        return cls(waves, Motion(box.n_joints, tuple(row)), round_off_of(reach, waves, box))


def round_off_of(reach: float, waves: Waves, box: Box) -> float:
    """What the value of a sum of waves can be off by.

    Every value is a sum of products in which no more than `count` roundings follow one another, each of them
    eps/2 of terms that add up to `reach`: the weights' subtraction and expansion, one contraction per joint,
    the sum over the factors. An angle m.q, and the place of a node, is off by some eps of the farthest one.
    """
    count = waves.coefficients.size + 32 * (1 + len(waves.sliding))
    angle = 1.0 + float((np.array(waves.degrees) * box.farthest).sum())
    return count * angle * float(np.finfo(float).eps) * reach


def _largest(factor: RateFactor, box: Box) -> float:
    kind, joints = factor
    limit = box.acceleration if kind == "qdd" else box.rate
    return float(np.prod([limit[joint] for joint in joints]))


def magnitude(polynomial: Polynomial, farthest: FloatArray) -> float:
    """Bound of a polynomial's magnitude over the box: sines and cosines have 1."""
    total = 0.0
    for monomial, weight in polynomial.items():
        size = abs(weight)
        for kind, multiples in monomial:
            if kind == "power":
                size *= float(np.dot(multiples, farthest))
        total += size
    return total
