"""The smallest model within a budget, or the best one of so many operations, at one level."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.simplification import dropping, pruned
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_model import exactly, measured, no_dearer
from gd_analyze.simplification.level import CandidateLevel, Level
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search import Progress
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.within_norm import within_norm

# --operations: the smallest multiple of the budget, and by what it is widened where a quick count promised
# too much. How close it is searched, and how often tightened then: among candidates, and in a recursion, of
# which every count takes seconds.
_LEAST, _WIDER = 1e-6, 1.05
_CLOSE, _CLOSE_IN_RECURSION = (1.02, 4), (1.1, 1)


def at_level(
    exact: ExactDynamics, budget: Budget, level: Level, how: SearchOptions, progress: Progress = None
) -> SimplifiedModel:
    """Simplify at a level, whatever `how` says of it; exact dynamics as they are `ExactDynamics.under` it."""
    if how.operations is None:
        return _within(exact, budget, level, how, progress)
    return _of_few_operations(exact, budget, level, how, how.operations, progress)


def _within(
    exact: ExactDynamics, budget: Budget, level: Level, how: SearchOptions, progress: Progress = None
) -> SimplifiedModel:
    """Search under what the budget allows every joint; or, of the norm, under what keeps that."""

    def search(
        exact: ExactDynamics,
        allowed: FloatArray,
        thorough: bool = True,
        start: SimplifiedModel | None = None,
    ) -> SimplifiedModel:
        # Written shortly, one that takes more operations than exact may still take fewer.
        trial = how if thorough else replace(how, thorough=False, write=False, dearer=True)
        return _within_allowed(exact, allowed, str(budget), level, trial, progress, start)

    allowed = exact.allowed(budget)
    if budget.norm is None:
        return _required(search(exact, allowed), allowed)
    return within_norm(exact, budget, search, exactly(exact, level, allowed, str(budget)))


def _within_allowed(
    exact: ExactDynamics,
    allowed: FloatArray,
    budget: str,
    level: Level,
    how: SearchOptions,
    progress: Progress,
    start: SimplifiedModel | None,
) -> SimplifiedModel:
    """Search on some of the states if there are very many; those that break the budget join them."""
    known, margin = exact.thinned(), 1.0  # what is added counts a little more every time, so it ends
    while True:
        model = _searched(known, margin * allowed, budget, level, how, progress, start)
        if known is exact:
            return model
        torque = model.torque(*exact.states.arrays)
        if (exact.errors_of(torque).counting <= allowed).all():
            return replace(model, accuracy=exact.held(replace(model.accuracy, allowed=allowed), torque))
        off, weights = np.abs(torque - exact.torque), exact.states.weights
        worst = exact.states.at(np.unique((off if weights is None else off * weights).argmax(axis=0)))
        known = known.at(known.states.joined_by(*worst.arrays, worst.weights))
        margin *= 0.98


def _searched(
    exact: ExactDynamics,
    allowed: FloatArray,
    budget: str,
    level: Level,
    how: SearchOptions,
    progress: Progress,
    start: SimplifiedModel | None,
) -> SimplifiedModel:
    if isinstance(level, CandidateLevel):
        found = dropping.dropped(exact, level, allowed, how, progress)
    else:
        found = pruned.pruned(exact, allowed, how, progress, None if start is None else start.terms)
    everything = exactly(exact, level, allowed, budget)
    accuracy = replace(everything.accuracy, steps=found.steps, solved=found.solved, cut_short=found.cut_short)
    model = measured(
        exact,
        replace(
            everything,
            terms=found.terms,
            program=found.program,
            refitted=found.refitted,
            accuracy=accuracy,
        ),
    )
    return model if how.dearer else no_dearer(exact, model)


def _required(model: SimplifiedModel, allowed: FloatArray) -> SimplifiedModel:
    """Refuse a model that misses what was allowed: a search that does so is at fault."""
    if not (model.accuracy.errors.counting <= allowed).all():
        raise GdAnalyzeError(
            "the simplified model misses its budget",
            expected=str(allowed.tolist()),
            found=str(model.accuracy.errors.counting.tolist()),
            next_step="please report this with the arm file and the states",
        )
    return model


def _of_few_operations(
    exact: ExactDynamics,
    budget: Budget,
    level: Level,
    how: SearchOptions,
    operations: int,
    progress: Progress,
) -> SimplifiedModel:
    """Scale the budget until the model takes no more operations than asked for.

    A quick count tells about where; whole searches then close in from there.
    """
    allowed = exact.allowed(budget)
    if operations >= exact.form.operations.total:
        return exactly(exact, level, allowed, str(budget))
    some = exact.thinned()
    if isinstance(level, CandidateLevel):
        quick, (close, attempts) = dropping.quick_count(some, level, allowed), _CLOSE
    else:
        quick, (close, attempts) = pruned.quick_count(some, allowed), _CLOSE_IN_RECURSION
    few, many = _LEAST, 1.0
    while quick(many) > operations:
        few, many = many, 2.0 * many
    while many / few > close:
        middle = (few * many) ** 0.5
        few, many = (middle, many) if quick(middle) > operations else (few, middle)
    best = _within(exact, budget.scaled(many), level, how, progress)
    while best.operations.total > operations:
        many *= _WIDER
        best = _within(exact, budget.scaled(many), level, how, progress)
    step = 0.8
    for _ in range(attempts):
        trial = _within(exact, budget.scaled(many * step), level, how)
        if trial.operations.total <= operations:
            best, many = trial, many * step
        else:
            step **= 0.5
    return best
