"""A verdict on a model over motions: errors, measured torques, and states outside a certificate's box."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import box_of
from gd_analyze.dynamics.measured_torque import TorqueComparison, compared
from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
from gd_analyze.motions.limits import ROUNDING, Quantity, Violation, require_joints
from gd_analyze.motions.pool import GivenMotions, motions_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import Accuracy, ErrorTable, share_of
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.evaluation import Evaluation, evaluate
from gd_analyze.simplification.exact import allowed_by
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import amount, html_of, joint_name, percent

_Stated: TypeAlias = Literal["promise", "stated"]


@dataclass(frozen=True)
class BoxExit:
    """A limit of a box exceeded by set points of one joint; SI and radians."""

    farthest: Violation  # at the set point farthest beyond it
    set_points: int  # number beyond it
    first: float  # instant of the first one, s
    begin: float  # start of the longest uninterrupted stretch beyond it, s
    end: float  # end of that stretch, s


def box_exits(arm: RobotArm, trajectory: Trajectory, box: Box) -> tuple[tuple[BoxExit, ...], Array]:
    """Find where a motion leaves a box, by joint and limit, and which set points lie outside, (N,).

    A value beyond a limit by less than a rounded digit is no exit, as for the limits of the arm.
    """
    found, time, outside = [], trajectory.time, np.zeros(trajectory.n_set_points, dtype=bool)
    for i, joint in enumerate(arm.joints):
        q, qd, qdd = trajectory.q[:, i], trajectory.qd[:, i], trajectory.qdd[:, i]
        # Values, limit, sign of the outside, and the power of time in the joint's unit.
        sides: tuple[tuple[Quantity, FloatArray, float, int, str], ...] = (
            ("position", q, float(box.lower[i]), -1, ""),
            ("position", q, float(box.upper[i]), 1, ""),
            ("velocity", np.abs(qd), float(box.velocity[i]), 1, "/s"),
            ("acceleration", np.abs(qdd), float(box.acceleration[i]), 1, "/s^2"),
        )
        for quantity, values, limit, side, per in sides:
            excess = side * (values - limit)
            beyond = excess > ROUNDING * max(1.0, abs(limit))
            if not beyond.any():
                continue
            outside |= beyond
            most, unit = int(excess.argmax()), joint.unit + per
            value, instant = float(values[most]), float(time[most])
            farthest = Violation(i + 1, joint.name, quantity, value, limit, instant, unit)
            runs: list[tuple[float, float]] = []
            for stretch in trajectory.stretches:
                edges = np.flatnonzero(np.diff(beyond[stretch], prepend=False, append=False)) + stretch.start
                runs += [(float(time[a]), float(time[b - 1])) for a, b in edges.reshape(-1, 2)]
            longest = max(runs, key=lambda run: run[1] - run[0])
            found.append(BoxExit(farthest, int(beyond.sum()), runs[0][0], *longest))
    return tuple(found), outside


class BesideMeasured(NamedTuple):
    """Measured torques compared with both models, with friction fitted separately for each."""

    exact: TorqueComparison
    simplified: TorqueComparison


@dataclass(frozen=True, eq=False)
class ValidatedMotion:
    """A model along one motion; torques are N m (N of prismatic joints)."""

    trajectory: Trajectory
    evaluation: Evaluation  # torque and error along it
    accuracy: Accuracy  # the model's promise, for this motion if it was fitted on several
    most: FloatArray | None  # error above which a joint fails, (n,); None without a verdict
    counted: FloatArray  # largest error at the set points judged, (n,)
    exits: tuple[BoxExit, ...]  # where the motion leaves the box
    outside: Array  # whether each set point lies outside, (N,)
    measured: BesideMeasured | None  # None where no torques were recorded

    def __repr__(self) -> str:
        failed = int(self.fails.sum())
        return f"ValidatedMotion({self.name!r}, {f'{failed} joints fail' if failed else 'no joint fails'})"

    @property
    def name(self) -> str:
        """Name of the motion."""
        return self.trajectory.name

    @property
    def fails(self) -> NDArray[np.bool_]:
        """Whether each joint's error is above its limit; False without a verdict."""
        return np.zeros(len(self.counted), dtype=bool) if self.most is None else self.counted > self.most

    @property
    def keeps_promise(self) -> NDArray[np.bool_]:
        """Whether each joint keeps the model's promise, shape (n,)."""
        return np.asarray(self.evaluation.within(self.accuracy.allowed))

    @cached_property
    def at(self) -> FloatArray:
        """Instant of each joint's largest error, s, shape (n,); nan if no error exceeds round-off."""
        error = np.abs(self.evaluation.torque - self.evaluation.dynamics.torque)
        instants = self.trajectory.time[error.argmax(axis=0)]
        return np.where(self.evaluation.errors.largest > 0.0, instants, np.nan)

    def error_text(self, joint: int) -> str:
        """State the largest error of one joint (from 0), its instant, and its limit."""
        errors, unit = self.evaluation.errors, self.evaluation.dynamics.arm.joints[joint].effort_unit
        largest, most = float(errors.largest[joint]), self.most
        if largest == 0.0:
            return "no torque error beyond round-off"
        share = percent(float(errors.largest_share[joint]))
        text = f"largest torque error {amount(largest, unit)} at {self.at[joint]:.6g} s, {share} of its peak"
        if most is not None:
            text += f", {largest / most[joint]:.4g} times its limit {amount(float(most[joint]), unit)}"
        return text


