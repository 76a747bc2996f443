"""A model held against the exact dynamics along any trajectory, or at any states."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.decomposition import decompose, decompose_states
from gd_analyze.errors import ModelError
from gd_analyze.levels.model import SimplifiedModel
from gd_analyze.levels.promise import ErrorTable
from gd_analyze.robots import RobotArm, fingerprint
from gd_analyze.states import States, states_of
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Exact and simplified torque at states, N m, shape (N, n), and the error between them."""

    exact: FloatArray
    simplified: FloatArray
    table: ErrorTable

    def within(self, allowed: FloatArray) -> FloatArray:
        """Whether each joint's largest error is within `allowed` (n,)."""
        return np.asarray(self.table.largest <= allowed)


def evaluate(
    model: SimplifiedModel,
    trajectory: Trajectory,
    dataset: xr.Dataset | None = None,
    *,
    arm: RobotArm | None = None,
) -> Evaluation:
    """Evaluate a model along a trajectory and measure its torque error there.

    Parameters
    ----------
    model
        The simplified model.
    trajectory
        Any trajectory of the model's arm.
    dataset
        The trajectory's decomposition where it is at hand; made otherwise.
    arm
        Another arm whose exact torque counts, such as the model's own carrying a payload; the model's own
        by default. Its drives count where they are part of the model.

    Returns
    -------
    Evaluation
        Torques and their error.

    Raises
    ------
    TrajectoryError
        If the trajectory is of another number of joints.
    ModelError
        If the dataset is not of this arm, this trajectory and the model's drives, or the arm is of another
        number of joints than the model.
    ArmError
        If the model includes drives and the arm describes none.
    """
    held = _held_against(model, arm)
    if dataset is not None:
        _require_same(model, held, trajectory, dataset)
    else:
        dataset = decompose(held, trajectory, coupling=False, drives=model.drives)
    return _compare(model, states_of(trajectory), dataset.torque.values)


def evaluate_states(model: SimplifiedModel, states: States, arm: RobotArm | None = None) -> Evaluation:
    """Evaluate a model at states that need not belong to any motion, such as those of a box.

    Parameters
    ----------
    model
        The simplified model.
    states
        Joint variables, rates and accelerations, see `gd_analyze.states.states_in_box`.
    arm
        As for `evaluate`.

    Returns
    -------
    Evaluation
        Torques and their error.

    Raises
    ------
    TrajectoryError
        If the states are of another number of joints.
    ModelError
        If the arm is of another number of joints than the model.
    ArmError
        If the model includes drives and the arm describes none.
    """
    held = _held_against(model, arm)
    exact = decompose_states(held, *states.arrays, coupling=False, drives=model.drives)
    return _compare(model, states, exact["torque"])


def _held_against(model: SimplifiedModel, arm: RobotArm | None) -> RobotArm:
    if arm is None:
        return model.arm
    if arm.n_joints != model.arm.n_joints:
        raise ModelError(
            f"the model is not of arm {arm.name}",
            where="arm",
            expected=f"{model.arm.n_joints} joints, as {model.arm.name} has",
            found=f"{arm.n_joints} joints",
        )
    return arm


def _compare(model: SimplifiedModel, states: States, exact: FloatArray) -> Evaluation:
    simplified = model.torque(*states.arrays)
    return Evaluation(exact, simplified, ErrorTable.of(exact, simplified))


def _require_same(model: SimplifiedModel, arm: RobotArm, trajectory: Trajectory, dataset: xr.Dataset) -> None:
    stated = {
        "arm_fingerprint": fingerprint(arm),
        "trajectory_fingerprint": trajectory.fingerprint,
        "drives": int(model.drives),
    }
    for name, value in stated.items():
        if dataset.attrs[name] != value:
            raise ModelError(
                "the decomposition is of another arm or trajectory, or differs from the model in its drives",
                where=name,
                expected=str(value),
                found=str(dataset.attrs[name]),
            )


def torque_csv(trajectory: Trajectory, evaluation: Evaluation) -> str:
    """Exact and simplified torque over time as CSV: time, exact1..n, simplified1..n."""
    n = trajectory.n_joints
    header = ["time", *(f"{kind}{i + 1}" for kind in ("exact", "simplified") for i in range(n))]
    rows = np.column_stack([trajectory.time, evaluation.exact, evaluation.simplified])
    lines = [",".join(header), *(",".join(repr(float(x)) for x in row) for row in rows)]
    return "\n".join(lines) + "\n"
