"""A model held against the exact dynamics along any trajectory, or at any states."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isclose
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.motions.pool import GivenMotions
from gd_analyze.motions.states import States, require_dataset
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.norm_share import NormShare
from gd_analyze.text import amount, html_of, joint_name, percent

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Evaluation:
    """A model's torque at states, N m, shape (N, n), what it was held against, and the error between them.

    Shares of the torque's norm are at 95 % and 99.9 % of the states, and at what the model's budget asks.
    """

    dynamics: ExactDynamics
    torque: FloatArray
    errors: ErrorTable
    norms: tuple[NormShare, ...]

    def __repr__(self) -> str:
        worst = self.errors.worst
        error = (
            f"{percent(float(self.errors.largest_share[worst]))} of the peak torque here (joint {worst + 1})"
        )
        return f"Evaluation({self.dynamics.states!r}, largest error {error})"

    def _repr_html_(self) -> str:
        """The errors, for a notebook."""
        errors, joints = self.errors, self.dynamics.arm.joints
        rows = [
            [
                joint_name(i + 1, joint.name),
                amount(float(errors.peak_torque[i]), joint.effort_unit),
                amount(float(errors.largest[i]), joint.effort_unit),
                percent(float(errors.largest_share[i])),
                amount(float(errors.rms[i]), joint.effort_unit),
            ]
            for i, joint in enumerate(joints)
        ]
        headings = ["joint", "peak torque here", "largest error", "of that peak", "RMS error"]
        return html_of(f"{self.dynamics.arm.name}: {self.dynamics.states.in_words}", headings, rows)

    def within(self, allowed: FloatArray) -> FloatArray:
        """Whether each joint's largest error is within `allowed` (n,)."""
        return np.asarray(self.errors.largest <= allowed)

    def keeps(self, asked: NormShare) -> bool:
        """Whether the share of the norm that the model's budget asks for is kept here."""
        found = next(norm.share for norm in self.norms if isclose(norm.states, asked.states))
        return found <= asked.share


def evaluate(
    model: SimplifiedModel,
    given: States | GivenMotions | xr.Dataset,
    arm: RobotArm | None = None,
) -> Evaluation:
    """Evaluate a model and measure its torque error.

    Parameters
    ----------
    model
        The simplified model.
    given
        Any trajectory of the model's arm, or its shipped name or path; its decomposition where it is at hand;
        or states that need not belong to any motion, such as those of
        `gd_analyze.motions.states.states_in_box`.
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
        If the states are of another number of joints.
    ModelError
        If a decomposition is not of this arm and the model's drives, or the arm is of another number of
        joints than the model.
    ArmError
        If the model includes drives and the arm describes none.
    """
    held = model.arm if arm is None else arm
    require_arm(model, held)
    if not isinstance(given, States | Trajectory | str | Path | Sequence):
        _require_same(model, held, given)
    exact = ExactDynamics.of(held, given, model.drives)
    _ = exact.torque  # first: it says best what is wrong with states of another arm
    torque = model.torque(*exact.states.arrays)
    norms = exact.norms_of(torque, model.accuracy.asked.norm)
    return Evaluation(exact, torque, exact.errors_of(torque), norms)


def require_arm(model: SimplifiedModel, held: RobotArm) -> None:
    """Refuse, with a ModelError, an arm of another number of joints than the model."""
    if held.n_joints != model.arm.n_joints:
        raise ModelError(
            f"the model is not of arm {held.name}",
            where="arm",
            expected=f"{model.arm.n_joints} joints, as {model.arm.name} has",
            found=f"{held.n_joints} joints",
        )


def _require_same(model: SimplifiedModel, arm: RobotArm, dataset: xr.Dataset) -> None:
    require_dataset(dataset)
    stated = {"arm_fingerprint": fingerprint(arm), "drives": int(model.drives)}
    for name, value in stated.items():
        if dataset.attrs[name] != value:
            raise ModelError(
                "the decomposition is of another arm, or differs from the model in its drives",
                where=name,
                expected=str(value),
                found=str(dataset.attrs[name]),
            )


def torque_csv(trajectory: Trajectory, evaluation: Evaluation) -> str:
    """Exact and simplified torque over time as CSV: time, exact1..n, simplified1..n."""
    import pandas as pd

    joints = range(1, trajectory.n_joints + 1)
    names = ["time", *(f"{kind}{joint}" for kind in ("exact", "simplified") for joint in joints)]
    rows = np.column_stack([trajectory.time, evaluation.dynamics.torque, evaluation.torque])
    return pd.DataFrame(rows, columns=names).to_csv(index=False, lineterminator="\n")
