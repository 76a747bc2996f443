"""A measured motion's readings as a table: what was read, what noise is left, and what it does to results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.dominance import elements
from gd_analyze.motions.logged import ColumnUse
from gd_analyze.motions.recording import Recording
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.schema import table

if TYPE_CHECKING:
    import xarray as xr

# Standard deviations within which noise stays nearly always.
_NEARLY_ALWAYS = 3.0
# Times the noise's own torque up to which a torque may be noise: at ends of a stretch there is more of it.
_MAY_BE_NOISE = 2.0
# Set points at which D is looked at, evenly spaced.
_MOST = 1000


def recording_table(
    arm: RobotArm, trajectory: Trajectory, dataset: xr.Dataset, dominance: xr.Dataset
) -> xr.Dataset:
    """Tabulate the readings of a measured motion, and what their noise makes of torques and ranking.

    Parameters
    ----------
    arm, trajectory
        Whose motion was measured.
    dataset, dominance
        Its decomposition and ranking.
    """
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

    Noise of accelerations has no part in elements of h and c: 0; that of positions and rates is far smaller.
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
