"""The cheapest model within a torque error budget: searched at few states, until it holds at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.coordinates import in_worthwhile_velocities, shortest
from gd_analyze.simplification.element import require_no_budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, with_gamma, with_rewriting
from gd_analyze.simplification.search import SearchOptions, TermProgress, selected_terms

# States that represent very many in a search, which evaluates each thousands of times.
MOST_SEARCHED = 600
MOST_ROUNDS = 20  # rounds after which the exact model stands for one that holds nowhere
# Rounds, after those of a check's patience, in which the budget of an exceeding joint shrinks slightly;
# later it shrinks by this power of the excess.
_SLIGHT_ROUNDS, _SLIGHT_SHARE, _SHRINK_POWER = 4, 0.96, 0.5
# Attempts of every round but the first, which continues the one before, as a share of the usual.
_CONTINUED_EFFORT = 0.25

USUAL = SearchOptions()


class Excess(NamedTuple):
    """Where a model exceeds its budget; without states it holds."""

    states: FloatArray  # q, qd and qdd that join the search, (3, M, n)
    weights: FloatArray  # what errors count there, see `States.weights`, (M, n)
    errors: FloatArray  # largest error of each joint, N m (N), shape (n,)


# Looks where a model exceeds its budget; also told the number of the round, from 0.
Check: TypeAlias = Callable[[SimplifiedModel, int], Excess]


class Searched(NamedTuple):
    """The outcome of a search."""

    model: SimplifiedModel
    sample: ExactDynamics  # at the states that the search looked at


def until_it_holds(
    first: ExactDynamics,
    budget: Budget,
    allowed: FloatArray,
    options: SearchOptions,
    checks: Sequence[Check],
    *,
    patience: int = 0,
    progress: TermProgress = None,
) -> Searched:
    """Search a model, look where it exceeds its budget, and search again with these states.

    Parameters
    ----------
    first
        Exact dynamics at the first states; very many are represented by some.
    budget, allowed
        The budget, and what it allows each joint, N m (N), shape (n,).
    options
        Level and effort. A search that ends with too many terms, see `SearchOptions.most_terms`, is the last.
    checks
        Asked one after another until one finds an excess.
    patience
        Rounds in which the budget of an exceeding joint does not shrink.
    progress
        Called with the number of terms dropped since the last call.

    Returns
    -------
    Searched
        The exact model if none that saves operations holds.
    """
    sample, share, start = first.thinned(MOST_SEARCHED), np.ones(len(allowed)), None
    everything = exactly(sample, options.level, allowed, str(budget))
    for turn in range(MOST_ROUNDS):
        effort = options.effort * (1.0 if start is None else _CONTINUED_EFFORT)
        search = selected_terms(sample, share * allowed, replace(options, effort=effort), start, progress)
        start = search.terms
        model = replace(everything, terms=search.terms)
        model = measured(sample, model.stating(replace(everything.accuracy, steps=search.steps)))
        model = with_gamma(sample, with_rewriting(model))
        if not model.saves or len(model.terms) > options.most_terms:
            return Searched(model, sample)
        excess = next((e for e in (check(model, turn) for check in checks) if e.states.size), None)
        if excess is None:
            return Searched(model, sample)
        sample = sample.joined_by(excess.states, excess.weights)
        exceeds = excess.errors > allowed
        needed = np.where(exceeds, 0.98 * allowed / np.where(exceeds, excess.errors, 1.0), 1.0)
        if turn >= patience + _SLIGHT_ROUNDS:
            share = share * needed**_SHRINK_POWER
        elif turn >= patience:
            share = np.where(exceeds, np.minimum(share, _SLIGHT_SHARE), share)
    return Searched(everything, sample)


def at_states(exact: ExactDynamics, allowed: FloatArray) -> Check:
    """Look at given states: the worst of every joint that exceeds its budget there joins the search."""
    states = exact.states
    weights = np.ones(states.q.shape) if states.weights is None else states.weights

    def check(model: SimplifiedModel, turn: int) -> Excess:
        torque = model.torque(*states.arrays)
        errors = exact.errors_of(torque).counting
        worst = (np.abs(torque - exact.torque) * weights).argmax(axis=0)
        joining = np.unique(worst[errors > allowed])
        return Excess(np.stack(states.arrays)[:, joining], weights[joining], errors)

    return check


def simplify_exact(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    options: SearchOptions = USUAL,
    *,
    everywhere: Sequence[Check] = (),
    provenance: Mapping[str, str] | None = None,
    progress: TermProgress = None,
    stage: Callable[[str], object] = lambda _: None,
) -> SimplifiedModel:
    """Simplify so that the budget holds at given states, see `gd_analyze.simplify`.

    `everywhere` looks at further states; `progress` is called with the number of terms dropped since the last
    call; `stage` with the name of a stage. TooManyTermsError if the level has too many terms for a search.
    """
    require_no_budget(options.level, f"budget {budget}")
    budget = Budget.of(budget)
    exact = exact.under(budget)
    allowed = exact.allowed(budget)
    stage(f"searching at level {options.level}")
    models = []
    for trial in in_worthwhile_velocities(exact, allowed, options):
        checks = [at_states(trial, allowed), *everywhere]
        models.append(until_it_holds(trial, budget, allowed, options, checks, progress=progress).model)
    return stated(exact, shortest(models)).stating(provenance=provenance)


def stated(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """State errors and gamma at given states; the exact model stands for one that saves nothing."""
    exact, accuracy = exact.with_form(model.form), model.accuracy
    if not model.saves:
        return with_gamma(exact, exactly(exact, model.level, accuracy.allowed, accuracy.budget))
    accuracy = replace(accuracy, fitted_on=exact.states.described)
    return with_gamma(exact, measured(exact, model.stating(accuracy)))
