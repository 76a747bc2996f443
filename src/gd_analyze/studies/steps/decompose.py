"""The second and third step of the main job: the exact dynamics, checked, and its elements ranked."""

from __future__ import annotations

import warnings
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.diagnosis.log_verdict import log_verdict
from gd_analyze.dynamics.dominance import rank
from gd_analyze.dynamics.drivetrain import with_friction
from gd_analyze.dynamics.measured_torque import compared
from gd_analyze.dynamics.pinocchio_check import Residual, cross_check
from gd_analyze.errors import GdAnalyzeWarning, LeadingWarning
from gd_analyze.motions.measured import has_torques
from gd_analyze.motions.pool import taken_apart
from gd_analyze.progress import Progress
from gd_analyze.results.diagnosis_result import diagnosis_table
from gd_analyze.results.motion_tables import measured_torque_table
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import too_many_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics, warn_of_torques
from gd_analyze.studies.steps.read import RunInputs
from gd_analyze.studies.steps.set_points import KeptMotion, LongMotion, set_points_of
from gd_analyze.text import named_joints

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class RunDynamics:
    """The exact dynamics along a motion."""

    points: KeptMotion | LongMotion  # the set points that searches look at, and their decomposition
    exact: ExactDynamics  # at these set points
    residuals: tuple[Residual, ...]  # differences from Pinocchio
    measured_torque: xr.Dataset | None
    arm: RobotArm  # with the friction that was fitted, if it was asked for
    diagnosis: xr.Dataset | None  # of measured torques; None if nothing can be compared
    is_contradicted: bool  # whether the log does not agree with the file
    too_many_terms: str  # why single terms are not ranked; "" if they are


def decompose_step(inputs: RunInputs, progress: Progress) -> RunDynamics:
    """Decompose the dynamics at the set points, and check them against Pinocchio and the log's torques."""
    arm, motion = inputs.arm, inputs.trajectory
    points = set_points_of(inputs, progress)
    progress.stage("checking and ranking")
    dataset = points.dataset
    dataset.attrs |= inputs.source
    residuals = cross_check(arm, dataset)
    exact = ExactDynamics.of(arm, dataset)
    warn_of_torques(exact)
    measured_torque = diagnosis = None
    is_contradicted = False
    if has_torques(motion):
        verdict = log_verdict(arm, taken_apart(motion))
        comparison = compared(arm, motion, points.torque)
        measured_torque = measured_torque_table(
            comparison, motion, verdict, fit_friction=inputs.settings.fit_friction
        )
        is_contradicted = verdict.word == "does not agree"
        if verdict.diagnosis is not None:
            diagnosis = diagnosis_table(verdict.diagnosis)
        if verdict.word != "agrees":
            warnings.warn(f"log {motion.name}: {verdict.text}", LeadingWarning, stacklevel=2)
        if inputs.settings.fit_friction:
            terms = comparison.friction.terms
            if unknown := (1 + np.flatnonzero(np.isnan(terms).any(axis=1))).tolist():
                joints = named_joints(unknown, arm.n_joints)
                text = f"the log does not determine the friction of {joints}: the model has the file's there"
                warnings.warn(text, GdAnalyzeWarning, stacklevel=2)
            arm = with_friction(arm, terms)
    return RunDynamics(
        points,
        exact,
        residuals,
        measured_torque,
        arm,
        diagnosis,
        is_contradicted,
        too_many_terms(exact.form),
    )


def rank_step(inputs: RunInputs, dynamics: RunDynamics, budget: Budget) -> xr.Dataset:
    """Rank the elements by what they do to torque, and give verdicts at a budget."""
    return rank(
        dynamics.points.dataset,
        threshold=inputs.settings.dominance,
        budget=dynamics.exact.under(budget).allowed(budget),
        extremes=dynamics.points.extremes,
    )


def warn_of_too_many_terms(dynamics: RunDynamics) -> None:
    """Warn where single terms are not ranked."""
    if dynamics.too_many_terms:
        name = dynamics.exact.arm.name
        text = f"{name} has {dynamics.too_many_terms}: elements are ranked, single terms are not"
        warnings.warn(text, GdAnalyzeWarning, stacklevel=2)
