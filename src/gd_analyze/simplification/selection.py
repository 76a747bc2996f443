"""The cheapest selection of parts whose torque error stays within the budget.

Torque is a sum of parts, so the error of joint i at set point t is linear in what is dropped:
sum_p a_pit (1 - x_p), x_p = 1 where part p is kept. What a selection costs is not linear in x, because
parts share arithmetic; but an intermediate result is needed exactly when one of the parts above it is kept.
Intermediates with the same parts above them form one block b of w_b operations, so

    minimise  sum_b w_b y_b   subject to   y_b >= x_p for every part p above b,
              | sum_p a_pit (1 - x_p) | <= allowed_i  for all i, t

is an integer program whose optimum is that in operations, up to the few that putting parts into torques may
share. Few set points decide: only those that a trial solution violates are added, until none is.
"""

from __future__ import annotations

import time
from collections import defaultdict
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.operations import Expression, Trace
from gd_analyze.vectors import FloatArray

# HiGHS accepts solutions that break a row by 1e-6; asking for that much less keeps the promise exact.
_FEASIBILITY_MARGIN = 2e-6
# Rows of larger numbers would lose the budget in the solver's tolerances.
_LARGEST_COEFFICIENT = 1e3
_TIME_LIMIT = 20.0  # s


@dataclass(frozen=True)
class Selection:
    """What to keep, and whether it is proven to be the cheapest."""

    kept: tuple[bool, ...]
    optimal: bool


def blocks(trace: Trace, outputs: list[list[object]]) -> dict[frozenset[int], int]:
    """Operations by the set of parts that need them.

    Parameters
    ----------
    trace
        The arithmetic.
    outputs
        Expressions of each part.

    Returns
    -------
    dict
        Number of multiplications and additions (sines and cosines too) needed by exactly those parts.
    """
    above: dict[int, int] = defaultdict(int)
    for p, expressions in enumerate(outputs):
        for expression in expressions:
            if isinstance(expression, Expression):
                above[expression.order] |= 1 << p
    weights: dict[int, int] = defaultdict(int)
    for node in reversed(trace.expressions):
        parts = above.get(node.order, 0)
        if not parts:
            continue
        for argument in node.arguments:
            if isinstance(argument, Expression):
                above[argument.order] |= parts
        if node.operation not in ("input", "negative"):
            weights[parts] += 1
    return {
        frozenset(p for p in range(len(outputs)) if parts >> p & 1): weight
        for parts, weight in weights.items()
    }


def select(
    errors: FloatArray,
    allowed: FloatArray,
    costs: dict[frozenset[int], int],
    seconds: float = _TIME_LIMIT,
) -> Selection:
    """Choose the parts to keep.

    Parameters
    ----------
    errors
        a_pit, torque lost at joint i and set point t when part p is dropped, N m, shape (P, n, N).
    allowed
        Allowed error per joint, N m, shape (n,).
    costs
        Operations by the set of parts that need them, see `blocks`.
    seconds
        Time the search may take.

    Returns
    -------
    Selection
        The cheapest parts within the budget; everything, not proven cheapest, where time ran out before any
        solution held at every set point.

    Raises
    ------
    GdAnalyzeError
        If the solver fails.
    """
    n_parts, n_joints, _ = errors.shape
    scaled = errors / allowed[:, None]
    rows = {(i, int(np.abs(scaled[p, i]).argmax())) for i in range(n_joints) for p in range(n_parts)}
    barred: set[frozenset[int]] = set()
    end = time.monotonic() + seconds
    while True:
        left_over = end - time.monotonic()
        if left_over <= 0.0:
            return Selection((True,) * n_parts, optimal=False)
        kept, optimal = _solve(scaled, costs, sorted(rows), sorted(barred, key=sorted), left_over)
        left = scaled[~kept].sum(axis=0)
        worst = {(i, int(np.abs(left[i]).argmax())) for i in range(n_joints) if np.abs(left[i]).max() > 1.0}
        if not worst:
            return Selection(tuple(bool(k) for k in kept), optimal and not barred)
        # A row that is there already was broken within the solver's tolerance: bar what broke it.
        barred |= {
            frozenset(np.flatnonzero(~kept & (scaled[:, i, t] != 0.0)).tolist()) for i, t in worst & rows
        }
        rows |= worst


def _solve(
    scaled: FloatArray,
    costs: dict[frozenset[int], int],
    rows: list[tuple[int, int]],
    barred: list[frozenset[int]],
    seconds: float,
) -> tuple[NDArray[np.bool_], bool]:
    """Integer program over x (parts) and y (blocks).

    `rows` are the (joint, set point) held to the budget; of each set in `barred` one part must stay.
    """
    import highspy

    n_parts = len(scaled)
    members = [sorted(parts) for parts in costs]
    cost = np.concatenate([np.zeros(n_parts), np.array(list(costs.values()), dtype=float)])
    n_columns = len(cost)
    solver = highspy.Highs()
    solver.setOptionValue("output_flag", False)
    solver.setOptionValue("time_limit", seconds)
    solver.addVars(n_columns, np.zeros(n_columns), np.ones(n_columns))
    solver.changeColsCost(n_columns, np.arange(n_columns, dtype=np.int32), cost)
    solver.changeColsIntegrality(
        n_parts,
        np.arange(n_parts, dtype=np.int32),
        np.full(n_parts, int(highspy.HighsVarType.kInteger), dtype=np.uint8),
    )
    pairs = np.array([(n_parts + b, p) for b, parts in enumerate(members) for p in parts], dtype=np.int32)
    _add_rows(solver, pairs, np.tile([1.0, -1.0], (len(pairs), 1)), 0.0, np.inf)
    lost = np.array([scaled[:, i, t] for i, t in rows])
    shrink = np.maximum(1.0, np.abs(lost).max(axis=1) / _LARGEST_COEFFICIENT)
    lost, limit = lost / shrink[:, None], (1.0 - _FEASIBILITY_MARGIN) / shrink
    everything = lost.sum(axis=1)
    each_part = np.tile(np.arange(n_parts, dtype=np.int32), (len(rows), 1))
    _add_rows(solver, each_part, lost, everything - limit, everything + limit)
    for parts in barred:
        _add_rows(solver, np.array([sorted(parts)], dtype=np.int32), np.ones((1, len(parts))), 1.0, np.inf)
    solver.run()
    status = solver.getModelStatus()
    values = np.array(solver.getSolution().col_value)
    if status == highspy.HighsModelStatus.kTimeLimit and not solver.getInfo().primal_solution_status:
        return np.ones(n_parts, dtype=bool), False
    if len(values) != n_columns or not solver.getInfo().primal_solution_status:
        raise GdAnalyzeError(
            "the selection of parts failed",
            found=solver.modelStatusToString(status),
            next_step="please report this with the arm file and the trajectory",
        )
    return values[:n_parts] > 0.5, status == highspy.HighsModelStatus.kOptimal


def _add_rows(
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