@dataclass(frozen=True, eq=False)
class Validation:
    """Verdict on a model along every motion it was validated on.

    Parameters
    ----------
    model, box
        The model, and the box of states for which it is bounded.
    fail_over
        Error above which a joint fails: a budget, "promise", "stated", or None without a verdict.
    motions
        The model's errors along each motion.
    """

    model: SimplifiedModel
    box: Box
    fail_over: Budget | _Stated | None
    motions: tuple[ValidatedMotion, ...]

    @property
    def failures(self) -> tuple[tuple[ValidatedMotion, int], ...]:
        """Motion and joint (from 0) of every error above its limit."""
        return tuple((one, int(joint)) for one in self.motions for joint in np.flatnonzero(one.fails))

    @property
    def passed(self) -> bool:
        """Whether no joint fails on any motion."""
        return not self.failures

    @property
    def worst(self) -> tuple[ValidatedMotion, int]:
        """Motion and joint (from 0) of the largest error relative to its limit.

        Without a verdict, relative to the joint's peak torque along the motion.
        """

        def size(one: ValidatedMotion) -> FloatArray:
            errors = one.evaluation.errors
            return errors.largest_share if one.most is None else share_of(one.counted, one.most)

        worst = max(self.motions, key=lambda one: float(size(one).max()))
        return worst, int(size(worst).argmax())

    def __repr__(self) -> str:
        verdict = "" if self.fail_over is None else f", {'passed' if self.passed else 'failed'}"
        count = len(self.motions)
        return f"Validation({self.model.arm.name!r}, {count} motion{'s' if count > 1 else ''}{verdict})"

    def _repr_html_(self) -> str:
        """A row per motion and joint, for a notebook."""
        rows = []
        for one in self.motions:
            errors = one.evaluation.errors
            for i, joint in enumerate(self.model.arm.joints):
                largest = amount(float(errors.largest[i]), joint.effort_unit)
                share, kept = percent(float(errors.largest_share[i])), "yes" if one.keeps_promise[i] else "no"
                passes = "–" if one.most is None else "no" if one.fails[i] else "yes"
                rows.append([one.name, joint_name(i + 1, joint.name), largest, share, kept, passes])
        headings = ["motion", "joint", "largest error", "of peak torque", "as promised", "passes"]
        return html_of(repr(self), headings, rows)


