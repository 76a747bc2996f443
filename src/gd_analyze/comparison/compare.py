"""Every formulation on one arm: counted, timed, held against each other and against Pinocchio."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass

from gd_analyze.comparison.agreement import Agreement, agreement
from gd_analyze.comparison.costs import SIZES, Cost, Growth, count_cost, growth
from gd_analyze.comparison.explanation import Explanation, explanations
from gd_analyze.comparison.methods import METHODS
from gd_analyze.comparison.states import random_states, states_of
from gd_analyze.comparison.timing import N_SET_POINTS, REPEATS, Timing, time_methods
from gd_analyze.provenance import provenance
from gd_analyze.robots import RobotArm
from gd_analyze.trajectories import Trajectory

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
    states
        Where agreement was measured, in words.
    trajectory
        The trajectory given, if any.
    costs
        By method, of this arm.
    growth
        Costs on the generic chain.
    explanations
        Why they differ from the text's.
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
    states: str
    trajectory: Trajectory | None
    costs: Mapping[str, Cost]
    growth: Growth
    explanations: tuple[Explanation, ...]
    timing: Timing
    agreement: Agreement
    warnings: tuple[str, ...]
    provenance: Mapping[str, str]


def compare(
    arm: RobotArm,
    trajectory: Trajectory | None = None,
    *,
    command: str = "",
    warned: Iterable[str] = (),
    progress: Callable[[int], None] | None = None,
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
    """
    step = progress or (lambda done: None)
    source = provenance(command)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        compared = (
            random_states(arm, N_RANDOM)
            if trajectory is None
            else states_of(arm, trajectory, MOST_SET_POINTS)
        )
        agreed = agreement(arm, compared.q, compared.qd, compared.qdd)
        step(1)
        timed = random_states(arm, N_SET_POINTS)
        times = time_methods(arm, timed.q, timed.qd, timed.qdd, progress=step)
        costs = {}
        for name, method in METHODS.items():
            costs[name] = count_cost(method, arm)
            step(1)
        grown = growth(progress=step)
    return Comparison(
        arm=arm,
        states=compared.origin,
        trajectory=trajectory,
        costs=costs,
        growth=grown,
        explanations=explanations(grown),
        timing=times,
        agreement=agreed,
        warnings=(*warned, *(str(item.message) for item in caught)),
        provenance=source,
    )
