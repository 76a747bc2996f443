"""The cheapest model within a torque error budget, or with limited operations, at any level."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.motions.pool import GivenMotions
from gd_analyze.motions.states import States
from gd_analyze.operations.angles import priced
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import LevelTried
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.exact import ExactDynamics, too_many_terms
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import CandidateLevel, Level
from gd_analyze.simplification.levels import SearchOptions, level_named
from gd_analyze.simplification.model import SimplifiedModel, exactly, measured, no_dearer
from gd_analyze.simplification.pruning import pruned, quick_pruned_count
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search import Progress, dropped, quick_count
from gd_analyze.text import SINE_PRICE

if TYPE_CHECKING:
    import xarray as xr

# --operations: the smallest multiple of the budget, and its growth if a quick count promised too much.
# Resolution of the search, and number of refinements: among candidates, and in a recursion, with slow counts.
_LEAST, _WIDER = 1e-6, 1.05
_CLOSE, _CLOSE_IN_RECURSION = (1.02, 4), (1.1, 1)
# If terms take less than this share of the exact torque's operations, the recursion is not tried: it took
# half to four fifths at 1 % of peak torque. At few states it may take fewer, as its numbers are fitted to
# them, but errs more between them. Nor is it tried for this few joints, whose equations are short.
_FEW, _FEW_JOINTS = 0.65, 4
# If a quick count finds that the terms left take more than this multiple of the exact torque's operations,
# they are not searched: the search and a careful program saved up to two fifths of it.
_MANY = 1.7
# Levels that are tried; the others give a mechanical system, or the founding text's conclusions.
LEVELS_TRIED = (TERM, RECURSIVE)
_USUAL = SearchOptions()


def simplify(
    arm: RobotArm | str | Path,
    states: States | GivenMotions | xr.Dataset,
    budget: Budget | str | None = None,
    *,
    level: str | Level | None = None,
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
        By default the level with the fewest operations. "term" drops single torque terms; "recursive"
        simplifies steps of the Newton-Euler recursion, for arms with many terms; "energy" drops terms of the
        energies, so that the model stays a mechanical system; "element" drops effects of D_ij and h_i, and
        c_i, the founding text's method.
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
    own = None if level is None else level_named(level)
    how = SearchOptions(own, refit, operations, effort=effort, sine_price=sine_price)
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
    budget = Budget.of(budget)
    exact = exact.under(budget)
    models: list[SimplifiedModel] = []
    tried: list[LevelTried] = []
    for level in LEVELS_TRIED if how.level is None else (how.level,):
        why = unpromising(exact, level, budget, how, models) if how.level is None else ""
        if not why:
            stage(f"searching at level {level}")
            try:
                models.append(_at_level(exact, budget, level, how, progress))
            except TooManyTermsError as error:
                if how.level is not None:
                    raise
                why = error.what
        tried.append(LevelTried(level.name, None if why else models[-1].operations.total, why))
    if how.operations is None:
        best = min(models, key=lambda model: priced(model.program, how.sine_price))
    else:
        best = min(models, key=lambda model: float(model.accuracy.allowed.max()))
    accuracy = replace(best.accuracy, levels=tuple(tried) if how.level is None else ())
    return replace(best, accuracy=accuracy, provenance=dict(provenance or {}))


def unpromising(
    exact: ExactDynamics,
    level: Level,
    budget: Budget,
    how: SearchOptions,
    models: Sequence[SimplifiedModel],
    few: float = _FEW,
) -> str:
    """Reason why a level cannot take fewer operations than the models found; "" if it may."""
    full, is_short = exact.form.operations.total, exact.arm.n_joints <= _FEW_JOINTS
    if level is TERM and (many := too_many_terms(exact.form)):
        return f"the arm has {many}"
    if how.operations is not None:
        return ""
    if level is TERM:
        if is_short:
            return ""
        try:
            about = quick_count(exact.thinned(), TERM, exact.allowed(budget))(1.0)
        except TooManyTermsError as error:
            return error.what
        long = f"the terms left take about {about} operations, the exact torque {full}"
        return long if about > _MANY * full else ""
    if models and is_short:
        return f"the arm has at most {_FEW_JOINTS} joints, and numbers would be fitted to the states"
    least = min((model.operations.total for model in models), default=full)
    if least < few * full:
        return f"{least} of {full} operations are few already, and it takes long"
    return ""


def _at_level(
    exact: ExactDynamics, budget: Budget, level: Level, how: SearchOptions, progress: Progress
) -> SimplifiedModel:
    """Simplify at a level within a budget, or scale the budget until the model has few enough operations.

    A quick count estimates the factor; full searches then refine it.
    """
    operations = how.operations
    if operations is None:
        return _within(exact, budget, level, how, progress)
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


def _within(
    exact: ExactDynamics, budget: Budget, level: Level, how: SearchOptions, progress: Progress = None
) -> SimplifiedModel:
    """Find the model with the fewest operations within a budget."""
    allowed, how = exact.allowed(budget), replace(how, way=[] if how.way is None else how.way)
    # Very many states are represented by some; those that exceed the budget are added, each time with a
    # slightly larger weight, so that it ends.
    known, margin = exact.thinned(), 1.0
    while True:
        most = margin * allowed
        if isinstance(level, CandidateLevel):
            found = dropped(known, level, most, how, progress)
        else:
            found = pruned(known, most, how, progress)
        model = exactly(known, level, most, str(budget))
        done = replace(model.accuracy, steps=found.steps, solved=found.solved, cut_short=found.cut_short)
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
