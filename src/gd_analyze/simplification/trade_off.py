"""Operations against torque error: models for smaller and larger budgets at every level that keeps one."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.operations.program import OperationCount
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import TooManyTermsError, require_few_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics, require_exact, warn_of_torques
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import LEVELS, SearchOptions
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.threads import one_thread

# Level and refit: every level of single terms, with a refit and without.
LevelAndRefit = tuple[Level, bool]
LEVELS_AND_REFITS: tuple[LevelAndRefit, ...] = tuple(
    (level, refit) for level in LEVELS.values() if level.has_torque_terms for refit in (False, True)
)
BUDGET_FACTORS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True)
class TradeOffPoint:
    """One model of the curve; the exact one if nothing cheaper is within the budget."""

    level: Level
    refit: bool
    factor: float  # multiple of the curve's budget
    budget: str  # as written by a user
    operations: OperationCount  # of one torque evaluation
    error_share: float  # largest error of any joint over its `Budget.shares_of`


def curves(points: Sequence[TradeOffPoint]) -> dict[LevelAndRefit, tuple[TradeOffPoint, ...]]:
    """Points by level and refit, each with growing budget."""
    kinds = dict.fromkeys((point.level, point.refit) for point in points)
    ordered = sorted(points, key=lambda point: point.factor)
    return {kind: tuple(p for p in ordered if (p.level, p.refit) == kind) for kind in kinds}


@strict
@one_thread()
def trade_off(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    *,
    factors: Sequence[float] = BUDGET_FACTORS,
    kinds: Sequence[LevelAndRefit] = LEVELS_AND_REFITS,
    thorough: bool = True,
    progress: Callable[[int], None] = lambda _: None,
) -> tuple[TradeOffPoint, ...]:
    """Simplify for several budgets at every level.

    A model within a smaller budget is also within a larger one: no point takes more operations than one of
    its kind for a smaller budget.

    Parameters
    ----------
    exact
        Exact dynamics at the states.
    budget
        The budget to scale; by default 1 % of each joint's peak torque.
    factors
        Multiples of the budget.
    kinds
        Pairs of level and refit.
    thorough
        Search each point as `simplify` does; otherwise by a descent alone, which is quicker.
    progress
        Called with the number of points done since the last call.

    Returns
    -------
    tuple
        Points (`TradeOffPoint`) by kind and growing budget.

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
    for level, refit in kinds:
        best = exactly(exact, level, allowed, str(budget))
        for factor in sorted(factors):
            scaled = budget.scaled(factor)
            options = SearchOptions(level, refit, thorough=thorough)
            try:
                model = simplify_exact(exact, scaled, options)
            except TooManyTermsError:  # so many that any model costs more than the exact torque
                model = best
            best = min(best, model, key=lambda candidate: candidate.operations.total)
            error = best.accuracy.errors.largest
            # The largest share of any joint; a joint without torque has none.
            share = float(np.divide(error, whole, out=np.zeros_like(error), where=whole > 0.0).max())
            points.append(TradeOffPoint(level, refit, factor, str(scaled), best.operations, share))
            progress(1)
    return tuple(points)
