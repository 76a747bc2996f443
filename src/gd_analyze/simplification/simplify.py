"""The cheapest model within a torque error budget, or with limited operations, at any level."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.coordinates import in_worthwhile_velocities, shortest
from gd_analyze.simplification.element import ELEMENT, model_by_verdicts, require_no_budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.level import CandidateLevel
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model import (
    SimplifiedModel,
    exactly,
    measured,
    no_dearer,
    with_gamma,
    with_rewriting,
)
from gd_analyze.simplification.search import TermProgress, quick_count, selected_terms
from gd_analyze.simplification.torque_program import FINAL


@dataclass(frozen=True, kw_only=True)
class _OperationSearch:
    """The search for the multiple of the budget at which a model has few enough operations."""

    least_multiple: float = 1e-6  # smallest multiple of the budget
    unlimited_multiple: float = 1e12  # multiple at which a model keeps only what it must
    close_multiples: float = 1.02  # ratio of two multiples at which the search ends
    # Factor by which the multiple grows if the quick count promised too few operations.
    widening: float = 1.05
    refinements: int = 4  # full searches that refine the multiple
    # States that represent very many in a search among terms, which evaluates each thousands of times.
    most_states: int = 600


_BY_OPERATIONS = _OperationSearch()

_USUAL = SearchOptions()


def simplify_exact(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    options: SearchOptions = _USUAL,
    *,
    provenance: Mapping[str, str] | None = None,
    progress: TermProgress = None,
    stage: Callable[[str], object] = lambda _: None,
) -> SimplifiedModel:
    """Simplify so that the budget holds at given states, see `gd_analyze.simplify`.

    `progress` is called with the number of candidates dropped since the last call; `stage` with the name of a
    stage. TooManyTermsError if the level has too many terms for a search.
    """
    if options.level is ELEMENT:
        if budget is not None or options.operations is not None:
            require_no_budget(options.level, f"budget {budget}, operations {options.operations}")
        return replace(with_gamma(exact, model_by_verdicts(exact)), provenance=dict(provenance or {}))
    budget = Budget.of(budget)
    exact = exact.under(budget)
    stage(f"searching at level {options.level}")
    trials = in_worthwhile_velocities(exact, exact.allowed(budget), options)
    model = shortest([search_terms(trial, budget, options, progress) for trial in trials])
    return replace(model, provenance=dict(provenance or {}))


def search_terms(
    exact: ExactDynamics, budget: Budget, options: SearchOptions, progress: TermProgress = None
) -> SimplifiedModel:
    """Simplify as `simplify_exact` does at a level of terms, in the velocities of the exact dynamics."""
    return with_gamma(exact, _at_level(exact, budget, options, progress))


def _at_level(
    exact: ExactDynamics, budget: Budget, options: SearchOptions, progress: TermProgress
) -> SimplifiedModel:
    """Simplify at a level within a budget, or scale the budget until the model has few enough operations.

    A quick count estimates the factor; full searches then refine it.
    """
    operations, level = options.operations, options.level
    if operations is None:
        return _within(exact, budget, options, progress)
    allowed = exact.allowed(budget)
    if operations >= exact.form.operations.total:
        return exactly(exact, level, allowed, str(budget))
    thinned = exact.thinned()
    assert isinstance(level, CandidateLevel)  # other levels take no number of operations
    quick = quick_count(thinned, level, allowed)
    smallest_model = quick(_BY_OPERATIONS.unlimited_multiple)
    if smallest_model > operations:
        raise UsageError(
            f"no model of level {level} takes so few operations",
            where="operations",
            expected=f"{smallest_model} or more",
            found=str(operations),
            next_step="allow more, or take another level",
        )
    lower, upper = _BY_OPERATIONS.least_multiple, 1.0
    while quick(upper) > operations:
        lower, upper = upper, 2.0 * upper
    while upper / lower > _BY_OPERATIONS.close_multiples:
        middle = (lower * upper) ** 0.5
        lower, upper = (middle, upper) if quick(middle) > operations else (lower, middle)
    best = _within(exact, budget.scaled(upper), options, progress)
    while best.operations.total > operations:
        upper *= _BY_OPERATIONS.widening
        best = _within(exact, budget.scaled(upper), options, progress)
    step = 0.8
    for _ in range(_BY_OPERATIONS.refinements):
        trial = _within(exact, budget.scaled(upper * step), options)
        if trial.operations.total <= operations:
            best, upper = trial, upper * step
        else:
            step **= 0.5
    return best


def _within(
    exact: ExactDynamics, budget: Budget, options: SearchOptions, progress: TermProgress = None
) -> SimplifiedModel:
    """Find the model with the fewest operations within a budget."""
    allowed, level = exact.allowed(budget), options.level
    assert isinstance(level, CandidateLevel)
    options = replace(options, selections=[] if options.selections is None else options.selections)
    # A sample represents very many states. The worst of all states join it while they exceed the budget. The
    # margin shrinks each time, so that the loop ends.
    sample, margin = exact.thinned(_BY_OPERATIONS.most_states), 1.0
    while True:
        limit = margin * allowed
        outcome = selected_terms(sample, level, limit, options, progress)
        model = exactly(sample, level, limit, str(budget))
        model = replace(model, terms=outcome.terms, program=outcome.program, refitted=outcome.refitted)
        model = measured(sample, model.stating(replace(model.accuracy, steps=outcome.steps)))
        model = with_rewriting(model) if options.writing == FINAL else model
        model = model if options.dearer else no_dearer(sample, model)
        if sample is exact:
            break
        torque = model.torque(*exact.states.arrays)
        if (exact.errors_of(torque).counting <= allowed).all():
            model = model.stating(exact.held(replace(model.accuracy, allowed=allowed), torque))
            break
        off, weights = np.abs(torque - exact.torque), exact.states.weights
        worst = exact.states.at(np.unique((off if weights is None else off * weights).argmax(axis=0)))
        sample = sample.at(sample.states.joined_by(*worst.arrays, worst.weights))
        margin *= 0.98
    if not (model.accuracy.errors.counting <= allowed).all():
        expected, errors = (str(values.tolist()) for values in (allowed, model.accuracy.errors.counting))
        raise GdAnalyzeError(
            "the model misses its budget",
            expected=expected,
            found=errors,
            next_step="please report this with the arm file and the states",
        )
    if model.refitted and margin < 1.0:
        # A refit errs more at the states left out; keeping the budget there may cost more than it saves.
        without = _within(exact, budget, replace(options, refit=False, selections=None), progress)
        if without.operations_minimized.total <= model.operations_minimized.total:
            return without
    return model
