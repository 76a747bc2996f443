"""One model at smaller and larger budgets: the terms that it gains and loses on the way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import TooManyTermsError, candidates_of
from gd_analyze.simplification.effort import POINT
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import CandidateLevel, Terms
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured
from gd_analyze.simplification.pruning import pruned_path
from gd_analyze.simplification.selection import Choice, Selection, SelectionSettings, descend

# Factors of a path: from a tenth of the budget to ten times it, ten steps to each side.
PATH_FACTORS = tuple(10.0 ** (step / 10) for step in range(-10, 11))
# A search in a recursion is slow, for a smaller budget as slow as for the model itself: it is done for one in
# this many of a path's larger budgets, and for no recursion of more operations: minutes.
_APART, _LONGEST = 5, 700
# States that represent a longer motion.
_STATES = 300
# Budgets far below the model's keep many terms: they are dropped in larger portions.
_PORTIONS = SelectionSettings(at_once=0.02)


def joined_path(
    path: Sequence[SimplifiedModel], others: Sequence[SimplifiedModel]
) -> tuple[tuple[SimplifiedModel, ...], tuple[int, ...]]:
    """Other models among those of a path, by their number of terms; also the place of each of these."""
    models = list(path)
    for other in others:
        fewer = (k for k, model in enumerate(models) if len(model.terms) < len(other.terms))
        models.insert(next(fewer, len(models)), other)
    places = {id(model): place for place, model in enumerate(models)}
    return tuple(models), tuple(places[id(other)] for other in others)


def budget_path(exact: ExactDynamics, budget: Budget, given: SimplifiedModel) -> tuple[SimplifiedModel, ...]:
    """Follow a model to smaller and larger budgets: one per factor of `PATH_FACTORS`, within that budget.

    For larger budgets no term returns, and no step is restored. Where a smaller budget would keep too many
    terms to choose from, the exact torque stands for its model.
    """
    everything = exactly(exact, given.level, given.accuracy.allowed, str(budget))
    if isinstance(given.level, CandidateLevel):
        trials = _along_terms(exact, given)
    else:
        trials = _along_steps(exact, given)
    last, models = everything, []
    for factor, trial in zip(PATH_FACTORS, trials, strict=True):
        allowed = factor * given.accuracy.allowed
        if trial is not None and _may_follow(last, trial, given, allowed):
            last = trial
        accuracy = replace(last.accuracy, allowed=allowed, budget=str(budget.scaled(factor)))
        models.append(replace(last, accuracy=accuracy))
    return tuple(models)


def _may_follow(
    last: SimplifiedModel, trial: SimplifiedModel, given: SimplifiedModel, allowed: FloatArray
) -> bool:
    """Whether a model is within its budget, and takes fewer terms, or fewer operations in a recursion."""
    if trial is given:
        return True
    if not (trial.accuracy.errors.counting <= allowed).all():
        return False
    if isinstance(trial.level, CandidateLevel):
        return len(trial.terms) < len(last.terms)
    return trial.operations.total < last.operations.total


def _along_terms(exact: ExactDynamics, given: SimplifiedModel) -> Iterator[SimplifiedModel | None]:
    """Models that keep fewer and fewer terms; None where too many would remain."""
    known: dict[frozenset[object], SimplifiedModel] = {frozenset(given.terms): given}
    for terms in (*_smaller(exact, given), given.terms, *_larger(exact, given)):
        if terms is None:
            yield None
            continue
        key = frozenset(terms)
        if key not in known:
            program = given.level.write(given.form, terms, POINT)
            known[key] = measured(exact, replace(given, terms=terms, program=program))
        yield known[key]


def _smaller(exact: ExactDynamics, given: SimplifiedModel) -> Iterator[Terms | None]:
    """Terms for each smaller budget: the model's, and those that it needs to err less."""
    assert isinstance(given.level, CandidateLevel)
    factors = [factor for factor in PATH_FACTORS if factor < 1.0]
    selection = candidates = None
    for factor in factors:
        if candidates is None:
            allowed = factor * given.accuracy.allowed
            try:
                candidates = candidates_of(exact.thinned(_STATES), given.level, allowed, also=given.terms)
            except TooManyTermsError:
                yield None
                continue
            selection, first = candidates.selection(), factor
            stays = candidates.selection(given.terms).selected
        assert selection is not None
        descend(selection, stays, _PORTIONS, limit=factor / first)
        yield candidates.chosen(selection.selected)


def _larger(exact: ExactDynamics, given: SimplifiedModel) -> Iterator[Terms]:
    """Terms for each larger budget: fewer and fewer of the model's, with their coefficients."""
    level, form, some = given.level, given.form, exact.thinned(_STATES)
    assert isinstance(level, CandidateLevel)
    listed, allowed = list(given.terms), given.accuracy.allowed
    torque = given.torque(*some.states.arrays)
    base = (some.torque - torque).T / allowed[:, None]
    if some.states.weights is not None:
        base = base * some.states.weights.T
    effects = level.term_torques(form, given.terms).at(some.states).over(allowed)
    needed = level.indispensable(form, listed)
    stays = np.array([term in needed for term in listed], dtype=bool)
    selection = Selection(
        Choice(effects, base, level.costs(form, listed, 0)), np.ones(len(listed), dtype=bool)
    )
    for factor in PATH_FACTORS:
        if factor > 1.0:
            descend(selection, stays, limit=factor)
            yield {
                term: given.terms[term]
                for term, is_in in zip(listed, selection.selected, strict=True)
                if is_in
            }


def _along_steps(exact: ExactDynamics, given: SimplifiedModel) -> Iterator[SimplifiedModel | None]:
    """Models with more and more simplified steps: the given one, and some beyond it."""
    some, allowed = exact.thinned(), given.accuracy.allowed
    is_long = exact.form.operations.total > _LONGEST
    larger = [] if is_long else PATH_FACTORS[PATH_FACTORS.index(1.0) + _APART :: _APART]
    known = {1.0: given}
    models = pruned_path(some, [factor * allowed for factor in larger], given.terms)
    for factor, model in zip(larger, models, strict=True):
        known[factor] = measured(exact, replace(given, terms=model.terms, program=model.program))
    yield from (known.get(factor) for factor in PATH_FACTORS)
