"""Elements of D, h and c as sums of the products that a model chooses its terms from.

D follows from D' in absolute velocities, whose products are the shortest, h_ijk = (dD_ij/dq_k + dD_ik/dq_j -
dD_jk/dq_i) / 2 and c_i = dU/dq_i by the product rule: term by term what the torques of `lagrangian` are in
joint velocities. Squares have the form of `squares`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.lagrangian import absolute_inertia, potential_products, slope_of
from gd_analyze.harmonics.squares import Squares
from gd_analyze.harmonics.terms import Monomial, TorqueTerm, Velocity
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial

# Weights by product: of the whole, of translation and rotation, and of every link, shape (3 + n,).
Products = dict[Monomial, FloatArray]


class ElementProducts:
    """Elements of an arm's dynamics as products, each computed on first use; joints count from 0."""

    def __init__(self, harmonics: Harmonics) -> None:
        self._harmonics, self._velocities = harmonics, harmonics.velocities
        self._absolute: dict[tuple[int, int], Products] = {}
        self._joint: dict[tuple[int, int], Products] = {}

    def inertia(self, i: int, j: int) -> Products:
        """D_ij, i <= j."""
        return self._printed(self._inertia(i, j), TorqueTerm(i, (Velocity(2, j),), ()), self._noise[0])

    def christoffel(self, i: int, j: int, k: int) -> Products:
        """h_ijk."""
        slopes = ((0.5, i, j, k), (0.5, i, k, j), (-0.5, j, k, i))
        parts = [(sign, self._slope(self._inertia(min(a, b), max(a, b)), by)) for sign, a, b, by in slopes]
        place = TorqueTerm(i, (Velocity(1, j), Velocity(1, k)), ())
        return self._printed(_sum(parts), place, DEGREE * self._noise[0])

    def gravity_loading(self, i: int) -> Products:
        """c_i."""
        return self._printed(self._slope(self._potential, i), TorqueTerm(i, (), ()), self._noise[1])

    @property
    def _noise(self) -> tuple[float, float]:
        return self._harmonics.noise

    def _printed(self, products: Products, place: TorqueTerm, noise: float) -> Products:
        """Products above the noise, with squares in one form."""
        terms = {place._replace(monomial=m): w for m, w in products.items() if abs(w[0]) > noise}
        squares = Squares.of(terms)
        parts = (
            (1.0, {new.monomial: factor * weight for new, factor in squares.written(term).items()})
            for term, weight in terms.items()
        )
        return {monomial: weight for monomial, weight in _sum(parts).items() if abs(weight[0]) > noise}

    def _inertia(self, i: int, j: int) -> Products:
        """D_ij before its squares are rewritten."""
        if (i, j) not in self._joint:
            self._joint[i, j] = _sum(
                (float(a.sign * b.sign), self._absolute_inertia(min(a.joint, b.joint), max(a.joint, b.joint)))
                for a in self._velocities.outboard(i)
                for b in self._velocities.outboard(j)
            )
        return self._joint[i, j]

    def _absolute_inertia(self, i: int, j: int) -> Products:
        """D'_ij, i <= j."""
        if (i, j) not in self._absolute:
            self._absolute[i, j] = absolute_inertia(self._velocities, self._rows, i, j, self._noise[0], 3)
        return self._absolute[i, j]

    @cached_property
    def _rows(self) -> Mapping[tuple[int, int], TrigonometricPolynomial]:
        """Polynomials of every element that is known: the whole, effects, links."""
        harmonics, links = self._harmonics, range(self._harmonics.arm.n_joints)
        zero = TrigonometricPolynomial.constant(tuple(not turns for turns in harmonics.arm.is_revolute), 0.0)
        by_link = {place: parts.total() for place, parts in harmonics.inertia_by_link.items()}
        return {
            (i, j): TrigonometricPolynomial.stacked(
                [effects.total(), effects, *(by_link.get((s, i, j), zero) for s in links)]
            )
            for (i, j), effects in harmonics.inertia.items()
        }

    @cached_property
    def _potential(self) -> Products:
        """Potential energy, all of which is translation."""
        of_links = self._harmonics.potential_by_link
        whole = self._harmonics.potential
        rows = TrigonometricPolynomial.stacked([whole, whole.added([0], 2), of_links])
        return potential_products(self._velocities, rows, self._noise[1])

    def _slope(self, products: Products, joint: int) -> Products:
        """Derivative by a joint's variable."""
        direction = np.eye(self._velocities.n_joints)[joint]
        return _sum(
            (1.0, {inner: factor * weight for inner, factor in slope_of(monomial, direction).items()})
            for monomial, weight in products.items()
            if any(factor.multiples[joint] for factor in monomial)
        )


def _sum(parts: Iterable[tuple[float, Products]]) -> Products:
    out: Products = {}
    for factor, products in parts:
        for monomial, weight in products.items():
            out[monomial] = out[monomial] + factor * weight if monomial in out else factor * weight
    return out
