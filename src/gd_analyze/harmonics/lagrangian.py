"""Torque as a sum of terms that follow from the kinetic and potential energy.

In absolute velocities p (`absolute_velocities`) the inertia matrix D' has far fewer terms than D: for the
PUMA 560 70 instead of 98 for i <= j. A term c f(q) of D'_ij is a kinetic energy c f p_i p_j (half of it for
i = j), and Lagrange's equations give its torques

    tau'_i += c (f pd_j + fd p_j),  tau'_j += c (f pd_i + fd p_i),  tau'_m -= c (df/dp_m) p_i p_j

(half of them for i = j), where fd = sum_m (df/dp_m) p_m. A term g(q) of the potential gives dg/dp_m. So a
torque term is a coefficient times a monomial in sines and cosines, and up to two velocities or one
acceleration.
"""

from __future__ import annotations

import itertools
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from functools import lru_cache

import numpy as np

from gd_analyze.arrays import FloatArray, falling
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.products import to_products
from gd_analyze.harmonics.terms import (
    CANCELLED_SHARE,
    Energies,
    EnergyTerm,
    Factor,
    Monomial,
    Torques,
    TorqueTerm,
    Velocity,
    accumulated,
    summed,
)
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial

# Relative round-off of a coefficient, which some hundred products make; the arm's data are coarser.
_ROUND_OFF = 1e-12


def energy_terms(harmonics: Harmonics, drive_inertia: FloatArray | None = None) -> dict[EnergyTerm, float]:
    """Exact terms of the kinetic energy in absolute velocities and of the potential energy.

    The drives' inertia, shape (n,), is added to the diagonal of D in the joints' own velocities: to constants
    alone, so that all other terms are those of the links.
    """
    velocities = harmonics.velocities
    weights = energy_weights(velocities, harmonics.whole_inertia(), harmonics.potential, harmonics.noise)
    energies = {term: float(weight[0]) for term, weight in weights.items()}
    if drive_inertia is not None:
        added = velocities.matrix.T @ np.diag(drive_inertia) @ velocities.matrix
        for i, j in np.argwhere(np.triu(added)).tolist():
            constant = EnergyTerm(i, j, ())
            energies[constant] = energies.get(constant, 0.0) + float(added[i, j])
    return _without_round_off(energies)


def energy_weights(
    velocities: AbsoluteVelocities,
    inertia: Mapping[tuple[int, int], TrigonometricPolynomial],
    potential: TrigonometricPolynomial,
    noise: tuple[float, float],
) -> dict[EnergyTerm, FloatArray]:
    """Terms of P energies, and their weights (P,), from P polynomials for D_ij, i <= j, and the potential.

    All are exact in the same terms: those of any of them above the `noise` of D and potential.
    """
    out: dict[EnergyTerm, FloatArray] = {}
    for i, j in itertools.combinations_with_replacement(range(velocities.n_joints), 2):
        products = absolute_inertia(velocities, inertia, i, j, noise[0], len(potential.coefficients))
        out |= {EnergyTerm(i, j, monomial): weight for monomial, weight in products.items()}
    products = potential_products(velocities, potential, noise[1], len(potential.coefficients))
    return out | {EnergyTerm(-1, -1, monomial): weight for monomial, weight in products.items()}


def absolute_inertia(
    velocities: AbsoluteVelocities,
    inertia: Mapping[tuple[int, int], TrigonometricPolynomial],
    i: int,
    j: int,
    noise: float,
    deciding: int = 1,
) -> dict[Monomial, FloatArray]:
    """Products of D'_ij and their weights (P,), from P polynomials for D_km, k <= m, joints from 0."""
    a = velocities.matrix
    parts = [
        float(a[k, i] * a[m, j]) * inertia[min(k, m), max(k, m)]
        for k in np.flatnonzero(a[:, i]).tolist()
        for m in np.flatnonzero(a[:, j]).tolist()
    ]
    return _products(TrigonometricPolynomial.summed(parts), velocities, len(parts) * noise, deciding)


