"""Operations against error: what every level gives for smaller and larger budgets, with and without refit."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from gd_analyze.levels import LEVELS, Budget, ExactDynamics, Level
from gd_analyze.levels.effort import ROUGH
from gd_analyze.operations import OperationCount
from gd_analyze.search.candidates import SWEEP, Candidates, candidates_of
from gd_analyze.search.elimination import Elimination, eliminate
from gd_analyze.search.simplify import How, simplify_exact
from gd_analyze.vectors import FloatArray

# Every level, and every level once more with a refit that can have one.
KINDS: tuple[tuple[Level, bool], ...] = tuple(
    (level, refit)
    for level in LEVELS.values()
    for refit in ((False, True) if level.has_torque_terms else (False,))
)
FACTORS = (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)


@dataclass(frozen=True)
class TradeOffPoint:
    """One model of the curve; the exact one where nothing cheaper is within the budget.

    Parameters
    ----------
    level, refit
        How it was simplified.
    factor, budget
        Its budget, as a multiple of the one the curve is about and as a user would put it.
    operations
        What one torque evaluation takes.
    error_share
        Largest error at the states, the worst joint's: over peak torque, or under a budget that is no share
        of it over the error allowed by the budget that was multiplied, see `Budget.shares_of`.
    """

    level: Level
    refit: bool
    factor: float
    budget: str
    operations: OperationCount
    error_share: float


def curves(points: Sequence[TradeOffPoint]) -> dict[tuple[Level, bool], tuple[TradeOffPoint, ...]]:
    """Points by level and refit, each with growing budget."""
    kinds = dict.fromkeys((point.level, point.refit) for point in points)
    return {
        kind: tuple(sorted((p for p in points if (p.level, p.refit) == kind), key=lambda point: point.factor))
        for kind in kinds
    }


def trade_off(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    *,
    factors: Sequence[float] = FACTORS,
    kinds: Sequence[tuple[Level, bool]] = KINDS,
    thorough: bool = True,
    progress: Callable[[int], None] | None = None,
) -> tuple[TradeOffPoint, ...]:
    """Simplify for several budgets at every level.

    Parameters
    ----------
    exact
        Exact dynamics at the states that count.
    budget
        The budget that is multiplied; 1 % of each joint's peak torque by default.
    factors
        Multiples of the budget.
    kinds
        Pairs of level and refit.
    thorough
        Search each point as `simplify` does. Otherwise all points of a kind come from one elimination, which
        takes hundredths of a second and somewhat more operations.
    progress
        Called with the number of points done since the last call.

    Returns
    -------
    tuple
        Points by kind and growing budget.
    """
    budget = Budget.of(budget)
    tell = progress or (lambda _: None)
    points: list[TradeOffPoint] = []
    exact = exact if thorough else exact.thinned()
    allowed = exact.allowed(budget)
    whole = exact.peak_torque if budget.shares_of == "peak torque" else allowed
    budgets = [budget.scaled(factor) for factor in factors]
    known: dict[Level, Candidates] = {}
    found: Iterator[tuple[OperationCount, float]]
    for level, refit in kinds:
        if thorough:
            models = map(partial(simplify_exact, exact, how=How(level, refit)), budgets)
            found = ((made.operations, _share(made.promise.errors.largest, whole)) for made in models)
        else:
            if level not in known:
                known[level] = candidates_of(exact, level, allowed, SWEEP * min(1.0, *factors))
            elimination = eliminate(known[level], refit=refit)
            found = _eliminated(exact, (allowed, whole), elimination, refit, factors)
        for factor, stated, (operations, error) in zip(factors, budgets, found, strict=True):
            points.append(TradeOffPoint(level, refit, factor, str(stated), operations, error))
            tell(1)
    return tuple(points)


def _eliminated(
    exact: ExactDynamics,
    measures: tuple[FloatArray, FloatArray],
    elimination: Elimination,
    refit: bool,
    factors: Sequence[float],
) -> Iterator[tuple[OperationCount, float]]:
    """The last models of one elimination within each budget; given are what is allowed, and shares are of."""
    (allowed, whole), candidates = measures, elimination.candidates
    largest = elimination.errors().max(axis=1) if refit else None
    for factor in factors:
        if largest is None:
            kept, scale = elimination.within(factor), elimination.scales[0]
        else:
            last = int(np.flatnonzero(largest <= factor)[-1])
            kept, scale = elimination.kept(last), elimination.scales[last]
        operations = candidates.count(kept, scale, ROUGH)
        if operations.total < exact.form.operations.total:
            yield operations, _share(_errors(candidates, kept * scale - 1.0) * allowed, whole)
        else:
            yield exact.form.operations, 0.0


def _errors(candidates: Candidates, weights: FloatArray) -> FloatArray:
    """Largest errors of the joints over what is allowed."""
    error: FloatArray = np.abs(np.tensordot(weights, candidates.effects, axes=1)).max(axis=1)
    return (1.0 - candidates.swept) * error + candidates.swept


def _share(error: FloatArray, whole: FloatArray) -> float:
    """Largest share of any joint; one without a whole has none."""
    return float(np.divide(error, whole, out=np.zeros_like(error), where=whole > 0.0).max())
