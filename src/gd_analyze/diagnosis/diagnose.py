"""What is wrong between a log and an arm's file: hypotheses, ranked by what remains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, reduce
from pathlib import Path

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.diagnosis.answer import opening, word_of
from gd_analyze.diagnosis.as_filed import AsFiled, residuals_as_filed
from gd_analyze.diagnosis.causes import (
    CLEAR_FALL,
    MOST_RESIDUAL_SHARE,
    claimed,
    is_unexplained,
    ranked,
    rivals_of,
)
from gd_analyze.diagnosis.equations import corrected_columns
from gd_analyze.diagnosis.faults import VELOCITIES, Fault, without_faults
from gd_analyze.diagnosis.fit import MOST_CHANGES, FileFit
from gd_analyze.diagnosis.hypothesis import Candidate, Problem
from gd_analyze.diagnosis.remedies import Remedy, nothing
from gd_analyze.diagnosis.samples import samples_of
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.errors import UsageError
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.measured import require_torques, settled
from gd_analyze.motions.pool import GivenMotions, motions_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.result import value_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.text import html_of, joint_name
from gd_analyze.threads import one_thread

# Logs that no common answer explains are diagnosed one by one, up to this number: each takes a second.
_MOST_DIAGNOSED_ALONE = 8
# Share of the torque by which what is left may rise at a joint, beside a file as it is.
_WORSE_SHARE = 0.05
# Constant torque, as a share of a joint's RMS torque, and of the largest of all revolute or all prismatic
# joints, that is more than a sensor's usual bias. Of files that agree with real logs of six arms it is at
# most 0.05 of its own at joints that carry weight; wrists have more.
_MUCH_OFFSET_SHARE, _LEAST_OFFSET_SHARE = 0.2, 0.05
# Share of the samples in which a joint moves one way, of which friction and offset are told apart.
_LEAST_SHARE_OF_A_WAY = 0.15


@dataclass(frozen=True, eq=False)
class Diagnosis:
    """What is wrong between logs and an arm's file.

    Parameters
    ----------
    arm, logs
        The arm as its file says, and names of the logs.
    causes
        The cause found, or two of which each is seen beside the other; empty if nothing needs an explanation.
    rivals
        Causes that the logs do not tell from the one found, and others nearly as good.
    ranking
        All that was tried as first cause; the one found comes first, if there is one alone.
    faults
        Faults of readings, such as frozen or clipped torques, which are not compared.
    before, after
        Fit of file and friction alone, and with the causes, of links off by no more than a file's usually
        are; residuals by joint are shares of torque, nan at joints that rest or have no torques.
    problem, corrected
        Samples compared as logged, and corrected.
    tells
        Whether the logs tell anything of the links beside friction; otherwise there is too little motion.
    apart
        Logs that have a cause of their own which explains them, unlike most; none if one answer is all logs'.
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
    apart: tuple[tuple[str, Candidate], ...] = ()

    def __repr__(self) -> str:
        names = ", ".join(cause.name for cause in self.causes) or "no cause"
        return f"Diagnosis({self.arm.name!r}, {word_of(self)}: {names})"

    def _repr_html_(self) -> str:
        """What remains of each joint's torque, as logged and mended, for a notebook."""
        columns = (self.before.residuals.tolist(), self.after.residuals.tolist())
        rows = [
            [joint_name(i, joint.name), *(value_text(x, shown="percent") for x in pair)]
            for i, (joint, *pair) in enumerate(zip(self.arm.joints, *columns, strict=True), start=1)
        ]
        causes = [f"{cause.what}: {cause.remedy}." for cause in self.causes] or [opening(self)]
        title = f"{self.arm.title or self.arm.name} diagnosed with {', '.join(self.logs)}"
        return html_of(title, ["joint", "remains", "with the causes"], rows, " ".join(causes))

    @cached_property
    def as_filed(self) -> AsFiled:
        """What the file as it is leaves of each joint's torque, with friction."""
        return residuals_as_filed(self.problem)

    @cached_property
    def needing_a_fit(self) -> tuple[int, ...]:
        """Joints, from 1, of which the file as it is leaves more than a file's usual error does."""
        return tuple((1 + np.flatnonzero(self.as_filed.share > MOST_RESIDUAL_SHARE)).tolist())

    @cached_property
    def as_mended(self) -> AsFiled:
        """The same with the causes."""
        return residuals_as_filed(self.corrected) if self.causes else self.as_filed

    @cached_property
    def made_worse(self) -> tuple[int, ...]:
        """Joints, from 1, of which the file as it is leaves clearly more with the causes than without."""
        worse = self.as_mended.share > self.as_filed.share + _WORSE_SHARE
        return tuple((1 + np.flatnonzero(worse)).tolist())

    @cached_property
    def unmoved(self) -> tuple[int, ...]:
        """Joints, from 1, that every reading has at one position."""
        recordings = [log.recording for log in self.problem.samples.logs]
        q = np.concatenate([recording.q for recording in recordings if recording is not None])
        return tuple((1 + np.flatnonzero(np.ptp(q, axis=0) == 0.0)).tolist())

    @cached_property
    def offsets(self) -> dict[int, float]:
        """Constant torques, N m (N), that the file does not explain and that are much of a joint's, by joint.

        Joints count from 1. Those of which much else remains are left out, and those that hardly move one of
        both ways, where a constant may be friction.
        """
        size, constant = self.as_mended.rms / self.as_mended.share, self.after.joint_numbers[:, -1]
        is_revolute = np.array(self.arm.is_revolute)
        largest = [np.fmax.reduce(size[is_revolute == kind], initial=0.0) for kind in is_revolute]
        is_much = np.abs(constant) > np.maximum(
            _MUCH_OFFSET_SHARE * size, _LEAST_OFFSET_SHARE * np.array(largest)
        )
        is_much &= self.after.residuals <= MOST_RESIDUAL_SHARE
        if not is_much.any():
            return {}
        columns, counts, shared = corrected_columns(self.corrected.samples, self.corrected.correction)
        offsets = {}
        for i in np.flatnonzero(is_much).tolist():
            ahead = float(np.mean(columns[i, counts[:, i], shared + 1] > 0.0))
            if min(ahead, 1.0 - ahead) > _LEAST_SHARE_OF_A_WAY:
                offsets[i + 1] = float(constant[i])
        return offsets

    @property
    def cause(self) -> Candidate | None:
        """The first cause; None if there is none."""
        return self.causes[0] if self.causes else None

    @property
    def remedy(self) -> Remedy:
        """What the causes ask for, together."""
        return reduce(Remedy.then, (cause.remedy for cause in self.causes), nothing(self.problem.samples))

    @property
    def is_far_off(self) -> bool:
        """Whether links must be off by more than a file's usually are, with the causes, too."""
        return self.after.changed > MOST_CHANGES


