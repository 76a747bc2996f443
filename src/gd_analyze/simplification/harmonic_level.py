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
from gd_analyze.simplification.candidates import SWEEP_SHARE, Candidates, candidates_at, swept
from gd_analyze.simplification.selection import select
from gd_analyze.simplification.states import States
from gd_analyze.vectors import FloatArray

# Time the integer program may take beside the elimination.
_SEARCH_SECONDS = 3.0
# Candidates tried per step before giving up; the order is a guess, the check is not.
_TRIES = 12


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
    pool = candidates_at(
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


def _eliminate(pool: Candidates, progress: Callable[[int], None] | None) -> list[int]:
    """Drop candidates, coefficients as they are, until none can go; what is kept."""
    terms, *states = pool.effects.shape
    torques = (pool.effects * pool.coefficients[:, None, None]).reshape(terms, math.prod(states))
    merit = np.einsum("ks,ks->k", torques, torques) / pool.cost
    kept = swept(pool)
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
    pool: Candidates, target: FloatArray, progress: Callable[[int], None] | None
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
    pool = candidates_at(basis, states, members, np.ones(len(members)), allowed)
    greedy = _eliminate(pool, progress)
    kept_by_sweep = swept(pool)
    terms = [next(iter(members[k])) for k in kept_by_sweep]
    # The sweep has spent its share of the budget.
    rest = np.full(len(allowed), 1.0 - SWEEP_SHARE)
    selection = select(pool.effects[kept_by_sweep], rest, _shared_costs(terms), _SEARCH_SECONDS)
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
