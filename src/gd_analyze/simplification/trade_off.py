"""Operations against torque error: models for smaller and larger budgets at every level that keeps one."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.operations.program import OperationCount
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.simplification.budget import BUDGET_FACTORS, Budget
from gd_analyze.simplification.candidates import TooManyTermsError, require_few_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics, require_exact, warn_of_torques
from gd_analyze.simplification.harmonic import HARMONIC_LEVELS, TERM
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.threads import one_thread


@dataclass(frozen=True)
class TradeOffPoint:
    """One model of the curve; the exact one if nothing cheaper is within the budget."""

    level: Level
    factor: float  # multiple of the curve's budget
    budget: str  # as written by a user
    operations: OperationCount  # of one torque evaluation
    error_share: float  # largest error of any joint over its `Budget.shares_of`


def curves(points: Sequence[TradeOffPoint]) -> dict[Level, tuple[TradeOffPoint, ...]]:
    """Points by level, each with growing budget."""
    levels = dict.fromkeys(point.level for point in points)
    ordered = sorted(points, key=lambda point: point.factor)
    return {level: tuple(point for point in ordered if point.level is level) for level in levels}


@strict
@one_thread()
def trade_off(
    exact: ExactDynamics,
    budget: Budget | str | float | None = None,
    *,
    factors: Sequence[float] = BUDGET_FACTORS,
    levels: Sequence[Level] = tuple(HARMONIC_LEVELS.values()),
    thorough: bool = True,
    progress: Progress = NO_PROGRESS,
) -> tuple[TradeOffPoint, ...]:
    """Simplify for several budgets at every level.

    A model within a smaller budget is also within a larger one: no point takes more operations than one of
    its level for a smaller budget.

    Parameters
    ----------
    exact
        Exact dynamics at the states.
    budget
        The budget to scale; by default 1 % of each joint's peak torque.
    factors
        Multiples of the budget.
    levels
        Levels of single terms.
    thorough
        Search each point as `simplify` does; otherwise by a descent alone, which is quicker.
    progress
        Told the points done.

    Returns
    -------
    tuple
        Points (`TradeOffPoint`) by level and growing budget.

    Raises
    ------
    TooManyTermsError
        If the arm has too many terms to be written out.
    """
    require_exact(exact)
    require_few_terms(exact, TERM)
    warn_of_torques(exact)
    budget = Budget.of(budget)
    exact = exact.under(budget)
    allowed = exact.allowed(budget)
    whole = exact.peak_torque if budget.shares_of == "peak torque" else allowed
    points: list[TradeOffPoint] = []
    progress.stage("simplifying", len(levels) * len(factors))
    for level in levels:
        best = exactly(exact, level, allowed, str(budget))
        for factor in sorted(factors):
            scaled = budget.scaled(factor)
            options = SearchOptions(level, thorough=thorough)
            try:
                model = simplify_exact(exact, scaled, options)
            except TooManyTermsError:  # so many that any model costs more than the exact torque
                model = best
            best = min(best, model, key=lambda candidate: candidate.operations.total)
            error = best.accuracy.errors.largest
            # The largest share of any joint; a joint without torque has none.
            share = float(np.divide(error, whole, out=np.zeros_like(error), where=whole > 0.0).max())
            points.append(TradeOffPoint(level, factor, str(scaled), best.operations, share))
            progress.advance()
    return tuple(points)
