"""Errors of a model on motions or at other states, and a verdict: on what it states, or on a budget."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import box_of
from gd_analyze.dynamics.measured_torque import TorqueComparison, compared
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.errors import UsageError
from gd_analyze.motions.limits import require_trajectory_joints
from gd_analyze.motions.pool import GivenMotions, motions_of
from gd_analyze.motions.states import States
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of
from gd_analyze.simplification.accuracy import Accuracy, ErrorTable, share_of
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


class BesideMeasured(NamedTuple):
    """Measured torques compared with both models, with friction fitted separately for each."""

    exact: TorqueComparison
    simplified: TorqueComparison


@dataclass(frozen=True, eq=False)
class EvaluatedMotion(ModelTorque):
    """A model's torque along one motion, or at other states; torques are N m (N of prismatic joints)."""

    trajectory: Trajectory | None  # None for other states
    accuracy: Accuracy  # the model's promise, for this motion if it was fitted on several
    most: FloatArray | None  # error above which a joint fails, (n,); None without a verdict
    judged: NDArray[np.bool_]  # states with a verdict, (N,)
    exits: tuple[BoxExit, ...]  # where the motion leaves the box
    outside: Array  # whether each state lies outside, (N,)
    measured: BesideMeasured | None  # None where no torques were recorded

    def __repr__(self) -> str:
        failed = int(self.fails.sum())
        return f"EvaluatedMotion({self.name!r}, {f'{failed} joints fail' if failed else 'no joint fails'})"

    @property
    def name(self) -> str:
        """Name of the motion, or the states in words."""
        return self.dynamics.states.in_words if self.trajectory is None else self.trajectory.name

    @cached_property
    def counted(self) -> FloatArray:
        """Largest error at the states judged, shape (n,)."""
        if self.judged.all() or not self.judged.any():
            return self.errors.largest
        return ErrorTable.of(self.dynamics.torque[self.judged], self.torque[self.judged]).largest

    @property
    def fails(self) -> NDArray[np.bool_]:
        """Whether each joint's error is above its limit; False without a verdict."""
        return np.zeros(len(self.counted), dtype=bool) if self.most is None else self.counted > self.most

    @property
    def passed(self) -> bool | None:
        """Whether no joint fails; None without a verdict."""
        return None if self.most is None else not self.fails.any()

    @property
    def keeps_promise(self) -> NDArray[np.bool_]:
        """Whether each joint keeps the model's promise, shape (n,)."""
        return np.asarray(self.within(self.accuracy.allowed))

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
        Whether states without a verdict fail.
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

    @property
    def failures(self) -> tuple[tuple[EvaluatedMotion, int], ...]:
        """Motion and joint (from 0) of every error above its limit."""
        rows = ((motion, np.flatnonzero(motion.fails)) for motion in self.motions)
        return tuple((motion, int(joint)) for motion, joints in rows for joint in joints)

    @property
    def not_judged(self) -> tuple[EvaluatedMotion, ...]:
        """Motions with set points that have no verdict, although one was asked for."""
        if self.fail_over is None:
            return ()
        return tuple(motion for motion in self.motions if not motion.judged.all())

    @property
    def passed(self) -> bool:
        """Whether no joint fails on any motion; if `strict`, also whether every set point has a verdict."""
        return not self.failures and not (self.strict and self.not_judged)

    @property
    def verdict(self) -> str:
        """The verdict in words; "" without one."""
        if self.fail_over is None:
            return ""
        options = f"(--fail-over {self.fail_over}{', --strict' if self.strict else ''})"
        judged = [motion for motion in self.motions if motion.most is not None]
        if not judged:
            reason = f"the model states nothing for {'these states' if len(self.motions) == 1 else 'them'}"
            return f"{'Failed' if self.strict else 'Not judged'}: {reason} {options}."
        failed, total = sum(not motion.passed for motion in judged), len(self.motions)
        if total == 1:
            text = "Failed" if failed else "Passed"
            if self.not_judged:
                count = int(judged[0].judged.sum())
                text += f" at {count} of {len(judged[0].judged)} states, the others not judged"
        else:
            counts = {"failed": failed, "passed": len(judged) - failed, "not judged": total - len(judged)}
            partly = len(self.not_judged) - counts["not judged"]
            words = [
                f"{name} on {count}" if name != "not judged" else f"{count} {name}"
                for name, count in counts.items()
                if count
            ]
            words[0] += f" of {total} motions"
            text = ", ".join(words)
            if partly:
                text += f", {partly} judged in part"
            text = text[0].upper() + text[1:]
        if not self.passed and not failed:
            text = f"Failed: {text[0].lower()}{text[1:]}"
        return f"{text} {options}."

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
        verdict = "" if self.fail_over is None else f", {'passed' if self.passed else 'failed'}"
        if self.not_judged and self.passed:
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
                as_promised = "yes" if motion.keeps_promise[i] else "no"
                passes = "–"
                if motion.most is not None:
                    passes = "no" if motion.fails[i] else "yes"
                names = motion.name, joint_name(i + 1, joint.name)
                rows.append([*names, peak, largest, share, rms, as_promised, passes])
        headings = ["motion", "joint", "peak torque", "largest error", "of peak torque", "RMS error"]
        return html_of(repr(self), [*headings, "as promised", "passes"], rows)


