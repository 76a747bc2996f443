"""The cheapest model within a torque error budget, at any level."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.coordinates import in_worthwhile_velocities, shortest
from gd_analyze.simplification.element import ELEMENT, model_by_verdicts, require_no_budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import (
    SimplifiedModel,
    exactly,
    measured,
    no_dearer,
    with_gamma,
    with_rewriting,
)
from gd_analyze.simplification.search import SearchOptions, TermProgress, selected_terms
from gd_analyze.simplification.torque_program import FINAL

# States that represent very many in a search among terms, which evaluates each thousands of times.
_MOST_STATES = 600

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
        if budget is not None:
            require_no_budget(options.level, f"budget {budget}")
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
    return with_gamma(exact, _within(exact, budget, options, progress))


def _within(
    exact: ExactDynamics, budget: Budget, options: SearchOptions, progress: TermProgress = None
) -> SimplifiedModel:
    """Find the model with the fewest operations within a budget."""
    allowed = exact.allowed(budget)
    options = replace(options, selections=[] if options.selections is None else options.selections)
    # A sample represents very many states. The worst of all states join it while they exceed the budget. The
    # margin shrinks each time, so that the loop ends.
    sample, margin = exact.thinned(_MOST_STATES), 1.0
    while True:
        limit = margin * allowed
        outcome = selected_terms(sample, limit, options, progress)
        model = exactly(sample, options.level, limit, str(budget))
        model = replace(model, terms=outcome.terms, program=outcome.program)
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
    return model
