"""Every formulation on one arm: operations, and agreement with each other and with Pinocchio."""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.mass_matrix import require_positive_definite
from gd_analyze.dynamics.methods import METHODS, Method, torque_of_states
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.motions.limits import check_against_arm, require_trajectory_joints
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.operations.counting import Tally
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.trace import Trace
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.result import Fact, Result, Table, Value, attributes_of, values_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.limits import box_limits
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.schema import declared_table
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.studies.study_files import inputs_stated
from gd_analyze.text import number


class Cost(NamedTuple):
    """Arithmetic of one torque evaluation."""

    executed: OperationCount  # by the code as written, products with zero included
    folded: OperationCount  # constants folded, products with 0 and 1 removed, equal subexpressions shared


@cache
def count_cost(method: Method, arm: RobotArm) -> Cost:
    """Count one method's torque of an arm, whose numbers are constants; the state is not."""
    tally, trace = Tally(), Trace()
    _, torque = (
        method.torque(arm, *(numbers.inputs(name, arm.n_joints) for name in ("q", "qd", "qdd")))
        for numbers in (tally, trace)
    )
    return Cost(tally.count, Program.of(trace, list(torque[:, 0])).count)


@dataclass(frozen=True, eq=False)
class Agreement:
    """Largest differences over all joints and set points, SI units."""

    torque: FloatArray  # between any two of the m methods and, last, Pinocchio, N m (N), (m + 1, m + 1)
    from_pinocchio: Mapping[str, Mapping[str, float]]  # by method and quantity: D, h, c and torque
    bounds: Mapping[str, float]  # what round-off explains, by quantity

    @property
    def largest(self) -> float:
        """Largest difference of torque between any two, N m (N)."""
        return float(self.torque.max())

    @property
    def holds(self) -> bool:
        """Whether round-off explains every difference."""
        rows, bounds = self.from_pinocchio.values(), self.bounds.items()
        beside_pinocchio = all(row[quantity] <= bound for row in rows for quantity, bound in bounds)
        return beside_pinocchio and self.largest <= self.bounds["torque"]


# Products of 4x4 or 3x3 matrices take twice the roundings per joint of rotating a vector, and probing sums
# whole torques: each of two formulations may be off by twice what `round_off_bounds` allows.
_ROUNDINGS = 4


def agreement(
    arm: RobotArm,
    states: States,
    *,
    methods: Mapping[str, Method] = METHODS,
    progress: Progress = NO_PROGRESS,
) -> Agreement:
    """Compare torque, D, h and c of methods at the same states; recursions are probed for D, h and c."""
    q_last, qd_last, _ = states.last
    reference = pinocchio_dynamics(arm, *states.arrays)
    torques, from_pinocchio = [], {}
    progress.stage("comparing", len(methods))
    for name, method in methods.items():
        torques.append(torque_of_states(method, arm, *states.arrays))
        dynamics = method.dynamics(arm, q_last, qd_last)
        quantities = {
            "inertia": np.moveaxis(dynamics.inertia, -1, 0),
            "coriolis_centrifugal": dynamics.coriolis_centrifugal.T,
            "gravity_loading": dynamics.gravity_loading.T,
            "torque": torques[-1],
        }
        from_pinocchio[name] = {
            quantity: float(np.abs(quantities[quantity] - value).max())
            for quantity, value in reference.items()
        }
        progress.advance()
    torques.append(reference["torque"])
    differences = np.array([[np.abs(a - b).max() for b in torques] for a in torques])
    bounds = {
        name: _ROUNDINGS * float(bound) for name, bound in round_off_bounds(arm, *states.arrays).items()
    }
    return Agreement(differences, from_pinocchio, bounds)


# Most set points that are compared one by one in Pinocchio.
_MOST_SET_POINTS = 5000
# States drawn if there is no motion, and the seed of the draw.
_RANDOM_STATES = 500
_SEED = 1987


def formulations_compared(
    arm: RobotArm,
    trajectory: Trajectory | None = None,
    *,
    progress: Progress = NO_PROGRESS,
) -> Result:
    """Count and compare every formulation on one arm; a disagreement does not raise.

    Torques are compared along the trajectory or, without one, at random states within the arm's limits.
    Raises a `TrajectoryError` if the numbers of joints differ, an `ArmError` if D is not positive definite.
    """
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        warn_of_implausible(arm)
        if trajectory is None:
            states = states_in_box(arm, _RANDOM_STATES, _SEED)
            drawn = f"{_RANDOM_STATES} random states within the arm's limits"
            compared_at = f"{drawn}{box_limits(arm).remark}"
        else:
            check_against_arm(trajectory, arm)
            require_trajectory_joints(trajectory, arm)
            all_states = states_of(trajectory)
            states, compared_at = all_states.evenly(_MOST_SET_POINTS), all_states.in_words
            if len(states) < len(all_states):
                compared_at = f"{len(states)} of the {all_states.in_words}"
        require_positive_definite(arm, states, arm.counts_drives())
        agreed = agreement(arm, states, progress=progress)
    unit = "N m" if all(arm.is_revolute) else "N m or N"
    largest, explained = number(agreed.largest), number(agreed.bounds["torque"])
    exact = ExactForm(arm).operations
    return Result(
        title=arm.title or arm.name,
        subtitle=f"formulations compared at {compared_at}",
        headline=(
            f"All formulations {'agree' if agreed.holds else 'DISAGREE'}. "
            f"Largest torque difference {largest} {unit}, explained by round-off up to {explained} {unit}."
        ),
        facts=(
            Fact(
                "operations_full",
                f"Exact torque{' without drives' if arm.drives else ''}, the reference for models",
                asdict(exact),
                text=str(exact),
            ),
            Value("compared_at", compared_at),
            Value("agrees", agreed.holds),
            Value("largest_difference", agreed.largest),
        ),
        parts=(_cost_table(arm), _differences_table(agreed)),
        notices=tuple(dict.fromkeys(str(item.message) for item in caught)),
        provenance=inputs_stated(arm, trajectory),
    )


def _cost_table(arm: RobotArm) -> Table:
    methods = METHODS.values()
    values: dict[str, Any] = {"name": [*METHODS]}
    seen = {"formulation": [method.short for method in methods]}
    for name in ("executed", "folded"):
        counts = [getattr(count_cost(method, arm), name) for method in methods]
        values[name] = [asdict(count) for count in counts]
        seen[name] = [f"{x.multiplications} + {x.additions}, {x.sines_cosines}" for x in counts]
    values |= attributes_of([*methods], "growth", "form")
    names = ["formulation", "executed", "folded", "growth", "form"]
    title = "Operations of one torque: multiplications + additions, sines and cosines"
    return declared_table("formulations", "methods", title, values, names, seen=seen)


def _differences_table(agreed: Agreement) -> Table:
    last = "explained by round-off"
    differences = values_of([*agreed.from_pinocchio.values(), agreed.bounds])
    return declared_table(
        "formulations",
        "from_pinocchio",
        "Largest difference from Pinocchio, SI units",
        {"name": [*METHODS, last], **differences},
        ["formulation", *differences],
        seen={"formulation": [*(method.short for method in METHODS.values()), last]},
    )
