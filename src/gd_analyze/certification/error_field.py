"""The torque error of a model: polynomials in the positions times accelerations and products of rates."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gd_analyze.certification.box import Box
from gd_analyze.certification.motion import Motion, RateFactor
from gd_analyze.certification.waves import Expansion, Polynomial, Waves
from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.terms import Monomial, TorqueTerm
from gd_analyze.vectors import FloatArray

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