def potential_products(
    velocities: AbsoluteVelocities, potential: TrigonometricPolynomial, noise: float, deciding: int = 1
) -> dict[Monomial, FloatArray]:
    """Products of the potential energy without its constant, and their weights (P,)."""
    moving = potential.only((potential.multiples != 0).any(axis=1))
    return _products(moving, velocities, noise, deciding)


def _products(
    polynomial: TrigonometricPolynomial, velocities: AbsoluteVelocities, noise: float, deciding: int
) -> dict[Monomial, FloatArray]:
    """Those with a weight above the noise in any of the deciding polynomials; the first's largest first."""
    products = to_products(polynomial, velocities, noise, deciding)
    ordered = sorted(products.items(), key=lambda item: (falling(item[1][0]), item[0]))
    # Rewriting may leave noise of terms that cancel.
    return {monomial: weight for monomial, weight in ordered if np.abs(weight[:deciding]).max() > noise}


def _without_round_off(terms: dict[EnergyTerm, float]) -> dict[EnergyTerm, float]:
    """Give one magnitude to coefficients that only round-off tells apart, so that programs share products."""
    out = dict(terms)
    last = 0.0
    for term in sorted(terms, key=lambda term: abs(terms[term])):
        size = abs(terms[term])
        last = last if size - last <= _ROUND_OFF * size else size
        out[term] = float(np.copysign(last, terms[term]))
    return out


@lru_cache(maxsize=1 << 14)
def torques_of(term: EnergyTerm, velocities: AbsoluteVelocities) -> Torques:
    """Torque terms of one energy term with unit coefficient."""
    i, j, monomial = term
    slopes = [
        (m, inner, weight)
        for m, direction in enumerate(velocities.matrix.T.tolist())
        for inner, weight in slope_of(monomial, direction).items()
    ]
    if term.is_potential:
        return {TorqueTerm(m, (), inner): weight for m, inner, weight in slopes}
    out: dict[TorqueTerm, float] = defaultdict(float)
    half = 0.5 if i == j else 1.0
    for row, column in ((i, j), (j, i)):
        out[TorqueTerm(row, (Velocity(2, column),), monomial)] += half
        for m, inner, weight in slopes:
            out[TorqueTerm(row, _pair(column, m), inner)] += half * weight
    for m, inner, weight in slopes:
        out[TorqueTerm(m, _pair(i, j), inner)] -= half * weight
    return {key: weight for key, weight in out.items() if weight != 0.0}


def torques_of_energies(energies: Energies, velocities: AbsoluteVelocities) -> dict[TorqueTerm, float]:
    """Torque terms of energy terms with their coefficients; those that cancel are left out."""
    return summed((coefficient, torques_of(term, velocities)) for term, coefficient in energies.items())


def summed_per_unit(sources: Iterable[tuple[FloatArray, Torques]]) -> dict[TorqueTerm, FloatArray]:
    """Sum of torque terms, each source times a factor per parameter; weights that cancel are zero."""
    sums, sizes = accumulated(sources)
    return {
        key: np.where(abs(weight) > CANCELLED_SHARE * sizes[key], weight, 0.0) for key, weight in sums.items()
    }


def _pair(j: int, k: int) -> tuple[Velocity, Velocity]:
    return Velocity(1, min(j, k)), Velocity(1, max(j, k))


def slope_of(monomial: Monomial, direction: Sequence[float]) -> dict[Monomial, float]:
    """Derivative of a monomial along a direction of q, by the product rule."""
    out: dict[Monomial, float] = defaultdict(float)
    for place, (kind, multiples) in enumerate(monomial):
        weight = sum(
            multiple * slope for multiple, slope in zip(multiples, direction, strict=True) if multiple
        )
        if weight == 0.0:
            continue
        cofactor = monomial[:place] + monomial[place + 1 :]
        if kind == "power":
            out[cofactor] += weight
        else:
            partner = Factor("sin" if kind == "cos" else "cos", multiples)
            out[tuple(sorted((*cofactor, partner)))] += -weight if kind == "cos" else weight
    return {inner: weight for inner, weight in out.items() if weight != 0.0}
