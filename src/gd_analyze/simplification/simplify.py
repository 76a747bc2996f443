"""The smallest model within a torque error budget, or the best one of so many operations, at any level."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from gd_analyze.motions.pool import GivenMotions
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.at_level import at_level
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.cheapest import cheapest
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import level_named
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search import Progress
from gd_analyze.simplification.search_options import SearchOptions

if TYPE_CHECKING:
    import xarray as xr

_USUAL = SearchOptions()


def simplify(
    arm: RobotArm | str | Path,
    states: States | GivenMotions | xr.Dataset,
    budget: Budget | str | None = None,
    *,
    level: str | Level | None = None,
    refit: bool = False,
    operations: int | None = None,
    drives: bool | None = None,
    effort: float = 1.0,
) -> SimplifiedModel:
    """Leave out what a torque error budget allows, so that few operations remain.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    states
        States over which the budget holds: a trajectory's set points, or its shipped name or path; those of
        several, on each of which the budget then holds; their decomposition where it is at hand; or drawn
        ones, see `states_in_box`.
    budget
        Allowed torque error per joint, or its text such as "1% or 10% friction", see `Budget.parse`; 1 % of
        each joint's peak torque over the states by default.
    level, refit, operations, effort
        See `SearchOptions`. By default the level that takes the fewest operations is found out. "term" drops
        torque
        terms one by one; "recursive" changes steps of the recursion of Newton and Euler, for arms of many
        terms; "energy" drops terms of the energies, so that the model stays a mechanical system; "element"
        drops the effects of D_ij and h_i and c_i, the founding text's method.
    drives
        Include drive inertia, or take the links alone; by default it is included where the arm describes
        drives, see `ExactDynamics.of`.

    Returns
    -------
    SimplifiedModel
        Its largest error over the states is within the budget, measured on its own program. Where that takes
        as many operations as the exact torque, it is the exact model. Its `notice` tells where the budget is
        less than a joint's friction or the uncertainty of its torque.

    Raises
    ------
    UsageError
        If the budget is not understood, does not fit the number of joints, or is a share of what the arm does
        not state; or if level and refit do not go together.
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> arm = gd.load_arm("two_link")
    >>> model = gd.simplify(arm, gd.read_trajectory("two-link-swing", arm), "1%")
    >>> bool((model.accuracy.errors.largest_share <= 0.01).all())
    True
    """
    how = SearchOptions(None if level is None else level_named(level), refit, operations, effort=effort)
    return simplify_exact(ExactDynamics.of(arm, states, drives), budget, how)


def simplify_exact(
    exact: ExactDynamics,
    budget: Budget | str | None = None,
    how: SearchOptions = _USUAL,
    *,
    provenance: Mapping[str, str] | None = None,
    progress: Progress = None,
    stage: Callable[[str], object] | None = None,
) -> SimplifiedModel:
    """Do what `simplify` does, against exact dynamics that are at hand.

    Parameters
    ----------
    exact, budget, how
        What to simplify, how far, and how.
    provenance
        Stored with the model.
    progress
        Called with the number of candidates dropped, or of changes made, since the last call.
    stage
        Told what begins, in words.

    Raises
    ------
    TooManyTermsError
        If the level asked for has more terms than a search can weigh.
    """
    budget, stage = Budget.of(budget), stage or (lambda _: None)
    if how.operations is not None:
        budget.require_per_joint("a model of so many operations", "ask for a share of the norm alone")
    exact = exact.under(budget)
    if how.level is None:
        model = cheapest(exact, budget, how, progress, stage)
    else:
        stage(f"searching at level {how.level}")
        model = at_level(exact, budget, how.level, how, progress)
    return replace(model, provenance=dict(provenance or {}))
