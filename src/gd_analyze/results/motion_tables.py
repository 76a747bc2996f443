"""Motions as labelled tables: set points, motion by motion, readings, and measured torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.arrays import FloatArray, round_off_of
from gd_analyze.dynamics.dominance import elements, rank
from gd_analyze.dynamics.friction import TERMS
from gd_analyze.dynamics.measured_torque import TorqueComparison
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.motions.logged import ColumnUse, Recording
from gd_analyze.motions.trajectory import Motion, Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import table
from gd_analyze.simplification.accuracy import Accuracy

if TYPE_CHECKING:
    import xarray as xr


# What is told of a motion besides.
_ABOUT = ("start", "origin", "derivatives_from", "fingerprint")
# What of the ranking of the elements is told motion by motion.
_RANKED = ("verdict", "dominant", "torque_share", "torque_joint")


def rank_by_motion(
    arm: RobotArm, dataset: xr.Dataset, trajectory: Trajectory, allowed: Sequence[FloatArray]
) -> list[xr.Dataset]:
    """Rank the elements along each motion by itself, given what the budget allows there, N m, shape (n,)."""
    alone = [_alone(arm, dataset, motion) for motion in trajectory.motions]
    return [rank(part, budget=budget) for part, budget in zip(alone, allowed, strict=True)]


def motions_table(
    arm: RobotArm,
    trajectory: Trajectory,
    dominance: xr.Dataset,
    ranked: Sequence[xr.Dataset],
    accuracy: Accuracy,
) -> xr.Dataset:
    """Tabulate what is found along each motion by itself, in the order of the ranking over all of them."""
    along, labels = accuracy.motions, dominance.element.values
    ranked = [one.sel(element=labels) for one in ranked]
    turning = arm.is_revolute
    columns: dict[str, Any] = {
        name: np.stack([one[name].values for one in ranked], axis=1) for name in _RANKED
    }
    times = [trajectory.time[motion.rows] for motion in trajectory.motions]
    return table(
        "motions",
        {
            "set_points": [motion.n_set_points for motion in trajectory.motions],
            "duration": [float(time[-1] - time[0]) for time in times],
            "peak_torque": np.array([one.errors.peak_torque for one in along]),
            "allowed_error": np.array([one.allowed for one in along]),
            "largest_error": np.array([one.errors.largest for one in along]),
            "rms_error": np.array([one.errors.rms for one in along]),
            **columns,
        },
        turning,
        {
            "motion": [motion.name for motion in trajectory.motions],
            **{
                f"motion_{name}": ("motion", [getattr(motion, name) for motion in trajectory.motions])
                for name in _ABOUT
            },
            "joint_name": ("joint", [joint.name for joint in arm.joints]),
            "element": labels,
            "quantity": ("element", dominance.quantity.values),
        },
    )


def motions_in(motions: xr.Dataset) -> tuple[Motion, ...]:
    """Which set points are whose, of the table."""
    ends = np.cumsum(motions.set_points.values).tolist()
    rows = zip(motions.motion.values.tolist(), [0, *ends[:-1]], ends, strict=True)
    described = zip(
        *(motions[f"motion_{name}"].values.tolist() for name in _ABOUT),
        strict=True,
    )
    return tuple(Motion(*row, *more) for row, more in zip(rows, described, strict=True))


def _alone(arm: RobotArm, dataset: xr.Dataset, motion: Motion) -> xr.Dataset:
    """The decomposition of one motion, and what is round-off there."""
    part = dataset.isel(time=motion.rows)
    states = (part[name].values for name in ("q", "qd", "qdd"))
    bound = round_off_bounds(arm, *states)["torque"]
    return part.assign_attrs(torque_round_off=round_off_of(part.torque.values, bound))


# Standard deviations within which noise stays nearly always.
_NEARLY_ALWAYS = 3.0
# Times the noise's own torque up to which a torque may be noise: at ends of a stretch there is more of it.
_MAY_BE_NOISE = 2.0
# Set points at which D is looked at, evenly spaced.
_MOST = 1000


def recording_table(
    arm: RobotArm, trajectory: Trajectory, dataset: xr.Dataset, dominance: xr.Dataset
) -> xr.Dataset:
    """Tabulate the readings of a measured motion, and what their noise makes of torques and ranking."""
    recording = trajectory.recording
    assert recording is not None  # asked for of a recording only
    count = dataset.sizes["time"]
    points = np.unique(np.linspace(0, count - 1, min(count, _MOST)).round().astype(int))
    inertia = np.asarray(dataset.inertia.isel(time=points).values.sum(axis=1))
    sigma = recording.noise_qdd
    drives = np.diag(arm.drive_inertia) if "drive_torque" in dataset else 0.0
    torque_noise = np.sqrt(np.square((inertia + drives) * sigma).sum(axis=2).mean(axis=0))
    noise = _of_elements(inertia, np.broadcast_to(sigma, (len(points), len(sigma))), dominance)
    made = _of_elements(inertia, trajectory.qdd[points], dominance)
    peak = dominance.torque_peak.values
    floor = np.asarray(dominance.attrs["floor"])[dominance.torque_joint.values - 1]
    columns = recording.columns
    return table(
        "recording",
        {
            "q_read": recording.q,
            "cutoff": recording.cutoff,
            "noise_q": recording.noise_q,
            "noise_qdd": sigma,
            "torque_noise": torque_noise,
            "element_noise": noise,
            "within_noise": (noise > 0.0) & (made <= _MAY_BE_NOISE * noise),
            "verdict_open": (noise > 0.0) & (np.abs(peak - floor) <= _NEARLY_ALWAYS * noise),
            "column_role": np.array([use.role for use in columns], dtype=str),
            "column_joint": np.array([use.joint for use in columns], dtype=str),
            "column_unit": np.array([use.unit for use in columns], dtype=str),
            "column_why": np.array([use.why for use in columns], dtype=str),
        },
        arm.is_revolute,
        {
            "time": ("time", trajectory.time, {"units": "s"}),
            "element": dominance.element.values,
            "torque_unit": ("element", dominance.torque_unit.values),
            "column": np.array([use.column for use in columns], dtype=str),
        },
        {"treatment": "\n".join(recording.treatment)},
    )


def recording_in(tables: Mapping[str, xr.Dataset]) -> Recording | None:
    """Recording of a motion that was tabulated; None where there is none."""
    if "recording" not in tables:
        return None
    found, torques = tables["recording"], tables.get("measured_torque")
    columns = zip(
        *(found[name].values.tolist() for name in ("column", "column_role", "column_joint")),
        *(found[name].values.tolist() for name in ("column_unit", "column_why")),
        strict=True,
    )
    treatment = found.attrs["treatment"]
    return Recording(
        q=found.q_read.values,
        torque=None if torques is None else torques.measured.values,
        torque_filtered=None if torques is None else torques.filtered.values,
        cutoff=found.cutoff.values,
        noise_q=found.noise_q.values,
        noise_qdd=found.noise_qdd.values,
        columns=tuple(ColumnUse(*column) for column in columns),
        treatment=tuple(treatment.split("\n")) if treatment else (),
    )


def _of_elements(inertia: FloatArray, qdd: FloatArray, dominance: xr.Dataset) -> FloatArray:
    """Root mean square of every element's torque, at its torque_joint and in the order of the ranking.

    Noise of accelerations has no part in h and c: 0; that of positions and velocities is far smaller.
    """
    of_label = {element.label: element for element in elements(qdd.shape[1])}
    out = np.zeros(dominance.sizes["element"])
    there = dominance.peak.values > 0.0
    for row, (label, joint) in enumerate(
        zip(dominance.element.values.tolist(), dominance.torque_joint.values.tolist(), strict=True)
    ):
        element = of_label[label]
        if element.j is not None and there[row]:
            # At one of its joints it makes torque of the other's acceleration.
            other = element.i if element.j == joint - 1 else element.j
            out[row] = np.sqrt(np.square(inertia[:, element.i, element.j] * qdd[:, other]).mean())
    return out


def measured_torque_table(
    comparison: TorqueComparison, trajectory: Trajectory, *, fit_friction: bool = False
) -> xr.Dataset:
    """Tabulate a comparison, with the friction that was fitted only where it is asked for."""
    recording = trajectory.recording
    assert recording is not None  # a comparison is of one
    arm, friction = comparison.arm, comparison.friction
    values: dict[str, Any] = {
        "measured": recording.torque,
        "filtered": comparison.measured,
        "correlation": comparison.correlation,
        "slope": comparison.slope,
        "bias": comparison.bias,
        "rms_difference": comparison.rms,
        "peak_measured": comparison.peak_measured,
        "peak_model": comparison.peak_model,
        "explained": comparison.explained,
        "slope_beside_friction": comparison.slope_beside_friction,
        "slope_error": comparison.slope_error,
        "verdict": np.array(comparison.verdicts),
        "resembles": np.array(comparison.resembles),
    }
    if fit_friction:
        for k, name in enumerate(TERMS):
            values |= {name: friction.terms[:, k], f"{name}_error": friction.errors[:, k]}
        for name in ("rms", "correlation", "explained"):
            values[f"{name}_beside_friction"] = getattr(friction, name)
    return table(
        "measured_torque",
        values,
        arm.is_revolute,
        {
            "time": ("time", trajectory.time, {"units": "s"}),
            "joint_name": ("joint", [joint.name for joint in arm.joints]),
        },
        {"compared": comparison.compared, "filter": int(recording.cutoff is not None)},
    )


def trajectory_table(arm: RobotArm, trajectory: Trajectory) -> xr.Dataset:
    """Tabulate the motion."""
    gaps = {"stretch_from": [1, *(row + 1 for row in trajectory.gaps)]} if trajectory.gaps else {}
    return table(
        "trajectory",
        {"q": trajectory.q, "qd": trajectory.qd, "qdd": trajectory.qdd, **gaps},
        arm.is_revolute,
        {"time": ("time", trajectory.time, {"units": "s"})},
        {
            "name": trajectory.name,
            "origin": trajectory.origin,
            "velocities": trajectory.derivatives_from,
            "fingerprint": trajectory.fingerprint,
        },
    )


def gaps_in(motion: xr.Dataset) -> tuple[int, ...]:
    """Gaps of a trajectory that was tabulated."""
    return tuple((motion.stretch_from.values[1:] - 1).tolist()) if "stretch_from" in motion else ()
