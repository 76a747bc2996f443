"""A model held against the exact dynamics along any trajectory."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.decomposition import decompose
from gd_analyze.errors import ModelError
from gd_analyze.models.model_schema import AnyModel
from gd_analyze.models.simplified import ErrorTable
from gd_analyze.trajectories import Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Exact and simplified torque along a trajectory, N m, shape (N, n), and the error between them."""

    exact: FloatArray
    simplified: FloatArray
    table: ErrorTable

    def within(self, allowed: FloatArray) -> FloatArray:
        """Whether each joint's largest error is within `allowed` (n,)."""
        return np.asarray(self.table.largest <= allowed)


def evaluate(model: AnyModel, trajectory: Trajectory, dataset: xr.Dataset | None = None) -> Evaluation:
    """Evaluate a model along a trajectory and measure its torque error there.

    Parameters
    ----------
    model
        The simplified model.
    trajectory
        Any trajectory of the model's arm.
    dataset
        The trajectory's decomposition where it is at hand; made otherwise.

    Returns
    -------
    Evaluation
        Torques and their error.

    Raises
    ------
    TrajectoryError
        If the trajectory is of another number of joints.
    ModelError
        If the dataset is not of this trajectory and the model's drives.
    """
    if dataset is not None:
        _require_same(model, trajectory, dataset)
    else:
        dataset = decompose(model.arm, trajectory, coupling=False, drives=model.drives)
    exact = dataset.torque.values
    simplified = model.torque(trajectory.q, trajectory.qd, trajectory.qdd)
    return Evaluation(exact, simplified, ErrorTable.of(exact, simplified))


def _require_same(model: AnyModel, trajectory: Trajectory, dataset: xr.Dataset) -> None:
    stated = {"trajectory_fingerprint": trajectory.fingerprint, "drives": int(model.drives)}
    for name, value in stated.items():
        if dataset.attrs[name] != value:
            raise ModelError(
                "the decomposition is of another trajectory, or differs from the model in its drives",
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
