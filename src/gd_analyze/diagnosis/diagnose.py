"""What is wrong between a log and an arm's file: hypotheses, ranked by what remains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array
from gd_analyze.diagnosis.correction import Correction
from gd_analyze.diagnosis.faults import VELOCITIES, Fault, faults_of
from gd_analyze.diagnosis.fit import FileFit
from gd_analyze.diagnosis.hypothesis import Candidate, Hypothesis, Problem
from gd_analyze.diagnosis.of_positions import (
    Coupling,
    Direction,
    JointOrder,
    TimeUnit,
    WristCoupling,
    Zero,
    ZeroOfSlide,
)
from gd_analyze.diagnosis.of_the_arm import ChangeInTime, Gravity, NamedEnd, Payload
from gd_analyze.diagnosis.of_torques import JointScale, Lag, TorqueColumns, TorqueScale, TorqueSign
from gd_analyze.diagnosis.samples import samples_of
from gd_analyze.diagnosis.settings import DIAGNOSIS_SETTINGS, DiagnosisSettings
from gd_analyze.dynamics.measured_torque import require_torques
from gd_analyze.errors import UsageError
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.pool import GivenMotions, motions_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.result import value_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.text import html_of, joint_name
from gd_analyze.threads import one_thread

# Every kind of cause; a new one is one more entry.
HYPOTHESES: tuple[Hypothesis, ...] = (
    TorqueSign(),
    TorqueScale(),
    JointScale(),
    TorqueColumns(),
    Lag(),
    Direction(),
    Zero(),
    ZeroOfSlide(),
    JointOrder(),
    Coupling(),
    WristCoupling(),
    TimeUnit(),
    Gravity(),
    Payload(),
    NamedEnd(),
    ChangeInTime(),
)


# Factor on torques beside which those of links vanish.
_WEIGHTLESS_FACTOR = 1e4


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What is wrong between logs and an arm's file.

    Parameters
    ----------
    arm, logs
        The arm as its file says, and names of the logs.
    causes
        Causes found, each beside those before; empty if nothing needs an explanation.
    rivals
        Causes nearly as good as the first, with another remedy.
    ranking
        All that was tried as first cause, the best first.
    faults
        Faults of readings, such as frozen or clipped torques, which are not compared.
    before, after
        Fit of file and friction alone, and with the causes; residuals by joint are shares of torque, nan at
        joints that rest or have no torques.
    problem, corrected
        Samples compared as logged, and corrected.
    tells
        Whether the logs tell anything of the links beside friction; otherwise there is too little motion.
    """

    arm: RobotArm
    logs: tuple[str, ...]
    causes: tuple[Candidate, ...]
    rivals: tuple[Candidate, ...]
    ranking: tuple[Candidate, ...]
    faults: tuple[Fault, ...]
    before: FileFit
    after: FileFit
    problem: Problem
    corrected: Problem
    tells: bool

    def __repr__(self) -> str:
        names = ", ".join(cause.name for cause in self.causes) or "no cause"
        return f"Diagnosis({self.arm.name!r}, {names})"

    def _repr_html_(self) -> str:
        """What remains of each joint's torque, as logged and mended, for a notebook."""
        columns = (self.before.residuals.tolist(), self.after.residuals.tolist())
        rows = [
            [joint_name(i, joint.name), *(value_text(x, shown="percent") for x in pair)]
            for i, (joint, *pair) in enumerate(zip(self.arm.joints, *columns, strict=True), start=1)
        ]
        causes = [f"{cause.what}: {cause.remedy}." for cause in self.causes] or ["No cause was found."]
        title = f"{self.arm.title or self.arm.name} diagnosed with {', '.join(self.logs)}"
        return html_of(title, ["joint", "remains", "with the causes"], rows, " ".join(causes))

    @property
    def cause(self) -> Candidate | None:
        """The first cause; None if there is none."""
        return self.causes[0] if self.causes else None

    @property
    def is_far_off(self) -> bool:
        """Whether links must be off by more than a file's usually are, with the causes, too."""
        return self.after.changed > self.problem.settings.most_changes


@strict
@one_thread()
def diagnose(
    arm: RobotArm | str | Path,
    logs: GivenMotions,
    *,
    thorough: bool = True,
    settings: DiagnosisSettings = DIAGNOSIS_SETTINGS,
) -> Diagnosis:
    """Say why logs and an arm's file disagree.

    The file's own error, friction and drives are part of every hypothesis, and so of none the cause: every
    one is fitted to some stretches of the logs and scored on the others. A cause is claimed where the score
    falls clearly below that of the file's error alone.

    Parameters
    ----------
    arm
        The arm; or a shipped name, or the path of a file.
    logs
        Recordings with torques; or paths of files.
    thorough
        Try every cause, even where file and friction leave nothing to explain.
    settings
        Weights and thresholds.

    Returns
    -------
    Diagnosis
        Causes with the option or edit that mends each, and the ranking of all that was tried.

    Raises
    ------
    UsageError
        If a log has no torques, the file has no masses, or no joint moves.
    TrajectoryError
        If a log has another number of joints.

    Examples
    --------
    >>> from gd_analyze.diagnosis.hypothesis import Hypothesis
    >>> all(isinstance(one, Hypothesis) for one in HYPOTHESES)
    True
    """
    arm = arm_with_masses(arm)
    return diagnosed(arm, motions_of(logs, arm), thorough=thorough, settings=settings)


