"""The level that takes the fewest operations: those that are promising for an arm are tried."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

from gd_analyze.simplification.accuracy import LevelTried
from gd_analyze.simplification.at_level import at_level
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.dropping import quick_count
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.many_terms import has_many_terms, many_terms_told
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search import Progress
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.term import TERM

# Where terms take less than this share of the exact torque's operations, the recursion is not tried: it was
# found to take half to four fifths at states of all the arm's limits, at 1 % of peak torque. At few states it
# may take fewer than terms, as its numbers are fitted to them, and then errs the more between them.
# Nor is it tried for so few joints, whose equations are short.
_FEW, _FEW_JOINTS = 0.65, 4
# Where a quick count finds that terms left take more than so many times the exact torque's operations, they
# are not searched: the search and a program written with care were found to save up to two fifths of it.
_MANY = 1.7
# Levels that are tried; the others are for more than few operations: a mechanical system, or the founding
# text's conclusions.
_TRIED = (TERM, RECURSIVE)


def cheapest(
    exact: ExactDynamics,
    budget: Budget,
    how: SearchOptions,
    progress: Progress = None,
    stage: Callable[[str], object] = lambda _: None,
) -> SimplifiedModel:
    """Simplify at every promising level, and give the model of fewest operations.

    Of models of a given number of operations it is the one of the smallest budget. What was tried, and what
    was not, is said in `Promise.levels`.
    """
    models: list[SimplifiedModel] = []
    tried: list[LevelTried] = []
    for level in _TRIED:
        why = _unpromising(exact, level, models if how.operations is None else [])
        if not why and level is TERM and how.operations is None:
            why = _too_long(exact, budget)
        if not why:
            stage(f"searching at level {level}")
            try:
                models.append(at_level(exact, budget, level, how, progress))
            except TooManyTermsError as error:
                why = error.what
        operations = None if why else models[-1].operations.total
        tried.append(LevelTried(level.name, operations, why))
    best = min(models, key=_operations if how.operations is None else _allowed)
    return replace(best, accuracy=replace(best.accuracy, levels=tuple(tried)))


def _unpromising(exact: ExactDynamics, level: Level, models: Sequence[SimplifiedModel]) -> str:
    """Why a level cannot take fewer operations than the models there are; "" where it may."""
    if level is TERM:
        return f"the arm has {many_terms_told(exact.form)}" if has_many_terms(exact.form) else ""
    if models and exact.arm.n_joints <= _FEW_JOINTS:
        return f"the arm has at most {_FEW_JOINTS} joints, and its numbers would be fitted to the states"
    full = exact.form.operations.total
    least = min((model.operations.total for model in models), default=full)
    if least < _FEW * full:
        return f"{least} of {full} operations are few, and its numbers would be fitted to the states"
    return ""


def _too_long(exact: ExactDynamics, budget: Budget) -> str:
    """Why the terms that a budget leaves are no short way to write the torque; "" where they may be."""
    full = exact.form.operations.total
    if budget.norm is not None or exact.arm.n_joints <= _FEW_JOINTS:
        return ""
    try:
        about = quick_count(exact.thinned(), TERM, exact.allowed(budget))(1.0)
    except TooManyTermsError as error:
        return error.what
    return (
        f"the terms left take about {about} operations, the exact torque {full}"
        if about > _MANY * full
        else ""
    )


def _operations(model: SimplifiedModel) -> float:
    return model.operations.total


def _allowed(model: SimplifiedModel) -> float:
    return float(model.accuracy.allowed.max())
