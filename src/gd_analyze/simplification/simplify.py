"""The smallest model within a torque error budget, or the best one of so many operations, at any level."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.errors import UsageError
from gd_analyze.models.simplified import LEVELS, ErrorTable, Level, SimplifiedModel
from gd_analyze.robots import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import candidates_of
from gd_analyze.simplification.elimination import eliminate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.making import Kept, make_model, operations_of
from gd_analyze.simplification.search import Found, search
from gd_analyze.simplification.selection import select
from gd_analyze.simplification.states import States
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr

# --operations: the smallest multiple of the budget, how close it is searched, how often it is tightened.
_LEAST, _CLOSE, _ATTEMPTS = 1e-6, 1.02, 4


def simplify(
    arm: RobotArm,
    states: States | Trajectory | xr.Dataset,
    budget: Budget | None = None,
    *,
    level: Level = "term",
    refit: bool = False,
    drives: bool = False,
    operations: int | None = None,
    provenance: Mapping[str, str] | None = None,
    progress: Callable[[int], None] | None = None,
) -> SimplifiedModel:
    """Leave out what a torque error budget allows, so that few operations remain.

    Parameters
    ----------
    arm
        The arm.
    states
        States over which the budget holds: a trajectory's set points, their decomposition where it is at
        hand, or drawn ones, see `states_in_box`.
    budget
        Allowed torque error per joint; 1 % of each joint's peak torque over the states by default.
    level
        "term": torque terms one by one, the fewest operations; "energy": terms of the energies, so that the
        model stays a mechanical system; "element": the effects of D_ij and h_i and c_i, the text's method.
    refit
        Change kept coefficients to absorb what is dropped; parts of level "element" have none.
    drives
        Include drive inertia.
    operations
        Multiplications and additions the model may take: the budget is then scaled, for all joints alike, to
        the smallest that so many allow.
    provenance
        Stored with the model, with the operations after each step of the search.
    progress
        Called with the number of candidates dropped since the last call.

    Returns
    -------
    SimplifiedModel
        Its largest error over the states is within the budget, measured on its own program.

    Raises
    ------
    UsageError
        If the budget does not fit the number of joints, or level and refit do not go together.
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> arm = gd.load_arm("two_link")
    >>> model = gd.simplify(arm, gd.read_trajectory("two-link-swing", arm), gd.Budget.parse("1%"))
    >>> bool((model.promise.largest_share <= 0.01).all())
    True
    """
    return simplify_exact(
        ExactDynamics.of(arm, states, drives),
        budget or Budget(),
        level=level,
        refit=refit,
        operations=operations,
        provenance=provenance,
        progress=progress,
    )


def simplify_exact(
    exact: ExactDynamics,
    budget: Budget,
    *,
    level: Level = "term",
    refit: bool = False,
    operations: int | None = None,
    thorough: bool = True,
    write: bool = True,
    provenance: Mapping[str, str] | None = None,
    progress: Callable[[int], None] | None = None,
) -> SimplifiedModel:
    """Do what `simplify` does, against exact dynamics that are at hand.

    Without `thorough` the integer program is not searched, without `write` no time is spent on a program of
    few operations: tenths of a second each instead of seconds.
    """
    if level not in LEVELS:
        raise UsageError("there is no such level", where="level", expected=", ".join(LEVELS), found=level)
    if refit and level == "element":
        raise UsageError(
            "parts of elements have no coefficients to refit",
            where="refit",
            expected="level term or energy",
            found="level element",
        )
    how = _How(level, refit, thorough, write, dict(provenance or {}), progress)
    if operations is None:
        return _within(exact, budget, how)
    if operations < 0:
        raise UsageError("so few operations do not exist", where="operations", found=str(operations))
    return _of_few_operations(exact, budget, how, operations)


@dataclass(frozen=True)
class _How:
    """How to search, and whom to tell; see `simplify_exact`."""

    level: Level
    refit: bool
    thorough: bool
    write: bool
    provenance: Mapping[str, str]
    progress: Callable[[int], None] | None


def _within(exact: ExactDynamics, budget: Budget, how: _How) -> SimplifiedModel:
    """Search on some of the states if there are very many; those that break the budget join them."""
    allowed = exact.allowed(budget)
    known, margin = exact.thinned(), 1.0  # what is added counts a little more every time, so it ends
    while True:
        model = _searched(known, margin * allowed, str(budget), how)
        if known is exact:
            return model
        torque = model.torque(*exact.states.arrays)
        promise = ErrorTable.of(exact.torque, torque)
        if (promise.largest <= allowed).all():
            return dataclasses.replace(model, budget=allowed, promise=promise)
        worst = np.unique(np.abs(torque - exact.torque).argmax(axis=0))
        known = known.joined_by(*(x[worst] for x in exact.states.arrays))
        margin *= 0.98


def _searched(exact: ExactDynamics, allowed: FloatArray, budget_stated: str, how: _How) -> SimplifiedModel:
    level = how.level
    candidates = candidates_of(exact, level, allowed)

    def count(kept: Kept, scale: FloatArray) -> int:
        return operations_of(exact, level, *candidates.whole(kept, scale), thorough=how.thorough).total

    if level == "element":
        chosen = select(candidates.effects, 1.0, candidates.costs)
        kept = np.array(chosen.kept)
        one = np.ones(len(kept))
        found = Found(kept, one, {"integer program": (kept, one)}, chosen.optimal)
    else:
        found = search(candidates, count, refit=how.refit, thorough=how.thorough, progress=how.progress)
    steps = ", ".join(
        # All written the same quick way, so that they compare.
        f"{name} {operations_of(exact, level, *candidates.whole(*step), thorough=False).total}"
        for name, step in found.steps.items()
    )
    return make_model(
        exact,
        level,
        *candidates.whole(found.kept, found.scale),
        allowed=allowed,
        budget_stated=budget_stated,
        thorough=how.write and how.thorough,
        provenance={**how.provenance, "search": steps + (", solved to the end" if found.solved else "")},
    )


def _of_few_operations(exact: ExactDynamics, budget: Budget, how: _How, operations: int) -> SimplifiedModel:
    """Scale the budget until the model takes no more operations than asked for.

    Elimination alone tells quickly about where; whole searches then close in from there.
    """
    some = exact.thinned()
    candidates = candidates_of(some, how.level, exact.allowed(budget))
    elimination = eliminate(candidates)
    one = np.ones(len(elimination.order))

    def quick(factor: float) -> int:
        return operations_of(some, how.level, *candidates.whole(elimination.within(factor), one)).total

    few, many = _LEAST, 1.0
    if quick(few) <= operations:  # nothing need be dropped but what is nothing
        return _within(exact, budget.scaled(few), how)
    while quick(many) > operations:
        few, many = many, 2.0 * many
    while many / few > _CLOSE:
        middle = (few * many) ** 0.5
        few, many = (middle, many) if quick(middle) > operations else (few, middle)
    best = _within(exact, budget.scaled(many), how)
    step, quietly = 0.8, dataclasses.replace(how, progress=None)
    for _ in range(_ATTEMPTS):
        trial = _within(exact, budget.scaled(many * step), quietly)
        if trial.operations.total <= operations:
            best, many = trial, many * step
        else:
            step **= 0.5
    return best
