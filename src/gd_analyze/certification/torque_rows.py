"""Torques in the joints' own rates: polynomials in q times accelerations and products of rates."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Mapping, Sequence

import numpy as np

from gd_analyze.certification.box import Box
from gd_analyze.certification.motion import RateFactor
from gd_analyze.harmonics import AbsoluteRates, Harmonics, Waves
from gd_analyze.harmonics.conversion import to_waves
from gd_analyze.harmonics.terms import Monomial, Rate, Torques
from gd_analyze.harmonics.transform import slopes_of
from gd_analyze.vectors import FloatArray


def rate_factors(n: int) -> tuple[RateFactor, ...]:
    """What the polynomials of every joint's torque are multiplied by, in this order."""
    pairs = itertools.combinations_with_replacement(range(n), 2)
    return ("1", ()), *(("qdd", (j,)) for j in range(n)), *(("qd", pair) for pair in pairs)


def model_rows(torques: Torques, rates: AbsoluteRates, sliding: Sequence[bool]) -> list[Waves]:
    """Every joint's torque from terms in absolute rates: a polynomial for each of `rate_factors`."""
    polynomials: dict[tuple[int, tuple[Rate, ...]], dict[Monomial, float]] = defaultdict(dict)
    for term, weight in torques.items():
        polynomials[term.row, term.rates][term.monomial] = weight
    place = {factor: k for k, factor in enumerate(rate_factors(rates.n_joints))}
    into: list[list[tuple[int, int]]] = [[] for _ in range(rates.n_joints)]
    for p, (row, moving) in enumerate(polynomials):
        kind = "1" if not moving else "qdd" if moving[0].order == 2 else "qd"
        for own in itertools.product(*(rates.inboard(rate.joint) for rate in moving)):
            for joint in rates.inboard(row):
                into[joint].append((p, place[kind, tuple(sorted(own))]))
    waves = to_waves(list(polynomials.values()), sliding)
    return [waves[[p for p, _ in row]].added([k for _, k in row], len(place)) for row in into]


def model_roundings(torques: Torques, rates: AbsoluteRates, box: Box) -> FloatArray:
    """What rounding the coefficients of `model_rows` makes of every joint's torque in a box, shape (n,).

    Each is a sum over terms, of which one may come as often as it has sines and cosines; the magnitudes of
    these summands add up to no more than those of the terms, sines and cosines being 1.
    """
    limits = {1: rates.absolute(box.rate), 2: rates.absolute(box.acceleration)}
    out = np.zeros(box.n_joints)
    for term, weight in torques.items():
        moving = [float(limits[rate.order][rate.joint]) for rate in term.rates]
        powers = [float(box.farthest @ f.multiples) for f in term.monomial if f.kind == "power"]
        out[term.row] += abs(weight) * math.prod(moving + powers)
    return 4 * len(torques) * np.finfo(float).eps * np.array(rates.joint_rows(out))


def exact_row(
    harmonics: Harmonics, inertia: Mapping[tuple[int, int], Waves], i: int
) -> tuple[Waves, list[int]]:
    """What adds up to the exact torque of joint i, D being `inertia`, and for each which of `rate_factors`.

    The factor of qd_j qd_k, j < k, is 2 h_ijk, that of qd_j^2 is h_ijj.
    """
    n = harmonics.arm.n_joints
    parts = [harmonics.gravity_loading[i], *(inertia[min(i, j), max(i, j)] for j in range(n))]
    places = list(range(n + 1))
    for place, (_, (j, k)) in enumerate(rate_factors(n)[n + 1 :], start=n + 1):
        parts += [(1.0 if j == k else 2.0) * slope for slope in slopes_of(inertia, i, j, k)]
        places += [place] * 3
    return Waves.stacked(parts), places
