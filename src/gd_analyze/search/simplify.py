"""The smallest model within a torque error budget, or the best one of so many operations, at any level."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.errors import GdAnalyzeError, UsageError
from gd_analyze.levels import (
    ELEMENT,
    TERM,
    Budget,
    ExactDynamics,
    Level,
    SearchStep,
    SimplifiedModel,
    level_named,
)
from gd_analyze.levels.effort import COUNTING, ROUGH, THOROUGH
from gd_analyze.robots import RobotArm
from gd_analyze.search.candidates import Kept, TooManyTermsError, candidates_of
from gd_analyze.search.elimination import eliminate
from gd_analyze.search.exact_model import exactly, measured, no_dearer
from gd_analyze.search.search import Progress, search
from gd_analyze.search.within_norm import within_norm
from gd_analyze.search.work import Work
from gd_analyze.states import States
from gd_analyze.trajectories import GivenMotions
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr

# --operations: the smallest multiple of the budget, how close it is searched, how often it is tightened.
_LEAST, _CLOSE, _ATTEMPTS = 1e-6, 1.02, 4
# Writing a program to count it takes as long as so many multiplications for each term.
_WRITING = 3e5


@dataclass(frozen=True)
class How:
    """How to simplify.

    Parameters
    ----------
    level
        "term", "energy" or "element", or the level itself.
    refit
        Change kept coefficients to absorb what is dropped.
    operations
        Multiplications and additions the model may take: the budget is then scaled, for all joints alike, to
        the smallest that so many allow.
    thorough
        Search the integer program; dive into it only otherwise: tenths of a second instead of seconds.
    write
        Spend tenths of a second on a program of few operations, as for all that is shown.
    effort
        How much to do, as a multiple of the usual: about a minute at most. Where it ends, the best so far is
        given, and said to be that.
    dearer
        Give what was found even where the exact torque takes no more operations: to see what matters.

    Raises
    ------
    UsageError
        If there is no such level, it has no coefficients to refit, or so few operations do not exist.
    """

    level: Level = TERM
    refit: bool = False
    operations: int | None = None
    thorough: bool = True
    write: bool = True
    effort: float = 1.0
    dearer: bool = False

    def __post_init__(self) -> None:
        object.__setattr__(self, "level", level_named(self.level))
        if self.refit and not self.level.has_torque_terms:
            raise UsageError(
                f"{self.level.keeps} have no coefficients to refit",
                where="refit",
                expected="level term or energy",
                found=f"level {self.level}",
            )
        if not self.effort > 0.0:
            raise UsageError(
                "a search takes some effort", where="effort", expected="above 0", found=f"{self.effort}"
            )
        if self.operations is not None and self.operations < 0:
            raise UsageError("so few operations do not exist", where="operations", found=str(self.operations))


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
) -> SimplifiedModel:
    """Leave out what a torque error budget allows, so that few operations remain.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    states
        States over which the budget holds: a trajectory's set points, or its shipped name or path; those of
        several, on each of which the budget then holds; their decomposition where it is at hand; or drawn
        ones, see `states_in_box`.
    budget
        Allowed torque error per joint, or its text such as "1% or 10% friction", see `Budget.parse`; 1 % of
        each joint's peak torque over the states by default.
    level, refit, operations, effort
        See `How`: "term" drops torque terms one by one, the fewest operations; "energy" drops terms of the
        energies, so that the model stays a mechanical system; "element" drops the effects of D_ij and h_i
        and c_i, the founding text's method.
    drives
        Include drive inertia, or take the links alone; by default it is included where the arm describes
        drives, see `ExactDynamics.of`.

    Returns
    -------
    SimplifiedModel
        Its largest error over the states is within the budget, measured on its own program. Where that takes
        as many operations as the exact torque, it is the exact model. Its `notice` tells where the budget is
        less than a joint's friction or the uncertainty of its torque.

    Raises
    ------
    UsageError
        If the budget is not understood, does not fit the number of joints, or is a share of what the arm does
        not state; or if level and refit do not go together.
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> arm = gd.load_arm("two_link")
    >>> model = gd.simplify(arm, gd.read_trajectory("two-link-swing", arm), "1%")
    >>> bool((model.promise.errors.largest_share <= 0.01).all())
    True
    """
    how = How(level_named(level), refit, operations, effort=effort)
    return simplify_exact(ExactDynamics.of(arm, states, drives), budget, how)


def simplify_exact(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    how: How = How(),
    *,
    provenance: Mapping[str, str] | None = None,
    progress: Progress = None,
) -> SimplifiedModel:
    """Do what `simplify` does, against exact dynamics that are at hand.

    Parameters
    ----------
    exact, budget, how
        What to simplify, how far, and how.
    provenance
        Stored with the model.
    progress
        Called with the number of candidates dropped since the last call.
    """
    budget = Budget.of(budget)
    exact = exact.under(budget)
    if how.operations is not None:
        budget.require_per_joint("a model of so many operations", "give the share of the norm alone")
    if how.operations is None:
        model = _within(exact, budget, how, progress)
    else:
        model = _of_few_operations(exact, budget, how, how.operations, progress)
    return replace(model, provenance=dict(provenance or {}))


def _within(exact: ExactDynamics, budget: Budget, how: How, progress: Progress = None) -> SimplifiedModel:
    """Search under what the budget allows every joint, or of the norm, under what keeps that."""

    def search(exact: ExactDynamics, allowed: FloatArray, thorough: bool = True) -> SimplifiedModel:
        # Written shortly, one that takes more operations than exact may still take fewer.
        trial = how if thorough else replace(how, thorough=False, write=False, dearer=True)
        return _within_allowed(exact, allowed, str(budget), trial, progress)

    allowed = exact.allowed(budget)
    if budget.norm is None:
        return search(exact, allowed)
    everything = exactly(exact, how.level, allowed, str(budget))
    try:
        return within_norm(exact, budget, search, everything)
    except TooManyTermsError:
        return replace(everything, promise=replace(everything.promise, cut_short=True))


def _within_allowed(
    exact: ExactDynamics, allowed: FloatArray, budget: str, how: How, progress: Progress
) -> SimplifiedModel:
    """Search on some of the states if there are very many; those that break the budget join them."""
    known, margin = exact.thinned(), 1.0  # what is added counts a little more every time, so it ends
    while True:
        model = _searched(known, margin * allowed, budget, how, progress)
        if known is exact:
            return model
        torque = model.torque(*exact.states.arrays)
        if (exact.errors_of(torque).counting <= allowed).all():
            return replace(model, promise=exact.held(replace(model.promise, allowed=allowed), torque))
        off, weights = np.abs(torque - exact.torque), exact.states.weights
        worst = exact.states.at(np.unique((off if weights is None else off * weights).argmax(axis=0)))
        known = known.at(known.states.joined_by(*worst.arrays, worst.weights))
        margin *= 0.98


def _searched(
    exact: ExactDynamics, allowed: FloatArray, budget: str, how: How, progress: Progress
) -> SimplifiedModel:
    level, form = how.level, exact.form
    try:
        candidates = candidates_of(exact, level, allowed)
    except TooManyTermsError:
        if how.dearer:
            raise
        # So many terms take more operations than the exact torque, and more than a file or a reader takes.
        model = exactly(exact, ELEMENT, allowed, budget)
        return replace(model, promise=replace(model.promise, cut_short=True))
    writing, work = COUNTING if how.thorough else ROUGH, Work(how.effort)

    def count(kept: Kept, scale: FloatArray) -> int:
        work.spend(_WRITING * int(kept.sum()))
        return candidates.count(kept, scale, writing).total

    found, solved = search(
        candidates, count, refit=how.refit, thorough=how.thorough, work=work, progress=progress
    )
    effort = THOROUGH if how.write else COUNTING
    written = {name: level.write(form, candidates.keep(*step), effort) for name, step in found.items()}
    steps = tuple(SearchStep(name, program.count.total) for name, program in written.items())
    # The search counts roughly; of steps that take as many operations the last has been fitted.
    best = min(reversed(steps), key=lambda step: step.operations).name
    kept, scale = found[best]
    terms = candidates.keep(kept, scale)
    everything = exactly(exact, level, allowed, budget)
    model = replace(
        everything,
        terms=terms,
        program=written[best],
        refitted=bool((scale[kept] != 1.0).any()),
        promise=replace(everything.promise, steps=steps, solved=solved, cut_short=work.was_short),
    )
    model = measured(exact, model)
    if not (model.promise.errors.counting <= allowed).all():
        raise GdAnalyzeError(
            "the simplified model misses its budget",
            expected=str(allowed.tolist()),
            found=str(model.promise.errors.counting.tolist()),
            next_step="please report this with the arm file and the states",
        )
    return model if how.dearer else no_dearer(exact, model)


def _of_few_operations(
    exact: ExactDynamics, budget: Budget, how: How, operations: int, progress: Progress
) -> SimplifiedModel:
    """Scale the budget until the model takes no more operations than asked for.

    Elimination alone tells quickly about where; whole searches then close in from there.
    """
    if operations >= exact.form.operations.total:
        return exactly(exact, how.level, exact.allowed(budget), str(budget))
    some = exact.thinned()
    candidates = candidates_of(some, how.level, exact.allowed(budget))
    elimination = eliminate(candidates)
    one = np.ones(len(candidates))

    def quick(factor: float) -> int:
        return candidates.count(elimination.within(factor), one, COUNTING).total

    few, many = _LEAST, 1.0
    while quick(many) > operations:
        few, many = many, 2.0 * many
    while many / few > _CLOSE:
        middle = (few * many) ** 0.5
        few, many = (middle, many) if quick(middle) > operations else (few, middle)
    best = _within(exact, budget.scaled(many), how, progress)
    step = 0.8
    for _ in range(_ATTEMPTS):
        trial = _within(exact, budget.scaled(many * step), how)
        if trial.operations.total <= operations:
            best, many = trial, many * step
        else:
            step **= 0.5
    return best
