"""Every formulation on one arm: counted, timed, held against each other and against Pinocchio."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.motions.checks import check_against_arm, require_joints
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.program import OperationCount
from gd_analyze.results.provenance import provenance_of_run
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe_in_full
from gd_analyze.robots.limits import box_limits
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.studies.agreement import Agreement, agreement
from gd_analyze.studies.costs import SIZES, Cost, Growth, count_cost, growth
from gd_analyze.studies.timing import N_SET_POINTS, REPEATS, Timing, time_methods

# States at which the formulations are held against each other; Pinocchio takes them one by one.
MOST_SET_POINTS = 5000
N_RANDOM = 500
# Steps that `compare` reports to its caller.
STEPS = len(SIZES) * len(METHODS) + len(METHODS) + REPEATS + 1 + 1


@dataclass(frozen=True, eq=False)
class Comparison:
    """Everything one comparison found.

    Parameters
    ----------
    arm
        The arm.
    compared_at
        Where agreement was measured, in words.
    trajectory
        The trajectory given, if any.
    costs
        By method, of this arm.
    exact
        Operations of the exact torque in the fewest known, as every model's are counted.
    growth
        Costs on the generic chain.
    timing
        Seconds per set point, at random states.
    agreement
        Largest differences.
    warnings
        What is suspicious about the input, in sentences.
    provenance
        Versions, time, command.
    """

    arm: RobotArm
    compared_at: str
    trajectory: Trajectory | None
    costs: Mapping[str, Cost]
    exact: OperationCount
    growth: Growth
    timing: Timing
    agreement: Agreement
    warnings: tuple[str, ...]
    provenance: Mapping[str, str]

    @property
    def unit(self) -> str:
        """Unit of torques of any joint of the arm."""
        return "N m" if all(self.arm.is_revolute) else "N m or N"


def compare(
    arm: RobotArm,
    trajectory: Trajectory | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] = lambda done: None,
) -> Comparison:
    """Count, time and compare every formulation on one arm.

    Parameters
    ----------
    arm
        The arm.
    trajectory
        Where to compare torques; random states within the arm's limits where it is left out.
    command
        What the user typed, for provenance.
    warned
        Warnings given while the input was read; those given here are added.
    progress
        Called with the number of steps done since the last call, of `STEPS`.

    Returns
    -------
    Comparison
        What was found; whether all agree is in it, a disagreement does not raise.

    Raises
    ------
    TrajectoryError
        If the trajectory is of another number of joints.
    ArmError
        If D is not positive definite somewhere.
    """
    # Two runs measure other times.
    source = provenance_of_run(command, names_of(arm, trajectory), describe_in_full(arm), repeats=False)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_implausible(arm, stacklevel=2)
        if trajectory is not None:
            check_against_arm(trajectory, arm)
        compared, origin = _compared(arm, trajectory)
        require_positive_definite(arm, compared, arm.counts_drives())
        agreed = agreement(arm, compared)
        progress(1)
        times = time_methods(arm, _drawn(arm, N_SET_POINTS), progress=progress)
        costs = {name: count_cost(method, arm) for name, method in METHODS.items()}
        progress(len(costs))
        exact = ExactForm(arm).operations
        grown = growth(progress)
    return Comparison(
        arm=arm,
        compared_at=origin,
        trajectory=trajectory,
        costs=costs,
        exact=exact,
        growth=grown,
        timing=times,
        agreement=agreed,
        warnings=tuple(dict.fromkeys([*warned, *(str(item.message) for item in caught)])),
        provenance=source,
    )


def names_of(arm: RobotArm, trajectory: Trajectory | None) -> tuple[str, str]:
    """Name arm and motion: what a comparison was asked for; "" without a motion."""
    return arm.name, "" if trajectory is None else trajectory.name


def _compared(arm: RobotArm, trajectory: Trajectory | None) -> tuple[States, str]:
    """States to compare at, and what they are."""
    if trajectory is None:
        limits = f"the arm's limits{box_limits(arm).remark}"
        return _drawn(arm, N_RANDOM), f"{N_RANDOM} random states within {limits}"
    require_joints(trajectory, arm)
    every = states_of(trajectory)
    few = every.evenly(MOST_SET_POINTS)
    return few, f"{len(few)} of the {every.in_words}" if len(few) < len(every) else every.in_words


def _drawn(arm: RobotArm, count: int) -> States:
    """Draw random states within the arm's limits, the same ones every time."""
    return states_in_box(arm, count, 1987)
