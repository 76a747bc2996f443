"""The cheapest selection of candidates whose torque error stays within the budget: an integer program.

The error of joint i at state s is sum_p a_pis (1 - x_p), x_p = 1 where candidate p is kept. Intermediate
results that the same candidates need form a block b of w_b operations, needed where one of these is kept:

    minimise  sum_b w_b y_b   subject to   y_b >= x_p for every candidate p above b,
              | sum_p a_pis (1 - x_p) | <= allowed_i  for all i, s.

Few states decide: those that a trial solution violates are added until none is. A dive (solve the relaxed
program, keep what is largest, again) takes hundredths of a second; the search from there stops after a number
of nodes, not of seconds, so that every machine finds the same.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeError
from gd_analyze.simplification.effort import Work

# HiGHS accepts solutions that break a row by 1e-6; asking for that much less keeps the promise exact.
_FEASIBILITY_MARGIN = 2e-6
# Rows of larger numbers would lose the budget in the solver's tolerances.
_LARGEST_COEFFICIENT = 1e3
# Nodes per solution, and solutions until every state holds; the relaxed program takes states in bunches.
_NODES, _SOLUTIONS, _BUNCH = 40, 12, 50
# What such a search takes, in solutions of the relaxed program from the start: cuts, heuristics and nodes.
_SEARCHING = 50
# A relaxed variable this close to 0 or 1 is that.
_WHOLE = 1e-6
# The dive keeps what is this close to 1, beside the largest.
_NEARLY = 0.7


def select(
    errors: FloatArray,
    allowed: float,
    costs: Mapping[frozenset[int], int],
    *,
    thorough: bool = True,
    work: Work | None = None,
) -> tuple[NDArray[np.bool_], bool]:
    """Choose the candidates to keep, (P,), given a_pis, N m, (P, n, N); and whether none are cheaper.

    Only one descent is made unless `thorough`. A GdAnalyzeError if the solver fails.
    """
    count, n_joints, n_states = errors.shape
    flat = (errors / allowed).reshape(count, n_joints * n_states)
    program = _Program(flat, costs, work or Work())
    best = program.dive()
    if not thorough:
        return best, False
    for _ in range(_SOLUTIONS):
        found = program.search(best)
        if found is None:
            break
        kept, optimal = found
        if program.hold(kept):
            cheaper = kept if program.cost(kept) < program.cost(best) else best
            return cheaper, optimal and not program.barred
    return best, False


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
        """Operations of a selection, as blocks tell."""
        needed = [kept[members].any() for members in self._members]
        return float(self._weights[needed].sum())

    def hold(self, kept: NDArray[np.bool_]) -> bool:
        """Whether a selection is within the budget at every state; those where it is not join the rows."""
        beyond = _largest_beyond(np.abs(self._flat[~kept].sum(axis=0)))
        fresh = sorted({*beyond} - {*self._rows})
        self._rows += fresh
        if beyond and not fresh:
            # A row that is there already was broken within the solver's tolerance: bar what broke it.
            self.barred.append(np.flatnonzero(~kept & (self._flat[:, beyond[0]] != 0.0)).tolist())
        return not beyond

    def search(self, start: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], bool] | None:
        """Best selection found within the budget at the rows, and whether it is proven; None if too long."""
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
        status = solver.getModelStatus()
        values = np.array(solver.getSolution().col_value)
        if len(values) != count + len(self._members) or not solver.getInfo().primal_solution_status:
            if not ended:
                return None
            raise _failed(solver)
        return values[:count] > 0.5, status == highspy.HighsModelStatus.kOptimal

    def dive(self) -> NDArray[np.bool_]:
        """Solve the relaxed program, keep the largest fraction, and again; what is undecided then stays."""
        import highspy

        solver, count = self._solver(), len(self._flat)
        solver.setOptionValue("presolve", "off")  # the solver goes on from where it was
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
        while not self.hold(kept):  # by the solver's tolerance at most
            dropped = np.flatnonzero(~kept)
            kept[dropped[np.abs(self._flat[dropped]).max(axis=1).argmax()]] = True
        return kept

    def _solver(self) -> Any:
        """The relaxed program with the rows so far."""
        import highspy

        count = len(self._flat)
        cost = np.concatenate([np.zeros(count), self._weights])
        solver = highspy.Highs()
        solver.setOptionValue("output_flag", False)
        solver.addVars(len(cost), np.zeros(len(cost)), np.ones(len(cost)))
        solver.changeColsCost(len(cost), np.arange(len(cost), dtype=np.int32), cost)
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
    """Where errors are beyond the budget, the largest of them."""
    beyond = np.flatnonzero(errors > 1.0)
    return [int(s) for s in beyond[np.argsort(-errors[beyond], kind="stable")][:_BUNCH]]


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
