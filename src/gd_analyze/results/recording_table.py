"""A measured motion's readings as a table: what was read, what noise is left, and what it does to results."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.elements import elements
from gd_analyze.logs import ColumnUse
from gd_analyze.robots import RobotArm
from gd_analyze.schema import table
from gd_analyze.trajectories import Recording, Trajectory
from gd_analyze.vectors import FloatArray

if TYPE_CHECKING:
    import xarray as xr

# Standard deviations within which noise stays nearly always.
NEARLY_ALWAYS = 3.0
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
    inertia = _inertia(dataset)
    sigma = recording.noise_qdd
    drives = np.diag(arm.drive_inertia) if "drive_torque" in dataset else 0.0
    torque_noise = np.sqrt(np.square((inertia + drives) * sigma).sum(axis=2).mean(axis=0))
    noise = np.where(dominance.peak.values > 0.0, _element_noise(inertia, sigma, dominance), 0.0)
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
            "within_noise": (noise > 0.0) & (peak <= NEARLY_ALWAYS * noise),
            "verdict_open": (noise > 0.0) & (np.abs(peak - floor) <= NEARLY_ALWAYS * noise),
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


def _inertia(dataset: xr.Dataset) -> FloatArray:
    """D at some set points, shape (N, n, n)."""
    count = dataset.sizes["time"]
    points = np.unique(np.linspace(0, count - 1, min(count, _MOST)).round().astype(int))
    return np.asarray(dataset.inertia.isel(time=points).values.sum(axis=1))


def _element_noise(inertia: FloatArray, sigma: FloatArray, dominance: xr.Dataset) -> FloatArray:
    """What noise of accelerations makes of every element's torque, in the order of the ranking.

    Elements of h and c have no part in it: noise of positions and rates is far smaller.
    """
    size = np.sqrt(np.square(inertia).mean(axis=0))
    of_label = {element.label: element for element in elements(len(sigma))}
    out = np.zeros(dominance.sizes["element"])
    for row, (label, at) in enumerate(
        zip(dominance.element.values.tolist(), (dominance.torque_joint.values - 1).tolist(), strict=True)
    ):
        element = of_label[label]
        if element.j is not None:
            # At one of its joints it makes torque of the other's acceleration.
            other = element.i if element.j == at else element.j
            out[row] = size[element.i, element.j] * sigma[other]
    return out
