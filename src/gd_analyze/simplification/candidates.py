"""What a simplification may drop: parts, torque terms or energy terms, and what each makes of torque."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import (
    EnergyTerm,
    Monomial,
    Rate,
    Torques,
    TorqueTerm,
    absolute_rates,
    torques_of,
)
from gd_analyze.models.element_level import parts_of, torque_by_part, trace_parts
from gd_analyze.models.simplified import Level
from gd_analyze.simplification.element_costs import part_costs
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.states import States
from gd_analyze.vectors import FloatArray

Costs = Mapping[frozenset[int], int]

# Coefficients that are equal in mathematics, or twice or half each other, and differ by round-off.
_EQUAL = 1e-9


@dataclass(frozen=True, eq=False)
class Candidates:
    """What may be dropped.

    Parameters
    ----------
    effects
        Torque of every candidate over the allowed error, shape (K, n, N); their sum is the exact torque.
    costs
        Operations by the set of candidates that need them.
    parameter
        Which free number scales a candidate in a refit, shape (K,). Candidates whose coefficients were equal,
        opposite or a power of two apart share one, so that what they share in arithmetic stays shared.
    """

    effects: FloatArray
    costs: Costs
    parameter: NDArray[np.int64]

    @property
    def flat(self) -> FloatArray:
        """Effects with joints and states in one row, shape (K, n N)."""
        return self.effects.reshape(len(self.effects), math.prod(self.effects.shape[1:]))


def candidates_of(exact: ExactDynamics, level: Level, allowed: FloatArray) -> Candidates:
    """Make the candidates of a level.

    Parameters
    ----------
    exact
        Exact dynamics at the states that count.
    level
        "element": one candidate per part; "term": per torque term, in the order of `exact.torques`;
        "energy": per energy term, in the order of `exact.energy`.
    allowed
        Allowed error per joint, N m, shape (n,).
    """
    if level == "element":
        parts = parts_of(exact.arm.n_joints)
        effects = torque_by_part(exact.quantities, exact.states.qdd, parts)
        effects /= allowed[:, None]
        return Candidates(effects, part_costs(trace_parts(exact.arm), exact.drives), np.arange(len(parts)))
    rates = absolute_rates(exact.harmonics.basis)
    sources = [torques_of(term, rates) for term in exact.energy]
    number = _tied(exact.energy)
    terms = list(exact.torques)
    costs = shared_costs(terms)
    if level == "term":
        groups: list[Torques] = [{term: weight} for term, weight in exact.torques.items()]
        made_by: dict[TorqueTerm, set[int]] = defaultdict(set)
        for k, source in zip(number, sources, strict=True):
            for term in source:
                made_by[term].add(k)
        fresh = iter(range(len(exact.energy), len(exact.energy) + len(terms)))
        # A term made by energies of different coefficients is a number of its own.
        parameter = [min(made_by[t]) if len(made_by[t]) == 1 else next(fresh) for t in terms]
    else:
        groups = [
            {term: energy.coefficient * weight for term, weight in source.items()}
            for energy, source in zip(exact.energy, sources, strict=True)
        ]
        users: dict[TorqueTerm, list[int]] = defaultdict(list)
        for k, source in enumerate(sources):
            for term in source:
                users[term].append(k)
        gathered: dict[frozenset[int], int] = defaultdict(int)
        for members, operations in costs.items():
            gathered[frozenset(k for m in members for k in users[terms[m]])] += operations
        costs, parameter = gathered, number
    return Candidates(
        _effects(exact.harmonics.basis, exact.states, groups, allowed), costs, np.array(parameter, dtype=int)
    )


def _tied(energy: tuple[EnergyTerm, ...]) -> list[int]:
    """Number every coefficient, those alike but for their sign and powers of two the same."""
    known: list[float] = []
    out = []
    for term in energy:
        mantissa = math.frexp(abs(term.coefficient))[0]
        for k, other in enumerate(known):
            if abs(mantissa - other) <= _EQUAL * other:
                out.append(k)
                break
        else:
            known.append(mantissa)
            out.append(len(known) - 1)
    return out


def _effects(basis: Basis, states: States, groups: list[Torques], allowed: FloatArray) -> FloatArray:
    """Torques of every group at every state over allowed error, in the joints' own coordinates."""
    values = _MonomialValues(basis, states)
    effects = np.zeros((len(groups), basis.n_joints, len(states.q)))
    for k, group in enumerate(groups):
        for term, weight in group.items():
            effects[k, term.row] += weight * values(term)
    for run in basis.runs:
        for inner, outer in reversed(list(zip(run.joints[:-1], run.joints[1:], strict=True))):
            effects[:, inner] += effects[:, outer]
    effects /= allowed[:, None]
    return effects


class _MonomialValues:
    """Values of monomials times rates at the states, each literal and each product formed once."""

    def __init__(self, basis: Basis, states: States) -> None:
        back = np.linalg.inv(absolute_rates(basis))
        self._q = states.q.T
        self._moving = {1: back @ states.qd.T, 2: back @ states.qdd.T}
        self._literals: dict[tuple[str, tuple[int, ...]], FloatArray] = {}
        self._known: dict[tuple[tuple[Rate, ...], Monomial], FloatArray] = {}

    def __call__(self, term: TorqueTerm) -> FloatArray:
        key = (term.rates, term.monomial)
        if key not in self._known:
            value = np.ones(self._q.shape[1])
            for rate in term.rates:
                value = value * self._moving[rate.order][rate.joint]
            for literal in term.monomial:
                value = value * self._literal(literal)
            self._known[key] = value
        return self._known[key]

    def _literal(self, literal: tuple[str, tuple[int, ...]]) -> FloatArray:
        if literal not in self._literals:
            kind, multiples = literal
            argument = np.array(multiples, dtype=float) @ self._q
            if kind != "power":
                argument = np.cos(argument) if kind == "cos" else np.sin(argument)
            self._literals[literal] = argument
        return self._literals[literal]


def shared_costs(terms: list[TorqueTerm]) -> dict[frozenset[int], int]:
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
