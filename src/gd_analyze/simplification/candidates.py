"""What a simplification may drop: parts, torque terms or energy terms, and what each makes of torque."""

from __future__ import annotations

import itertools
import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.errors import UsageError
from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Energies, Monomial, Rate, Torques, TorqueTerm
from gd_analyze.models.element_level import parts_of, torque_by_part, trace_parts
from gd_analyze.models.simplified import Level
from gd_analyze.simplification.element_costs import part_costs
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.states import States
from gd_analyze.vectors import FloatArray

Costs = Mapping[frozenset[int], int]

# Above so many terms the smallest go first: no search could weigh them all.
MANY = 1000
# What those may make of the budget together, and how many may then be left at most.
SWEEP, _MOST = 0.3, 4000
# Numbers held at a time while looking for them.
_AT_ONCE = 10_000_000

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
    magnitude
        Magnitude of the coefficient behind each candidate, shape (K,).
    ratio
        Factor of every candidate's coefficient where its free number is 1, shape (K,); 1 at first.
    members, total
        Which of all terms the candidates are, shape (K,), and how many there are. The others, of an arm with
        very many, are dropped beforehand; `effects` are over what they leave of the budget.
    swept
        Share of the budget that those others take together, 0 where there are none.
    """

    effects: FloatArray
    costs: Costs
    parameter: NDArray[np.int64]
    magnitude: FloatArray
    ratio: FloatArray
    members: NDArray[np.int64]
    total: int
    swept: float = 0.0

    @classmethod
    def untied(cls, effects: FloatArray, costs: Costs) -> Candidates:
        """Candidates that each have a number of their own."""
        count = len(effects)
        every = np.arange(count)
        return cls(effects, costs, every, np.ones(count), np.ones(count), every, count)

    def whole(self, kept: NDArray[np.bool_], scale: FloatArray) -> tuple[NDArray[np.bool_], FloatArray]:
        """What is kept of all terms, and factors of all their coefficients."""
        every, factors = np.zeros(self.total, dtype=bool), np.ones(self.total)
        every[self.members], factors[self.members] = kept, scale
        return every, factors

    @property
    def flat(self) -> FloatArray:
        """Effects with joints and states in one row, shape (K, n N)."""
        return self.effects.reshape(len(self.effects), math.prod(self.effects.shape[1:]))


def candidates_of(
    exact: ExactDynamics, level: Level, allowed: FloatArray, sweep: float = SWEEP
) -> Candidates:
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
    sweep
        Share of the budget that terms may take which are dropped beforehand, the smallest first, until no
        more than `MANY` are left.

    Raises
    ------
    UsageError
        If far too many terms would be left.
    """
    if level == "element":
        parts = parts_of(exact.arm.n_joints)
        effects = torque_by_part(exact.quantities, exact.states.qdd, parts)
        effects /= allowed[:, None]
        return Candidates.untied(effects, part_costs(trace_parts(exact.arm), exact.drives))
    basis, every = exact.harmonics.rates, _every(exact, level)
    members, swept = np.arange(len(every)), 0.0
    if len(every) > MANY:
        members, swept = _swept(basis, exact.states, every, allowed, sweep)
    if len(members) > _MOST:
        raise UsageError(
            f"too many of the {len(every)} terms of {exact.arm.name} matter within that budget",
            where="budget",
            expected=f"at most {_MOST}",
            found=str(len(members)),
            next_step="allow a larger error, or use --level element",
        )
    chosen = [every[k] for k in members]
    effects = _effects(basis, exact.states, [term.torques for term in chosen])
    effects /= ((1.0 - swept) * allowed)[:, None]
    return Candidates(
        effects,
        _costs(chosen),
        np.array([term.parameter for term in chosen], dtype=int),
        np.array([term.magnitude for term in chosen]),
        np.ones(len(chosen)),
        members,
        len(every),
        swept,
    )


@dataclass(frozen=True)
class _Term:
    """Torques of one candidate, its free number, and the magnitude of its coefficient."""

    torques: Torques
    parameter: int
    magnitude: float


