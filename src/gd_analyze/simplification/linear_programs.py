"""The cheapest selection within the budget, an integer program, and its refitted coefficients, a linear one.

The error of joint i at state s is sum_p a_pis (1 - x_p), with x_p = 1 if candidate p is kept. Intermediate
results of w_b operations that the same candidates need form a block b. Minimize sum_b w_b y_b, with y_b >=
x_p for every p above b, and allowed errors. A dive (solve the relaxed program, keep the largest, repeat)
takes hundredths of a second; the search from there stops after some nodes, so that every machine finds the
same. Few states matter: those that a trial solution violates are added until none is violated.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.simplification.candidates import Candidates, Kept
from gd_analyze.simplification.effort import Work

# HiGHS accepts solutions that violate a row by 1e-6; a budget smaller by that much is kept exactly.
_FEASIBILITY_MARGIN = 2e-6
# In rows of larger numbers the budget would vanish in the solver's tolerances.
_LARGEST_COEFFICIENT = 1e3
# Nodes per solution, and solutions until every state holds; the relaxed program adds states in batches.
_NODES, _SOLUTIONS, _BUNCH = 40, 12, 50
# Cost of such a search, in solutions of the relaxed program: cuts, heuristics and nodes.
_SEARCHING = 50
# A relaxed variable this close to 0 or 1 is rounded.
_WHOLE = 1e-6
# The dive keeps variables this close to 1, and the largest.
_NEARLY = 0.7


def select(
    errors: FloatArray,
    allowed: float,
    costs: Mapping[frozenset[int], int],
    *,
    thorough: bool = True,
    work: Work | None = None,
) -> NDArray[np.bool_]:
    """Choose candidates to keep, (P,), given a_pis, N m, (P, n, N)."""
    count, n_joints, n_states = errors.shape
    flat = (errors / allowed).reshape(count, n_joints * n_states)
    program = _Program(flat, costs, work or Work())
    best = program.dive()
    if not thorough:
        return best
    for _ in range(_SOLUTIONS):
        kept = program.search(best)
        if kept is None:
            break
        if program.hold(kept):
            return kept if program.cost(kept) < program.cost(best) else best
    return best


class _Program:
    """The program over x (candidates) and y (blocks), with the states held so far."""

    def __init__(self, flat: FloatArray, costs: Mapping[frozenset[int], int], work: Work) -> None:
        self._work, self._relaxed = work, 0.0
        self._flat = flat
        self._members = [sorted(members) for members in costs]
        self._weights = np.array(list(costs.values()), dtype=float)
        self._rows = sorted(set(np.abs(flat).argmax(axis=1).tolist())) if flat.size else []
        self.barred: list[list[int]] = []

    def cost(self, kept: NDArray[np.bool_]) -> float:
        """Operations of a selection, from blocks."""
        needed = [kept[members].any() for members in self._members]
        return float(self._weights[needed].sum())

    def hold(self, kept: NDArray[np.bool_]) -> bool:
        """Whether a selection is within the budget at every state; violated states become rows."""
        beyond = _largest_beyond(np.abs(self._flat[~kept].sum(axis=0)))
        fresh = sorted({*beyond} - {*self._rows})
        self._rows += fresh
        if beyond and not fresh:
            # An existing row was violated within the solver's tolerance: exclude this selection.
            self.barred.append(np.flatnonzero(~kept & (self._flat[:, beyond[0]] != 0.0)).tolist())
        return not beyond

    def search(self, start: NDArray[np.bool_]) -> NDArray[np.bool_] | None:
        """Best selection found within the budget at the rows; None if too long."""
        import highspy

        if not self._work.affords(_SEARCHING * self._relaxed):
            return None
        solver, count = self._solver(), len(self._flat)
        whole = np.full(count, int(highspy.HighsVarType.kInteger), dtype=np.uint8)
        solver.changeColsIntegrality(count, np.arange(count, dtype=np.int32), whole)
        for members in self.barred:
            add_rows(solver, np.array([members], dtype=np.int32), np.ones((1, len(members))), 1.0, np.inf)
        solver.setOptionValue("mip_max_nodes", _NODES)
        guess = highspy.HighsSolution()
        needed = [float(start[members].any()) for members in self._members]
        guess.col_value = [*start.astype(float).tolist(), *needed]
        solver.setSolution(guess)
        ended = self._work.solve(solver)
        values = np.array(solver.getSolution().col_value)
        if len(values) != count + len(self._members) or not solver.getInfo().primal_solution_status:
            if not ended:
                return None
            raise _failed(solver)
        return values[:count] > 0.5

    def dive(self) -> NDArray[np.bool_]:
        """Solve the relaxed program, keep the largest fraction, and repeat; undecided candidates stay."""
        import highspy

        solver, count = self._solver(), len(self._flat)
        solver.setOptionValue("presolve", "off")  # the solver continues from its last basis
        settled = np.zeros(count, dtype=bool)
        x = np.ones(count)
        while True:
            before = self._work.spent
            if not self._work.solve(solver):
                break
            self._relaxed = max(self._relaxed, self._work.spent - before)
            if solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
                raise _failed(solver)
            x = np.array(solver.getSolution().col_value)[:count]
            beyond = _largest_beyond(np.abs((1.0 - x) @ self._flat))
            if fresh := sorted({*beyond} - {*self._rows}):
                self._rows += fresh
                self._add_states(solver, fresh)
                continue
            open_ = (x > _WHOLE) & (x < 1.0 - _WHOLE) & ~settled
            if not open_.any():
                break
            largest = int(np.where(open_, x, -1.0).argmax())
            for k in {*np.flatnonzero(open_ & (x > _NEARLY)).tolist(), largest}:
                settled[k] = True
                solver.changeColBounds(k, 1.0, 1.0)
        kept = x > _WHOLE
        while not self.hold(kept):  # violated at most by the solver's tolerance
            dropped = np.flatnonzero(~kept)
            kept[dropped[np.abs(self._flat[dropped]).max(axis=1).argmax()]] = True
        return kept

    def _solver(self) -> Any:
        """The relaxed program with the rows so far."""
        count = len(self._flat)
        solver = _solver_of(np.concatenate([np.zeros(count), self._weights]), 0.0, 1.0)
        pairs = [(count + b, p) for b, members in enumerate(self._members) for p in members]
        signs = np.tile([1.0, -1.0], (len(pairs), 1))
        add_rows(solver, np.array(pairs, dtype=np.int32).reshape(-1, 2), signs, 0.0, np.inf)
        self._add_states(solver, self._rows)
        return solver

    def _add_states(self, solver: Any, rows: list[int]) -> None:
        lost = self._flat[:, rows].T
        shrink = np.maximum(1.0, np.abs(lost).max(axis=1, initial=0.0) / _LARGEST_COEFFICIENT)
        lost, limit = lost / shrink[:, None], (1.0 - _FEASIBILITY_MARGIN) / shrink
        everything = lost.sum(axis=1)
        columns = np.tile(np.arange(len(self._flat), dtype=np.int32), (len(rows), 1))
        add_rows(solver, columns, lost, everything - limit, everything + limit)


def _largest_beyond(errors: FloatArray) -> list[int]:
    """Largest errors beyond the budget."""
    beyond = np.flatnonzero(errors > 1.0)
    return [int(s) for s in beyond[np.argsort(-errors[beyond], kind="stable")][:_BUNCH]]


def _solver_of(costs: Array, lower: float, upper: float) -> Any:
    """An empty program over variables of these costs, all between the same bounds."""
    import highspy

    def silenced(solver: Any) -> None:  # since 1.16 the first call prints a banner: this is the first
        solver.setOptionValue("output_flag", False)
        highspy.Highs.enableCallbacks(solver)

    solver, count = type("Silent", (highspy.Highs,), {"enableCallbacks": silenced})(), len(costs)
    solver.addVars(count, np.full(count, lower), np.full(count, upper))
    solver.changeColsCost(count, np.arange(count, dtype=np.int32), costs.astype(float))
    return solver


def _failed(solver: Any) -> GdAnalyzeError:
    status = solver.modelStatusToString(solver.getModelStatus())
    next_step = "please report this with the arm file and the trajectory"
    return GdAnalyzeError("the selection failed", found=status, next_step=next_step)


def add_rows(
    solver: Any,
    columns: NDArray[np.int32],
    coefficients: FloatArray,
    lower: FloatArray | float,
    upper: FloatArray | float,
) -> None:
    """Add rows lower <= sum of coefficients * columns <= upper, one per line of `columns`."""
    count, width = columns.shape
    solver.addRows(
        count,
        np.broadcast_to(lower, count).astype(float),
        np.broadcast_to(upper, count).astype(float),
        columns.size,
        np.arange(0, columns.size, max(width, 1), dtype=np.int32),
        columns.ravel(),
        coefficients.ravel(),
    )


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
            found = _solved(columns[:, self._deciding], self._target[self._deciding], limit, self._work)
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


def _solved(
    columns: FloatArray, target: FloatArray, limit: float | None, work: Work
) -> tuple[FloatArray, float] | None:
    """Coefficients within a limit, or with minimal largest error, and that error; None if not found."""
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
    solver = _solver_of(np.arange(width) == parameters, -infinite, infinite)
    add_rows(solver, np.tile(np.arange(width, dtype=np.int32), (rows, 1)), matrix, lower, upper)
    if not work.solve(solver) or solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
        return None
    values = np.array(solver.getSolution().col_value)
    return values[:parameters] / size, float(values[-1]) if limit is None else limit
