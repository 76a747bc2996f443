"""Torque of very many terms at states: each acts on one or two joints, and only these rows are stored."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

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
        Term and joint of each row, shape (E,); joints ascend, and so do the terms of each.
    torque
        Torque, N m (N), shape (E, N).
    """

    count: int
    n_joints: int
    term: NDArray[np.intp]
    joint: NDArray[np.intp]
    torque: FloatArray

    @cached_property
    def of_joints(self) -> list[slice]:
        """Rows of every joint."""
        edges = np.searchsorted(self.joint, np.arange(self.n_joints + 1)).tolist()
        return [slice(*pair) for pair in pairwise(edges)]

    @cached_property
    def _of_terms(self) -> list[NDArray[np.intp]]:
        order = np.argsort(self.term, kind="stable")
        return np.split(order, np.searchsorted(self.term[order], np.arange(1, self.count)))

    def rows_of(self, term: int) -> NDArray[np.intp]:
        """Rows of one term."""
        return self._of_terms[term]

    def largest(self, values: FloatArray) -> FloatArray:
        """Largest of positive values of the rows, shape (E,), for every term, shape (K,)."""
        largest = np.zeros(self.count)
        np.maximum.at(largest, self.term, values)
        return largest

    def total(self, terms: Mask) -> FloatArray:
        """Torque of some terms together, N m, shape (n, N)."""
        chosen = terms[self.term]
        return np.stack([self.torque[rows][chosen[rows]].sum(axis=0) for rows in self.of_joints])

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
        joint = np.concatenate([self.joint, np.full(len(terms), self.n_joints)])
        term, joined = np.concatenate([self.term, terms]), np.concatenate([self.torque, rows])
        return Effects(self.count, self.n_joints + 1, term, joint, joined)

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
        columns = columns[np.lexsort((columns[:, 0], columns[:, 1]))]
        self.term, self.joint, self.monomial, self.moving = columns[:, :4].astype(np.intp).T
        self.weight = columns[:, 4]
        self.monomials, self.products = list(monomials), list(moving)

    def at(self, states: States) -> TorquesAtStates:
        """Torques of all terms at states, weighted as the states are."""
        return TorquesAtStates(self, states)


class TorquesAtStates:
    """Torques of K terms at N states, of which as many are formed at once as are asked for."""

    def __init__(self, torques: TermTorques, states: States) -> None:
        self.torques, self.states, self.count = torques, states, torques.count
        variables = TorqueVariables(torques.velocities, states.last)

        def values(keys: Sequence[tuple[Velocity | Factor, ...]]) -> FloatArray:
            out = np.ones((len(keys), len(states)))
            for row, key in zip(out, keys, strict=True):
                for factor in key:
                    row *= variables(factor)
            return out

        self._monomials, self._products = values(torques.monomials), values(torques.products)

    def effects(self, terms: NDArray[np.intp] | slice = slice(None)) -> Effects:
        """Torque of some terms, renumbered in their order."""
        of_all, states = self.torques, self.states
        chosen = np.arange(self.count)[terms]
        place = np.full(self.count, -1)
        place[chosen] = np.arange(len(chosen))
        rows = np.flatnonzero(place[of_all.term] >= 0)
        rows = rows[np.lexsort((place[of_all.term[rows]], of_all.joint[rows]))]
        torque = self._monomials[of_all.monomial[rows]]
        torque *= of_all.weight[rows, None]
        torque *= self._products[of_all.moving[rows]]
        term, joint = place[of_all.term[rows]], of_all.joint[rows]
        # Several torque terms of one term may act on the same joint.
        starts = np.flatnonzero(np.diff(joint * self.count + term, prepend=-1))
        if len(starts) < len(rows):
            torque, term, joint = np.add.reduceat(torque, starts), term[starts], joint[starts]
        if states.weights is not None:
            torque *= states.weights.T[joint]
        return Effects(len(chosen), of_all.velocities.n_joints, term, joint, torque)

    def together(self, terms: NDArray[np.intp]) -> FloatArray:
        """Torque of some terms together, shape (n, N)."""
        if len(terms) == 0:
            return np.zeros((self.torques.velocities.n_joints, len(self.states)))
        from scipy.sparse import csr_array  # slow to load

        of_all, weights = self.torques, self.states.weights
        chosen = np.zeros(self.count, dtype=bool)
        chosen[terms] = True
        rows = np.flatnonzero(chosen[of_all.term])
        n, count = of_all.velocities.n_joints, len(self._products)
        # One bracket of monomials per joint and product of velocities.
        bracket = of_all.joint[rows] * count + of_all.moving[rows]
        shape = n * count, len(self._monomials)
        brackets = csr_array((of_all.weight[rows], (bracket, of_all.monomial[rows])), shape) @ self._monomials
        torque = (brackets.reshape(n, count, -1) * self._products).sum(axis=1)
        return torque if weights is None else torque * weights.T

    def in_blocks(self, numbers: int) -> Iterator[tuple[slice, Effects]]:
        """All terms, block by block of terms, with at most some numbers each."""
        step = max(1, numbers // (2 * max(len(self.states), 1)))
        for start in range(0, self.count, step):
            block = slice(start, min(start + step, self.count))
            yield block, self.effects(block)
