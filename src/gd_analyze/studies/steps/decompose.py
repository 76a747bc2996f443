"""The second and third step of the main job: the exact dynamics, checked, and its elements ranked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.diagnosis.log_verdict import LogVerdict, verdict_with_warning
from gd_analyze.dynamics.dominance import rank
from gd_analyze.dynamics.drivetrain import with_friction
from gd_analyze.dynamics.measured_torque import TorqueComparison, compared
from gd_analyze.dynamics.pinocchio_check import Residual, cross_check
from gd_analyze.errors import warn_caller
from gd_analyze.motions.measured import has_torques
from gd_analyze.progress import Progress
from gd_analyze.results.diagnosis_result import diagnosis_table
from gd_analyze.results.motion_tables import measured_torque_table
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import too_many_terms
from gd_analyze.simplification.exact_dynamics import ExactDynamics, warn_of_torques
from gd_analyze.studies.against_log import require_log, with_log
from gd_analyze.studies.settings import Settings
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
    asked: Budget  # of the run; without one that is given, what the log allows if it agrees, or else 1 %
    too_many_terms: str  # why single terms are not ranked; "" if they are
    verdict: LogVerdict | None = None  # on the log, if there is one with torques
    comparison: TorqueComparison | None = None  # with its torques

    @property
    def is_contradicted(self) -> bool:
        """Whether the log does not agree with the file, at some joint at least."""
        return self.verdict is not None and (
            self.verdict.word == "does not agree" or bool(self.verdict.contradicted)
        )


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
    measured_torque = diagnosis = verdict = comparison = None
    if has_torques(motion):
        verdict = verdict_with_warning(arm, motion)
        comparison = compared(arm, motion, points.torque)
        measured_torque = measured_torque_table(
            comparison, motion, verdict, fit_friction=inputs.settings.fit_friction
        )
        require_log(verdict, inputs.settings.asked)
        exact = with_log(exact, verdict)
        if verdict.diagnosis is not None:
            diagnosis = diagnosis_table(verdict.diagnosis)
        if inputs.settings.fit_friction:
            terms = comparison.friction.terms
            if unknown := (1 + np.flatnonzero(np.isnan(terms).any(axis=1))).tolist():
                joints = named_joints(unknown, arm.n_joints)
                text = f"the log does not determine the friction of {joints}: the model has the file's there"
                warn_caller(text)
            arm = with_friction(arm, terms)
    return RunDynamics(
        points,
        exact,
        residuals,
        measured_torque,
        arm,
        diagnosis,
        _asked(inputs.settings, verdict),
        too_many_terms(exact.form),
        verdict,
        comparison,
    )


def _asked(settings: Settings, verdict: LogVerdict | None) -> Budget:
    """The budget given; without one, what a log that agrees with the file allows."""
    is_from_log = verdict is not None and verdict.word == "agrees" and verdict.resolution is not None
    return Budget.parse("log") if settings.budget is None and is_from_log else settings.asked


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
        warn_caller(text)
