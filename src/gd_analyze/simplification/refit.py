"""Refitted coefficients: what is kept, changed so that it absorbs what was dropped.

The error of joint and state s is sum_p theta_p a_ps - tau_s, a_p the sum of the kept effects that share
coefficient p. Which coefficients keep it within a budget, or make the largest least, are linear programs. Few
states decide: those a trial solution violates are added, and mostly decide of the next selection, too.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import Candidates, Kept
from gd_analyze.simplification.effort import Work
from gd_analyze.simplification.selection import add_rows

# States that a quadratic fit errs most at start the set; further ones join in bunches, and at most so many
# stay for the next selection.
_FIRST, _BUNCH, _MOST = 200, 25, 600
# The solver keeps its rows to 1e-7 of numbers that are some hundred budgets large.
_CLOSE = 1e-6


class Refit:
    """Fits kept candidates again and again, remembering which states decide."""

    def __init__(self, candidates: Candidates, work: Work, like: Refit | None = None) -> None:
        """`like` is a refit of the same effects, whose deciding states are a good start."""
        self._work = work
        self._flat = candidates.flat
        self._parameter = candidates.parameter
        self._ratio = candidates.ratio
        self._target = self._flat.sum(axis=0)
        self._deciding: list[int] = list(like._deciding) if like is not None else []

    def within(self, kept: Kept) -> FloatArray | None:
        """Factors of all coefficients, (K,), with which the budget is kept; None if there are none."""
        fitted = self._fitted(kept, 1.0 - _CLOSE)
        return fitted if fitted is not None and self._largest(kept, fitted) <= 1.0 else None

    def best(self, kept: Kept, known: FloatArray) -> FloatArray:
        """Factors of all coefficients, (K,), that make the largest error least; the known where these do."""
        fitted = self._fitted(kept, None)
        return known if fitted is None or self._largest(kept, known) < self._largest(kept, fitted) else fitted

    def _largest(self, kept: Kept, scale: FloatArray) -> float:
        return float(np.abs((kept * scale - 1.0) @ self._flat).max(initial=0.0))

    def _fitted(self, kept: Kept, limit: float | None) -> FloatArray | None:
        members = np.flatnonzero(kept)
        members = members[np.argsort(self._parameter[members], kind="stable")]
        _, first, place = np.unique(self._parameter[members], return_index=True, return_inverse=True)
        scale = np.ones(len(kept))
        if not len(members):
            return scale if limit is None or np.abs(self._target).max(initial=0.0) <= limit else None
        columns = np.add.reduceat(self._ratio[members, None] * self._flat[members], first, axis=0)
        if not self._deciding:
            theta, *_ = np.linalg.lstsq(columns.T, self._target, rcond=None)
            self._deciding = np.argsort(-np.abs(theta @ columns - self._target))[:_FIRST].tolist()
        del self._deciding[:-_MOST]
        while True:
            found = _solved(columns[:, self._deciding], self._target[self._deciding], limit, self._work)
            if found is None:
                return None
            theta, least = found
            scale[members] = theta[place] * self._ratio[members]
            error = np.abs(theta @ columns - self._target)
            worst = np.argpartition(-error, min(_BUNCH, len(error) - 1))[:_BUNCH]
            beyond = least * (1.0 + _CLOSE) + _CLOSE
            fresh = sorted(set(worst[error[worst] > beyond].tolist()) - {*self._deciding})
            if not fresh:
                return scale
            self._deciding += fresh


def _solved(
    columns: FloatArray, target: FloatArray, limit: float | None, work: Work
) -> tuple[FloatArray, float] | None:
    """Coefficients within a limit, or of the least largest error, and that; None if none are found."""
    import highspy

    parameters, states = columns.shape
    size = np.maximum(np.abs(columns).max(axis=1, initial=0.0), np.finfo(float).tiny)
    matrix = (columns / size[:, None]).T
    infinite = highspy.kHighsInf
    if limit is None:
        one = np.ones((states, 1))
        matrix = np.vstack([np.hstack([matrix, -one]), np.hstack([matrix, one])])
        lower = np.concatenate([np.full(states, -infinite), target])
        upper = np.concatenate([target, np.full(states, infinite)])
    else:
        lower, upper = target - limit, target + limit
    rows, width = matrix.shape
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.addVars(width, np.full(width, -infinite), np.full(width, infinite))
    if limit is None:
        solver.changeColsCost(1, np.array([parameters], dtype=np.int32), np.ones(1))
    add_rows(solver, np.tile(np.arange(width, dtype=np.int32), (rows, 1)), matrix, lower, upper)
    if not work.solve(solver) or solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        return None
    values = np.array(solver.getSolution().col_value)
    return values[:parameters] / size, float(values[-1]) if limit is None else limit


# Pairs tried in all, and how far apart the coefficients of a pair may be, as a factor.
_TRIALS, _APART = 60, 1.5


def share_coefficients(
    candidates: Candidates,
    kept: Kept,
    scale: FloatArray,
    count: Callable[[Kept, FloatArray], int],
    work: Work,
) -> tuple[Candidates, FloatArray]:
    """Tie coefficients to each other while the budget holds and operations, as `count` says, go down.

    Returned are the candidates with fewer free numbers, and the factors, shape (K,).
    """
    fewest, trials = count(kept, scale), _TRIALS
    refit = Refit(candidates, work)
    while True:
        for one, other in _pairs(candidates, kept, scale):
            if trials == 0 or not work.affords(0.0):
                return candidates, scale
            trials -= 1
            trial = _tied(candidates, scale, one, other)
            refit = Refit(trial, work, refit)
            fitted = refit.within(kept)
            if fitted is not None and (operations := count(kept, fitted)) < fewest:
                candidates, scale, fewest = trial, fitted, operations
                break
        else:
            return candidates, scale


def _pairs(candidates: Candidates, kept: Kept, scale: FloatArray) -> list[tuple[int, int]]:
    """Pairs of candidates that stand for coefficients to tie, the closest first."""
    members = np.flatnonzero(kept & (scale != 0.0))
    _, first = np.unique(candidates.parameter[members], return_index=True)
    chosen = members[first]
    size = np.log2(np.abs(candidates.magnitude[chosen] * scale[chosen]))
    a, b = np.tril_indices(len(chosen), -1)
    apart = np.abs(size[a] - size[b] - np.round(size[a] - size[b]))
    near = apart <= np.log2(_APART)
    found = zip(apart[near].tolist(), chosen[a[near]].tolist(), chosen[b[near]].tolist(), strict=True)
    return [(one, other) for _, one, other in sorted(found)]


def _tied(candidates: Candidates, scale: FloatArray, one: int, other: int) -> Candidates:
    """Let the coefficient of one follow that of the other, at the nearest power of two."""
    size = candidates.magnitude[[one, other]] * np.abs(scale[[one, other]])
    step = size[1] * 2.0 ** np.round(np.log2(size[0] / size[1])) / size[0]
    parameter, ratio = candidates.parameter.copy(), candidates.ratio.copy()
    moved = parameter == parameter[one]
    free = {k: scale[k] / ratio[k] for k in (one, other)}
    ratio[moved] *= free[one] * step / free[other]
    parameter[moved] = parameter[other]
    return dataclasses.replace(candidates, parameter=parameter, ratio=ratio)
