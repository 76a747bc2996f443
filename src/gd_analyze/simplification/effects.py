"""Torque of very many terms at states: each acts on one or two joints, and only these rows are stored."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property, reduce

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import Factor, Monomial, Torques, Velocity
from gd_analyze.motions.states import States
from gd_analyze.simplification.torque_program import TorqueVariables

Mask = NDArray[np.bool_]
# Number of the candidate that each term belongs to.
IntegerArray = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Effects:
    """Torque of K terms at N states, by the joints on which each acts.

    Parameters
    ----------
    count, n_joints
        Number of terms K, and of joints n.
    term, joint
        Term and joint of each row, shape (E,); terms ascend.
    torque
        Torque, N m (N), shape (E, N).
    """

    count: int
    n_joints: int
    term: NDArray[np.intp]
    joint: NDArray[np.intp]
    torque: FloatArray

    @cached_property
    def first(self) -> NDArray[np.intp]:
        """First row of every term, and the number of rows, shape (K + 1,)."""
        return np.searchsorted(self.term, np.arange(self.count + 1))

    def rows_of(self, term: int) -> slice:
        """Rows of one term."""
        return slice(int(self.first[term]), int(self.first[term + 1]))

    def largest(self, values: FloatArray) -> FloatArray:
        """Largest of values of the rows, shape (E,), for every term, shape (K,); each term has a row."""
        return np.maximum.reduceat(values, self.first[:-1]) if self.count else np.empty(0)

    def total(self, terms: Mask) -> FloatArray:
        """Torque of some terms together, N m, shape (n, N)."""
        rows, out = terms[self.term], np.zeros((self.n_joints, self.torque.shape[1]))
        for joint in range(self.n_joints):
            out[joint] = self.torque[rows & (self.joint == joint)].sum(axis=0)
        return out

    @cached_property
    def by_joint(self) -> list[tuple[NDArray[np.intp], FloatArray]]:
        """Rows of every joint, and their torque, contiguous in memory."""
        rows = [np.flatnonzero(self.joint == joint) for joint in range(self.n_joints)]
        return [(joint_rows, self.torque[joint_rows]) for joint_rows in rows]

    def along(self, slope: FloatArray) -> FloatArray:
        """Sum over joints and states of every term's torque times a slope, shape (n, N), for terms (K,)."""
        sums = np.empty(len(self.term))
        for (rows, torque), joint_slope in zip(self.by_joint, slope, strict=True):
            sums[rows] = torque @ joint_slope
        return np.asarray(np.bincount(self.term, weights=sums, minlength=self.count), dtype=float)

    def over(self, allowed: FloatArray) -> Effects:
        """The same over the error allowed at every joint, N m, shape (n,)."""
        shares = self.torque / allowed[self.joint][:, None]
        return Effects(self.count, self.n_joints, self.term, self.joint, shares)

    def joined_by(self, terms: NDArray[np.intp], torque: FloatArray) -> Effects:
        """The same with one more row of some terms, shape (M, N), as if they acted on one more joint.

        Rows of one term add up.
        """
        terms, place = np.unique(terms, return_inverse=True)
        rows = np.zeros((len(terms), self.torque.shape[1]))
        np.add.at(rows, place, torque)
        term = np.concatenate([self.term, terms])
        order = np.argsort(term, kind="stable")
        joint = np.concatenate([self.joint, np.full(len(terms), self.n_joints)])[order]
        joined = np.concatenate([self.torque, rows])[order]
        return Effects(self.count, self.n_joints + 1, term[order], joint, joined)

    def dense(self) -> FloatArray:
        """Torque of every term at every joint, shape (K, n, N)."""
        out = np.zeros((self.count, self.n_joints, self.torque.shape[1]))
        out[self.term, self.joint] = self.torque
        return out


