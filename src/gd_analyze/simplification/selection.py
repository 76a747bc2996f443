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

from collections import defaultdict
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.errors import GdAnalyzeError
from gd_analyze.operations import Expression, Trace
from gd_analyze.vectors import FloatArray

# HiGHS accepts solutions that break a row by 1e-6; asking for that much less keeps the promise exact.
_FEASIBILITY_MARGIN = 2e-6
# Rows of larger numbers would lose the budget in the solver's tolerances.
_LARGEST_COEFFICIENT = 1e3
_TIME_LIMIT = 20.0


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


def select(errors: FloatArray, allowed: FloatArray, costs: dict[frozenset[int], int]) -> Selection:
    """Choose the parts to keep.

    Parameters
    ----------
    errors
        a_pit, torque lost at joint i and set point t when part p is dropped, N m, shape (P, n, N).
    allowed
        Allowed error per joint, N m, shape (n,).
    costs
        Operations by the set of parts that need them, see `blocks`.

    Returns
    -------
    Selection
        The cheapest parts within the budget.

    Raises
    ------
    GdAnalyzeError
        If the solver fails.
    """
    n_parts, n_joints, _ = errors.shape
    scaled = errors / allowed[:, None]
    rows = {(i, int(np.abs(scaled[p, i]).argmax())) for i in range(n_joints) for p in range(n_parts)}
    barred: set[frozenset[int]] = set()
    while True:
        kept, optimal = _solve(scaled, costs, sorted(rows), sorted(barred, key=sorted))
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
) -> tuple[NDArray[np.bool_], bool]:
    """Integer program over x (parts) and y (blocks).

    `rows` are the (joint, set point) held to the budget; of each set in `barred` one part must stay.
    """
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import coo_array

    n_parts = len(scaled)
    members = [sorted(parts) for parts in costs]
    weights = np.array(list(costs.values()), dtype=float)
    n_blocks = len(members)
    pairs = [(b, p) for b, parts in enumerate(members) for p in parts]
    r = np.arange(len(pairs))
    needs = coo_array(
        (
            np.concatenate([np.ones(len(pairs)), -np.ones(len(pairs))]),
            (
                np.concatenate([r, r]),
                np.concatenate([[n_parts + b for b, _ in pairs], [p for _, p in pairs]]).astype(int),
            ),
        ),
        shape=(len(pairs), n_parts + n_blocks),
    )
    lost = np.array([scaled[:, i, t] for i, t in rows])
    shrink = np.maximum(1.0, np.abs(lost).max(axis=1) / _LARGEST_COEFFICIENT)
    lost, limit = lost / shrink[:, None], (1.0 - _FEASIBILITY_MARGIN) / shrink
    everything = lost.sum(axis=1)
    held = [
        LinearConstraint(needs.tocsr(), 0.0, np.inf),
        LinearConstraint(_widened(lost, n_blocks), everything - limit, everything + limit),
    ]
    if barred:
        stays = np.array([[float(p in parts) for p in range(n_parts)] for parts in barred])
        held.append(LinearConstraint(_widened(stays, n_blocks), 1.0, np.inf))
    solution = milp(
        c=np.concatenate([np.zeros(n_parts), weights]),
        integrality=np.concatenate([np.ones(n_parts), np.zeros(n_blocks)]),
        bounds=Bounds(0.0, 1.0),
        constraints=held,
        options={"time_limit": _TIME_LIMIT},
    )
    if solution.x is None:
        raise GdAnalyzeError("the selection of parts failed", found=str(solution.message))
    return solution.x[:n_parts] > 0.5, solution.status == 0


def _widened(coefficients: FloatArray, n_blocks: int) -> FloatArray:
    """Rows over the parts as rows over parts and blocks."""
    return np.hstack([coefficients, np.zeros((len(coefficients), n_blocks))])
