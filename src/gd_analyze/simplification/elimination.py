"""The order in which candidates go, the least missed first, and what is lost on the way.

Squared torque error is a quadratic form in what is kept, so one Gram matrix shows which candidate adds the
least for every operation it saves. Largest errors, in which budgets are, are checked on every state.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import Candidates, Kept
from gd_analyze.simplification.effort import Work
from gd_analyze.simplification.level import Costs

# A refit of P numbers takes some P^3 multiplications; after so many candidates have gone that it comes to
# this for each, the next is due.
_REFIT_EACH = 100**3
# A share of each number's own square, thousands of roundings: what makes a singular fit regular.
_SLIGHTLY = 1e-12
# What a candidate counts as saving that saves nothing while those it shares its arithmetic with remain.
_LEAST_SAVING = 0.5


@dataclass(frozen=True, eq=False)
class Elimination:
    """Candidates in the order they go."""

    candidates: Candidates
    order: tuple[int, ...]
    scales: FloatArray  # (K + 1, K), factors of all coefficients with the first k dropped; 1 without refit

    def kept(self, dropped: int) -> NDArray[np.bool_]:
        """Which candidates remain when the first ones are dropped, shape (K,)."""
        kept = np.ones(len(self.order), dtype=bool)
        kept[list(self.order[:dropped])] = False
        return kept

    def errors(self) -> FloatArray:
        """Largest error per joint with the first k dropped, k = 0..K, over allowed; shape (K + 1, n)."""
        effects = self.candidates.effects
        out = np.zeros((len(self.order) + 1, effects.shape[1]))
        left = np.zeros(effects.shape[1:])
        whole = effects.sum(axis=0)
        for k, candidate in enumerate(self.order):
            before, now = self.scales[k], self.scales[k + 1]
            if (now == before).all():
                left += now[candidate] * effects[candidate]
            else:
                kept = np.flatnonzero(self.kept(k + 1))
                left = whole - np.tensordot(now[kept], effects[kept], axes=1)
            out[k + 1] = np.abs(left).max(axis=1)
        return out

    def within(self, factor: float = 1.0) -> NDArray[np.bool_]:
        """What remains, (K,), if each in this order goes unless `factor` times the budget breaks."""
        effects = self.candidates.flat
        kept = np.ones(len(effects), dtype=bool)
        lost = np.zeros(effects.shape[1])
        for candidate in self.order:
            trial = lost + effects[candidate]
            if np.abs(trial).max(initial=0.0) <= factor:
                lost, kept[candidate] = trial, False
        return kept


def eliminate(
    candidates: Candidates,
    *,
    by_cost: bool = True,
    refit: bool = False,
    last: Kept | None = None,
    work: Work | None = None,
) -> Elimination:
    """Order candidates by the error that each adds, with `by_cost` for every operation saved.

    With `refit` what remains is fitted after every step, or after some where numbers are many. `last` (K,) go
    when all others have gone.
    """
    flat = candidates.flat
    gram = flat @ flat.T
    savings = _Savings(candidates.costs, len(flat))
    fit = _LeastSquares(gram, candidates) if refit else None
    kept = np.ones(len(flat), dtype=bool)
    # Error of the model is sum_k weight_k effect_k, weight_k = kept_k scale_k - 1.
    scale, slope = np.ones(len(flat)), np.zeros(len(flat))
    order: list[int] = []
    scales = [scale]
    due = 0.0
    while kept.any():
        may_go = kept & ~last if last is not None and (kept & ~last).any() else kept
        added = scale * (scale * np.diag(gram) - 2.0 * slope)
        merit = added / (np.maximum(savings.now, _LEAST_SAVING) if by_cost else 1.0)
        # Taken from those that may go whatever their merit is, so that the loop ends.
        places = np.flatnonzero(may_go)
        chosen = int(places[merit[places].argmin()])
        kept[chosen] = False
        savings.drop(chosen)
        order.append(chosen)
        if fit is None:
            slope -= gram[chosen]
        else:
            fit.drop(chosen)
            due += _REFIT_EACH
            if due >= fit.numbers**3:
                due = 0.0
                if work is not None:
                    work.spend(fit.numbers**3)
                scale = fit.factors()
            slope = gram @ (kept * scale - 1.0)
        scales.append(scale)
    return Elimination(candidates, tuple(order), np.array(scales))


class _LeastSquares:
    """Factors that bring what is kept closest to the exact torque, as one candidate after the other goes."""

    def __init__(self, gram: FloatArray, candidates: Candidates) -> None:
        _, self._place = np.unique(candidates.parameter, return_inverse=True)
        self._gram, self._ratio = gram, candidates.ratio.copy()
        self._order = np.argsort(self._place, kind="stable")
        numbers = np.arange(int(self._place.max(initial=-1)) + 1)
        self._first = np.searchsorted(self._place[self._order], numbers)
        self._gathered = self._by_number(gram).T
        self._wished = gram.sum(axis=1)
        # What is left of a number where its candidates cancel is round-off of what they are.
        own = self._ratio * np.diag(gram)
        self._least = np.finfo(float).eps * self._by_number(own[:, None])[:, 0]

    def drop(self, k: int) -> None:
        """Fit without k from now on."""
        self._gathered[:, self._place[k]] -= self._gram[k] * self._ratio[k]
        self._ratio[k] = 0.0

    @property
    def _used(self) -> NDArray[np.bool_]:
        return np.asarray(np.logical_or.reduceat(self._ratio[self._order] != 0.0, self._first))

    @property
    def numbers(self) -> int:
        """How many free numbers are left."""
        return int(self._used.sum()) if len(self._first) else 0

    def factors(self) -> FloatArray:
        """Factors of all candidates, shape (K,); 1 of those dropped."""
        used = self._used
        normal = self._by_number(self._gathered)[np.ix_(used, used)]
        wished = self._by_number(self._wished[:, None])[used, 0]
        # Some coefficients, or differences of some, may not show in the torque at all: what is added to the
        # diagonal keeps them small, and changes the others by no more than their own round-off.
        size = np.sqrt(np.maximum(np.diag(normal), np.maximum(self._least[used], np.finfo(float).tiny)))
        scaled = normal / np.outer(size, size) + _SLIGHTLY * np.eye(len(size))
        fitted = np.zeros(len(used))
        fitted[used] = np.linalg.solve(scaled, wished / size) / size
        return np.where(self._ratio != 0.0, self._ratio * fitted[self._place], 1.0)

    def _by_number(self, rows: FloatArray) -> FloatArray:
        """Add up rows of candidates, times their ratios, that share a number."""
        weighted = (self._ratio[:, None] * rows)[self._order]
        return np.asarray(np.add.reduceat(weighted, self._first)) if len(self._first) else weighted


class _Savings:
    """Operations that dropping each candidate saves, beside what has gone already."""

    def __init__(self, costs: Costs, count: int) -> None:
        self.now = np.zeros(count)
        self._blocks: list[list[tuple[set[int], int]]] = [[] for _ in range(count)]
        for members, operations in costs.items():
            block = set(members), operations
            for k in members:
                self._blocks[k].append(block)
            self._credit(*block)

    def _credit(self, members: set[int], operations: int) -> None:
        if len(members) == 1:
            (k,) = members
            self.now[k] += operations

    def drop(self, k: int) -> None:
        for members, operations in self._blocks[k]:
            members.discard(k)
            self._credit(members, operations)
