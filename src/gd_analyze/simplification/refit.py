"""Refit: coefficients of the kept terms that make up for dropped ones, so that more terms can go.

The coefficients with the smallest largest error solve a linear program. Few states matter: those at which a
trial solution errs most are added until none errs more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.simplification.candidates import Candidates
from gd_analyze.simplification.effects import Mask


@dataclass(frozen=True, kw_only=True)
class _RefitSettings:
    """Linear programs on states that join by and by."""

    first_states: int = 200  # states of the first linear program
    joining_states: int = 25  # most states that are added to a linear program at a time
    most_continued_states: int = 600  # most states that the next linear program starts with
    solver_tolerance: float = 1e-6  # the solver keeps its rows to 1e-7 of numbers of some hundred budgets
    most_trials: int = 200  # most terms that a refit tries to drop: each try takes hundredths of a second


_SETTINGS = _RefitSettings()


def refitted(candidates: Candidates, selected: Mask, stays: Mask) -> tuple[Mask, FloatArray] | None:
    """Drop further terms of a selection, (K,), while a refit of the others keeps the budget.

    Also returns the factors of all coefficients, (K,); None if no refit keeps the budget.
    """
    fit = _Fit(candidates)
    factors, error = fit.best(selected)
    if error > 1.0:
        return None
    selected, trials = selected.copy(), _SETTINGS.most_trials
    order = _by_torque(candidates, selected & ~stays)
    improved = True
    while improved:
        improved = False
        for term in order:
            if not selected[term] or trials == 0:
                continue
            trials -= 1
            trial = selected.copy()
            trial[term] = False
            trial_factors, error = fit.best(trial)
            if error <= 1.0 - _SETTINGS.solver_tolerance:
                selected, factors, improved = trial, trial_factors, True
    return selected, factors


def _by_torque(candidates: Candidates, terms: Mask) -> list[int]:
    """Some terms, those with the smallest torque first."""
    effects = candidates.choice.effects
    size = np.bincount(effects.term, (effects.torque**2).sum(axis=1), minlength=len(candidates))
    chosen = np.flatnonzero(terms)
    return chosen[np.argsort(size[chosen], kind="stable")].tolist()


class _Fit:
    """Fits of selections, with memory of the states that decide."""

    def __init__(self, candidates: Candidates) -> None:
        choice = candidates.choice
        self._torque = choice.effects.dense().reshape(len(candidates), choice.base.size)
        self._target = self._torque.sum(axis=0) + choice.base.ravel()
        self._parameter = candidates.parameters
        self._deciding: NDArray[np.intp] = np.empty(0, dtype=np.intp)

    def best(self, selected: Mask) -> tuple[FloatArray, float]:
        """Factors of all coefficients, (K,), with the smallest largest error, and that error."""
        factors, members = np.ones(len(selected)), np.flatnonzero(selected)
        if not len(members):
            return factors, float(np.abs(self._target).max(initial=0.0))
        _, place = np.unique(self._parameter[members], return_inverse=True)
        columns = np.zeros((place.max() + 1, len(self._target)))
        np.add.at(columns, place, self._torque[members])
        if not len(self._deciding):
            theta, *_ = np.linalg.lstsq(columns.T, self._target, rcond=None)
            self._deciding = np.argsort(-np.abs(theta @ columns - self._target))[: _SETTINGS.first_states]
        deciding = self._deciding[-_SETTINGS.most_continued_states :]
        while True:
            theta, smallest_error = _smallest_largest(columns[:, deciding], self._target[deciding])
            error = np.abs(theta @ columns - self._target)
            if smallest_error > 1.0:  # beyond the budget at these states already
                break
            worst = np.argsort(-error, kind="stable")[: _SETTINGS.joining_states]
            tolerated = smallest_error * (1.0 + _SETTINGS.solver_tolerance) + _SETTINGS.solver_tolerance
            fresh = np.setdiff1d(worst[error[worst] > tolerated], deciding)
            if not len(fresh):
                break
            deciding = np.concatenate([deciding, fresh])
        self._deciding = deciding
        factors[members] = theta[place]
        return factors, float(error.max(initial=0.0))


def _smallest_largest(columns: FloatArray, target: FloatArray) -> tuple[FloatArray, float]:
    """Coefficients (P,) of columns (P, S) with the smallest largest error at S states, and that error."""
    from scipy.optimize import linprog

    size = np.maximum(np.abs(columns).max(axis=1), np.finfo(float).tiny)
    matrix = (columns / size[:, None]).T
    ones = np.ones((len(target), 1))
    solved = linprog(
        np.append(np.zeros(len(columns)), 1.0),
        A_ub=np.block([[matrix, -ones], [-matrix, -ones]]),
        b_ub=np.concatenate([target, -target]),
        bounds=[(None, None)] * len(columns) + [(0.0, None)],
        method="highs",
    )
    if solved.x is None:  # numerically hopeless: the coefficients of least squares
        theta, *_ = np.linalg.lstsq(matrix, target, rcond=None)
        return theta / size, float(np.abs(matrix @ theta - target).max())
    return solved.x[:-1] / size, float(solved.x[-1])
