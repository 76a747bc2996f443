"""The one call that simplifies: near a motion, over the arm's limits, or at given states."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, cast

from gd_analyze.arguments import strict
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import POSITIONS_PER_JOINT
from gd_analyze.certification.held import Held
from gd_analyze.certification.holding import simplify_held
from gd_analyze.certification.tube import Tube
from gd_analyze.diagnosis.log_verdict import verdict_with_warning
from gd_analyze.dynamics.measured_torque import compared
from gd_analyze.errors import UsageError
from gd_analyze.motions.margin import Margin
from gd_analyze.motions.measured import has_torques
from gd_analyze.motions.pool import GivenMotions, trajectory_of
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT, model_by_verdicts, require_search, require_verdicts
from gd_analyze.simplification.exact_dynamics import ExactDynamics, warn_of_torques
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.level import Level
from gd_analyze.simplification.levels import level_named
from gd_analyze.simplification.model import SimplifiedModel, with_gamma
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.search_time import SEARCH_SECONDS, SearchTime
from gd_analyze.simplification.simplify import Check, simplify_exact
from gd_analyze.studies.against_log import beside_log, require_log, with_log, within_log
from gd_analyze.text import SINE_PRICE, in_python
from gd_analyze.threads import one_thread

if TYPE_CHECKING:
    import xarray as xr


@strict
@one_thread()
def simplify(
    arm: RobotArm | str | Path,
    states: States | GivenMotions | xr.Dataset | None = None,
    budget: Budget | str | float | None = None,
    *,
    level: str | Level = TERM,
    drives: bool | None = None,
    seconds: float = SEARCH_SECONDS,
    sine_price: int = SINE_PRICE,
    margin: Margin | str | None = None,
    at_set_points: bool = False,
    certified: bool = False,
    region: Box | Tube | None = None,
    verdicts: str = "own",
    progress: Progress = NO_PROGRESS,
) -> SimplifiedModel:
    """Find the model with the fewest operations within a torque error budget, as `gd-analyze simplify` does.

    Parameters
    ----------
    arm
        The arm, or the name of a built-in one, or the path of its file.
    states
        Where the budget holds. Near a trajectory (also by shipped name or path), or near each of several,
        between set points too. Without one, within the arm's limits: at 20 000 random positions with the
        worst velocities and accelerations of each, and at those reached by an ascent from the worst. At given
        states only: those of a decomposition, or any others, see `states_in_box`.
    budget
        Allowed torque error per joint: a text such as "1% or 10% friction", see `Budget.parse`, or a number,
        0.01 for 1 % of each joint's peak torque over the states, which is the default.
    level
        "term": explicit D, h and c, sums of terms with the arm's own coefficients. "energy": terms of the
        energies, so that the model is a mechanical system. "element": the dominant parts of D and h, the
        method of [FGL87], which may miss the budget.
    drives
        Include drive inertia, or take the links alone; by default it is included if the arm describes
        drives, see `ExactDynamics.of`.
    seconds
        Processor time of the search; then the best model that holds is the answer, or the exact torque.
    sine_price
        Multiplications and additions that a sine or cosine counts as when models are compared; with 0 only
        multiplications and additions are minimized.
    margin
        How far from a motion the budget holds, see `Margin.parse`.
    at_set_points
        Keep the budget at the set points of trajectories only, or at states drawn within the limits.
    certified
        Return only a model whose budget is proven, or the exact one.
    region
        A box, or a tube around a motion, in which the budget holds; shares of peak torque are of that at the
        states.
    verdicts
        Level element: "own", the verdicts over the states, or "text", those of [FGL87].
    progress
        Told the stages of the work, see `Progress`.

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
        arm does not state; if arguments do not go together, see `require_consistent`; or if not even the
        exact model can be certified.
    TrajectoryError
        If no motion leads from one set point to the next; `at_set_points` does without one.
    ArmError
        If drives are asked for and the arm describes none.

    Warns
    -----
    GdAnalyzeWarning
        If the drives are too weak for the motion or the arm's weight, or no joint needs torque.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> model = gd.simplify("two_link", "two-link-swing", "60%")
    >>> bool((model.accuracy.certificate.certified <= model.accuracy.allowed).all())
    True
    """
    arm = arm_with_masses(arm)
    options = SearchOptions(level_named(level), sine_price=sine_price, time=SearchTime(seconds))
    motion, is_given = None, isinstance(states, States) or hasattr(states, "data_vars")
    require_consistent(
        options.level,
        has_motion=states is not None and not is_given,
        has_states=is_given,
        region=region,
        margin=margin,
        at_set_points=at_set_points,
        certified=certified,
        verdicts=verdicts,
    )
    if states is None:
        states = states_in_box(arm)
    elif not is_given:
        read = partial(read_trajectory, progress=progress)
        motion = trajectory_of(cast(GivenMotions, states), arm, read)
        states = states_of(motion)
    if region is not None and not isinstance(region, Box | Tube):
        message, expected = "this is no region", "a Box or a Tube of `gd_analyze.types`"
        raise UsageError(message, where="region", expected=expected, found=in_python(region))
    exact = ExactDynamics.of(arm, states, drives)
    warn_of_torques(exact)
    held_model = search_beside_log(
        exact,
        motion,
        budget,
        options,
        region=region,
        margin=margin,
        at_states=at_set_points or (is_given and region is None),
        certified=certified,
        verdicts=verdicts,
        progress=progress,
    )
    return held_model.model


def search_beside_log(
    exact: ExactDynamics,
    motion: Trajectory | None,
    budget: Budget | str | float | None,
    options: SearchOptions,
    **how: Any,
) -> Held:
    """Search as `search_model` does; measured torques are asked for a budget, and what they say is stated."""
    if motion is None or not has_torques(motion):
        return search_model(exact, motion, budget, options, **how)
    verdict, budget = verdict_with_warning(exact.arm, motion), Budget.of(budget)
    require_log(verdict, budget)
    exact = with_log(exact, verdict)

    def roughly(budget: Budget) -> Held:
        return search_model(exact, motion, budget, replace(options, thorough=False), at_states=True)

    def near_motion(budget: Budget) -> Held:
        return search_model(exact, motion, budget, options, **how)

    held = None
    if "log" in budget.wholes and verdict.resolution is not None:
        held = within_log(exact, verdict.resolution, budget, [roughly, near_motion])
    if held is None:
        held = near_motion(budget)
    comparison = compared(exact.arm, motion, exact.torque)
    return held._replace(model=beside_log(held.model, motion, comparison, verdict, exact.left_of_log))


def search_model(
    exact: ExactDynamics,
    motion: Trajectory | None,
    budget: Budget | str | float | None,
    options: SearchOptions,
    *,
    region: Box | Tube | None = None,
    margin: Margin | str | None = None,
    at_states: bool = False,
    certified: bool = False,
    verdicts: str = "own",
    proof_effort: int = POSITIONS_PER_JOINT,
    everywhere: Sequence[Check] = (),
    provenance: Mapping[str, str] | None = None,
    progress: Progress = NO_PROGRESS,
) -> Held:
    """Search as `simplify` does, from exact dynamics at the set points of a motion, or at other states.

    Parameters
    ----------
    exact, motion
        Exact dynamics at the first states, and the motion if they are its set points.
    at_states
        Keep the budget at these states only.
    budget, options, region, margin, certified, verdicts
        As for `simplify`.
    proof_effort
        Effort of every proof, see `certify`.
    everywhere, provenance, progress
        As for `simplify_exact`.

    Raises
    ------
    UsageError
        As for `simplify`, but for what `require_consistent` refuses.
    """
    if options.level is ELEMENT:
        model = with_gamma(exact, model_by_verdicts(exact, verdicts, budget=budget))
        return Held(replace(model, provenance=dict(provenance or {})))
    if region is None and not at_states:
        region = Box.of(exact.arm) if motion is None else Tube.along(exact.arm, motion, margin)
    if region is None:
        model = simplify_exact(
            exact,
            budget,
            options,
            everywhere=everywhere,
            provenance=provenance,
            progress=progress,
        )
        return Held(model)
    return simplify_held(
        exact,
        budget,
        region,
        options,
        certified=certified,
        effort=proof_effort,
        everywhere=everywhere,
        provenance=provenance,
        progress=progress,
    )


def require_consistent(
    level: Level,
    *,
    has_motion: bool = False,
    has_states: bool = False,
    region: Box | Tube | None = None,
    margin: Margin | str | None = None,
    at_set_points: bool = False,
    certified: bool = False,
    verdicts: str = "own",
) -> None:
    """Raise a UsageError unless what is asked of `simplify` goes together; its `where` is the argument.

    `has_motion` and `has_states` say whether states are those of a motion, or any others given.
    """
    require_verdicts(verdicts, level)
    beyond_states = {"certified": certified, "margin": margin is not None, "region": region is not None}
    names = [name for name, is_asked in beyond_states.items() if is_asked]
    searched = [*names, *(["at_set_points"] if at_set_points else [])]
    if searched:
        require_search(level, ", ".join(searched))
    if names and (at_set_points or (has_states and region is None)):
        raise UsageError(
            "the budget holds at given states only",
            where=names[0],
            expected="one that holds near a motion, in a region or within the arm's limits",
            next_step="leave it out, or let the budget hold between the states, too",
        )
    if margin is not None and (not has_motion or region is not None):
        message, expected = "a margin is one around a motion", "a trajectory and no region"
        raise UsageError(message, where="margin", expected=expected)