@strict
@one_thread()
def diagnose(
    arm: RobotArm | str | Path,
    logs: GivenMotions,
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
        Recordings with torques; or paths of files, or a folder of them.

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
    >>> from gd_analyze.diagnosis.causes import HYPOTHESES
    >>> HYPOTHESES[0].name
    'unit of positions'
    """
    arm = arm_with_masses(arm)
    return diagnosed(arm, motions_of(logs, arm))


def diagnosed(
    arm: RobotArm,
    motions: Sequence[Trajectory],
    *,
    pairs: bool = True,
) -> Diagnosis:
    """Diagnose motions as they are, several in one recording, too; see `diagnose`.

    Without `pairs`, a cause that leaves much is told alone: the search for a second takes some seconds.
    """
    for motion in motions:
        require_trajectory_joints(motion, arm)
        require_torques(motion)
    checked = [without_faults(arm, motion) for motion in motions]
    faults = [fault for faults_of_log, _ in checked for fault in faults_of_log]
    motions = [motion for _, motion in checked]
    usable = [settled(motion)[:, None] for motion in motions]
    problem = Problem(samples_of(arm, motions, usable), Trial.none(arm.n_joints))
    if not problem.samples.counts.any():
        if not any(fault.name != VELOCITIES for fault in faults):
            raise UsageError(
                "no joint moves enough to compare torques",
                where=f"arm {arm.name}",
                expected="joints that move to and fro, faster than creeping, for some seconds",
                next_step="record more motion: `gd-analyze plan ROBOT --exciting --duration 20` plans one",
            )
        nothing = FileFit.of_nothing(arm.n_joints)
        names = tuple(motion.name for motion in motions)
        return Diagnosis(arm, names, (), (), (), tuple(faults), nothing, nothing, problem, problem, False)
    # Torques that neither the file nor friction explains tell that something is wrong.
    tells = problem.friction_score > CLEAR_FALL
    ranking = ranked(problem)
    causes = claimed(problem, ranking, pairs=False)
    apart: tuple[tuple[str, Candidate], ...] = ()
    fit = causes[0].fit if causes else problem.null
    if fit is not None and is_unexplained(fit):
        apart = _causes_apart(arm, motions)
        causes = [] if apart else claimed(problem, ranking, pairs=pairs)
    corrected = Problem(problem.samples, causes[-1].correction) if causes else problem
    return Diagnosis(
        arm=arm,
        logs=tuple(motion.name for motion in motions),
        causes=tuple(causes),
        rivals=rivals_of(causes[0], ranking, problem) if len(causes) == 1 else (),
        ranking=tuple(ranking),
        faults=tuple(faults),
        before=problem.null,
        after=corrected.null,
        problem=problem,
        corrected=corrected,
        tells=bool(causes) or tells,
        apart=apart,
    )


def _causes_apart(arm: RobotArm, motions: Sequence[Trajectory]) -> tuple[tuple[str, Candidate], ...]:
    """Logs, of a few, that a cause explains which most do not have, with this cause."""
    if not 1 < len(motions) <= _MOST_DIAGNOSED_ALONE:
        return ()
    alone: dict[str, Candidate | None] = {}
    for motion in motions:
        try:
            diagnosis = diagnosed(arm, [motion], pairs=False)
        except UsageError:  # it does not move
            continue
        if not is_unexplained(diagnosis.after):
            alone[motion.name] = diagnosis.cause
    names = [None if cause is None else cause.name for cause in alone.values()]
    return tuple(
        (log, cause)
        for log, cause in alone.items()
        if cause is not None and 2 * names.count(cause.name) <= len(motions)
    )
