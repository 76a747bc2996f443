"""Motions as labelled tables: set points, motion by motion, readings, and measured torque."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, round_off_of
from gd_analyze.certification.certificate import Certificate
from gd_analyze.certification.tube import Tube
from gd_analyze.diagnosis.log_verdict import LogVerdict
from gd_analyze.dynamics.decomposition import (
    arrays_on_demand,
    decompose_states,
    decomposition_coordinates,
    on_demand,
)
from gd_analyze.dynamics.dominance import elements, rank
from gd_analyze.dynamics.friction import FRICTION_TERMS
from gd_analyze.dynamics.measured_torque import TorqueComparison, with_friction_fitted
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.motions.columns import ColumnUse
from gd_analyze.motions.smoothing import Recording
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Motion, Trajectory, Whole
from gd_analyze.results.run_tables import joint_names
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import table
from gd_analyze.simplification.accuracy import Accuracy
from gd_analyze.simplification.model import SimplifiedModel

if TYPE_CHECKING:
    import xarray as xr


# Further attributes of a motion.
_ABOUT = ("start", "origin", "derivatives_from", "fingerprint")
# Variables of the ranking that are stored motion by motion.
_RANKED = ("verdict", "dominant", "torque_share", "torque_joint")
# Standard deviations that noise hardly ever exceeds.
_NOISE_SIGMAS = 3.0
# A torque up to this multiple of the torque noise may be noise, of which the ends of a stretch have more.
_TORQUE_NOISE_RATIO = 2.0
# Set points at which D is evaluated, evenly spaced.
_INERTIA_SET_POINTS = 1000


def trajectory_table(arm: RobotArm, trajectory: Trajectory) -> xr.Dataset:
    """Tabulate the motion."""
    gaps = {"stretch_from": [1, *(row + 1 for row in trajectory.gaps)]} if trajectory.gaps else {}
    return table(
        "trajectory",
        {"q": trajectory.q, "qd": trajectory.qd, "qdd": trajectory.qdd, **gaps},
        arm.is_revolute,
        _over_time(trajectory),
        {
            "name": trajectory.name,
            "origin": trajectory.origin,
            "velocities": trajectory.derivatives_from,
            "fingerprint": trajectory.fingerprint,
        }
        | ({} if trajectory.whole is None else {"set_points": trajectory.n_stated}),
    )


def every_set_point_table(
    arm: RobotArm, motion: Trajectory, model: SimplifiedModel, *, drives: bool | None, **options: bool
) -> xr.Dataset:
    """Tabulate the decomposition and the model's torque at all set points, evaluated on access."""
    arrays = arrays_on_demand(arm, motion, drives, **options)

    def simplified(rows: NDArray[np.intp]) -> FloatArray:
        return model.torque(*(getattr(motion, kind)[rows] for kind in ("q", "qd", "qdd")))

    arrays["simplified_torque"] = on_demand(motion.q.shape, simplified)
    return table("every_set_point", arrays, arm.is_revolute, decomposition_coordinates(arm, motion, arrays))


def trajectory_in(tables: Mapping[str, xr.Dataset]) -> Trajectory:
    """Restore the tabulated motion."""
    motion = tables["trajectory"]
    gaps = (motion.stretch_from.values[1:] - 1).tolist() if "stretch_from" in motion else ()
    return Trajectory(
        motion.time.values,
        motion.q.values,
        motion.qd.values,
        motion.qdd.values,
        motion.attrs["name"],
        motion.attrs["origin"],
        motion.attrs["velocities"],
        gaps=tuple(gaps),
        whole=Whole(int(motion.attrs["set_points"]), motion.attrs["fingerprint"])
        if "set_points" in motion.attrs
        else None,
        motions=_motions_in(tables["motions"]) if "motions" in tables else (),
        recording=_recording_in(tables) if "recording" in tables else None,
    )


def rank_by_motion(
    arm: RobotArm, dataset: xr.Dataset, trajectory: Trajectory, allowed: Sequence[FloatArray]
) -> list[xr.Dataset]:
    """Rank the elements along each motion by itself, given the errors allowed there, N m, shape (n,)."""
    ranked = []
    for motion, budget in zip(trajectory.motions, allowed, strict=True):
        part = dataset.isel(time=motion.rows)
        bound = round_off_bounds(arm, *(part[name].values for name in ("q", "qd", "qdd")))["torque"]
        round_off = round_off_of(part.torque.values, bound)
        ranked.append(rank(part.assign_attrs(torque_round_off=round_off), budget=budget))
    return ranked