@one_thread()
def evaluate(
    model: SimplifiedModel,
    states: States | GivenMotions | xr.Dataset,
    arm: RobotArm | None = None,
    *,
    fail_over: Budget | str | None = "stated",
    strict: bool = False,
    box: Box | None = None,
    progress: Callable[[int], None] | None = None,
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
        same motion, or over all motions if it needs none there. "promise": the model's own budget. "stated":
        the bound of its certificate at states within, or the allowed error at those it was fitted on; others
        are not judged. None: no verdict.
    strict
        Fail where states are not judged.
    box
        Box outside which states are reported; by default the arm's limits, for which `certify` and
        `simplify` bound a model.
    progress
        Called with 1 after every motion.

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
    arm = model.arm if arm is None else arm_of(arm)
    require_arm(model, arm)
    limit, box = _limit_of(fail_over), box_of(box, arm)
    if strict and limit is None:
        raise UsageError("--strict needs a verdict", where="--strict", next_step="give --fail-over")
    trajectories: list[Trajectory | None] = [None]
    if isinstance(states, Trajectory | str | Path | Sequence):
        trajectories = [*motions_of(states, arm)]
    for trajectory in trajectories:
        if trajectory is not None:
            require_trajectory_joints(trajectory, arm)
    computed_torques = [
        (trajectory, model_torque(model, states if trajectory is None else trajectory, arm))
        for trajectory in trajectories
    ]
    peaks = np.max([computed.errors.peak_torque for _, computed in computed_torques], axis=0)
    motions = []
    for trajectory, computed in computed_torques:
        motions.append(_evaluated(model, trajectory, computed, limit, box, peaks))
        if progress is not None:
            progress(1)
    return Evaluation(model, box, limit, strict, tuple(motions))


def _evaluated(
    model: SimplifiedModel,
    motion: Trajectory | None,
    computed: ModelTorque,
    limit: Budget | _Stated | None,
    box: Box,
    peaks: FloatArray,
) -> EvaluatedMotion:
    """The verdict on one motion; the largest torques over all are shape (n,)."""
    exact, states = computed.dynamics, computed.dynamics.states
    arm, measured = exact.arm, None
    accuracy = model.accuracy.along(str(states.described.get("trajectory_fingerprint", "")))
    largest_allowed, judged = None, np.full(len(states), limit is not None)
    if limit == "promise":
        largest_allowed = accuracy.allowed
    elif limit == "stated":
        largest_allowed, judged = _as_stated(model, accuracy, states)
    elif limit is not None:
        # A share of torque is undefined for a joint that needs none along this motion.
        needs_torque = computed.errors.peak_torque > 0.0
        over_all = ReferenceTorques(arm, peaks, exact.uncertainty)
        largest_allowed = np.where(needs_torque, exact.allowed(limit), allowed_by(limit, over_all))
    if motion is not None:
        warn_of_torque_limits(arm, states, exact.torque)
        if motion.recording is not None and motion.recording.torque is not None:
            torques = exact.torque, computed.torque
            measured = BesideMeasured(*(compared(arm, motion, torque) for torque in torques))
    return EvaluatedMotion(
        exact,
        computed.torque,
        computed.errors,
        computed.norms,
        motion,
        accuracy,
        largest_allowed,
        judged,
        () if motion is None else box_exits(arm, motion, box),
        outside_of(arm, box, states),
        measured,
    )


def _as_stated(
    model: SimplifiedModel, accuracy: Accuracy, states: States
) -> tuple[FloatArray | None, NDArray[np.bool_]]:
    """Error that the model states at these states, (n,) or None, and whether it is for each, (N,)."""
    certificate, motion = model.accuracy.certificate, states.described.get("trajectory_fingerprint")
    all_states = np.ones(len(states), dtype=bool)
    if certificate is not None and not certificate.trajectory_fingerprint:
        limits = certificate.lower, certificate.upper, certificate.velocity, certificate.acceleration
        inside = ~outside_of(model.arm, Box(*limits), states)
        if inside.any():
            return certificate.certified, inside
    elif certificate is not None and certificate.trajectory_fingerprint == motion:
        return certificate.certified, all_states
    fitted_on = accuracy.fitted_on
    is_fitted = (
        fitted_on.get("trajectory_fingerprint") == motion
        if motion
        else bool(fitted_on) and dict(fitted_on) == dict(states.described)
    )
    return (accuracy.allowed, all_states) if is_fitted else (None, ~all_states)


def _limit_of(fail_over: Budget | str | None) -> Budget | _Stated | None:
    """The limit asked for."""
    word = fail_over.strip().lower() if isinstance(fail_over, str) else ""
    if fail_over is None or word == "none":
        return None
    if word == "stated":
        return "stated"
    if word == "promise":
        return "promise"
    return Budget.parse(fail_over, "--fail-over") if isinstance(fail_over, str) else Budget.of(fail_over)