def _every(exact: ExactDynamics, level: Level) -> list[_Term]:
    """All terms of a level."""
    sources = exact.sources
    number = _tied(exact.energy)
    if level == "energy":
        return [
            _Term({t: coefficient * w for t, w in source.items()}, k, abs(coefficient))
            for coefficient, source, k in zip(exact.energy.values(), sources, number, strict=True)
        ]
    made_by: dict[TorqueTerm, dict[int, float]] = defaultdict(dict)
    for k, coefficient, source in zip(number, exact.energy.values(), sources, strict=True):
        for term in source:
            made_by[term][k] = abs(coefficient)
    fresh = len(exact.energy)
    out = []
    for i, (term, weight) in enumerate(exact.torques.items()):
        makers = made_by[term]
        # A term made by energies of different coefficients is a number of its own.
        one, magnitude = next(iter(makers.items())) if len(makers) == 1 else (fresh + i, abs(weight))
        out.append(_Term({term: weight}, one, magnitude))
    return out


def _costs(terms: list[_Term]) -> dict[frozenset[int], int]:
    """Operations by the set of candidates that need them."""
    users: dict[TorqueTerm, list[int]] = defaultdict(list)
    for k, candidate in enumerate(terms):
        for term in candidate.torques:
            users[term].append(k)
    torque_terms = list(users)
    gathered: dict[frozenset[int], int] = defaultdict(int)
    for members, operations in shared_costs(torque_terms).items():
        gathered[frozenset(k for m in members for k in users[torque_terms[m]])] += operations
    return dict(gathered)


def _swept(
    basis: AbsoluteRates, states: States, terms: list[_Term], allowed: FloatArray, sweep: float
) -> tuple[NDArray[np.int64], float]:
    """Terms left when the smallest have gone, and the largest error over allowed that these make together."""
    groups = [term.torques for term in terms]
    peaks = np.zeros((len(groups), basis.n_joints))
    step = max(_AT_ONCE // (len(groups) * basis.n_joints), 1)
    for start in range(0, len(states.q), step):
        chunk = slice(start, start + step)
        some = States(states.q[chunk], states.qd[chunk], states.qdd[chunk], states.described)
        np.maximum(peaks, np.abs(_effects(basis, some, groups)).max(axis=2), out=peaks)
    order = np.argsort((peaks / allowed).max(axis=1), kind="stable")
    lost = np.zeros((basis.n_joints, len(states.q)))
    gone, share = 0, 0.0
    step = max(_AT_ONCE // lost.size, 1)
    for start in range(0, len(groups) - MANY, step):
        some_terms = order[start : min(start + step, len(groups) - MANY)]
        sums = lost + np.cumsum(_effects(basis, states, [groups[k] for k in some_terms]), axis=0)
        errors = (np.abs(sums).max(axis=2) / allowed).max(axis=1)
        within = np.flatnonzero(errors <= sweep)
        if within.size:
            gone, share = start + int(within[-1]) + 1, float(errors[within[-1]])
        lost = sums[-1]
    return np.sort(order[gone:]), share


def _tied(energy: Energies) -> list[int]:
    """Number every coefficient, those alike but for their sign and powers of two the same."""
    mantissas = np.array([math.frexp(abs(coefficient))[0] for coefficient in energy.values()])
    order = np.argsort(mantissas, kind="stable")
    # Of neighbours in size the ones a round-off apart are one; 1/2 and 1 are neighbours, too.
    steps = np.diff(mantissas[order]) > _EQUAL
    number = np.empty(len(energy), dtype=int)
    number[order] = np.concatenate([[0], np.cumsum(steps)]) if len(energy) else []
    if len(energy) and mantissas[order[0]] + (1.0 - mantissas[order[-1]]) / 2 <= 0.5 + _EQUAL:
        number[number == number.max()] = 0
    return [int(k) for k in number]


def _effects(basis: AbsoluteRates, states: States, groups: list[Torques]) -> FloatArray:
    """Torques of every group at every state, N m, in the joints' own coordinates, shape (K, n, N)."""
    values = _MonomialValues(basis, states)
    effects = np.zeros((len(groups), basis.n_joints, len(states.q)))
    for k, group in enumerate(groups):
        for term, weight in group.items():
            effects[k, term.row] += weight * values(term)
    for run in basis.runs:
        for inner, outer in reversed(list(itertools.pairwise(run))):
            effects[:, inner] += effects[:, outer]
    return effects


class _MonomialValues:
    """Values of monomials times rates at the states, each literal and each product formed once."""

    def __init__(self, basis: AbsoluteRates, states: States) -> None:
        back = np.linalg.inv(basis.matrix)
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