def motions_table(
    arm: RobotArm,
    trajectory: Trajectory,
    dominance: xr.Dataset,
    ranked: Sequence[xr.Dataset],
    accuracy: Accuracy,
    certificate: Certificate | None,
) -> xr.Dataset:
    """Tabulate the results along each motion and the bounds near it, in the order of the overall ranking."""
    motions, along, labels = trajectory.motions, accuracy.motions, dominance.element.values
    ranked = [ranking.sel(element=labels) for ranking in ranked]
    times = [trajectory.time[motion.rows] for motion in motions]
    about = {f"motion_{name}": ("motion", [getattr(motion, name) for motion in motions]) for name in _ABOUT}
    return table(
        "motions",
        {
            "set_points": [motion.n_set_points for motion in motions],
            "duration": [float(time[-1] - time[0]) for time in times],
            "peak_torque": np.array([motion_accuracy.errors.peak_torque for motion_accuracy in along]),
            "allowed_error": np.array([motion_accuracy.allowed for motion_accuracy in along]),
            "largest_error": np.array([motion_accuracy.errors.largest for motion_accuracy in along]),
            "rms_error": np.array([motion_accuracy.errors.rms for motion_accuracy in along]),
            "certified": _certified(certificate, (len(along), arm.n_joints)),
            **{name: np.stack([ranking[name].values for ranking in ranked], axis=1) for name in _RANKED},
        },
        arm.is_revolute,
        {
            "motion": [motion.name for motion in motions],
            **about,
            **joint_names(arm),
            "element": labels,
            "quantity": ("element", dominance.quantity.values),
        },
    )


def _certified(certificate: Certificate | None, shape: tuple[int, int]) -> FloatArray:
    """Proven bounds near each of several motions, shape (motions, n); nan where nothing is proven."""
    region = None if certificate is None else certificate.region
    if certificate is None or certificate.along is None or not isinstance(region, Tube):
        return np.full(shape, np.nan)
    assert region.motion is not None  # the tube is around several motions
    bounds = np.zeros(shape)
    np.maximum.at(bounds, region.motion, certificate.along)
    return bounds


def _motions_in(motions: xr.Dataset) -> tuple[Motion, ...]:
    """Assignment of set points to motions, from the table."""
    ends = np.cumsum(motions.set_points.values).tolist()
    about = (motions[f"motion_{name}"].values.tolist() for name in _ABOUT)
    rows = zip(motions.motion.values.tolist(), [0, *ends[:-1]], ends, *about, strict=True)
    return tuple(Motion(*row) for row in rows)


def recording_table(
    arm: RobotArm, motion: Trajectory, shown: Trajectory, dataset: xr.Dataset, dominance: xr.Dataset
) -> xr.Dataset:
    """Tabulate the readings of a measured motion, and the effect of their noise on torques and ranking.

    Readings are those at the set points `shown`, as in `dataset`; effects are those along the whole motion.
    """
    recording = shown.recording
    assert recording is not None  # called for recordings only
    states = states_of(motion).evenly(_INERTIA_SET_POINTS)
    inertia = decompose_states(arm, states, christoffel=False, shares=False)["inertia"].sum(axis=1)
    sigma = recording.noise_qdd
    drives = np.diag(dataset.attrs["drive_inertia"])
    torque_noise = np.sqrt(np.square((inertia + drives) * sigma).sum(axis=2).mean(axis=0))
    noise = _of_elements(inertia, np.broadcast_to(sigma, states.qdd.shape), dominance)
    motion_torque = _of_elements(inertia, states.qdd, dominance)
    peak = dominance.torque_peak.values
    floor = np.asarray(dominance.attrs["floor"])[dominance.torque_joint.values - 1]
    return table(
        "recording",
        {
            "q_read": recording.q,
            "cutoff": recording.cutoff,
            "noise_q": recording.noise_q,
            "noise_qdd": sigma,
            "torque_noise": torque_noise,
            "element_noise": noise,
            "within_noise": (noise > 0.0) & (motion_torque <= _TORQUE_NOISE_RATIO * noise),
            "verdict_open": (noise > 0.0) & (np.abs(peak - floor) <= _NOISE_SIGMAS * noise),
            **{f"column_{name}": _words(recording, name) for name in ("role", "joint", "unit", "why")},
        },
        arm.is_revolute,
        {
            **_over_time(shown),
            "element": dominance.element.values,
            "torque_unit": ("element", dominance.torque_unit.values),
            "column": np.array(_distinct([use.column for use in recording.columns]), dtype=str),
        },
        {"treatment": "\n".join(recording.treatment)},
    )


