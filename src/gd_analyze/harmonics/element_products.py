"""Elements of D, h and c as sums of the products that a model chooses its terms from.

D follows from D' in absolute velocities, whose products are the shortest, h_ijk = (dD_ij/dq_k + dD_ik/dq_j -
dD_jk/dq_i) / 2 and c_i = dU/dq_i by the product rule: term by term what the torques of `lagrangian` are in
joint velocities. Squares have the form of `squares`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cached_property

from gd_analyze.arrays import FloatArray
from gd_analyze.harmonics.lagrangian import absolute_inertia, potential_products, slope_of
from gd_analyze.harmonics.squares import Squares, has_squares
from gd_analyze.harmonics.terms import Monomial, TorqueTerm, Velocity
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial

# Weights by product: of the whole, of translation and rotation, and of every link, shape (3 + n,).
Products = Mapping[Monomial, FloatArray]


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
        parts = [(sign, self._inertia_slope(min(a, b), max(a, b), by)) for sign, a, b, by in slopes]
        place = TorqueTerm(i, (Velocity(1, j), Velocity(1, k)), ())
        return _printed(_sum(parts), place, DEGREE * self._noise[0])

    def gravity_loading(self, i: int) -> Products:
        """c_i."""
        return _printed(self._slope(self._potential, i), TorqueTerm(i, (), ()), self._noise[1])

    def _inertia_slope(self, i: int, j: int, joint: int) -> Products:
        if (i, j, joint) not in self._slopes:
            self._slopes[i, j, joint] = self._slope(self._inertia(i, j), joint)
        return self._slopes[i, j, joint]

    def _slope(self, products: Products, joint: int) -> Products:
        """Derivative by a joint's variable."""
        direction = [float(j == joint) for j in range(self._harmonics.arm.n_joints)]
        return _rewritten(products, lambda monomial: slope_of(monomial, direction))

    def _inertia(self, i: int, j: int) -> Products:
        """D_ij before its squares are rewritten."""
        if (i, j) not in self._joint:
            self._joint[i, j] = _sum(
                (a.sign * b.sign, self._absolute_inertia(min(a.joint, b.joint), max(a.joint, b.joint)))
                for a in self._velocities.outboard(i)
                for b in self._velocities.outboard(j)
            )
        return self._joint[i, j]

    def _absolute_inertia(self, i: int, j: int) -> Products:
        """D'_ij, i <= j."""
        if (i, j) not in self._absolute:
            products = absolute_inertia(self._velocities, self._rows, i, j, self._noise[0], deciding=3)
            self._absolute[i, j] = products
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
        return potential_products(self._velocities, polynomial, self._noise[1])


def _printed(products: Products, place: TorqueTerm, noise: float) -> Products:
    """Products above the noise, with squares in one form."""
    products = _above(products, noise)
    if not any(map(has_squares, products)):
        return products
    terms = {monomial: place._replace(monomial=monomial) for monomial in products}
    squares = Squares.of(terms.values())
    written = {
        monomial: {new.monomial: factor for new, factor in squares.written(term).items()}
        for monomial, term in terms.items()
    }
    return _above(_rewritten(products, written.__getitem__), noise)


def _above(products: Products, noise: float) -> Products:
    """Those whose whole weight is above the noise."""
    return {monomial: weights for monomial, weights in products.items() if abs(weights[0]) > noise}


def _rewritten(products: Products, written: Callable[[Monomial], Mapping[Monomial, float]]) -> Products:
    """Every product as a sum of others, with their factors."""
    return _sum((w, {new: weights}) for m, weights in products.items() for new, w in written(m).items())


def _sum(parts: Iterable[tuple[float, Products]]) -> Products:
    """Sum of products, each part times a factor."""
    out: dict[Monomial, FloatArray] = {}
    for factor, products in parts:
        for monomial, weights in products.items():
            out[monomial] = out.get(monomial, 0.0) + factor * weights
    return out
