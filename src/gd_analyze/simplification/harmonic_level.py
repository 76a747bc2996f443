"""Simplification by harmonic terms: backward elimination under a torque error budget.

Torque is linear in the coefficients of its terms, so the error over given states is linear in what is
dropped. Terms go one by one, the one of least weighted squared effect per operation first; after every step
the largest error over all states is checked, a step that breaks the budget is undone and the next candidate
tried, until none can go. With `refit` what remains is refitted by least squares at every step, and absorbs
what was dropped.
"""

from __future__ import annotations

import dataclasses
from collections import defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from gd_analyze.dominance import ROUND_OFF_SHARE, peak_magnitude
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.harmonics import Harmonics, identify
from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import (
    EnergyTerm,
    Monomial,
    Rate,
    Torques,
    TorqueTerm,
    absolute_rates,
    energy_terms,
    torques_of,
)
from gd_analyze.models.harmonic import HarmonicLevel, HarmonicModel, torques_of_energy
from gd_analyze.models.simplified import ErrorTable
from gd_analyze.models.torque_program import torque_programs
from gd_analyze.robots import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.selection import select
from gd_analyze.simplification.states import States
from gd_analyze.vectors import FloatArray

# Of the budget, what the first sweep may spend on terms too small to weigh one by one.
_SWEEP_SHARE = 0.02
# Time the integer program may take beside the elimination.
_SEARCH_SECONDS = 4.0
# Candidates tried per step before giving up; the order is a guess, the check is not.
_TRIES = 12


@dataclass(frozen=True, eq=False)
class _Candidates:
    """What may be dropped: torque terms that go together, their coefficients, and their torques.

    `effects` are the torques of unit coefficients over allowed error, shape (terms, n, N).
    """

    torques: tuple[Torques, ...]
    coefficients: FloatArray
    effects: FloatArray

    @property
    def cost(self) -> FloatArray:
        """Operations a term takes when nothing is shared."""
        return np.array(
            [sum(1 + len(term.rates) + len(term.monomial) for term in torques) for torques in self.torques],
            dtype=float,
        )


def simplify_harmonics(
    arm: RobotArm,
    states: States,
    budget: Budget | None = None,
    *,
    level: HarmonicLevel = "term",
    refit: bool = False,
    drives: bool = False,
    provenance: Mapping[str, str] | None = None,
    harmonics: Harmonics | None = None,
    progress: Callable[[int], None] | None = None,
) -> HarmonicModel:
    """Keep few harmonic terms within a torque error budget.

    Parameters
    ----------
    arm
        The arm.
    states
        States over which the budget holds.
    budget
        Allowed torque error per joint; 1 % of each joint's peak torque over the states by default.
    level
        "energy" keeps terms of the energies, so that the model stays a mechanical system; "term" keeps torque
        terms one by one, the fewest operations an integer program finds.
    refit
        At level "energy": refit the kept coefficients to absorb what is dropped.
    drives
        Include drive inertia.
    provenance
        Stored with the model.
    harmonics
        The identified dynamics where they are at hand.
    progress
        Called with the number of terms dropped since the last call.

    Returns
    -------
    HarmonicModel
        Its largest error over the states is within the budget, measured on its own program.

    Raises
    ------
    UsageError
        If the budget does not fit the number of joints.
    ArmError
        If drives are asked for and the arm describes none.
    """
    budget = budget or Budget()
    harmonics = harmonics or identify(arm)
    every = energy_terms(harmonics, arm.drive_inertia if drives else None)
    basis, rates = harmonics.basis, absolute_rates(harmonics.basis)
    torque = states.torque(arm, drives)
    peak = peak_magnitude(torque)
    allowed = np.maximum(budget.allowed(peak), ROUND_OFF_SHARE * peak.max())
    target = (torque / allowed).T
    pool = _pool(
        basis,
        states,
        [torques_of(term, rates) for term in every],
        np.array([term.coefficient for term in every]),
        allowed,
    )
    if level == "term":
        energy: tuple[EnergyTerm, ...] = ()
        torques = _select_torque_terms(
            basis, states, torques_of_energy(arm, every), allowed, target, progress
        )
    else:
        kept, coefficients = _eliminate(pool, target, refit, progress)
        energy = tuple(
            dataclasses.replace(every[k], coefficient=float(c))
            for k, c in zip(kept, coefficients, strict=True)
        )
        torques = torques_of_energy(arm, energy)
    exact = torque_programs(basis, torques_of_energy(arm, every))["torque"].count
    nothing = ErrorTable(np.zeros(len(peak)), np.zeros(len(peak)), np.zeros(len(peak)))
    draft = HarmonicModel(
        arm, level, energy, torques, drives, refit, allowed, str(budget), nothing, states.described, exact
    )
    promise = ErrorTable.of(torque, draft.torque(states.q, states.qd, states.qdd))
    if not (promise.largest <= allowed).all():
        raise GdAnalyzeError(
            "the simplified model misses its budget",
            expected=str(allowed.tolist()),
            found=str(promise.largest.tolist()),
            next_step="please report this with the arm file and the states",
        )
    return dataclasses.replace(draft, promise=promise, provenance=dict(provenance or {}))


