"""Errors of a model on motions or at other states, and the one verdict: on what it states, or on a budget.

`EvaluatedMotion.verdicts` decides joint by joint; everything that is printed or written reads it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import box_of
from gd_analyze.certification.held import stated_region
from gd_analyze.certification.tube import Tube
from gd_analyze.diagnosis.log_verdict import LogVerdict, log_verdict
from gd_analyze.dynamics.measured_torque import TorqueComparison, compared
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.errors import UsageError
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.measured import has_torques
from gd_analyze.motions.pool import GivenMotions, motions_of
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.states import States, in_words
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.progress import NO_PROGRESS, Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.simplification.accuracy import STATED, Accuracy, ErrorTable, share_of
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.exact_dynamics import allowed_by
from gd_analyze.simplification.model import SimplifiedModel, require_model
from gd_analyze.simplification.model_torque import ModelTorque, model_torque, require_arm
from gd_analyze.studies.box_exits import BoxExit, box_exits, outside_of
from gd_analyze.text import amount, html_of, joint_name, percent
from gd_analyze.threads import one_thread

if TYPE_CHECKING:
    import xarray as xr

_Stated: TypeAlias = Literal["promise", "stated"]
Outcome: TypeAlias = Literal["passed", "failed", "not judged"]


def is_passed(verdict: Outcome) -> bool | None:
    """The verdict as True, False, or None if there is none."""
    return None if verdict == "not judged" else verdict == "passed"


class _Limit(NamedTuple):
    """Error above which joints fail, and the states that it is for."""

    most: FloatArray | None  # (n,); None without one
    judged: NDArray[np.bool_]  # (N,)
    unchecked: bool = False  # whether a file states it, which nobody has proven or measured again


class BesideMeasured(NamedTuple):
    """Measured torques compared with both models, with friction fitted separately for each."""

    exact: TorqueComparison
    simplified: TorqueComparison


@dataclass(frozen=True, eq=False)
class EvaluatedMotion(ModelTorque):
    """A model's torque along one motion, or at other states; torques are N m (N of prismatic joints)."""

    trajectory: Trajectory | None  # None for other states
    accuracy: Accuracy  # the model's promise, for this motion if it was fitted on several
    limit: _Limit
    strict: bool  # whether states that are not judged fail
    exits: tuple[BoxExit, ...]  # where the motion leaves the box
    outside: Array  # whether each state lies outside, (N,)
    measured: BesideMeasured | None  # None where no torques were recorded

    def __repr__(self) -> str:
        return f"EvaluatedMotion({self.name!r}, {self.verdict})"

    @property
    def name(self) -> str:
        """Name of the motion, or the states in words."""
        return self.dynamics.states.in_words if self.trajectory is None else self.trajectory.name

    @property
    def most(self) -> FloatArray | None:
        """Error above which a joint fails, (n,); None if nothing is judged."""
        return self.limit.most

    @property
    def judged(self) -> NDArray[np.bool_]:
        """Whether each state is judged, (N,)."""
        return self.limit.judged

    @cached_property
    def counted(self) -> FloatArray:
        """Largest error at the states judged, shape (n,)."""
        if self.judged.all() or not self.judged.any():
            return self.errors.largest
        return ErrorTable.of(self.dynamics.torque[self.judged], self.torque[self.judged]).largest

    @property
    def fails(self) -> NDArray[np.bool_]:
        """Whether each joint's error is above its limit, (n,); False if nothing is judged."""
        return np.zeros(len(self.counted), dtype=bool) if self.most is None else self.counted > self.most

    @property
    def verdicts(self) -> tuple[Outcome, ...]:
        """Outcome on each joint."""
        if self.strict and not self.judged.all():
            return tuple(["failed"] * len(self.counted))
        words: list[Outcome] = ["failed" if fails else "passed" for fails in self.fails.tolist()]
        return tuple(words if self.most is not None else ["not judged"] * len(words))

    @property
    def verdict(self) -> Outcome:
        """Outcome on the motion: failed if a joint is."""
        return "failed" if "failed" in self.verdicts else self.verdicts[0]

    @property
    def passed(self) -> bool | None:
        """The verdict as True, False, or None if there is none."""
        return is_passed(self.verdict)

    @cached_property
    def at(self) -> FloatArray:
        """Instant of each joint's largest error, s, shape (n,); nan if there is none, or no time."""
        if self.trajectory is None:
            return np.full(len(self.errors.largest), np.nan)
        instants = self.trajectory.time[np.abs(self.torque - self.dynamics.torque).argmax(axis=0)]
        return np.where(self.errors.largest > 0.0, instants, np.nan)

    def error_text(self, joint: int) -> str:
        """State the largest error of one joint (from 0), its instant, and its limit."""
        unit = self.dynamics.arm.joints[joint].effort_unit
        largest, limit = float(self.errors.largest[joint]), self.most
        if largest == 0.0:
            return "no torque error beyond round-off"
        at = "" if np.isnan(self.at[joint]) else f" at {self.at[joint]:.6g} s"
        text = f"largest torque error {amount(largest, unit)}{at}, "
        text += f"{percent(float(self.errors.largest_share[joint]))} of its peak"
        if limit is None:
            return text
        if not self.judged.all():
            judged = f"{self.judged.sum()} of {len(self.judged)} states judged"
            text += f"; {amount(float(self.counted[joint]), unit)} at the {judged}"
        times = float(share_of(self.counted, limit)[joint])
        return f"{text}, {times:.4g} times its limit {amount(float(limit[joint]), unit)}"


