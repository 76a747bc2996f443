"""Models and terms at any states: errors, effect of a payload, torque of each term."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import ROUND_OFF_SHARE, FloatArray, chunks
from gd_analyze.dynamics.base_parameters import link_regressor
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import ModelError, require_type
from gd_analyze.motions.pool import GivenMotions
from gd_analyze.motions.states import States, require_dataset, states_for
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import fingerprint
from gd_analyze.simplification.accuracy import ErrorTable, NormShare, share_of
from gd_analyze.simplification.element import ElementLevel, parts_of, torque_by_part
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel, require_model

if TYPE_CHECKING:
    import xarray as xr

# Difference of the angle between two axes, rad, by which an arm is of another make: calibration moves axes by
# tenths of a degree, another design or zero position by tens.
_OTHER_AXES = np.radians(10.0)
# Number of positions at which axes are compared.
_POSITIONS = 8


@dataclass(frozen=True, eq=False)
class ModelTorque:
    """A model's torque at states, N m, shape (N, n), the exact dynamics, and the error.

    Shares of the torque's norm are at 95 % and 99.9 % of the states.
    """

    dynamics: ExactDynamics
    torque: FloatArray
    errors: ErrorTable
    norms: tuple[NormShare, ...]

    def within(self, allowed: FloatArray) -> FloatArray:
        """Whether each joint's largest error is within `allowed` (n,)."""
        return np.asarray(self.errors.largest <= allowed)


def model_torque(
    model: SimplifiedModel, states: States | GivenMotions | xr.Dataset, arm: RobotArm | None = None
) -> ModelTorque:
    """Compute a model's torque at states, and its error.

    Parameters
    ----------
    model
        The simplified model.
    states
        Any trajectory of the model's arm, or its shipped name or path; its decomposition; or any states, such
        as those of `states_in_box`.
    arm
        Another arm whose exact torque is the reference, such as the model's arm with a payload; by default
        the model's arm. Its drives are included if they are part of the model.

    Returns
    -------
    ModelTorque
        Torque of the model, N m (N), shape (N, n), and its errors.

    Raises
    ------
    TrajectoryError
        If the states have another number of joints.
    ModelError
        If a decomposition is of another arm or differs in drives, or the arm is of another make.
    ArmError
        If the model includes drives and the arm describes none.
    """
    reference = model.arm if arm is None else arm
    require_arm(model, reference)
    if not isinstance(states, States | Trajectory | str | Path | Sequence):
        require_dataset(states)
        for name, value in {"arm_fingerprint": fingerprint(reference), "drives": int(model.drives)}.items():
            if states.attrs[name] != value:
                message = "the decomposition is of another arm, or treats drives differently from the model"
                raise ModelError(message, where=name, expected=str(value), found=str(states.attrs[name]))
    exact = ExactDynamics.of(reference, states, model.drives)
    _ = exact.torque  # first: its error for states of another arm is the clearest
    torque = model.torque(*exact.states.arrays)
    return ModelTorque(exact, torque, exact.errors_of(torque), exact.norms_of(torque))


def require_arm(model: SimplifiedModel, arm: RobotArm) -> None:
    """Raise a ModelError for an arm of another make than the model's: other joints, or axes elsewhere."""
    model_arm = model.arm

    def misfit(expected: str, value: str) -> ModelError:
        step = f"name a version of {model_arm.name}, or make a model of {arm.name} with `gd-analyze simplify`"
        message = f"the model of {model_arm.name} does not fit {arm.name}"
        return ModelError(message, where="arm", expected=expected, found=value, next_step=step)

    if arm.n_joints != model_arm.n_joints:
        raise misfit(f"{model_arm.n_joints} joints, as {model_arm.name} has", f"{arm.n_joints} joints")
    pairs = zip(model_arm.is_revolute, arm.is_revolute, strict=True)
    for joint, (model_turns, turns) in enumerate(pairs, start=1):
        if model_turns != turns:
            kinds = ("prismatic", "revolute")
            expected = f"joint {joint} is {kinds[model_turns]}, as of {model_arm.name}"
            raise misfit(expected, f"it is {kinds[turns]}")
    model_angles, angles = _angles_between_axes(model_arm), _angles_between_axes(arm)
    difference = np.abs(angles - model_angles)
    if difference.max() > _OTHER_AXES:
        at = np.unravel_index(difference.argmax(), difference.shape)
        between = f"between the axes of joints {at[0] + 1} and {at[1] + 1} at one position"
        expected, value = (f"{np.degrees(x[at]):.0f}° {between}" for x in (model_angles, angles))
        raise misfit(expected, value)


