"""Everything one run of the main job found; the store and both reports are views of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gd_analyze.authority import Residual
from gd_analyze.models import Evaluation, SimplifiedModel
from gd_analyze.robots import RobotArm
from gd_analyze.trajectories import Trajectory

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Findings:
    """One arm along one trajectory.

    Parameters
    ----------
    arm, trajectory
        What was analysed.
    decomposition
        Dataset of `decompose`.
    dominance
        Dataset of `rank`.
    model, evaluation
        The simplified model and its torques along the trajectory.
    residuals
        Largest differences from Pinocchio.
    warnings
        What is suspicious about the input, in sentences.
    provenance
        Versions, time, command.
    """

    arm: RobotArm
    trajectory: Trajectory
    decomposition: xr.Dataset
    dominance: xr.Dataset
    model: SimplifiedModel
    evaluation: Evaluation
    residuals: tuple[Residual, ...]
    warnings: tuple[str, ...]
    provenance: Mapping[str, str]
