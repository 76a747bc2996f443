"""Candidates for dropping, the terms of a level, and the order of elimination.

Squared torque error is a quadratic form in the kept terms, so one Gram matrix shows which candidate adds
least per operation saved. Largest errors, which budgets limit, are checked at every state.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.operations.program import Program
from gd_analyze.simplification.effort import Effort, Work
from gd_analyze.simplification.exact import ExactDynamics, ExactForm, has_more_terms
from gd_analyze.simplification.level import CandidateLevel, Costs, Level, Terms
from gd_analyze.text import SINE_PRICE

Kept = NDArray[np.bool_]


# Above this many terms the smallest are dropped first: no search could weigh them all.
MANY = 1000
# Share of the budget that these may use together, and the most terms left.
SWEEP, _MOST = 0.3, 4000
# Most terms of an arm's torque that are written out: some seconds.
_WRITTEN = 60_000
# Numbers held at a time while identifying terms, used to rank them, or for a first estimate: seconds.
_AT_ONCE, _RANKED, _GLANCE = 10_000_000, 100_000_000, 20_000_000


class TooManyTermsError(UsageError):
    """More terms matter than a search can weigh."""


@dataclass(frozen=True, eq=False)
class Candidates:
    """Terms that may be dropped, with effects and costs; of very many the smallest are dropped beforehand."""

    level: CandidateLevel
    form: ExactForm
    terms: Terms
    # (K, n, N), weighted torque over the remaining allowed error; the sum is the exact torque
    effects: FloatArray
    costs: Costs
    parameter: NDArray[np.int64]  # (K,), index of the free number of a refit, see `level.Numbers`
    total: int  # number of all terms
    swept: float = 0.0  # share of the budget used by terms dropped beforehand

    def __len__(self) -> int:
        return len(self.effects)

    def keep(self, kept: Kept, scale: FloatArray) -> dict[Any, float]:
        """Terms of a selection, shape (K,), their coefficients times their factors, shape (K,)."""
        chosen = zip(self.terms.items(), kept, scale, strict=True)
        return {term: float(factor * weight) for (term, weight), keep, factor in chosen if keep}

    def write(self, kept: Kept, scale: FloatArray, effort: Effort) -> Program:
        """Write a selection as a program, with this effort."""
        return self.level.write(self.form, self.keep(kept, scale), effort)

    @property
    def flat(self) -> FloatArray:
        """Effects with joints and states in one row, shape (K, n N)."""
        return self.effects.reshape(len(self.effects), math.prod(self.effects.shape[1:]))


def candidates_of(
    exact: ExactDynamics,
    level: Level,
    allowed: FloatArray,
    sweep: float = SWEEP,
    *,
    sine_price: int = SINE_PRICE,
) -> Candidates:
    """Make the candidates of a level at states, with the allowed error of each joint, N m, shape (n,).

    Of very many terms the smallest are dropped beforehand, within the share `sweep` of the budget.
    """
    if not isinstance(level, CandidateLevel):
        what = f"level {level.name} has no single terms to choose from"
        raise UsageError(what, where="level", expected="term, energy or element", found=level.name)
    if level.has_torque_terms and has_more_terms(exact.form, _WRITTEN):
        what = f"the exact torque of {exact.arm.name} has too many terms to choose from"
        where, expected = f"level {level.name}", f"at most {_WRITTEN} torque terms"
        next_step = "`gd-analyze simplify ROBOT --level recursive` simplifies such an arm, `gd-analyze "
        next_step += "equations ROBOT --element D12 --min-share 1%` prints the largest terms of an element"
        raise TooManyTermsError(what, where=where, expected=expected, found="more", next_step=next_step)
    every = level.terms(exact.form)
    terms, swept = _swept(exact, level, every, allowed, sweep) if len(every) > MANY else (every, 0.0)
    listed = list(terms)
    return Candidates(
        level=level,
        form=exact.form,
        terms=terms,
        effects=_weighed(level.effects(exact, terms), exact) / ((1.0 - swept) * allowed)[:, None],
        costs=level.costs(exact.form, listed, sine_price),
        parameter=level.numbers(exact.form, listed),
        total=len(every),
        swept=swept,
    )


def _swept(
    exact: ExactDynamics, level: CandidateLevel, every: Terms, allowed: FloatArray, sweep: float
) -> tuple[Terms, float]:
    """Terms left without the smallest, and the error over allowed of these; a few states decide."""
    items, n, states = list(every.items()), exact.arm.n_joints, exact.states
    looked_at = _RANKED if np.isinf(sweep) else _GLANCE
    few = states.at(slice(None, None, max(len(items) * n * len(states) // looked_at, 1)))
    peaks = np.zeros((len(items), n))
    step = max(_AT_ONCE // (len(items) * n), 1)
    for start in range(0, len(few), step):
        some = exact.at(few.at(slice(start, start + step)))
        np.maximum(peaks, np.abs(_weighed(level.effects(some, every), some)).max(axis=2), out=peaks)
    order = np.argsort((peaks / allowed).max(axis=1), kind="stable")
    if np.isinf(sweep):
        left = dict(items[k] for k in np.sort(order[-MANY:]))
        rest = exact.torque.T - level.effects(exact, left).sum(axis=0)
        return left, float((np.abs(_weighed(rest, exact)).max(axis=1) / allowed).max())
    gone, share = _gone(exact.at(few), level, [items[k] for k in order], allowed, sweep)
    if len(few) < len(states) and len(items) - gone <= _MOST:
        gone, share = _gone(exact, level, [items[k] for k in order], allowed, sweep)
    if len(items) - gone > _MOST:
        what = f"too many of the {len(items)} terms of {exact.arm.name} matter within that budget"
        expected, found = f"at most {_MOST}", str(len(items) - gone)
        next_step = "use --level recursive, whose models keep no terms, or allow a larger error"
        raise TooManyTermsError(what, where="budget", expected=expected, found=found, next_step=next_step)
    return dict(items[k] for k in np.sort(order[gone:])), share


def _gone(
    exact: ExactDynamics,
    level: CandidateLevel,
    items: list[tuple[Any, float]],
    allowed: FloatArray,
    sweep: float,
) -> tuple[int, float]:
    """Number of first terms that may be dropped together, and their error over allowed."""
    lost = np.zeros((exact.arm.n_joints, len(exact.states)))
    gone, share = 0, 0.0
    step = max(_AT_ONCE // lost.size, 1)
    for start in range(0, len(items) - MANY, step):
        some = dict(items[start : min(start + step, len(items) - MANY)])
        sums = lost + np.cumsum(level.effects(exact, some), axis=0)
        errors = (np.abs(_weighed(sums, exact)).max(axis=2) / allowed).max(axis=1)
        within = np.flatnonzero(errors <= sweep)
        if within.size:
            gone, share = start + int(within[-1]) + 1, float(errors[within[-1]])
        lost = sums[-1]
    return gone, share


def _weighed(effects: FloatArray, exact: ExactDynamics) -> FloatArray:
    """Weighted effects (K, n, N)."""
    return effects if exact.states.weights is None else effects * exact.states.weights.T


# A refit of P numbers takes some P^3 multiplications; the next one is due when this many per dropped
# candidate have accumulated.
_REFIT_EACH = 100**3
# Regularization of a singular fit: a share of each number's square, thousands of roundings.
_SLIGHTLY = 1e-12
# Operations credited to a candidate that saves nothing while others share its arithmetic.
_LEAST_SAVING = 0.5


@dataclass(frozen=True, eq=False)
class Elimination:
    """Candidates in the order of elimination."""

    candidates: Candidates
    order: tuple[int, ...]
    scales: FloatArray  # (K + 1, K), factors of all coefficients with the first k dropped; 1 without refit

    def kept(self, dropped: int) -> NDArray[np.bool_]:
        """Mask of candidates that remain when the first ones are dropped, shape (K,)."""
        kept = np.ones(len(self.order), dtype=bool)
        kept[list(self.order[:dropped])] = False
        return kept

    def errors(self) -> FloatArray:
        """Largest error per joint with the first k dropped, k = 0..K, over allowed; shape (K + 1, n)."""
        effects, steps = self.candidates.effects, len(self.order) + 1
        gone = np.empty(steps - 1, dtype=np.intp)
        gone[list(self.order)] = np.arange(1, steps)  # number dropped when it goes
        lost = 1.0 - self.scales * (gone > np.arange(steps)[:, None])
        rows = max(_AT_ONCE // math.prod(effects.shape[1:]), 1)
        left = (lost[k : k + rows] @ self.candidates.flat for k in range(0, steps, rows))
        return np.concatenate([np.abs(x).reshape(-1, *effects.shape[1:]).max(axis=2) for x in left])

    def within(self, factor: float = 1.0) -> NDArray[np.bool_]:
        """Those that remain, (K,), if each in turn is dropped unless `factor` times the budget breaks."""
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
    """Order candidates by the error that each adds, with `by_cost` per operation saved.

    With `refit` the remaining ones are refitted repeatedly. `last` (K,) are dropped after all others.
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
        # Chosen among those that may be dropped, regardless of merit, so that the loop ends.
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
    """Factors that fit the kept candidates best to the exact torque, as they are dropped one by one."""

    def __init__(self, gram: FloatArray, candidates: Candidates) -> None:
        _, self._place = np.unique(candidates.parameter, return_inverse=True)
        self._gram, self._kept = gram, np.ones(len(gram))
        self._order = np.argsort(self._place, kind="stable")
        numbers = np.arange(int(self._place.max(initial=-1)) + 1)
        self._first = np.searchsorted(self._place[self._order], numbers)
        self._gathered = self._by_number(gram).T
        self._wished = gram.sum(axis=1)
        # If a number's candidates cancel, the rest is round-off relative to them.
        self._least = np.finfo(float).eps * self._by_number(np.diag(gram)[:, None])[:, 0]

    def drop(self, k: int) -> None:
        """Fit without k from now on."""
        self._gathered[:, self._place[k]] -= self._gram[k]
        self._kept[k] = 0.0

    @property
    def _used(self) -> NDArray[np.bool_]:
        return np.asarray(np.logical_or.reduceat(self._kept[self._order] != 0.0, self._first))

    @property
    def numbers(self) -> int:
        """Number of free numbers left."""
        return int(self._used.sum()) if len(self._first) else 0

    def factors(self) -> FloatArray:
        """Factors of all candidates, shape (K,); 1 for dropped ones."""
        used = self._used
        normal = self._by_number(self._gathered)[np.ix_(used, used)]
        wished = self._by_number(self._wished[:, None])[used, 0]
        # Some coefficients, or their differences, may not affect the torque: the addition to the diagonal
        # keeps them small, and changes the others by no more than their round-off.
        size = np.sqrt(np.maximum(np.diag(normal), np.maximum(self._least[used], np.finfo(float).tiny)))
        scaled = normal / np.outer(size, size) + _SLIGHTLY * np.eye(len(size))
        fitted = np.zeros(len(used))
        fitted[used] = np.linalg.solve(scaled, wished / size) / size
        return np.where(self._kept != 0.0, fitted[self._place], 1.0)

    def _by_number(self, rows: FloatArray) -> FloatArray:
        """Sum rows of kept candidates that share a number."""
        kept = (self._kept[:, None] * rows)[self._order]
        return np.asarray(np.add.reduceat(kept, self._first)) if len(self._first) else kept


class _Savings:
    """Operations that dropping each candidate saves, given those dropped already."""

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
