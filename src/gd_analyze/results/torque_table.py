"""Measured torques beside the exact model's, as a table."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from gd_analyze.dynamics.friction import TERMS
from gd_analyze.dynamics.measured_torque import TorqueComparison
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.schema import table

if TYPE_CHECKING:
    import xarray as xr


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