class TermTorques:
    """Torque terms of K terms, whose values at any states follow from few distinct products.

    Parameters
    ----------
    velocities
        Absolute velocities of the arm, in which the terms are.
    sources
        Coefficient and torque terms of each term.
    numbers
        Number of each term, from 0; terms of one number count as one. By default each is one by itself.
    """

    def __init__(
        self,
        velocities: AbsoluteVelocities,
        sources: Sequence[tuple[float, Torques]],
        numbers: NDArray[np.int64] | None = None,
    ) -> None:
        numbers = np.arange(len(sources)) if numbers is None else numbers
        self.velocities, self.count = velocities, int(numbers.max(initial=-1)) + 1
        monomials: dict[Monomial, int] = {}
        moving: dict[tuple[Velocity, ...], int] = {}
        rows = []
        carriers = [velocities.inboard(joint) for joint in range(velocities.n_joints)]
        for number, (coefficient, torques) in zip(numbers.tolist(), sources, strict=True):
            for term, weight in torques.items():
                monomial = monomials.setdefault(term.monomial, len(monomials))
                product = moving.setdefault(term.velocities, len(moving))
                for joint, sign in carriers[term.row]:
                    rows.append((number, joint, monomial, product, sign * coefficient * weight))
        columns = np.array(rows, dtype=float).reshape(-1, 5)
        columns = columns[np.lexsort((columns[:, 1], columns[:, 0]))]
        self._term, self._joint, self._monomial, self._moving = columns[:, :4].astype(np.intp).T
        self._weight = columns[:, 4]
        self._monomials, self._products = list(monomials), list(moving)
        self._last: tuple[States, FloatArray, FloatArray] | None = None

    def _factors(self, states: States) -> tuple[FloatArray, FloatArray]:
        """Values at states of all distinct products of sines and cosines, and of velocities, shape (.., N).

        Those of the last states are remembered, as terms are evaluated there block by block.
        """
        if self._last is None or self._last[0] is not states:
            variables, ones = TorqueVariables(self.velocities, states.last), np.ones(len(states))

            def values(keys: Sequence[tuple[Velocity | Factor, ...]]) -> FloatArray:
                products = [reduce(np.multiply, map(variables, key), ones) for key in keys]
                return np.reshape(products, (len(keys), len(states)))

            monomials, products = values(self._monomials), values(self._products)
            self._last = states, monomials, products
        return self._last[1:]

    def at(self, states: States, terms: NDArray[np.intp] | slice = slice(None)) -> Effects:
        """Torque of some terms, renumbered in their order, at states; weighted as the states are."""
        chosen = np.arange(self.count)[terms]
        place = np.full(self.count, -1)
        place[chosen] = np.arange(len(chosen))
        rows = np.flatnonzero(place[self._term] >= 0)
        rows = rows[np.argsort(place[self._term[rows]], kind="stable")]
        monomials, products = self._factors(states)
        torque = self._weight[rows, None] * monomials[self._monomial[rows]]
        torque *= products[self._moving[rows]]
        term, joint = place[self._term[rows]], self._joint[rows]
        # Several torque terms of one term may act on the same joint.
        starts = np.flatnonzero(np.diff(term * self.velocities.n_joints + joint, prepend=-1))
        if len(starts) < len(rows):
            torque, term, joint = np.add.reduceat(torque, starts), term[starts], joint[starts]
        if states.weights is not None:
            torque *= states.weights.T[joint]
        return Effects(len(chosen), self.velocities.n_joints, term, joint, torque)

    def together(self, states: States, terms: NDArray[np.intp]) -> FloatArray:
        """Torque of some terms together at states, shape (n, N); weighted as the states are."""
        if len(terms) == 0:
            return np.zeros((self.velocities.n_joints, len(states)))
        from scipy.sparse import csr_array  # slow to load

        monomials, products = self._factors(states)
        chosen = np.zeros(self.count, dtype=bool)
        chosen[terms] = True
        rows = np.flatnonzero(chosen[self._term])
        n, count = self.velocities.n_joints, len(products)
        # One bracket of monomials per joint and product of velocities.
        bracket = self._joint[rows] * count + self._moving[rows]
        shape = n * count, len(monomials)
        brackets = csr_array((self._weight[rows], (bracket, self._monomial[rows])), shape) @ monomials
        torque = (brackets.reshape(n, count, -1) * products).sum(axis=1)
        return torque if states.weights is None else torque * states.weights.T

    def in_blocks(self, states: States, numbers: int) -> Iterator[tuple[slice, Effects]]:
        """All terms, block by block of terms, with at most some numbers each."""
        step = max(1, numbers // (2 * max(len(states), 1)))
        for start in range(0, self.count, step):
            block = slice(start, min(start + step, self.count))
            yield block, self.at(states, block)
