"""Elements of D, h and c as sums of the products that a model chooses its terms from.

D follows from D' in absolute velocities, whose products are the shortest, h_ijk = (dD_ij/dq_k + dD_ik/dq_j -
dD_jk/dq_i) / 2 and c_i = dU/dq_i by the product rule: term by term what the torques of `lagrangian` are in
joint velocities. Squares have the form of `squares`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.lagrangian import absolute_inertia, potential_products, slope_of
from gd_analyze.harmonics.squares import Squares, has_squares
from gd_analyze.harmonics.terms import Monomial, TorqueTerm, Velocity
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial


class Products(NamedTuple):
    """T products, and their weights: of the whole, of translation and rotation, and of every link."""

    monomials: list[Monomial]
    weights: FloatArray  # (T, 3 + n)

    def above(self, noise: float) -> Products:
        """Those whose whole weight is above the noise."""
        rows = np.flatnonzero(np.abs(self.weights[:, 0]) > noise)
        return Products([self.monomials[row] for row in rows.tolist()], self.weights[rows])

    def scaled(self, factor: float) -> Products:
        """The same times a factor."""
        return Products(self.monomials, factor * self.weights)


class ElementProducts:
    """Elements of an arm's dynamics as products, each computed on first use; joints count from 0."""

    def __init__(self, harmonics: Harmonics) -> None:
        self._harmonics, self._velocities = harmonics, harmonics.velocities
        self._noise = harmonics.noise
        self._absolute: dict[tuple[int, int], Products] = {}
        self._joint: dict[tuple[int, int], Products] = {}
        self._slopes: dict[tuple[int, int, int], Products] = {}

    def inertia(self, i: int, j: int) -> Products:
        """D_ij, i <= j."""
        return _printed(self._inertia(i, j), TorqueTerm(i, (Velocity(2, j),), ()), self._noise[0])

    def christoffel(self, i: int, j: int, k: int) -> Products:
        """h_ijk."""
        slopes = ((0.5, i, j, k), (0.5, i, k, j), (-0.5, j, k, i))
        parts = [self._inertia_slope(min(a, b), max(a, b), by).scaled(sign) for sign, a, b, by in slopes]
        place = TorqueTerm(i, (Velocity(1, j), Velocity(1, k)), ())
        return _printed(_sum(parts), place, DEGREE * self._noise[0])

    def gravity_loading(self, i: int) -> Products:
        """c_i."""
        return _printed(_slope(self._potential, i), TorqueTerm(i, (), ()), self._noise[1])

    def _inertia_slope(self, i: int, j: int, joint: int) -> Products:
        if (i, j, joint) not in self._slopes:
            self._slopes[i, j, joint] = _slope(self._inertia(i, j), joint)
        return self._slopes[i, j, joint]

    def _inertia(self, i: int, j: int) -> Products:
        """D_ij before its squares are rewritten."""
        if (i, j) not in self._joint:
            self._joint[i, j] = _sum(
                [
                    self._absolute_inertia(min(a.joint, b.joint), max(a.joint, b.joint)).scaled(
                        a.sign * b.sign
                    )
                    for a in self._velocities.outboard(i)
                    for b in self._velocities.outboard(j)
                ]
            )
        return self._joint[i, j]

    def _absolute_inertia(self, i: int, j: int) -> Products:
        """D'_ij, i <= j."""
        if (i, j) not in self._absolute:
            weights = absolute_inertia(self._velocities, self._rows, i, j, self._noise[0], deciding=3)
            self._absolute[i, j] = self._products(weights)
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
        whole = self._harmonics.potential
        rows = [whole, whole.added([0], 2), self._harmonics.potential_by_link]
        polynomial = TrigonometricPolynomial.stacked(rows)
        return self._products(potential_products(self._velocities, polynomial, self._noise[1]))

    def _products(self, weights: Mapping[Monomial, FloatArray]) -> Products:
        size = len(weights), 3 + self._harmonics.arm.n_joints
        return Products(list(weights), np.reshape(list(weights.values()), size))


def _printed(products: Products, place: TorqueTerm, noise: float) -> Products:
    """Products above the noise, with squares in one form."""
    products = products.above(noise)
    if not any(map(has_squares, products.monomials)):
        return products
    terms = [place._replace(monomial=monomial) for monomial in products.monomials]
    squares = Squares.of(terms)
    written = ([(new.monomial, factor) for new, factor in squares.written(term).items()] for term in terms)
    return _rewritten(products, written).above(noise)


def _slope(products: Products, joint: int) -> Products:
    """Derivative by a joint's variable."""
    direction = np.eye(products.weights.shape[1] - 3)[joint].tolist()
    return _rewritten(products, (slope_of(monomial, direction).items() for monomial in products.monomials))


def _rewritten(products: Products, written: Iterable[Iterable[tuple[Monomial, float]]]) -> Products:
    """Every product as a sum of others, with their factors."""
    place: dict[Monomial, int] = {}
    parts = [
        (row, place.setdefault(monomial, len(place)), factor)
        for row, summands in enumerate(written)
        for monomial, factor in summands
    ]
    rows, places, factors = np.array(parts, dtype=float).reshape(-1, 3).T
    weights = np.zeros((len(place), products.weights.shape[1]))
    np.add.at(weights, places.astype(int), factors[:, None] * products.weights[rows.astype(int)])
    return Products([*place], weights)


def _sum(parts: list[Products]) -> Products:
    if len(parts) == 1:
        return parts[0]
    place: dict[Monomial, int] = {}
    places = [[place.setdefault(monomial, len(place)) for monomial in part.monomials] for part in parts]
    weights = np.zeros((len(place), parts[0].weights.shape[1]))
    for part, rows in zip(parts, places, strict=True):
        weights[rows] += part.weights
    return Products([*place], weights)
