"""One model at smaller and larger budgets: the terms that it gains and loses on the way."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace

import numpy as np

from gd_analyze.simplification.budget import BUDGET_FACTORS, Budget
from gd_analyze.simplification.candidates import (
    MANY_TERMS,
    TooManyTermsError,
    candidates_of,
    costs_together,
    numbers_of,
    of_any,
)
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.harmonic import HarmonicLevel
from gd_analyze.simplification.level import Terms
from gd_analyze.simplification.model import SimplifiedModel, measured
from gd_analyze.simplification.selection import Selection, TermChoice, descend

_SMALLER = tuple(factor for factor in BUDGET_FACTORS if factor < 1.0)
_LARGER = tuple(factor for factor in BUDGET_FACTORS if factor > 1.0)
_MOST_STATES = 300  # states that represent a longer motion

# Budgets far below the model's keep many terms: they are dropped in larger portions.
_AT_ONCE = 0.02


def joined_path(
    path: Sequence[SimplifiedModel], further_models: Sequence[SimplifiedModel]
) -> tuple[tuple[SimplifiedModel, ...], tuple[int, ...]]:
    """Insert further models into a path, by their number of terms; also return the place of each of them.

    They take the place of the path's own models of the same budgets.
    """
    budgets = {model.accuracy.budget for model in further_models}
    models = [model for model in path if model.accuracy.budget not in budgets]
    for further in further_models:
        fewer = (k for k, model in enumerate(models) if len(model.terms) < len(further.terms))
        models.insert(next(fewer, len(models)), further)
    places = {id(model): place for place, model in enumerate(models)}
    return tuple(models), tuple(places[id(further)] for further in further_models)


def budget_path(exact: ExactDynamics, budget: Budget, model: SimplifiedModel) -> tuple[SimplifiedModel, ...]:
    """Follow a model to smaller and larger budgets, and return the models by growing budget.

    For larger budgets no term returns. Budgets are those of `BUDGET_FACTORS`, but for the smallest where an
    arm of very many terms would keep too many to choose from.
    """
    if not model.has_terms:
        return (model,)  # parts of elements stand alone
    exact, models = exact.with_form(model.form), list[SimplifiedModel]()
    for factor, trial in _along_terms(exact, model):
        allowed = factor * model.accuracy.allowed
        if trial is not model and not (trial.accuracy.errors.counting <= allowed).all():
            if not models:
                continue
            trial = models[-1]
        accuracy = replace(trial.accuracy, allowed=allowed, budget=str(budget.scaled(factor)))
        models.append(trial.stating(accuracy))
    return tuple(models)


def _along_terms(exact: ExactDynamics, model: SimplifiedModel) -> Iterator[tuple[float, SimplifiedModel]]:
    """Models that keep fewer and fewer terms, and their multiples of the budget."""
    models: dict[frozenset[object], SimplifiedModel] = {frozenset(model.terms): model}
    for factor, terms in (*_smaller(exact, model), (1.0, model.terms), *_larger(exact, model)):
        key = frozenset(terms)
        if key not in models:
            models[key] = measured(exact, replace(model, terms=terms))
        yield factor, models[key]


def _smaller(exact: ExactDynamics, model: SimplifiedModel) -> Iterator[tuple[float, Terms]]:
    """Terms for each smaller budget: the model's, and those that it needs to err less."""
    thinned = exact.thinned(_MOST_STATES)
    for smallest in _SMALLER:
        with suppress(TooManyTermsError):
            candidates = candidates_of(
                thinned, model.level, smallest * model.accuracy.allowed, included=model.terms
            )
            if len(candidates) <= max(MANY_TERMS, len(model.terms)):
                break
    else:
        return
    selection, stays = candidates.selection(), candidates.selection(model.terms).selected
    for factor in _SMALLER:
        if factor < smallest:
            continue
        descend(selection, stays, limit=factor / smallest, at_once=_AT_ONCE)
        yield factor, candidates.chosen(selection.selected)


def _larger(exact: ExactDynamics, model: SimplifiedModel) -> Iterator[tuple[float, Terms]]:
    """Terms for each larger budget: fewer and fewer of the model's, with their coefficients."""
    level, form, thinned = model.level, model.form, exact.thinned(_MOST_STATES)
    assert isinstance(level, HarmonicLevel)
    listed, allowed = list(model.terms), model.accuracy.allowed
    numbers = numbers_of(level, form, listed)
    torque = model.torque(*thinned.states.arrays)
    base = (thinned.torque - torque).T / allowed[:, None]
    if thinned.states.weights is not None:
        base = base * thinned.states.weights.T
    effects = level.term_torques(form, model.terms, numbers).at(thinned.states).effects().over(allowed)
    choice = TermChoice(effects, base, costs_together(level.costs(form, listed, 0), numbers))
    stays = of_any(level.indispensable(form, listed), listed, numbers)
    selection = Selection(choice, np.ones(len(choice), dtype=bool))
    for factor in _LARGER:
        descend(selection, stays, limit=factor)
        rows = np.flatnonzero(selection.selected[numbers]).tolist()
        yield factor, {listed[row]: model.terms[listed[row]] for row in rows}
