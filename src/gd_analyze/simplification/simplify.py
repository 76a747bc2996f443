"""The cheapest model within a torque error budget: searched at few states, until it holds at all."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple, TypeAlias

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import warn_caller
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import require_few_terms
from gd_analyze.simplification.coordinates import in_cheaper_velocities
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, with_gamma, with_rewriting
from gd_analyze.simplification.search import SearchOptions, selected_terms
from gd_analyze.simplification.search_time import SearchTime
from gd_analyze.simplification.torque_program import COUNTING

# States that represent very many in a search, which evaluates each thousands of times.
MOST_SEARCHED = 600
# Rounds after which the exact model stands for one that holds nowhere.
MOST_ROUNDS = 40
# Share of the budget that a search keeps: its sums are rounded otherwise than a program's.
_SEARCHED_SHARE = 1.0 - 1e-6
# Times that an excess may be found in a region, after those of its patience, before the budget of an
# exceeding joint shrinks by a power of the excess; until then it shrinks slightly.
_SLIGHT_TIMES, _SLIGHT_SHARE, _SHRINK_POWER = 4, 0.96, 0.5
# Ratio of a draft's operations to the exact ones above which no more is searched: the final program takes a
# fifth fewer at most, and more states only add terms.
_HOPELESS_RATIO = 1.25
# Attempts of every round after the first, which continues the one before, as a share of the usual.
_CONTINUED_EFFORT = 0.125

USUAL = SearchOptions()


class Excess(NamedTuple):
    """Where a model exceeds its budget; without states it holds."""

    states: FloatArray  # q, qd and qdd that join the search, (3, M, n)
    weights: FloatArray  # what errors count there, see `States.weights`, (M, n)
    errors: FloatArray  # largest error of each joint, N m (N), shape (n,)
    is_of_region: bool = False  # found in a region, of which no few states tell all


# Looks where a model exceeds its budget; also told the number of the round, from 0.
Check: TypeAlias = Callable[[SimplifiedModel, int], Excess]


class Searched(NamedTuple):
    """The outcome of a search."""

    model: SimplifiedModel
    sample: ExactDynamics  # at the states that the search looked at
    is_cut: bool = False  # whether its time ended it


def until_it_holds(
    first: ExactDynamics,
    budget: Budget,
    allowed: FloatArray,
    options: SearchOptions,
    checks: Sequence[Check],
    *,
    proof: Check | None = None,
    patience: int = 0,
) -> Searched:
    """Search a model, look where it exceeds its budget, and search again with these states.

    Parameters
    ----------
    first
        Exact dynamics at the first states; very many are represented by some.
    budget, allowed
        The budget, and what it allows each joint, N m (N), shape (n,).
    options
        Level, effort and time. A search that ends with too many terms, see `SearchOptions.most_terms`, is the
        last.
    checks
        Asked one after another until one finds an excess. The more often it is found in a region, the smaller
        a budget the search is given.
    proof
        Asked last, of a model in its final program in which no check finds an excess.
    patience
        Times that an excess may be found in a region before the budget of an exceeding joint shrinks.

    Returns
    -------
    Searched
        The exact model if none that saves operations holds, or was found in time.
    """
    sample, start = first.thinned(MOST_SEARCHED), None
    share, times = np.full(len(allowed), _SEARCHED_SHARE), 0
    everything = exactly(sample, options.level, allowed, str(budget))
    most_operations = _HOPELESS_RATIO * everything.operations_minimized.total
    for turn in range(MOST_ROUNDS):
        if options.time.is_over:
            break
        is_closing = options.time.is_closing
        effort = options.effort * (_CONTINUED_EFFORT if turn else 1.0)
        round_options = replace(options, effort=effort, thorough=options.thorough and not is_closing)
        search = selected_terms(sample, share * allowed, round_options, start)
        if search.steps[-1].operations > most_operations:
            return Searched(everything, sample)
        start = search.terms
        model = replace(everything, terms=search.terms)
        model = model.stating(replace(everything.accuracy, steps=search.steps))
        is_long = len(model.terms) > COUNTING
        looked_at = with_gamma(sample, model.drafted() if is_long else model)
        if len(model.terms) > options.most_terms:
            return Searched(looked_at, sample, is_closing)
        excess = _first_excess(looked_at, turn, checks)
        if excess is None and is_long:
            # What holds is written in few operations, and looked at once more.
            looked_at = with_gamma(sample, model)
            excess = _first_excess(looked_at, turn, checks) if model.saves else None
        if excess is None and proof is not None and looked_at.saves:
            excess = _first_excess(looked_at, turn, [proof])
        if excess is None:
            return Searched(looked_at, sample, is_closing)
        sample = sample.joined_by(excess.states, excess.weights)
        if excess.is_of_region or is_closing:
            exceeds = excess.errors > allowed
            needed = np.where(exceeds, 0.98 * allowed / np.where(exceeds, excess.errors, 1.0), 1.0)
            if is_closing:
                share = share * needed
            elif times >= patience + _SLIGHT_TIMES:
                share = share * needed**_SHRINK_POWER
            elif times >= patience:
                share = np.where(exceeds, np.minimum(share, _SLIGHT_SHARE), share)
            times += 1
    return Searched(everything, sample, options.time.is_closing)


def _first_excess(model: SimplifiedModel, turn: int, checks: Sequence[Check]) -> Excess | None:
    """Where the first check that finds any says that a model exceeds its budget."""
    return next((excess for excess in (check(model, turn) for check in checks) if excess.states.size), None)


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
    budget: Budget | str | float | None = None,
    options: SearchOptions = USUAL,
    *,
    everywhere: Sequence[Check] = (),
    provenance: Mapping[str, str] | None = None,
    progress: Progress = NO_PROGRESS,
) -> SimplifiedModel:
    """Simplify so that the budget holds at given states, see `gd_analyze.simplify`.

    `everywhere` looks at further states. TooManyTermsError if the level has too many terms for a search.
    """
    require_few_terms(exact, options.level)
    budget = Budget.of(budget)
    exact = exact.under(budget)
    allowed = exact.allowed(budget)
    progress.stage(options.stage)
    exact = in_cheaper_velocities(exact, allowed, options)
    outcome = until_it_holds(exact, budget, allowed, options, [at_states(exact, allowed), *everywhere])
    model = stated(exact, outcome.model)
    warn_of_time(model, outcome, options.time)
    return model.stating(provenance=provenance)


def warn_of_time(model: SimplifiedModel, outcome: Searched, time: SearchTime) -> None:
    """Warn that time ended the search of a model."""
    if not outcome.is_cut:
        return
    budget, ended = model.accuracy.budget, f"{time.seconds:g} s of processor time ended the search"
    text = f"budget {budget}: {ended}; a longer one may find a model of fewer terms"
    if not model.saves:
        text = f"budget {budget}: {ended} and no model was found that holds: the exact torque stands for it"
    warn_caller(text)


def stated(exact: ExactDynamics, model: SimplifiedModel) -> SimplifiedModel:
    """State errors and gamma at given states; the exact model stands for one that saves nothing."""
    exact, accuracy = exact.with_form(model.form), model.accuracy
    if not model.saves:
        return with_gamma(exact, exactly(exact, model.level, accuracy.allowed, accuracy.budget))
    accuracy = replace(accuracy, fitted_on=exact.states.described)
    return with_gamma(exact, measured(exact, with_rewriting(model.stating(accuracy))))
