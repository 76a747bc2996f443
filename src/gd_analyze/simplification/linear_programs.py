"""The cheapest selection within the budget, an integer program, and its refitted coefficients, a linear one.

The error of joint i at state s is sum_p a_pis (1 - x_p), with x_p = 1 if candidate p is kept. Intermediate
results of w_b operations that the same candidates need form a block b. Minimize sum_b w_b y_b, with y_b >=
x_p for every p above b, and allowed errors. A dive (solve the relaxed program, keep the largest, repeat)
takes tenths of a second; the search stops after some nodes, so that every machine finds the same. Few states
matter: those that a trial solution violates are added until none is violated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.simplification.candidates import Candidates, Kept
from gd_analyze.simplification.effort import Work

# HiGHS accepts solutions that violate a row by 1e-6; a budget smaller by that much is kept exactly.
_FEASIBILITY_MARGIN = 2e-6
# In rows of larger numbers the budget would vanish in the solver's tolerances.
_LARGEST_COEFFICIENT = 1e3
# Nodes per solution, and solutions until every state holds; the relaxed program adds states in batches.
_NODES, _SOLUTIONS, _BUNCH = 40, 12, 50
# Multiplications per iteration and coefficient of a linear program, of as many iterations as rows, from times
# on a machine of 2025; and such programs in a search: cuts, heuristics and nodes.
_SIMPLEX, _SEARCHING = 3.0, 50
# Status of a program that ended at its limit of nodes.
_AT_LIMIT = 1
# A relaxed variable this close to 0 or 1 is rounded.
_WHOLE = 1e-6
# The dive keeps variables this close to 1, and the largest.
_NEARLY = 0.7


def _solved(
    work: Work,
    costs: FloatArray,
    rows: Any,
    ranges: tuple[FloatArray, FloatArray],
    bounds: tuple[FloatArray | float, FloatArray | float],
    whole: NDArray[np.int64] | None = None,
) -> Any:
    """Solve a linear program, or one with `whole` numbers to some nodes; None if it takes too long."""
    from scipy.optimize import Bounds, LinearConstraint, milp

    numbers = rows.size if isinstance(rows, np.ndarray) else rows.nnz
    amount = _SIMPLEX * numbers * rows.shape[0] * (1 if whole is None else _SEARCHING)
    if not work.affords(amount):
        return None
    work.spend(amount)
    constraints = LinearConstraint(rows, *ranges)
    options: Any = {} if whole is None else {"node_limit": _NODES}
    return milp(costs, integrality=whole, bounds=Bounds(*bounds), constraints=constraints, options=options)


def select(
    errors: FloatArray,
    allowed: float,
    costs: Mapping[frozenset[int], int],
    *,
    thorough: bool = True,
    work: Work | None = None,
) -> Kept:
    """Choose candidates to keep, (P,), given a_pis, N m, (P, n, N)."""
    program = _Selection((errors / allowed).reshape(len(errors), -1), costs, work or Work())
    best = program.dive()
    for _ in range(_SOLUTIONS if thorough else 0):
        kept = program.search()
        if kept is None:
            break
        if program.hold(kept):
            return min(best, kept, key=program.cost)
    return best


class _Selection:
    """The program over x (candidates) and y (blocks), with the states held so far."""

    def __init__(self, flat: FloatArray, costs: Mapping[frozenset[int], int], work: Work) -> None:
        from scipy.sparse import csr_array

        self._flat, self._work = flat, work
        self._weights = np.array(list(costs.values()), dtype=float)
        count = len(flat)
        pairs = np.array([(b, p) for b, members in enumerate(costs) for p in sorted(members)], dtype=int)
        blocks, members = pairs.reshape(-1, 2).T
        each = np.arange(len(blocks))
        signs, places = np.repeat([1.0, -1.0], len(each)), (np.tile(each, 2), np.r_[count + blocks, members])
        self._needs = csr_array((signs, places), shape=(len(each), count + len(costs)))
        self._users = csr_array((np.ones(len(each)), (blocks, members)), shape=(len(costs), count))
        self._rows = sorted(set(np.abs(flat).argmax(axis=1).tolist())) if flat.size else []
        self._barred: list[FloatArray] = []

    def cost(self, kept: Kept) -> float:
        """Operations of a selection, from blocks."""
        return float(self._weights[self._users @ kept.astype(float) > 0.0].sum())

    def hold(self, kept: Kept) -> bool:
        """Whether a selection is within the budget at every state; violated states become rows."""
        beyond = self._add(np.abs(self._flat[~kept].sum(axis=0)))
        if beyond is not None and not beyond:
            # An existing row was violated within the solver's tolerance: exclude this selection.
            self._barred.append((~kept).astype(float))
        return beyond is None

    def search(self) -> Kept | None:
        """Best selection found within the budget at the rows; None if too long."""
        x = self._solve(np.zeros(len(self._flat)), whole=True)
        return None if x is None else x > 0.5

    def dive(self) -> Kept:
        """Solve the relaxed program, keep the largest fraction, and repeat; undecided candidates stay."""
        settled, x = np.zeros(len(self._flat)), np.ones(len(self._flat))
        while (relaxed := self._solve(settled)) is not None:
            x = relaxed
            if self._add(np.abs((1.0 - x) @ self._flat)):
                continue
            unsettled = (x > _WHOLE) & (x < 1.0 - _WHOLE) & (settled == 0.0)
            if not unsettled.any():
                break
            settled[unsettled & (x > _NEARLY)] = 1.0
            settled[np.where(unsettled, x, -1.0).argmax()] = 1.0
        kept = x > _WHOLE
        while not self.hold(kept):  # the effort ended, or the solver's tolerance
            dropped = np.flatnonzero(~kept)
            kept[dropped[np.abs(self._flat[dropped]).max(axis=1).argmax()]] = True
        return kept

    def _add(self, errors: FloatArray) -> Sequence[int] | None:
        """Make rows of the states of the largest errors beyond the budget; the new ones, or None."""
        beyond = np.flatnonzero(errors > 1.0)
        if not beyond.size:
            return None
        largest = beyond[np.argsort(-errors[beyond], kind="stable")][:_BUNCH].tolist()
        fresh = sorted({*largest} - {*self._rows})
        self._rows += fresh
        return fresh

    def _solve(self, least: FloatArray, *, whole: bool = False) -> FloatArray | None:
        """The x of the program with the rows so far, and at least these x."""
        from scipy.sparse import csr_array, vstack

        count, width = len(self._flat), self._needs.shape[1]
        lost = self._flat[:, self._rows].T
        shrink = np.maximum(1.0, np.abs(lost).max(axis=1, initial=0.0) / _LARGEST_COEFFICIENT)
        lost, limit = lost / shrink[:, None], (1.0 - _FEASIBILITY_MARGIN) / shrink
        everything, barred = lost.sum(axis=1), np.array(self._barred).reshape(-1, count)
        dense = np.zeros((len(lost) + len(barred), width))
        dense[:, :count] = np.concatenate([lost, barred])
        free, needs = np.full(len(barred), np.inf), np.zeros(self._needs.shape[0])
        lower = np.r_[needs, everything - limit, np.ones(len(barred))]
        upper = np.r_[np.full(len(needs), np.inf), everything + limit, free]
        rows = vstack([self._needs, csr_array(dense)], format="csr")
        costs, bounds = np.r_[np.zeros(count), self._weights], (np.r_[least, 0.0 * self._weights], 1.0)
        kinds = (np.arange(width) < count).astype(int) if whole else None
        found = _solved(self._work, costs, rows, (lower, upper), bounds, kinds)
        if found is not None and found.x is None and found.status != _AT_LIMIT:
            next_step = "please report this with the arm file and the trajectory"
            raise GdAnalyzeError("the selection failed", found=found.message, next_step=next_step)
        return None if found is None or found.x is None else found.x[:count]


# The set starts with the states of largest errors of a quadratic fit; further ones are added in batches, and
# at most this many stay for the next selection.
_FIRST, _JOINING, _MOST = 200, 25, 600
# The solver keeps its rows to 1e-7 of numbers of some hundred budgets.
_CLOSE = 1e-6


class Refit:
    """Repeated refits of kept candidates, with memory of the deciding states."""

    def __init__(self, candidates: Candidates, work: Work) -> None:
        self._work = work
        self._flat = candidates.flat
        self._parameter = candidates.parameter
        self._target = self._flat.sum(axis=0)
        self._deciding: list[int] = []

    def within(self, kept: Kept) -> FloatArray | None:
        """Factors of all coefficients, (K,), that keep the budget; None if there are none."""
        fitted = self._fitted(kept, 1.0 - _CLOSE)
        return fitted if fitted is not None and self._largest(kept, fitted) <= 1.0 else None

    def best(self, kept: Kept, known: FloatArray) -> FloatArray:
        """Factors of all coefficients, (K,), that minimize the largest error; the known ones if these do."""
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
        columns = np.add.reduceat(self._flat[members], first, axis=0)
        if not self._deciding:
            theta, *_ = np.linalg.lstsq(columns.T, self._target, rcond=None)
            self._deciding = np.argsort(-np.abs(theta @ columns - self._target))[:_FIRST].tolist()
        del self._deciding[:-_MOST]
        while True:
            found = self._solve(columns[:, self._deciding], self._target[self._deciding], limit)
            if found is None:
                return None
            theta, least = found
            scale[members] = theta[place]
            error = np.abs(theta @ columns - self._target)
            worst = np.argpartition(-error, min(_JOINING, len(error) - 1))[:_JOINING]
            beyond = least * (1.0 + _CLOSE) + _CLOSE
            fresh = sorted(set(worst[error[worst] > beyond].tolist()) - {*self._deciding})
            if not fresh:
                return scale
            self._deciding += fresh

    def _solve(
        self, columns: FloatArray, target: FloatArray, limit: float | None
    ) -> tuple[FloatArray, float] | None:
        """Coefficients within a limit, or with minimal largest error, and that error; None if not found."""
        parameters, states = columns.shape
        size = np.maximum(np.abs(columns).max(axis=1, initial=0.0), np.finfo(float).tiny)
        matrix, free = (columns / size[:, None]).T, np.full(states, np.inf)
        if limit is None:
            one = np.ones((states, 1))
            matrix = np.vstack([np.hstack([matrix, -one]), np.hstack([matrix, one])])
            ranges = np.r_[-free, target], np.r_[target, free]
        else:
            ranges = target - limit, target + limit
        costs = (np.arange(matrix.shape[1]) == parameters).astype(float)
        found = _solved(self._work, costs, matrix, ranges, (-np.inf, np.inf))
        if found is None or found.x is None:
            return None
        return found.x[:parameters] / size, float(found.x[-1]) if limit is None else limit