@dataclass(frozen=True, eq=False)
class Evaluation:
    """Errors of a model on motions or at other states, and the verdict on each.

    Parameters
    ----------
    model, box
        The model, and the box outside which states are reported.
    fail_over
        Error above which a joint fails: a budget, "promise", "stated", or None without a verdict.
    strict
        Whether states that are not judged fail.
    motions
        The model's torque and errors along each motion; other states count as one.
    """

    model: SimplifiedModel
    box: Box
    fail_over: Budget | _Stated | None
    strict: bool
    motions: tuple[EvaluatedMotion, ...]

    @cached_property
    def errors(self) -> ErrorTable:
        """Errors over all motions, N m (N), shape (n,)."""
        tables = [motion.errors for motion in self.motions]
        counts = [len(motion.judged) for motion in self.motions]
        squares = np.average([table.rms**2 for table in tables], axis=0, weights=counts)
        peak, largest = (
            np.max([getattr(table, name) for table in tables], axis=0) for name in ("peak_torque", "largest")
        )
        return ErrorTable(peak, largest, np.sqrt(squares))

    @cached_property
    def log_verdict(self) -> LogVerdict | None:
        """Whether the logs agree with the arm's file; None if no torques were recorded."""
        logs = [motion.trajectory for motion in self.motions if motion.trajectory is not None]
        logs = [log for log in logs if has_torques(log)]
        return log_verdict(self.motions[0].dynamics.arm, logs) if logs else None

    @property
    def failures(self) -> tuple[tuple[EvaluatedMotion, int], ...]:
        """Motion and joint (from 0) of every error above its limit."""
        rows = ((motion, np.flatnonzero(motion.fails)) for motion in self.motions)
        return tuple((motion, int(joint)) for motion, joints in rows for joint in joints)

    @property
    def not_judged(self) -> tuple[EvaluatedMotion, ...]:
        """Motions with states that are not judged, although a verdict was asked for."""
        if self.fail_over is None:
            return ()
        return tuple(motion for motion in self.motions if not motion.judged.all())

    @property
    def verdict(self) -> Outcome:
        """The verdict: failed if a motion is, not judged if none is."""
        verdicts = {motion.verdict for motion in self.motions}
        return "failed" if "failed" in verdicts else "passed" if "passed" in verdicts else "not judged"

    @property
    def passed(self) -> bool | None:
        """The verdict as True, False, or None if there is none."""
        return is_passed(self.verdict)

    @property
    def unchecked(self) -> bool:
        """Whether a limit is one that a file states and nobody has proven or measured again."""
        return any(motion.limit.unchecked for motion in self.motions)

    @property
    def stated_for(self) -> str:
        """States for which the model states its error, in words."""
        certificate, fitted_on = self.model.accuracy.certificate, self.model.accuracy.fitted_on
        if certificate is not None:
            return certificate.where
        return in_words(fitted_on) if fitted_on else "states not named"

    @property
    def in_words(self) -> str:
        """The verdict in a sentence; "" if none was asked for."""
        if self.fail_over is None:
            return ""
        options = f"(--fail-over {self.fail_over}{', --strict' if self.strict else ''})"
        verdicts, total = [motion.verdict for motion in self.motions], len(self.motions)
        text = self.verdict.capitalize()
        if total > 1 and any(motion.judged.any() for motion in self.motions):
            words = [
                f"{verdict} on {count}" if verdict != "not judged" else f"{count} not judged"
                for verdict in ("failed", "passed", "not judged")
                if (count := verdicts.count(verdict))
            ]
            words[0] += f" of {total} motions"
            text = ", ".join(words)
        if self.not_judged and total == 1 and (count := int(self.motions[0].judged.sum())):
            text += f" at {count} of {len(self.motions[0].judged)} states, the others not judged"
        elif self.not_judged and not any(motion.judged.any() for motion in self.motions):
            text += f": the model states its error for {self.stated_for} alone"
        elif partly := sum(0 < motion.judged.sum() < len(motion.judged) for motion in self.motions):
            text += f", {partly} judged in part"
        by = f", by limits {STATED}" if self.unchecked else ""
        return f"{text[0].upper()}{text[1:]}{by} {options}."

    @property
    def worst(self) -> tuple[EvaluatedMotion, int]:
        """Motion and joint (from 0) of the largest error relative to its limit.

        If no motion is judged, relative to the joint's peak torque along the motion.
        """
        judged = [motion for motion in self.motions if motion.most is not None]

        def shares(motion: EvaluatedMotion) -> FloatArray:
            if motion.most is None:
                return motion.errors.largest_share
            return share_of(motion.counted, motion.most)

        worst = max(judged or self.motions, key=lambda motion: float(shares(motion).max()))
        return worst, int(shares(worst).argmax())

    def __repr__(self) -> str:
        verdict = "" if self.fail_over is None else f", {self.verdict}"
        if self.not_judged and self.verdict == "passed":
            verdict += f", {len(self.not_judged)} not judged"
        count, worst = len(self.motions), self.errors.worst
        error = f"error up to {percent(float(self.errors.largest_share.max()))} of peak torque"
        name = self.motions[0].name if count == 1 else f"{count} motions"
        return f"Evaluation({self.model.arm.name!r}, {name}, {error} (joint {worst + 1}){verdict})"

    def _repr_html_(self) -> str:
        """A row per motion and joint, for a notebook."""
        rows = []
        for motion in self.motions:
            errors = motion.errors
            for i, joint in enumerate(self.model.arm.joints):
                torques = (errors.peak_torque, errors.largest, errors.rms)
                peak, largest, rms = (amount(float(values[i]), joint.effort_unit) for values in torques)
                share = percent(float(errors.largest_share[i]))
                names = motion.name, joint_name(i + 1, joint.name)
                rows.append([*names, peak, largest, share, rms, motion.verdicts[i]])
        headings = ["motion", "joint", "peak torque", "largest error", "of peak torque", "RMS error"]
        return html_of(repr(self), [*headings, "verdict"], rows)