def diagnosed(
    arm: RobotArm,
    motions: Sequence[Trajectory],
    *,
    thorough: bool = True,
    settings: DiagnosisSettings = DIAGNOSIS_SETTINGS,
) -> Diagnosis:
    """Diagnose motions as they are, several in one recording, too; see `diagnose`."""
    for motion in motions:
        require_trajectory_joints(motion, arm)
        require_torques(motion)
    faults, usable = faults_of(arm, motions)
    usable = [good & _settled(motion)[:, None] for good, motion in zip(usable, motions, strict=True)]
    problem = Problem(samples_of(arm, motions, usable, settings), Correction.none(arm.n_joints), settings)
    if not problem.samples.counts.any():
        if not any(fault.name != VELOCITIES for fault in faults):
            raise UsageError(
                "no joint moves enough to compare torques",
                where=f"arm {arm.name}",
                expected="joints that move to and fro, faster than creeping, for some seconds",
                next_step="record more motion: `gd-analyze plan ROBOT --exciting` plans one",
            )
        nothing = FileFit.of_nothing(arm.n_joints)
        names = tuple(motion.name for motion in motions)
        return Diagnosis(arm, names, (), (), (), tuple(faults), nothing, nothing, problem, problem, False)
    tells = _tells(problem)
    ranking = _ranked(problem) if thorough or not tells or is_unexplained(problem.null, settings) else []
    causes: list[Candidate] = []
    rivals: list[Candidate] = []
    corrected, ranked = problem, ranking
    while ranked and is_clear(ranked[0], settings) and len(causes) < settings.most_causes:
        best = ranked[0]
        causes.append(best)
        if len(causes) == 1:
            rivals = [
                candidate
                for candidate in ranked[1:]
                if candidate.fall > best.fall - settings.alike_fall
                and is_clear(candidate, settings)
                and candidate.name != best.name
            ]
        corrected = Problem(problem.samples, best.correction, settings)
        if not is_unexplained(corrected.null, settings):
            break
        ranked = [
            candidate
            for candidate in _ranked(corrected)
            if candidate.name not in {cause.name for cause in causes}
        ]
    return Diagnosis(
        arm=arm,
        logs=tuple(motion.name for motion in motions),
        causes=tuple(causes),
        rivals=tuple(rivals[:2]),
        ranking=tuple(ranking),
        faults=tuple(faults),
        before=problem.null,
        after=corrected.null,
        problem=problem,
        corrected=corrected,
        tells=bool(causes) or tells,
    )


def is_clear(cause: Candidate, settings: DiagnosisSettings) -> bool:
    """Whether the score falls by enough to claim a cause."""
    assert cause.fit is not None  # judged
    return cause.fall > settings.clear_fall + settings.clear_fall_share * cause.fit.unexplained


def is_unexplained(fit: FileFit, settings: DiagnosisSettings) -> bool:
    """Whether more is to be explained than a file is usually off by."""
    largest_residual = float(np.nanmax(fit.residuals, initial=0.0))
    return fit.changed > settings.most_changes or largest_residual > settings.most_residual_share


def _ranked(problem: Problem) -> list[Candidate]:
    """Causes, the best first; of those about as good as the best, one of fewer numbers comes first."""
    candidates = [candidate for hypothesis in HYPOTHESES for candidate in hypothesis.judged(problem)]
    candidates.sort(key=lambda candidate: -candidate.fall)
    if candidates:
        alike = [
            candidate
            for candidate in candidates
            if candidate.fall > candidates[0].fall - problem.settings.known_advantage
        ]
        simplest = min(alike, key=lambda candidate: candidate.numbers)
        candidates.remove(simplest)
        candidates.insert(0, simplest)
    return candidates


def _tells(problem: Problem) -> bool:
    """Whether it would be noticed if the arm weighed next to nothing, so that friction alone remained."""
    light = problem.correction.with_torque(_WEIGHTLESS_FACTOR * np.eye(problem.n))
    return problem.score(light) > problem.settings.clear_fall


def _settled(motion: Trajectory) -> Array:
    """Set points away from the ends of stretches, where the filter has not settled, (N,)."""
    recording, inside = motion.recording, np.ones(motion.n_set_points, dtype=bool)
    if recording is None or recording.cutoff is None or not np.isfinite(recording.cutoff).any():
        return inside
    wait = 0.5 / float(np.nanmax(recording.cutoff))
    for stretch in motion.stretches:
        time = motion.time[stretch]
        inside[stretch] = (time - time[0] >= wait) & (time[-1] - time >= wait)
    return inside if inside.any() else ~inside
