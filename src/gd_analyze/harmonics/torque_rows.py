"""Torques in the joints' own rates: polynomials in q times accelerations and products of rates."""

from __future__ import annotations

import itertools
from collections.abc import Mapping

from gd_analyze.harmonics.transform import Harmonics, slopes_of
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial

# "1", an acceleration "qdd" (joint,) or a product of rates "qd" (joint, joint): the factor of a polynomial.
RateFactor = tuple[str, tuple[int, ...]]


def rate_factors(n: int) -> tuple[RateFactor, ...]:
    """What the polynomials of every joint's torque are multiplied by, in this order."""
    pairs = itertools.combinations_with_replacement(range(n), 2)
    return ("1", ()), *(("qdd", (j,)) for j in range(n)), *(("qd", pair) for pair in pairs)


def exact_row(
    harmonics: Harmonics, inertia: Mapping[tuple[int, int], TrigonometricPolynomial], i: int
) -> tuple[TrigonometricPolynomial, list[int]]:
    """What adds up to the exact torque of joint i, D being `inertia`, and for each which of `rate_factors`.

    The factor of qd_j qd_k, j < k, is 2 h_ijk, that of qd_j^2 is h_ijj.
    """
    n = harmonics.arm.n_joints
    parts = [harmonics.gravity_loading[i], *(inertia[min(i, j), max(i, j)] for j in range(n))]
    places = list(range(n + 1))
    for place, (_, (j, k)) in enumerate(rate_factors(n)[n + 1 :], start=n + 1):
        parts += [(1.0 if j == k else 2.0) * slope for slope in slopes_of(inertia, i, j, k)]
        places += [place] * 3
    return TrigonometricPolynomial.stacked(parts), places
