"""The cheapest model within a torque error budget, or with limited operations, at any level."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.pool import GivenMotions
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import MOST_STATES, ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import CandidateLevel, Level
from gd_analyze.simplification.levels import SearchOptions, level_named
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, no_dearer, with_gamma
from gd_analyze.simplification.pruning import pruned, quick_pruned_count
from gd_analyze.simplification.search import Progress, quick_count, selected_terms
from gd_analyze.simplification.verdicts import model_by_verdicts, require_no_budget
from gd_analyze.text import SINE_PRICE

if TYPE_CHECKING:
    import xarray as xr

# --operations: the smallest multiple of the budget, and its growth if a quick count promised too much.
# Resolution of the search, and number of refinements: among candidates, and in a recursion, with slow counts.
_LEAST, _WIDER = 1e-6, 1.05
_CLOSE, _CLOSE_IN_RECURSION = (1.02, 4), (1.1, 1)
# States that represent very many in a search among terms, which evaluates each thousands of times.
_STATES = 600
_USUAL = SearchOptions()


def simplify(
    arm: RobotArm | str | Path,
    states: States | GivenMotions | xr.Dataset,
    budget: Budget | str | None = None,
    *,
    level: str | Level = TERM,
    refit: bool = False,
    operations: int | None = None,
    drives: bool | None = None,
    effort: float = 1.0,
    sine_price: int = SINE_PRICE,
) -> SimplifiedModel:
    """Find the model with the fewest operations within a torque error budget.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    states
        States over which the budget holds: the set points of a trajectory (also by shipped name or path), or
        of several, with the budget kept on each; their decomposition; or drawn states, see `states_in_box`.
    budget
        Allowed torque error per joint, or its text such as "1% or 10% friction", see `Budget.parse`; by
        default 1 % of each joint's peak torque over the states.
    level
        "term" drops single torque terms; "energy" drops terms of the energies, so that the model stays a
        mechanical system; "element" keeps the dominant effects of D_ij and h_i, the founding text's
        method: it is written without a search, takes no budget, and states its error as one;
        "recursive" simplifies steps of the Newton-Euler recursion, for arms with many terms.
    refit
        Change kept coefficients to compensate for dropped ones.
    operations
        Most multiplications and additions of the model; the budget is scaled to the smallest that allows it.
    effort
        Length of the search relative to the usual one, which is about a minute at most.
    drives
        Include drive inertia, or take the links alone; by default it is included if the arm describes
        drives, see `ExactDynamics.of`.
    sine_price
        Multiplications and additions that a sine or cosine counts as when models are compared; with 0 only
        multiplications and additions are minimized.

    Returns
    -------
    SimplifiedModel
        Its largest error over the states, measured on its own program, is within the budget. If this takes as
        many operations as the exact torque, it is the exact model. Its `notice` names joints whose budget is
        below friction or torque uncertainty.

    Raises
    ------
    UsageError
        If the budget is not understood, does not fit the number of joints, or is a share of a number that the
        arm does not state; or if the level has nothing to refit.
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> arm = gd.load_arm("two_link")
    >>> model = gd.simplify(arm, gd.read_trajectory("two-link-swing", arm), "1%")
    >>> bool((model.accuracy.errors.largest_share <= 0.01).all())
    True
    """
    how = SearchOptions(level_named(level), refit, operations, effort=effort, sine_price=sine_price)
    return simplify_exact(ExactDynamics.of(arm, states, drives), budget, how)


def simplify_exact(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    how: SearchOptions = _USUAL,
    *,
    provenance: Mapping[str, str] | None = None,
    progress: Progress = None,
    stage: Callable[[str], object] = lambda _: None,
) -> SimplifiedModel:
    """Simplify given exact dynamics, see `simplify`.

    `progress` is called with the number of candidates dropped, or of operations saved, since the last call;
    `stage` with the name of a stage. TooManyTermsError if the level has too many terms for a search.
    """
    if how.level is ELEMENT:
        if budget is not None or how.operations is not None:
            require_no_budget(how.level, f"budget {budget}, operations {how.operations}")
        return replace(with_gamma(exact, model_by_verdicts(exact)), provenance=dict(provenance or {}))
    budget = Budget.of(budget)
    exact = exact.under(budget)
    stage(f"searching at level {how.level}")
    model = with_gamma(exact, _at_level(exact, budget, how, progress))
    return replace(model, provenance=dict(provenance or {}))


def _at_level(
    exact: ExactDynamics, budget: Budget, how: SearchOptions, progress: Progress
) -> SimplifiedModel:
    """Simplify at a level within a budget, or scale the budget until the model has few enough operations.

    A quick count estimates the factor; full searches then refine it.
    """
    operations, level = how.operations, how.level
    if operations is None:
        return _within(exact, budget, how, progress)
    allowed = exact.allowed(budget)
    if operations >= exact.form.operations.total:
        return exactly(exact, level, allowed, str(budget))
    some = exact.thinned()
    if isinstance(level, CandidateLevel):
        quick, (close, attempts) = quick_count(some, level, allowed), _CLOSE
    else:
        quick, (close, attempts) = quick_pruned_count(some, allowed), _CLOSE_IN_RECURSION
    few, many = _LEAST, 1.0
    while quick(many) > operations:
        few, many = many, 2.0 * many
    while many / few > close:
        middle = (few * many) ** 0.5
        few, many = (middle, many) if quick(middle) > operations else (few, middle)
    best = _within(exact, budget.scaled(many), how, progress)
    while best.operations.total > operations:
        many *= _WIDER
        best = _within(exact, budget.scaled(many), how, progress)
    step = 0.8
    for _ in range(attempts):
        trial = _within(exact, budget.scaled(many * step), how)
        if trial.operations.total <= operations:
            best, many = trial, many * step
        else:
            step **= 0.5
    return best


def _within(
    exact: ExactDynamics, budget: Budget, how: SearchOptions, progress: Progress = None
) -> SimplifiedModel:
    """Find the model with the fewest operations within a budget."""
    allowed, level = exact.allowed(budget), how.level
    how = replace(how, way=[] if how.way is None else how.way)
    # Very many states are represented by some; those that exceed the budget are added, each time with a
    # slightly larger weight, so that it ends.
    known, margin = exact.thinned(_STATES if isinstance(level, CandidateLevel) else MOST_STATES), 1.0
    while True:
        most = margin * allowed
        if isinstance(level, CandidateLevel):
            found = selected_terms(known, level, most, how, progress)
        else:
            found = pruned(known, most, how, progress)
        model = exactly(known, level, most, str(budget))
        done = replace(model.accuracy, steps=found.steps, cut_short=found.cut_short)
        model = replace(model, terms=found.terms, program=found.program, refitted=found.refitted)
        model = measured(known, replace(model, accuracy=done))
        model = model if how.dearer else no_dearer(known, model)
        if known is exact:
            break
        torque = model.torque(*exact.states.arrays)
        if (exact.errors_of(torque).counting <= allowed).all():
            model = replace(model, accuracy=exact.held(replace(model.accuracy, allowed=allowed), torque))
            break
        off, weights = np.abs(torque - exact.torque), exact.states.weights
        worst = exact.states.at(np.unique((off if weights is None else off * weights).argmax(axis=0)))
        known = known.at(known.states.joined_by(*worst.arrays, worst.weights))
        margin *= 0.98
    if not (model.accuracy.errors.counting <= allowed).all():
        expected, errors = (str(values.tolist()) for values in (allowed, model.accuracy.errors.counting))
        what, next_step = "the model misses its budget", "please report this with the arm file and the states"
        raise GdAnalyzeError(what, expected=expected, found=errors, next_step=next_step)
    return model
