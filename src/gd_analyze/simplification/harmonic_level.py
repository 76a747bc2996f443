"""Simplification by harmonic terms: backward elimination under a torque error budget.

Torque is linear in the coefficients of its terms, so the error over given states is linear in what is
dropped. Terms go one by one, the one of least weighted squared effect per operation first; after every step
the largest error over all states is checked, a step that breaks the budget is undone and the next candidate
tried, until none can go. With `refit` what remains is refitted by least squares at every step, and absorbs
what was dropped.
"""

from __future__ import annotations

import dataclasses
import math
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
_SEARCH_SECONDS = 3.0
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
    # Without any torque anywhere nothing is worth keeping, and any positive budget says so.
    allowed = np.maximum(budget.allowed(peak), ROUND_OFF_SHARE * (peak.max() or 1.0))
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
        torques = _select_torque_terms(basis, states, torques_of_energy(arm, every), allowed, progress)
    else:
        if refit:
            kept, coefficients = _eliminate_refitting(pool, target, progress)
        else:
            kept = _eliminate(pool, progress)
            coefficients = pool.coefficients[kept]
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


def _eliminate(pool: _Candidates, progress: Callable[[int], None] | None) -> list[int]:
    """Drop candidates, coefficients as they are, until none can go; what is kept."""
    terms, *states = pool.effects.shape
    torques = (pool.effects * pool.coefficients[:, None, None]).reshape(terms, math.prod(states))
    merit = np.einsum("ks,ks->k", torques, torques) / pool.cost
    kept = _swept(pool)
    left_out = np.setdiff1d(np.arange(len(torques)), kept)
    lost = torques[left_out].sum(axis=0)
    kept.sort(key=lambda k: float(merit[k]))
    while True:
        for candidate in kept[:_TRIES]:
            trial = lost + torques[candidate]
            if np.abs(trial).max() <= 1.0:
                lost = trial
                kept.remove(candidate)
                if progress is not None:
                    progress(1)
                break
        else:
            return sorted(kept)


def _eliminate_refitting(
    pool: _Candidates, target: FloatArray, progress: Callable[[int], None] | None
) -> tuple[list[int], FloatArray]:
    """Drop candidates, the others refitted by least squares at every step; what is kept, its coefficients."""
    terms, *states = pool.effects.shape
    flat = pool.effects.reshape(terms, math.prod(states))
    wanted = target.reshape(-1)
    gram, wished, cost = flat @ flat.T, flat @ wanted, pool.cost
    kept, x = list(range(len(flat))), pool.coefficients.copy()
    while kept:
        inverse = np.linalg.pinv(gram[np.ix_(kept, kept)], hermitian=True)
        effect = x**2 / np.maximum(np.diag(inverse), np.finfo(float).tiny)
        for candidate in np.argsort(effect / cost[kept])[:_TRIES]:
            without = kept[:candidate] + kept[candidate + 1 :]
            fitted, *_ = np.linalg.lstsq(gram[np.ix_(without, without)], wished[without], rcond=None)
            if np.abs(fitted @ flat[without] - wanted).max(initial=0.0) <= 1.0:
                kept, x = without, np.asarray(fitted, dtype=float)
                if progress is not None:
                    progress(1)
                break
        else:
            break
    return kept, x


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
    progress: Callable[[int], None] | None,
) -> Torques:
    """Keep few torque terms within the budget; the rows of D part, so it need not stay symmetric.

    Backward elimination always ends; an integer program over the same terms is often cheaper and sometimes
    endless. Both are made, and the program of fewer operations is taken.
    """
    if not torques:
        return {}
    members = [{term: weight} for term, weight in torques.items()]
    pool = _pool(basis, states, members, np.ones(len(members)), allowed)
    greedy = _eliminate(pool, progress)
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
