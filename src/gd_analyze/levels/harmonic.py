"""What the levels of harmonic terms share: values of terms at states, their price, their form in files."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.legend import torque_legend
from gd_analyze.formulas.writing import torque_formulas
from gd_analyze.harmonics.terms import Energies, Factor, Monomial, Rate, Torques, TorqueTerm
from gd_analyze.harmonics.waves import DEGREE
from gd_analyze.levels.exact import ExactDynamics, ExactForm
from gd_analyze.levels.level import Effort, Level, Terms
from gd_analyze.levels.torque_program import torque_program
from gd_analyze.operations import Program
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

# Coefficients that are equal in mathematics, or twice or half each other, and differ by round-off.
_EQUAL = 1e-9

# Kind, how often every joint goes into the argument, exponent.
FactorEntry = tuple[Literal["cos", "sin", "power"], list[int], Annotated[int, Field(ge=1, le=DEGREE)]]


class HarmonicLevel(Level):
    """A level whose models are sums of harmonic torque terms."""

    can_be_refitted: ClassVar[bool] = True
    has_torque_terms: ClassVar[bool] = True

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Factor the torques that the terms make."""
        return torque_program(form.rates, self.torques(form, terms), effort)

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Torques in absolute rates, terms with the same rates in brackets before them."""
        return torque_formulas(form.rates, self.torques(form, terms))

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Absolute rates, sines and cosines."""
        return torque_legend(form.rates, self.torques(form, terms))


def group_effects(exact: ExactDynamics, groups: Sequence[Torques]) -> FloatArray:
    """Torques of every group of terms at every state, N m, at the joints themselves, shape (K, n, N)."""
    values = _Values(exact)
    rows = np.zeros((exact.arm.n_joints, len(groups), len(exact.states)))
    for k, group in enumerate(groups):
        for term, weight in group.items():
            rows[term.row, k] += weight * values(term)
    return np.stack(exact.form.rates.joint_rows(rows), axis=1)


class _Values:
    """Values of monomials times rates at the states, each factor and each product formed once."""

    def __init__(self, exact: ExactDynamics) -> None:
        rates, states = exact.form.rates, exact.states
        self._q = states.q.T
        self._moving = {1: rates.absolute(states.qd.T), 2: rates.absolute(states.qdd.T)}
        self._factors: dict[Factor, FloatArray] = {}
        self._known: dict[tuple[tuple[Rate, ...], Monomial], FloatArray] = {}

    def __call__(self, term: TorqueTerm) -> FloatArray:
        key = (term.rates, term.monomial)
        if key not in self._known:
            value = np.ones(self._q.shape[1])
            for rate in term.rates:
                value = value * self._moving[rate.order][rate.joint]
            for factor in term.monomial:
                value = value * self._factor(factor)
            self._known[key] = value
        return self._known[key]

    def _factor(self, factor: Factor) -> FloatArray:
        if factor not in self._factors:
            argument = np.array(factor.multiples, dtype=float) @ self._q
            if factor.kind != "power":
                argument = np.cos(argument) if factor.kind == "cos" else np.sin(argument)
            self._factors[factor] = argument
        return self._factors[factor]


def shared_costs(terms: Sequence[TorqueTerm]) -> dict[frozenset[int], int]:
    """Operations by the set of torque terms that need them: a guess at what factoring will find.

    A term takes its coefficient and its sum; equal products of sines and cosines are formed once, and rates
    multiply the sum of all terms behind them.
    """
    costs: dict[frozenset[int], int] = defaultdict(int)
    products: dict[Monomial, set[int]] = defaultdict(set)
    brackets: dict[tuple[int, tuple[Rate, ...]], set[int]] = defaultdict(set)
    for p, term in enumerate(terms):
        costs[frozenset([p])] += 2
        products[term.monomial].add(p)
        brackets[term.row, term.rates].add(p)
    for monomial, members in products.items():
        costs[frozenset(members)] += max(len(monomial) - 1, 0)
    for (_, rates), members in brackets.items():
        costs[frozenset(members)] += len(rates)
    return dict(costs)


def numbered(energies: Energies) -> list[int]:
    """Number every coefficient, those alike but for their sign and powers of two the same."""
    mantissas = np.array([math.frexp(abs(coefficient))[0] for coefficient in energies.values()])
    order = np.argsort(mantissas, kind="stable")
    # Of neighbours in size the ones a round-off apart are one; 1/2 and 1 are neighbours, too.
    steps = np.diff(mantissas[order]) > _EQUAL
    number = np.empty(len(energies), dtype=int)
    number[order] = np.concatenate([[0], np.cumsum(steps)]) if len(energies) else []
    if len(energies) and mantissas[order[0]] + (1.0 - mantissas[order[-1]]) / 2 <= 0.5 + _EQUAL:
        number[number == number.max()] = 0
    return [int(k) for k in number]


def factor_entries(monomial: Monomial) -> list[FactorEntry]:
    """Write a monomial for a model file."""
    return [(f.kind, list(f.multiples), monomial.count(f)) for f in dict.fromkeys(monomial)]


def monomial_of(arm: RobotArm, entries: Sequence[FactorEntry]) -> Monomial:
    """Read a monomial back; a ModelError where no arm of this make has it."""
    monomial = sorted(Factor(kind, tuple(m)) for kind, m, exponent in entries for _ in range(exponent))
    for factor in monomial:
        revolute = [arm.is_revolute[j] for j in factor.joints[: arm.n_joints]]
        # Beyond the degree of D no multiple of an angle and no further power occurs.
        known = len(factor.multiples) == arm.n_joints and all(abs(m) <= DEGREE for m in factor.multiples)
        if factor.kind == "power":
            fitting = revolute == [False] and sum(factor.multiples) == 1
        else:
            fitting = bool(revolute) and all(revolute)
        if not (known and fitting):
            raise ModelError(f"{factor.kind} of {list(factor.multiples)} is no factor of the arm's equations")
    return tuple(monomial)