def _distinct(names: Sequence[str]) -> list[str]:
    """Names of columns; a repeated one gets its number: "temp (9)"."""
    return [f"{name} ({k})" if name in names[: k - 1] else name for k, name in enumerate(names, start=1)]


def _words(recording: Recording, name: str) -> np.ndarray:
    return np.array([getattr(use, name) for use in recording.columns], dtype=str)


def _recording_in(tables: Mapping[str, xr.Dataset]) -> Recording:
    """Restore the recording of a tabulated motion."""
    recording, torques = tables["recording"], tables.get("measured_torque")
    names = ("column", "column_role", "column_joint", "column_unit", "column_why")
    columns = zip(*(recording[name].values.tolist() for name in names), strict=True)
    treatment = recording.attrs["treatment"]
    return Recording(
        q=recording.q_read.values,
        torque=None if torques is None else torques.measured.values,
        torque_filtered=None if torques is None else torques.filtered.values,
        cutoff=recording.cutoff.values,
        noise_q=recording.noise_q.values,
        noise_qdd=recording.noise_qdd.values,
        columns=tuple(ColumnUse(*column) for column in columns),
        treatment=tuple(treatment.split("\n")) if treatment else (),
    )


def _of_elements(inertia: FloatArray, qdd: FloatArray, dominance: xr.Dataset) -> FloatArray:
    """RMS torque of every element at its torque_joint, in the order of the ranking.

    It is 0 for h and c, which accelerations do not enter; noise of positions and velocities is far smaller.
    """
    of_label = {element.label: element for element in elements(qdd.shape[1])}
    out = np.zeros(dominance.sizes["element"])
    rows = zip(*(dominance[name].values for name in ("element", "torque_joint", "peak")), strict=True)
    for row, (label, joint, peak) in enumerate(rows):
        element = of_label[label]
        if element.j is not None and peak > 0.0:
            # At one of its joints an element multiplies the acceleration of the other.
            other_joint = element.i if element.j == joint - 1 else element.j
            out[row] = np.sqrt(np.square(inertia[:, element.i, element.j] * qdd[:, other_joint]).mean())
    return out


def measured_torque_table(
    comparison: TorqueComparison, trajectory: Trajectory, verdict: LogVerdict, *, fit_friction: bool = False
) -> xr.Dataset:
    """Tabulate a comparison beside the verdict; fitted friction is included only if asked for."""
    recording = trajectory.recording
    assert recording is not None  # a comparison needs a recording
    arm, friction = comparison.arm, comparison.friction
    values: dict[str, Any] = {
        "measured": recording.torque,
        "filtered": comparison.measured,
        "bias": comparison.bias,
        "rms_difference": comparison.rms,
        "peak_measured": comparison.peak_measured,
        "rms_measured": comparison.rms_measured,
        "explained": comparison.explained,
        "rms_beside_friction": friction.rms,
        "below_95": friction.below_95,
        "with_friction": with_friction_fitted(comparison, trajectory),
    }
    if fit_friction:
        for k, name in enumerate(FRICTION_TERMS):
            values |= {name: friction.terms[:, k], f"{name}_error": friction.errors[:, k]}
        values["explained_beside_friction"] = friction.explained
    attributes = {
        "compared": comparison.compared,
        "filter": int(recording.cutoff is not None),
        "verdict": verdict.word,
        "opening": verdict.opening,
        "agreement": verdict.text,
    }
    coordinates = _over_time(trajectory) | joint_names(arm)
    return table("measured_torque", values, arm.is_revolute, coordinates, attributes)


def _over_time(trajectory: Trajectory) -> dict[str, Any]:
    return {"time": ("time", trajectory.time, {"units": "s"})}