def validate(
    model: SimplifiedModel,
    motions: GivenMotions,
    *,
    fail_over: Budget | str | None = "stated",
    box: Box | None = None,
    arm: RobotArm | None = None,
    progress: Callable[[int], None] | None = None,
) -> Validation:
    """Compare a model with the exact dynamics of its arm along motions, and with measured torques.

    Each motion gets its own verdict; `gd_analyze.evaluate` gives torques and errors at any states.

    Parameters
    ----------
    model
        The simplified model.
    motions
        Motions of its arm: trajectories, shipped names, paths of files or folders. Torques recorded in a
        motion are compared with exact and simplified ones.
    fail_over
        Error above which a joint fails. A budget per joint: its shares are of the joint's torque along the
        same motion, or over all motions if it needs none there. "promise": the model's own budget. "stated":
        the bound of its certificate at set points within, or the allowed error along a motion it was fitted
        on; no verdict elsewhere. None: no verdict.
    box
        Box outside which set points are reported; by default the arm's limits, for which `certify` and
        `simplify_certified` bound a model.
    arm
        Another arm whose exact torque is the reference, such as a newer version of the same arm.
    progress
        Called with 1 after every motion.

    Returns
    -------
    Validation
        Errors, verdicts, states outside the box and comparisons with measured torques, by motion.

    Raises
    ------
    TrajectoryError
        If there are no motions, or one has another number of joints.
    UsageError
        If `fail_over` is not a budget per joint, or needs a number that the arm does not state; or if the box
        has another number of joints.

    Warns
    -----
    GdAnalyzeWarning
        If limits of the box are assumed as the arm states none, or a motion exceeds the drives' torque.
    """
    arm = model.arm if arm is None else arm
    asked, box, given = _asked(model, fail_over), box_of(box, arm), motions_of(motions, arm)
    for one in given:
        require_joints(one, arm)
    tried = [(one, evaluate(model, one, arm)) for one in given]
    peaks, found = np.max([evaluation.errors.peak_torque for _, evaluation in tried], axis=0), []
    for one, evaluation in tried:
        warn_of_torque_limits(arm, evaluation.dynamics.states, evaluation.dynamics.torque)
        accuracy, measured = model.accuracy.along(one.fingerprint), None
        most = accuracy.allowed if asked == "promise" else None
        counted = evaluation.errors.largest
        if asked == "stated":
            most, counted = _as_stated(model, accuracy, one, evaluation)
        if isinstance(asked, Budget):
            # A share of torque is undefined for a joint that needs none along this motion.
            exact, needs = evaluation.dynamics, evaluation.errors.peak_torque > 0.0
            over_all = ReferenceTorques(arm, peaks, exact.uncertainty)
            most = np.where(needs, exact.allowed(asked), allowed_by(asked, over_all))
        if one.recording is not None and one.recording.torque is not None:
            torques = evaluation.dynamics.torque, evaluation.torque
            measured = BesideMeasured(*(compared(arm, one, torque) for torque in torques))
        exits = box_exits(arm, one, box)
        found.append(ValidatedMotion(one, evaluation, accuracy, most, counted, *exits, measured))
        if progress is not None:
            progress(1)
    return Validation(model, box, asked, tuple(found))


def _as_stated(
    model: SimplifiedModel, accuracy: Accuracy, motion: Trajectory, evaluation: Evaluation
) -> tuple[FloatArray | None, FloatArray]:
    """What the model states for a motion's set points, (n,) or None, and the largest error there."""
    stated, largest = model.accuracy.certificate, evaluation.errors.largest
    if stated is not None and not stated.trajectory_fingerprint:
        box = Box(stated.lower, stated.upper, stated.velocity, stated.acceleration)
        inside = ~box_exits(model.arm, motion, box)[1]
        if inside.any():
            torques = evaluation.dynamics.torque[inside], evaluation.torque[inside]
            return stated.certified, ErrorTable.of(*torques).largest
    elif stated is not None and stated.trajectory_fingerprint == motion.fingerprint:
        return stated.certified, largest
    fitted = accuracy.fitted_on.get("trajectory_fingerprint") == motion.fingerprint
    return accuracy.allowed if fitted else None, largest


def _asked(model: SimplifiedModel, fail_over: Budget | str | None) -> Budget | _Stated | None:
    """The limit asked for."""
    if fail_over is None:
        return None
    if isinstance(fail_over, str) and fail_over.strip().lower() == "stated":
        return "stated"
    if isinstance(fail_over, str) and fail_over.strip().lower() == "promise":
        return "promise"
    return Budget.parse(fail_over, "--fail-over") if isinstance(fail_over, str) else Budget.of(fail_over)
