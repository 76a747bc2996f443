"""Models for smaller and larger budgets, each of which keeps part of what the one before it keeps.

They lead through a model that is given: terms join it for a smaller budget and leave it for a larger one, so
that every term has one budget at which it goes, and a reader can follow. Of a recursion more and more steps
are changed, from the exact one for smaller budgets and from the given one for larger.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import SWEEP, Candidates, TooManyTermsError, candidates_of
from gd_analyze.simplification.elimination import eliminate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_model import exactly, measured
from gd_analyze.simplification.level import CandidateLevel, Terms
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.pruned import pruned_path

# From a tenth of the budget to ten times it, ten steps to each side.
FACTORS = tuple(10.0 ** (step / 10) for step in range(-10, 11))
# A search in a recursion takes long: it is done for one in so many of them, and of recursions of more
# operations, where it would take minutes, for none.
_APART, _LONG = 5, 700


def budget_path(
    exact: ExactDynamics, budget: Budget, given: SimplifiedModel, factors: Sequence[float] = FACTORS
) -> tuple[SimplifiedModel, ...]:
    """Follow a model to smaller and to larger budgets.

    Where the model was refitted, coefficients remain so from its own budget on, and are exact below.

    Parameters
    ----------
    exact
        Exact dynamics at the states it was made for.
    budget, given
        Its budget, and the model; the path leads through it at a factor of 1.
    factors
        Multiples of its budget, growing.

    Returns
    -------
    tuple
        One model per factor, within that budget: the exact one where none found on the way takes fewer
        operations. None keeps a term that one before it does not keep, or takes more operations.
    """
    if isinstance(given.level, CandidateLevel):
        trials = _nested(exact, given, factors)
    else:
        trials = _pruned(exact, given, factors)
    last, models = exactly(exact, given.level, given.accuracy.allowed, str(budget)), []
    for factor, trial in zip(factors, trials, strict=True):
        allowed = factor * given.accuracy.allowed
        # A model that undercuts the given one for a smaller budget is not on a way that leads through it.
        least = given.operations.total if factor < 1.0 else 0
        if trial is given or (
            trial is not None
            and least <= trial.operations.total < last.operations.total
            and (trial.accuracy.errors.counting <= allowed).all()
        ):
            last = trial
        accuracy = replace(last.accuracy, allowed=allowed, budget=str(budget.scaled(factor)))
        models.append(replace(last, accuracy=accuracy))
    return tuple(models)


def _pruned(
    exact: ExactDynamics, given: SimplifiedModel, factors: Sequence[float]
) -> Iterator[SimplifiedModel | None]:
    """Models with more and more changes of the recursion: some up to the given one, and some from it on."""
    some, allowed = exact.thinned(), given.accuracy.allowed
    is_long = exact.form.operations.total > _LONG
    for side, start in (
        ([f for f in factors if f <= 1.0], {}),
        ([f for f in factors if f > 1.0], given.terms),
    ):
        looked_at = [
            factor for k, factor in enumerate(side) if k % _APART == 0 and factor != 1.0 and not is_long
        ]
        found = dict(zip(looked_at, pruned_path(some, [f * allowed for f in looked_at], start), strict=True))
        for factor in side:
            if factor in found:
                own = replace(given, terms=found[factor].terms, program=found[factor].program)
                yield measured(exact, own)
            else:
                yield given if factor == 1.0 else None


def _written(
    exact: ExactDynamics, given: SimplifiedModel, kept: Sequence[Terms]
) -> dict[frozenset[Any], SimplifiedModel]:
    """Models by what they keep, as far as they may take fewer operations than exact."""
    several = {frozenset(terms): terms for terms in reversed(kept)}
    most = exact.form.operations.total - 1
    programs = given.level.write_steps(given.form, [*several.values()], most)
    return {
        name: measured(exact, replace(given, terms=terms, program=program))
        for (name, terms), program in zip(several.items(), programs, strict=False)
    }


def _nested(
    exact: ExactDynamics, given: SimplifiedModel, factors: Sequence[float]
) -> Iterator[SimplifiedModel | None]:
    """Models that keep fewer and fewer terms; none where that takes more operations than exact."""
    kept = [*_kept(exact, given, factors)]
    known = _written(exact, given, [terms for f, terms in zip(factors, kept, strict=True) if f != 1.0])
    for factor, terms in zip(factors, kept, strict=True):
        yield given if factor == 1.0 else known.get(frozenset(terms))


def _kept(exact: ExactDynamics, given: SimplifiedModel, factors: Sequence[float]) -> Iterator[Terms]:
    """What is kept for each factor; at 1 what the model keeps."""
    try:
        swept = SWEEP * min(factors)
        candidates = candidates_of(exact.thinned(), given.level, given.accuracy.allowed, swept)
    except TooManyTermsError:
        # Any model of so many terms takes more operations than the exact torque.
        yield from (given.terms for _ in factors)
        return
    yield from _eliminated(candidates, given.terms, factors)


def _eliminated(candidates: Candidates, given: Terms, factors: Sequence[float]) -> Iterator[Terms]:
    """Let terms go in one order, the given model's last, whenever a budget allows."""
    effects, swept = candidates.flat, candidates.swept
    stays = np.array([term in given for term in candidates.terms])
    fitted = np.array([given.get(term, weight) / weight for term, weight in candidates.terms.items()])
    order = eliminate(candidates, last=stays).order
    listed = {term: weight for term, weight in given.items() if term not in candidates.terms}
    kept, scale = np.ones(len(effects), dtype=bool), np.ones(len(effects))
    lost = np.zeros(effects.shape[1])
    for factor in factors:
        if factor >= 1.0 and scale is not fitted:
            kept, scale = stays.copy(), fitted
            lost = (1.0 - kept * scale) @ effects
        for k in order:
            if kept[k] and stays[k] == (factor > 1.0):
                trial = lost + scale[k] * effects[k]
                if np.abs(trial).max(initial=0.0) <= (factor - swept) / (1.0 - swept):
                    kept[k], lost = False, trial
        yield candidates.keep(kept, scale) | listed