@strict
@one_thread()
def evaluate(
    model: SimplifiedModel,
    states: States | GivenMotions | xr.Dataset,
    arm: RobotArm | None = None,
    *,
    fail_over: Budget | str | float | None = "stated",
    strict: bool = False,
    box: Box | None = None,
    progress: Progress = NO_PROGRESS,
) -> Evaluation:
    """Compare a model with exact dynamics along motions or at other states, and with measured torques.

    Parameters
    ----------
    model
        The simplified model.
    states
        Motions of its arm, each with its own verdict: trajectories, shipped names, paths of files or folders;
        or a decomposition; or any states, such as those of `states_in_box`. Torques recorded in a motion are
        compared with exact and simplified ones.
    arm
        Another arm whose exact torque is the reference, such as the model's arm with a payload, or a newer
        version of it. Its drives are included if they are part of the model.
    fail_over
        Error above which a joint fails. A budget per joint: its shares are of the joint's torque along the
        same motion, or over all motions if it needs none there. "promise": the model's own budget, or at
        level "element" its error, wherever it was fitted. "stated": the same at the states it was fitted on,
        and the bound of its certificate within its region, which is near a motion that is given or shipped,
        or within limits; other states are not judged. None: no verdict.
    strict
        Fail where states are not judged.
    box
        Box outside which states are reported; by default the arm's limits, for which `certify` and
        `simplify` bound a model.
    progress
        Told the motions done.

    Returns
    -------
    Evaluation
        Errors over all motions; by motion the torque, errors, verdicts, states outside the box and
        comparisons with measured torques.

    Raises
    ------
    TrajectoryError
        If there are no motions or states, or they have another number of joints.
    ModelError
        If a decomposition is of another arm or differs in drives, or the arm is of another make.
    ArmError
        If the model includes drives and the arm describes none.
    UsageError
        If `fail_over` is not a budget per joint, or needs a number that the arm does not state; if `strict`
        has no verdict to be strict about; or if the box has another number of joints.

    Warns
    -----
    GdAnalyzeWarning
        If limits of the box are assumed as the arm states none, or a motion exceeds the drives' torque.
    """
    require_model(model)
    arm = model.arm if arm is None else arm_with_masses(arm)
    require_arm(model, arm)
    limit, box = _limit_of(fail_over), box_of(box, arm)
    if strict and limit is None:
        raise UsageError(
            "there is no verdict to be strict about", where="strict", next_step="give `fail_over`"
        )
    trajectories: list[Trajectory | None] = [None]
    if isinstance(states, Trajectory | str | Path | Sequence):
        trajectories = [*motions_of(states, arm, partial(read_trajectory, progress=progress))]
    for trajectory in trajectories:
        if trajectory is not None:
            require_trajectory_joints(trajectory, arm)
    progress.stage("evaluating", len(trajectories))
    computed_torques = [
        (trajectory, model_torque(model, states if trajectory is None else trajectory, arm))
        for trajectory in trajectories
    ]
    peaks = np.max([computed.errors.peak_torque for _, computed in computed_torques], axis=0)
    region = stated_region(model, [motion for motion in trajectories if motion is not None])
    motions = []
    for trajectory, computed in computed_torques:
        motions.append(_evaluated(model, trajectory, computed, limit, strict, region, box, peaks))
        progress.advance()
    return Evaluation(model, box, limit, strict, tuple(motions))


