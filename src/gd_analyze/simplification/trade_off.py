"""Models for smaller and larger budgets: a curve per level, and the path of a given model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.operations.program import OperationCount
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import (
    SWEEP,
    Candidates,
    Elimination,
    Kept,
    TooManyTermsError,
    candidates_of,
    eliminate,
)
from gd_analyze.simplification.effort import inputs_of
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import ExactDynamics, ExactForm, too_many_terms
from gd_analyze.simplification.level import CandidateLevel, Level, Terms
from gd_analyze.simplification.levels import LEVELS, SearchOptions
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured
from gd_analyze.simplification.pruning import pruned_path
from gd_analyze.simplification.simplify import simplify_exact

# Level and refit: every level that keeps a budget, and again with a refit if it can have one.
Kind = tuple[Level, bool]
KINDS: tuple[Kind, ...] = tuple(
    (level, refit)
    for level in LEVELS.values()
    if level is not ELEMENT  # which keeps no budget
    for refit in ((False, True) if level.has_torque_terms else (False,))
)
FACTORS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
# Factors of a path: from a tenth of the budget to ten times it, ten steps to each side.
PATH_FACTORS = tuple(10.0 ** (step / 10) for step in range(-10, 11))
# A search in a recursion is slow, for a smaller budget as slow as for the model itself: it is done for one in
# this many of a path's larger budgets, and for no recursion of more operations: minutes.
_APART, _LONGEST = 5, 700
# Budgets that differ by less are equal.
_SAME = 1.01
# Operations of a point, and its largest error per joint, N m.
_Found = tuple[OperationCount, FloatArray]


def kinds_for(form: ExactForm) -> tuple[Kind, ...]:
    """Kinds that make sense for an arm: without those of single terms if it has very many."""
    many = too_many_terms(form)
    return tuple(kind for kind in KINDS if not (many and kind[0].has_torque_terms))


@dataclass(frozen=True)
class TradeOffPoint:
    """One model of the curve; the exact one if nothing cheaper is within the budget."""

    level: Level
    refit: bool
    factor: float  # multiple of the curve's budget
    budget: str  # as written by a user
    operations: OperationCount  # of one torque evaluation
    error_share: float  # largest error of any joint over its `Budget.shares_of`


def curves(points: Sequence[TradeOffPoint]) -> dict[Kind, tuple[TradeOffPoint, ...]]:
    """Points by level and refit, each with growing budget."""
    kinds = dict.fromkeys((point.level, point.refit) for point in points)
    ordered = sorted(points, key=lambda point: point.factor)
    return {kind: tuple(p for p in ordered if (p.level, p.refit) == kind) for kind in kinds}


def trade_off(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    *,
    factors: Sequence[float] = FACTORS,
    kinds: Sequence[Kind] | None = None,
    thorough: bool = True,
    progress: Callable[[int], None] = lambda _: None,
) -> tuple[TradeOffPoint, ...]:
    """Simplify for several budgets at every level.

    A model within a smaller budget is also within a larger one, and a model without refit is valid with
    refit: so no point takes more operations than one for a smaller budget, or without refit.

    Parameters
    ----------
    exact
        Exact dynamics at the states.
    budget
        The budget to scale; by default 1 % of each joint's peak torque.
    factors
        Multiples of the budget.
    kinds
        Pairs of level and refit; by default those of `kinds_for`.
    thorough
        Search each point as `simplify` does. Otherwise all points of a kind come from one elimination, or
        each continues from the next smaller budget. Operations are counted the same way.
    progress
        Called with the number of points done since the last call.

    Returns
    -------
    tuple
        Points (`TradeOffPoint`) by kind and growing budget.
    """
    budget = Budget.of(budget)
    points: list[TradeOffPoint] = []
    exact = exact.under(budget)
    allowed, order = exact.allowed(budget), sorted(factors)
    exact = exact if thorough else exact.thinned()
    whole = exact.peak_torque if budget.shares_of == "peak torque" else allowed
    of_level = cache(lambda level: _candidates(exact, level, allowed, SWEEP * min(1.0, *factors)))
    without: dict[Level, list[_Found]] = {}
    found: Iterable[_Found]
    for level, refit in kinds_for(exact.form) if kinds is None else kinds:
        if thorough:
            how = SearchOptions(level, refit)
            searched = (simplify_exact(exact, budget.scaled(factor), how) for factor in order)
            found = ((model.operations, model.accuracy.errors.largest) for model in searched)
        elif not isinstance(level, CandidateLevel):
            models = tuple(pruned_path(exact, [factor * allowed for factor in order]))
            found = _best_of(exact, models, allowed, order)
        elif (candidates := of_level(level)) is None:
            found = _best_of(exact, (), allowed, order)
        else:
            found = _eliminated(exact, allowed, eliminate(candidates, refit=refit), refit, order)
        best: list[_Found] = []
        others = without.get(level, [])
        for k, (factor, each) in enumerate(zip(order, found, strict=True)):
            operations, error = min([each, *others[k : k + 1], *best[-1:]], key=lambda one: one[0].total)
            best.append((operations, error))
            # The largest share of any joint; a joint without torque has none.
            share = float(np.divide(error, whole, out=np.zeros_like(error), where=whole > 0.0).max())
            points.append(TradeOffPoint(level, refit, factor, str(budget.scaled(factor)), operations, share))
            progress(1)
        without.setdefault(level, best)
    return tuple(points)


def _candidates(exact: ExactDynamics, level: Level, allowed: FloatArray, sweep: float) -> Candidates | None:
    """Terms to choose from; None if there are so many that any model costs more than the exact torque."""
    try:
        return candidates_of(exact, level, allowed, sweep)
    except TooManyTermsError:
        return None


def _best_of(
    exact: ExactDynamics, models: Sequence[SimplifiedModel], allowed: FloatArray, factors: Sequence[float]
) -> Iterator[_Found]:
    """The given, or exact, models with fewest operations within each budget."""
    everything = exact.form.operations, np.zeros(len(allowed))
    for factor in factors:
        best = None
        for model in models:
            stated = model.accuracy
            # A model with fitted numbers must have been made for that budget.
            made_for = not model.level.always_refits or (stated.allowed <= _SAME * factor * allowed).all()
            fewer = model.operations.total < (everything[0] if best is None else best.operations).total
            if made_for and fewer and (stated.errors.counting <= factor * allowed).all():
                best = model
        if best is None:
            yield everything
        else:
            yield best.operations, best.accuracy.errors.largest


def _eliminated(
    exact: ExactDynamics, allowed: FloatArray, elimination: Elimination, refit: bool, factors: Sequence[float]
) -> list[_Found]:
    """The last models of one elimination within each budget."""
    candidates = elimination.candidates
    swept, largest = candidates.swept, elimination.errors().max(axis=1) if refit else None
    selected: list[tuple[Kept, FloatArray]] = []
    for factor in factors:
        limit = (factor - swept) / (1.0 - swept)
        if largest is None:
            selected.append((elimination.within(limit), elimination.scales[0]))
        else:
            last = int(np.flatnonzero(largest <= limit)[-1])
            selected.append((elimination.kept(last), elimination.scales[last]))
    steps = [candidates.keep(*one) for one in reversed(selected)]
    programs = candidates.level.write_steps(candidates.form, steps, exact.form.operations.total - 1)
    found: list[_Found] = []
    inputs = inputs_of(exact.states)
    for program in programs:
        found.append((program.count, exact.errors_of(program.run(inputs).T).largest))
    everything = exact.form.operations, np.zeros(len(allowed))
    return [everything] * (len(factors) - len(found)) + found[::-1]


def budget_path(exact: ExactDynamics, budget: Budget, given: SimplifiedModel) -> tuple[SimplifiedModel, ...]:
    """Follow a model to smaller and larger budgets: one per factor of `PATH_FACTORS`, within that budget.

    For larger budgets no term returns, no step is restored, and operations do not grow, but at level element
    beyond those of the exact torque, which stands at smaller budgets.
    """
    trials = (_nested if isinstance(given.level, CandidateLevel) else _pruned)(exact, given)
    last, models = exactly(exact, given.level, given.accuracy.allowed, str(budget)), []
    for factor, trial in zip(PATH_FACTORS, trials, strict=True):
        allowed = factor * given.accuracy.allowed
        # A model for a smaller budget with fewer operations than the given one cannot be on its path.
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


def _pruned(exact: ExactDynamics, given: SimplifiedModel) -> Iterator[SimplifiedModel | None]:
    """Models with more and more simplified steps: the given one, and some beyond it."""
    some, allowed = exact.thinned(), given.accuracy.allowed
    is_long = exact.form.operations.total > _LONGEST
    larger = [] if is_long else PATH_FACTORS[PATH_FACTORS.index(1.0) + _APART :: _APART]
    found = {1.0: given}
    models = pruned_path(some, [factor * allowed for factor in larger], given.terms)
    for factor, model in zip(larger, models, strict=True):
        found[factor] = measured(exact, replace(given, terms=model.terms, program=model.program))
    yield from (found.get(factor) for factor in PATH_FACTORS)


def _nested(exact: ExactDynamics, given: SimplifiedModel) -> Iterator[SimplifiedModel | None]:
    """Models that keep fewer and fewer terms; None if one takes more operations than exact."""
    kept = [*_kept(exact, given)]
    others = [terms for factor, terms in zip(PATH_FACTORS, kept, strict=True) if factor != 1.0]
    several = {frozenset(terms): terms for terms in reversed(others)}
    most = exact.form.operations.total - 1
    programs = given.level.write_steps(given.form, [*several.values()], most)
    known = {
        name: measured(exact, replace(given, terms=terms, program=program))
        for (name, terms), program in zip(several.items(), programs, strict=False)
    }
    for factor, terms in zip(PATH_FACTORS, kept, strict=True):
        yield given if factor == 1.0 else known.get(frozenset(terms))


def _kept(exact: ExactDynamics, model: SimplifiedModel) -> Iterator[Terms]:
    """Terms kept for each factor, at 1 those of the model: one order of dropping, the model's terms last."""
    given = model.terms
    candidates = _candidates(exact.thinned(), model.level, model.accuracy.allowed, SWEEP * PATH_FACTORS[0])
    if candidates is None:
        yield from (given for _ in PATH_FACTORS)
        return
    effects, swept = candidates.flat, candidates.swept
    stays = np.array([term in given for term in candidates.terms])
    fitted = np.array([given.get(term, weight) / weight for term, weight in candidates.terms.items()])
    order = eliminate(candidates, last=stays).order
    listed = {term: weight for term, weight in given.items() if term not in candidates.terms}
    kept, scale = np.ones(len(effects), dtype=bool), np.ones(len(effects))
    lost = np.zeros(effects.shape[1])
    for factor in PATH_FACTORS:
        if factor >= 1.0 and scale is not fitted:
            kept, scale = stays.copy(), fitted
            lost = (1.0 - kept * scale) @ effects
        for k in order:
            if kept[k] and stays[k] == (factor > 1.0):
                trial = lost + scale[k] * effects[k]
                if np.abs(trial).max(initial=0.0) <= (factor - swept) / (1.0 - swept):
                    kept[k], lost = False, trial
        yield candidates.keep(kept, scale) | listed