def _angles_between_axes(arm: RobotArm) -> FloatArray:
    """Angle between the axes of every two joints at a few positions, rad, shape (n, n, positions)."""
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (arm.n_joints, _POSITIONS))
    axes = solve_kinematics(arm, q).joint_axes
    return np.arccos(np.clip(np.einsum("iak,jak->ijk", axes, axes), -1.0, 1.0))


def torque_csv(trajectory: Trajectory, computed: ModelTorque) -> str:
    """Exact and simplified torque over time as CSV: time, exact1..n, simplified1..n."""
    import pandas as pd

    joints = range(1, trajectory.n_joints + 1)
    names = ["time", *(f"{kind}{joint}" for kind in ("exact", "simplified") for joint in joints)]
    rows = np.column_stack([trajectory.time, computed.dynamics.torque, computed.torque])
    return pd.DataFrame(rows, columns=names).to_csv(index=False, lineterminator="\n")


@dataclass(frozen=True, eq=False)
class PayloadEffect:
    """Effect of a point mass at the end effector (the last frame's origin) on a model over some states."""

    torque_per_kg: FloatArray  # largest torque per mass, (n,), N m per kg (N per kg)
    # Largest mass, kg, (n,), with which each joint's error stays within the budget: 0 if it exceeds it
    # without mass, infinite if no mass acts on the joint.
    mass_within_budget: FloatArray

    @property
    def largest_mass(self) -> float:
        """Largest mass, kg, with which every joint's error stays within the budget."""
        return float(self.mass_within_budget.min())

    @property
    def limiting_joint(self) -> int | None:
        """The joint, from 1, that exceeds its budget first; None if no mass acts on any."""
        return int(self.mass_within_budget.argmin()) + 1 if np.isfinite(self.largest_mass) else None


def payload_effect(model: SimplifiedModel, states: States) -> PayloadEffect:
    """Find the torque of a payload at every joint, and the largest payload that a model's budget allows.

    Torque is linear in a mass at a fixed point of the last link, so the error at a state is e - m g, with the
    torque g of one kilogram, and reaches the budget b at m = (b +- e) / abs(g).

    Parameters
    ----------
    model
        A model of the arm without the payload.
    states
        States at which the result holds.

    Returns
    -------
    PayloadEffect
        Torque per mass, N m/kg (N/kg), and largest mass, kg, by joint.
    """
    require_model(model)
    require_type(states, States, "states", "the States of `states_of` or `states_in_box`")
    states = states_for(model.arm, states)
    exact = ExactDynamics(model.form, states)
    error = model.torque(*states.arrays) - exact.torque
    # One column of the regressor, N m, shape (N, n).
    of_a_kilogram = np.empty(error.shape)
    for chunk in chunks(len(states)):
        of_a_kilogram[chunk] = link_regressor(model.arm, *states.at(chunk).last)[:, -1, 0].T
    # Round-off of cancelled terms is neither an error nor an effect.
    size, sign = np.abs(of_a_kilogram), np.sign(of_a_kilogram)
    acts = size > ROUND_OFF_SHARE * size.max()
    error[np.abs(error) <= exact.round_off] = 0.0
    allowed = model.accuracy.allowed
    mass = np.full(size.shape, np.inf)
    np.divide(allowed + sign * error, size, out=mass, where=acts)
    mass[np.abs(error) > allowed] = 0.0
    return PayloadEffect(np.where(acts, size, 0.0).max(axis=0), mass.min(axis=0))


@dataclass(frozen=True)
class Loss:
    """One dropped part, and its torque alone at the joint where it matters most."""

    part: str
    torque_peak: float  # N m
    torque_joint: int  # from 1
    torque_share: float  # of the peak torque there; infinite if the joint has none


def losses(model: SimplifiedModel, exact: ExactDynamics) -> tuple[Loss, ...]:
    """Rank dropped parts of elements by their torque alone, as shares of peak torque, the largest first.

    At other levels single terms are dropped, see `rank_terms`, or none, and the result is empty.
    """
    if not isinstance(model.level, ElementLevel):
        return ()
    parts = tuple(part for part in parts_of(model.arm.n_joints) if part not in model.terms)
    largest = np.zeros((len(parts), model.arm.n_joints))
    for chunk in chunks(len(exact.states)):
        dynamics = exact.at(exact.states.at(chunk))
        torque = np.abs(torque_by_part(dynamics.quantities, dynamics.states.qdd, parts))
        np.maximum(largest, torque.max(axis=2, initial=0.0), out=largest)
    shares = share_of(largest, exact.peak_torque)
    rows = [
        Loss(part.label, float(largest[p, joint]), int(joint) + 1, float(shares[p, joint]))
        for p, (part, joint) in enumerate(zip(parts, shares.argmax(axis=1), strict=True))
    ]
    return tuple(sorted(rows, key=lambda loss: -loss.torque_share))
