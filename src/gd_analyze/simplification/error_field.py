"""The torque error of a model as polynomials in the positions, ready to be bounded."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import Monomial, TorqueTerm, slope_of
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

Polynomial = dict[Monomial, float]


@dataclass(frozen=True, eq=False)
class Box:
    """Positions between `lower` and `upper`, rates and accelerations up to their limits; shape (n,) each."""

    lower: FloatArray
    upper: FloatArray
    rate: FloatArray
    acceleration: FloatArray

    @classmethod
    def of(cls, arm: RobotArm) -> Box:
        """Take the arm's own limits.

        Raises
        ------
        UsageError
            If the arm lacks one.
        """
        box = cls(
            arm.limits("lower"),
            arm.limits("upper"),
            arm.limits("rate_limit"),
            arm.limits("acceleration_limit"),
        )
        if not np.isfinite([box.lower, box.upper, box.rate, box.acceleration]).all():
            raise UsageError(
                f"arm {arm.name} does not state all its limits",
                where=f"arm {arm.name}",
                expected="range, rate and acceleration limits of every joint",
                next_step="add them to the arm file, or give the box",
            )
        return box


# "1", an acceleration (joint,), or a product of two rates (joint, joint): the factor of a polynomial in q.
RateFactor = tuple[int, ...]
ErrorRow = dict[tuple[str, RateFactor], Polynomial]


def error_rows(
    basis: Basis, exact: Mapping[TorqueTerm, float], simplified: Mapping[TorqueTerm, float]
) -> list[ErrorRow]:
    """Error of every joint's torque by rates and accelerations of the joints themselves."""
    inboard = {joint: run.joints[: k + 1] for run in basis.runs for k, joint in enumerate(run.joints)}
    rows: list[ErrorRow] = [defaultdict(lambda: defaultdict(float)) for _ in range(basis.n_joints)]
    for term in {*exact, *simplified}:
        weight = simplified.get(term, 0.0) - exact.get(term, 0.0)
        if weight == 0.0:
            continue
        factors: dict[tuple[str, RateFactor], float] = defaultdict(float)
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


class ErrorField:
    """The polynomials F of one joint with their slopes, ready for many positions at once."""

    def __init__(self, row: ErrorRow, box: Box) -> None:
        n = len(box.lower)
        self.factors = list(row)
        self.sizes = np.array([_largest(factor, box) for factor in self.factors])
        largest = _literal_bounds(row, box)
        units = np.eye(n)
        slopes = [[_slope(polynomial, units[k]) for polynomial in row.values()] for k in range(n)]
        self.axes = [k for k in range(n) if any(slopes[k])]
        families = [list(row.values()), *(slopes[k] for k in self.axes)]
        index = {
            m: i for i, m in enumerate(dict.fromkeys(m for family in families for p in family for m in p))
        }
        self._monomials = list(index)
        self._weights = np.zeros((len(families) * len(self.factors), len(index)))
        for f, family in enumerate(families):
            for p, polynomial in enumerate(family):
                for monomial, weight in polynomial.items():
                    self._weights[f * len(self.factors) + p, index[monomial]] = weight
        self.curvature = np.array(
            [
                [
                    sum(
                        size * _magnitude(_slope(slopes[k][p], units[m]), largest)
                        for p, size in enumerate(self.sizes)
                    )
                    for m in self.axes
                ]
                for k in self.axes
            ]
        ).reshape(len(self.axes), len(self.axes))
        # Sums of as many products, each with a relative error of some eps per factor.
        terms = sum(size * _magnitude(p, largest) for size, p in zip(self.sizes, row.values(), strict=True))
        self.round_off = 8.0 * (len(index) + 8) * float(np.finfo(float).eps) * float(terms)

    def __call__(self, q: FloatArray) -> tuple[FloatArray, FloatArray]:
        """F at positions (n, K), shape (P, K), and its slopes along `axes`, shape (axes, P, K)."""
        literals = {literal for monomial in self._monomials for literal in monomial}
        known = {literal: _literal_value(literal, q) for literal in literals}
        values = np.ones((len(self._monomials), q.shape[1]))
        for i, monomial in enumerate(self._monomials):
            for literal in monomial:
                values[i] *= known[literal]
        out = (self._weights @ values).reshape(len(self.axes) + 1, len(self.factors), q.shape[1])
        return out[0], out[1:]


def _largest(factor: tuple[str, RateFactor], box: Box) -> float:
    kind, joints = factor
    limit = {"1": box.rate, "qd": box.rate, "qdd": box.acceleration}[kind]
    return float(np.prod([limit[joint] for joint in joints]))


def _slope(polynomial: Polynomial, direction: FloatArray) -> Polynomial:
    out: Polynomial = defaultdict(float)
    for monomial, weight in polynomial.items():
        for inner, factor in slope_of(monomial, direction).items():
            out[inner] += weight * factor
    return {monomial: weight for monomial, weight in out.items() if weight != 0.0}


def _literal_bounds(row: ErrorRow, box: Box) -> dict[tuple[str, tuple[int, ...]], float]:
    """Largest magnitude of every sliding variable in the box; sines and cosines have 1."""
    far = np.maximum(np.abs(box.lower), np.abs(box.upper))
    literals = {literal for polynomial in row.values() for monomial in polynomial for literal in monomial}
    return {literal: float(np.array(literal[1]) @ far) for literal in literals if literal[0] == "power"}


def _magnitude(polynomial: Polynomial, largest: Mapping[tuple[str, tuple[int, ...]], float]) -> float:
    """Bound of a polynomial's magnitude over the box."""
    return sum(
        abs(weight) * float(np.prod([largest.get(literal, 1.0) for literal in monomial]))
        for monomial, weight in polynomial.items()
    )


def _literal_value(literal: tuple[str, tuple[int, ...]], q: FloatArray) -> FloatArray:
    kind, multiples = literal
    argument = np.array(multiples, dtype=float) @ q
    if kind == "power":
        return argument
    return np.asarray(np.cos(argument) if kind == "cos" else np.sin(argument))