def _pool(
    basis: Basis, states: States, torques: list[Torques], coefficients: FloatArray, allowed: FloatArray
) -> _Candidates:
    """Torques of every candidate at every state, in the joints' own coordinates."""
    values = _MonomialValues(basis, states)
    effects = np.zeros((len(torques), basis.n_joints, len(states.q)))
    for k, group in enumerate(torques):
        for term, weight in group.items():
            effects[k, term.row] += weight * values(term)
    for run in basis.runs:
        for inner, outer in reversed(list(zip(run.joints[:-1], run.joints[1:], strict=True))):
            effects[:, inner] += effects[:, outer]
    return _Candidates(tuple(torques), coefficients, effects / allowed[:, None])


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


def _eliminate(
    pool: _Candidates, target: FloatArray, refit: bool, progress: Callable[[int], None] | None
) -> tuple[list[int], FloatArray]:
    """Drop candidates until none can go; what is kept, and its coefficients."""
    flat = pool.effects.reshape(len(pool.effects), -1)
    wanted = target.reshape(-1)
    kept = _swept(pool)
    gram = flat[kept] @ flat[kept].T
    wished = flat[kept] @ wanted
    cost = pool.cost[kept]
    place = list(range(len(kept)))  # places within `kept` that are still there

    def solution(places: list[int]) -> FloatArray:
        if not refit:
            return pool.coefficients[[kept[p] for p in places]]
        fitted, *_ = np.linalg.lstsq(gram[np.ix_(places, places)], wished[places], rcond=None)
        return np.asarray(fitted, dtype=float)

    def worst(places: list[int], x: FloatArray) -> float:
        return float(np.abs(x @ flat[[kept[p] for p in places]] - wanted).max(initial=0.0))

    x = solution(place)
    if worst(place, x) > 1.0:  # the sweep and round-off together; start over without a sweep
        kept = list(range(len(pool.coefficients)))
        gram, wished, cost = flat @ flat.T, flat @ wanted, pool.cost
        place, x = list(kept), pool.coefficients.copy()
    while True:
        if refit and place:
            inverse = np.linalg.pinv(gram[np.ix_(place, place)], hermitian=True)
            effect = x**2 / np.maximum(np.diag(inverse), np.finfo(float).tiny)
        else:
            effect = x**2 * np.diag(gram)[place]
        for candidate in np.argsort(effect / cost[place])[:_TRIES]:
            without = place[:candidate] + place[candidate + 1 :]
            trial = solution(without)
            if worst(without, trial) <= 1.0:
                place, x = without, trial
                if progress is not None:
                    progress(1)
                break
        else:
            return [kept[p] for p in place], x


def _swept(pool: _Candidates) -> list[int]:
    """Candidates that matter: the others together stay below a small share of the budget."""
    largest = np.abs(pool.effects).max(axis=2) * np.abs(pool.coefficients)[:, None]
    order = np.argsort(largest.max(axis=1))
    together = np.cumsum(largest[order], axis=0).max(axis=1)
    return sorted(int(k) for k in order[together > _SWEEP_SHARE])


def _select_torque_terms(
    basis: Basis,
    states: States,
    torques: Mapping[TorqueTerm, float],
    allowed: FloatArray,
    target: FloatArray,
    progress: Callable[[int], None] | None,
) -> Torques:
    """Keep few torque terms within the budget; the rows of D part, so it need not stay symmetric.

    Backward elimination always ends; an integer program over the same terms is often cheaper and sometimes
    endless. Both are made, and the program of fewer operations is taken.
    """
    members = [{term: weight} for term, weight in torques.items()]
    pool = _pool(basis, states, members, np.ones(len(members)), allowed)
    greedy, _ = _eliminate(pool, target, False, progress)
    swept = _swept(pool)
    terms = [next(iter(members[k])) for k in swept]
    # The sweep has spent its share of the budget.
    rest = np.full(len(allowed), 1.0 - _SWEEP_SHARE)
    selection = select(pool.effects[swept], rest, _shared_costs(terms), _SEARCH_SECONDS)
    choices = [
        {term: torques[term] for k in greedy for term in members[k]},
        {term: torques[term] for term, keep in zip(terms, selection.kept, strict=True) if keep},
    ]
    return min(choices, key=lambda kept: torque_programs(basis, kept)["torque"].count.total)


def _shared_costs(terms: list[TorqueTerm]) -> dict[frozenset[int], int]:
    """Operations by the set of terms that need them: a guess at what factoring will find.

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
