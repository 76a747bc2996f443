"""The one call that simplifies: near a motion, over the arm's limits, or at given states."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from gd_analyze.certification.box import Box
from gd_analyze.certification.holding import simplify_held
from gd_analyze.certification.tube import Tube
from gd_analyze.errors import UsageError
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import SearchOptions, level_named
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.text import SINE_PRICE
from gd_analyze.threads import on_one_thread

if TYPE_CHECKING:
    import xarray as xr


@on_one_thread
def simplify(
    arm: RobotArm | str | Path,
    states: States | GivenMotions | xr.Dataset | None = None,
    budget: Budget | str | None = None,
    *,
    level: str | Level = TERM,
    refit: bool = False,
    operations: int | None = None,
    drives: bool | None = None,
    effort: float = 1.0,
    within: float | None = None,
    sine_price: int = SINE_PRICE,
    margin: Margin | str | None = None,
    at_set_points: bool = False,
    certified: bool = False,
) -> SimplifiedModel:
    """Find the model with the fewest operations within a torque error budget, as `gd-analyze simplify` does.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    states
        Where the budget holds. Near a trajectory (also by shipped name or path), or near each of several,
        between set points too; without one, as far as a search within the arm's limits finds, see
        `simplify_held`. At given states only: those of a decomposition, or any others, see `states_in_box`.
    budget
        Allowed torque error per joint, or its text such as "1% or 10% friction", see `Budget.parse`; by
        default 1 % of each joint's peak torque over the states.
    level
        "term": explicit D, h and c, sums of terms with the arm's own coefficients. "energy": terms of the
        energies, so that the model is a mechanical system. "element": the dominant parts of D and h, the
        founding text's method, which keeps no budget but states its error. "fast": the shortest torque
        program that a search finds; it needs Numba.
    refit
        Change kept coefficients to compensate for dropped ones.
    operations
        Most multiplications and additions of the torque; the budget is scaled to the smallest that allows it,
        and holds at the states only.
    drives
        Include drive inertia, or take the links alone; by default it is included if the arm describes
        drives, see `ExactDynamics.of`.
    effort
        Length of the search relative to the usual one.
    within
        Level fast: seconds after which the search ends with the shortest program found by then.
    sine_price
        Multiplications and additions that a sine or cosine counts as when models are compared; with 0 only
        multiplications and additions are minimized.
    margin
        How far from a motion the budget holds, see `Margin.parse`.
    at_set_points
        Keep the budget at the set points of trajectories only, or at states drawn within the limits.
    certified
        Return only a model whose budget is proven, or the exact one.

    Returns
    -------
    SimplifiedModel
        Its largest error over the states, measured on its own program, is within the budget; what is proven
        beyond is its `accuracy.certificate`. It is the exact model if none that saves operations was found.
        Its `notice` names joints whose budget is below friction or torque uncertainty.

    Raises
    ------
    UsageError
        If the budget is not understood, does not fit the number of joints, or is a share of a number that the
        arm does not state; if the level has nothing to refit; or if a margin or a proof is asked for where
        the budget holds at given states only.
    TrajectoryError
        If no motion leads from one set point to the next; `at_set_points` does without one.
    ArmError
        If drives are asked for and the arm describes none.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> model = gd.simplify("two_link", "two-link-swing", "60%")
    >>> bool((model.accuracy.certificate.certified <= model.accuracy.allowed).all())
    True
    """
    arm = arm_of(arm)
    how = SearchOptions(
        level_named(level), refit, operations, effort=effort, sine_price=sine_price, within=within
    )
    region: Box | Tube | None = None
    if states is None:
        region, states = Box.of(arm), states_in_box(arm)
    elif isinstance(states, States) or hasattr(states, "data_vars"):
        _refuse(margin is not None or certified, "states")
    else:
        motion = trajectory_of(states, arm)
        region, states = Tube.along(arm, motion, margin), states_of(motion)
    exact = ExactDynamics.of(arm, states, drives)
    if region is None or at_set_points or operations is not None or how.level is ELEMENT:
        _refuse(certified or margin is not None, "at_set_points, operations and level element")
        return simplify_exact(exact, budget, how)
    return simplify_held(exact, budget, region, how, certified=certified).model


def _refuse(is_wrong: bool, where: str) -> None:
    """Raise a UsageError for a margin or a proof without a region."""
    if is_wrong:
        message, expected = "the budget holds at given states only", "neither margin nor certified"
        next_step = "give a trajectory, or none for the arm's limits"
        raise UsageError(message, where=where, expected=expected, next_step=next_step)
