"""How far a simplified D is from D, and what its terms contribute where it cannot be used as a D.

The measure is gamma, the largest |eigenvalue of D^-1 Ds - I|, with the simplified D as Ds. If gamma is below
1, a symmetric Ds is positive definite, and feedback through it converges, the faster the smaller gamma is.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.terms import EnergyTerm
from gd_analyze.simplification.effects import Mask
from gd_analyze.simplification.torque_program import TorqueVariables


def gammas(inertia: FloatArray, simplified: FloatArray) -> FloatArray:
    """Largest |eigenvalue of D^-1 Ds - I| at every position, shape (N,).

    Parameters
    ----------
    inertia, simplified
        D, positive definite, and the simplified D, shape (N, n, n).
    """
    change = np.linalg.solve(inertia, simplified - inertia)
    return np.asarray(np.abs(np.linalg.eigvals(change)).max(axis=1, initial=0.0))


class InertiaTerms:
    """Terms of D' at positions: their sum, and what it lacks there.

    Parameters
    ----------
    velocities
        Absolute velocities, in which the terms are.
    terms, weights
        K elements and monomials, i <= j, and their coefficients.
    q
        Positions, shape (N, n).
    """

    def __init__(
        self, velocities: AbsoluteVelocities, terms: Sequence[EnergyTerm], weights: FloatArray, q: FloatArray
    ) -> None:
        variables, ones = TorqueVariables(velocities, (q.T, q.T, q.T)), np.ones(len(q))
        distinct = {term.monomial: 0 for term in terms}
        products = {key: reduce(np.multiply, map(variables, key), ones) for key in distinct}
        self._values = weights[:, None] * np.reshape([products[t.monomial] for t in terms], (-1, len(q)))
        self._i, self._j = np.array([(term.i, term.j) for term in terms], dtype=np.intp).reshape(-1, 2).T
        # qd = A p, so that D = A^-T D' A^-1.
        self._to_absolute = np.linalg.inv(velocities.matrix)

    def inertia(self, selected: Mask) -> FloatArray:
        """D of some of the terms, shape (N, n, n)."""
        n, count = len(self._to_absolute), self._values.shape[1]
        absolute = np.zeros((n, n, count))
        np.add.at(absolute, (self._i[selected], self._j[selected]), self._values[selected])
        upper = np.moveaxis(absolute, -1, 0)
        whole = upper + upper.swapaxes(1, 2) - upper * np.eye(n)
        return np.asarray(self._to_absolute.T @ whole @ self._to_absolute)

    def excess(
        self, inertia: FloatArray, selected: Mask, limit: float
    ) -> tuple[FloatArray, FloatArray] | None:
        """Where gamma of a selection exceeds a limit: what terms add to Ds there, and what it lacks beside.

        At a position, gamma is reached in one direction x of qd, scaled so that x^T D x = 1. There
        x^T (D - Ds) x is a sum over dropped terms, as an error of the torque is.

        Returns
        -------
        tuple
            x^T (its D) x of every term, shape (K, N), and of everything that is no term here, shape (N,),
            zero where gamma is below half the limit; None if it exceeds the limit nowhere.
        """
        root = np.linalg.inv(np.linalg.cholesky(inertia))
        change: Array = root @ (self.inertia(selected) - inertia) @ root.swapaxes(1, 2)
        values, vectors = np.linalg.eigh(change)
        worst, rows = np.abs(values).argmax(axis=1), np.arange(len(values))
        reached = values[rows, worst]
        if (np.abs(reached) <= limit).all():
            return None
        direction = np.einsum("nji,nj->ni", root, vectors[rows, :, worst])
        moving = direction @ self._to_absolute.T
        multiplicity = np.where(self._i == self._j, 1.0, 2.0)[:, None]
        added = self._values * multiplicity * moving[:, self._i].T * moving[:, self._j].T
        remainder = -reached - added[~selected].sum(axis=0)
        counts = np.abs(reached) > limit / 2
        return added * counts, remainder * counts
