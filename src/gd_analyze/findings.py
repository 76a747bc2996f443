"""Everything one run of the main job found; the store and both reports are views of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from gd_analyze.certification import Certificate
from gd_analyze.harmonics import Harmonics
from gd_analyze.models import ElementModel, ErrorTable, Evaluation, SimplifiedModel
from gd_analyze.pinocchio_check import Residual
from gd_analyze.robots import RobotArm
from gd_analyze.simplification import PayloadEffect, TermRanking, TradeOffPoint
from gd_analyze.trajectories import Trajectory

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Beyond:
    """What the model does away from the set points it was made for.

    Parameters
    ----------
    certificate
        Bound over all states between the extremes of the trajectory; None for a model of level "element".
    within_limits
        Error over states drawn from the arm's limits, and how many; None where the arm lacks a limit.
    drawn
        Number of those states.
    payload
        What a point mass in the hand does along the trajectory.
    """

    certificate: Certificate | None
    within_limits: ErrorTable | None
    drawn: int
    payload: PayloadEffect


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
    harmonics
        The exact equations; None for an arm that has too many to write out.
    model, evaluation
        The simplified model and its torques along the trajectory.
    element_model
        The model by the text's own method, keeping or dropping effects of elements; the same as `model` where
        that is its level.
    terms
        Ranking of every single term of D, h and c.
    trade_off
        Operations against error for all levels.
    beyond
        What the model does elsewhere.
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
    harmonics: Harmonics | None
    model: SimplifiedModel
    evaluation: Evaluation
    element_model: ElementModel
    terms: TermRanking
    trade_off: tuple[TradeOffPoint, ...]
    beyond: Beyond
    residuals: tuple[Residual, ...]
    warnings: tuple[str, ...]
    provenance: Mapping[str, str]