def _evaluated(
    model: SimplifiedModel,
    motion: Trajectory | None,
    computed: ModelTorque,
    fail_over: Budget | _Stated | None,
    strict: bool,
    region: Box | Tube | None,
    box: Box,
    peaks: FloatArray,
) -> EvaluatedMotion:
    """The verdict on one motion; the largest torques over all are shape (n,)."""
    exact, states = computed.dynamics, computed.dynamics.states
    if model.accuracy.log is not None:
        exact = replace(exact, left_of_log=model.accuracy.log.left)
    arm, measured = exact.arm, None
    accuracy = model.accuracy.along(str(states.described.get("trajectory_fingerprint", "")))
    everywhere = np.ones(len(states), dtype=bool)
    if fail_over is None:
        limit = _Limit(None, ~everywhere)
    elif fail_over == "promise":
        limit = _Limit(model.promised(accuracy), everywhere, not accuracy.measured)
    elif fail_over == "stated":
        limit = _as_stated(model, accuracy, region, states)
    else:
        # A share of torque is undefined for a joint that needs none along this motion.
        needs_torque = computed.errors.peak_torque > 0.0
        over_all = ReferenceTorques(arm, peaks, exact.uncertainty, exact.left_of_log)
        allowed = np.where(needs_torque, exact.allowed(fail_over), allowed_by(fail_over, over_all))
        limit = _Limit(allowed, everywhere)
    if motion is not None:
        warn_of_torque_limits(arm, states, exact.torque)
        if has_torques(motion):
            torques = exact.torque, computed.torque
            measured = BesideMeasured(*(compared(arm, motion, torque) for torque in torques))
    return EvaluatedMotion(
        exact,
        computed.torque,
        computed.errors,
        computed.norms,
        motion,
        accuracy,
        limit,
        strict,
        () if motion is None else box_exits(arm, motion, box),
        outside_of(arm, box, states),
        measured,
    )


def _as_stated(
    model: SimplifiedModel, accuracy: Accuracy, region: Box | Tube | None, states: States
) -> _Limit:
    """What the model states at these states: its budget where it was fitted, its bound in its region."""
    certificate, motion = model.accuracy.certificate, states.described.get("trajectory_fingerprint")
    everywhere = np.ones(len(states), dtype=bool)
    fitted_on = accuracy.fitted_on
    is_fitted = (
        fitted_on.get("trajectory_fingerprint") == motion
        if motion
        else bool(fitted_on) and dict(fitted_on) == dict(states.described)
    )
    inside = ~everywhere
    if isinstance(region, Tube):
        inside = everywhere if region.fingerprint == motion else region.contains(*states.arrays)
    elif region is not None:
        inside = ~outside_of(model.arm, region, states)
    if is_fitted:
        most, unchecked = model.promised(accuracy), not accuracy.measured
        if certificate is not None and inside.all():  # both statements hold
            most = np.minimum(most, certificate.certified)
            unchecked |= not certificate.proven_here
        return _Limit(most, everywhere, unchecked)
    if certificate is not None and inside.any():
        return _Limit(certificate.certified, inside, not certificate.proven_here)
    return _Limit(None, ~everywhere)


def _limit_of(fail_over: Budget | str | float | None) -> Budget | _Stated | None:
    """The limit asked for."""
    word = fail_over.strip().lower() if isinstance(fail_over, str) else ""
    if fail_over is None or word == "none":
        return None
    if word == "stated":
        return "stated"
    if word == "promise":
        return "promise"
    return Budget.of(fail_over, "fail_over")
