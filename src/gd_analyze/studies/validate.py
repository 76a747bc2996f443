"""A verdict on a model over motions."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.certification.box import Box
from gd_analyze.certification.certificate import box_of
from gd_analyze.errors import UsageError
from gd_analyze.motions.checks import require_joints
from gd_analyze.motions.pool import GivenMotions, motions_of
from gd_analyze.simplification.accuracy import Accuracy, share_of
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.evaluation import Evaluation, evaluate
from gd_analyze.simplification.exact import allowed_by
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.studies.along import ValidatedMotion
from gd_analyze.studies.beside_measured import BesideMeasured
from gd_analyze.studies.box_exits import box_exits
from gd_analyze.text import amount, html_of, joint_name, percent

# In the place of an error that joints may have: what the model promises itself.
PROMISE = "promise"
_OPTION = "--fail-over"


@dataclass(frozen=True, eq=False)
class Validation:
    """A model along every motion it was tried on.

    Parameters
    ----------
    model, box
        The model, and the states that bounds on it are about.
    fail_over
        Error above which a joint fails: a budget, "promise", or None where nobody asked for a verdict.
    motions
        What came of each.
    """

    model: SimplifiedModel
    box: Box
    fail_over: Budget | Literal["promise"] | None
    motions: tuple[ValidatedMotion, ...]

    @property
    def failures(self) -> tuple[tuple[ValidatedMotion, int], ...]:
        """Motion and joint (from 0) of every error above what it may be; none where nobody asked."""
        return tuple((one, int(joint)) for one in self.motions for joint in np.flatnonzero(one.fails))

    @property
    def passed(self) -> bool:
        """Whether no joint fails on any motion."""
        return not self.failures

    @property
    def worst(self) -> tuple[ValidatedMotion, int]:
        """Motion and joint (from 0) of the error nearest to, or farthest beyond, what it may be.

        Where nobody asked, that of the largest share of the joint's peak torque along the motion.
        """

        def size(one: ValidatedMotion) -> FloatArray:
            errors = one.evaluation.errors
            return errors.largest_share if one.most is None else share_of(errors.largest, one.most)

        worst = max(self.motions, key=lambda one: float(size(one).max()))
        return worst, int(size(worst).argmax())

    def __repr__(self) -> str:
        verdict = "" if self.fail_over is None else f", {'passed' if self.passed else 'failed'}"
        count = len(self.motions)
        return f"Validation({self.model.arm.name!r}, {count} motion{'s' if count > 1 else ''}{verdict})"

    def _repr_html_(self) -> str:
        """A row per motion and joint, for a notebook."""
        rows = [
            [
                one.name,
                joint_name(i + 1, joint.name),
                amount(float(one.evaluation.errors.peak_torque[i]), joint.effort_unit),
                amount(float(one.evaluation.errors.largest[i]), joint.effort_unit),
                percent(float(one.evaluation.errors.largest_share[i])),
                "yes" if one.keeps_promise[i] else "no",
                "–" if one.most is None else "no" if one.fails[i] else "yes",
            ]
            for one in self.motions
            for i, joint in enumerate(self.model.arm.joints)
        ]
        headings = [
            "motion",
            "joint",
            "peak torque",
            "largest error",
            "of that peak",
            "as promised",
            "passes",
        ]
        outside = sum(int(one.outside.sum()) for one in self.motions)
        return html_of(repr(self), headings, rows, f"{outside} set points lie outside {self.box.where}.")


def validate(
    model: SimplifiedModel,
    motions: GivenMotions,
    *,
    fail_over: Budget | str | None = None,
    box: Box | None = None,
    progress: Callable[[int], None] | None = None,
) -> Validation:
    """Hold a model against the exact dynamics of its arm along motions, and against measured torques.

    `gd_analyze.evaluate` gives torques and errors at any states; this one gives a verdict on each motion by
    itself.

    Parameters
    ----------
    model
        The simplified model.
    motions
        Motions of its arm: trajectories, shipped names, paths of files or of folders. Torques that were
        recorded with one are held against the exact and the simplified ones.
    fail_over
        Error above which a joint fails: a budget per joint, whose shares are of the joint's own torque along
        the same motion (over all of them at a joint that needs none along it), or "promise", what the model
        promises; None for no verdict.
    box
        The states to look for those outside of; the arm's own limits by default, for which `certify` and
        `simplify_certified` bound a model.
    progress
        Called with 1 after every motion.

    Returns
    -------
    Validation
        Errors, verdicts, states outside of the box and comparisons with measured torques, motion by motion.

    Raises
    ------
    TrajectoryError
        If there are no motions, or one is of another number of joints.
    UsageError
        If `fail_over` is no budget per joint, or a share of what the arm does not state; or the box is of
        another number of joints.

    Warns
    -----
    GdAnalyzeWarning
        Of limits of the box that are assumed, as the arm states none.
    """
    arm = model.arm
    asked = _asked(model, fail_over)
    box = box_of(box, arm)
    given = motions_of(motions, arm)
    for one in given:
        require_joints(one, arm)
    tried = [(one, evaluate(model, one)) for one in given]
    promises = [model.accuracy.along(one.fingerprint) for one, _ in tried]
    most = _most([evaluation for _, evaluation in tried], promises, asked)
    found = []
    for (one, evaluation), accuracy, each in zip(tried, promises, most, strict=True):
        measured = BesideMeasured.of(arm, one, evaluation)
        found.append(ValidatedMotion(one, evaluation, accuracy, each, *box_exits(arm, one, box), measured))
        if progress is not None:
            progress(1)
    return Validation(model, box, asked, tuple(found))


def _asked(model: SimplifiedModel, fail_over: Budget | str | None) -> Budget | Literal["promise"] | None:
    """What was asked for as a value; anything that tells of no joint alone is refused."""
    if fail_over is None:
        return None
    if isinstance(fail_over, str) and fail_over.strip().lower() == PROMISE:
        if model.accuracy.asked.norm is not None:
            raise UsageError(
                "this model promises no joint an error of its own",
                where=_OPTION,
                expected='a budget per joint, such as "1%"',
                found=f'"{PROMISE}", and a model with a budget of {model.accuracy.budget}',
            )
        return "promise"
    budget = Budget.parse(fail_over, _OPTION) if isinstance(fail_over, str) else Budget.of(fail_over)
    return budget.require_per_joint("a verdict on every joint")


def _most(
    tried: Sequence[Evaluation], promises: Sequence[Accuracy], asked: Budget | Literal["promise"] | None
) -> list[FloatArray | None]:
    """Error that each joint may have along each motion, N m, shape (n,) each."""
    if asked is None:
        return [None] * len(tried)
    if isinstance(asked, str):
        return [accuracy.allowed for accuracy in promises]
    peaks = np.max([one.errors.peak_torque for one in tried], axis=0)
    most: list[FloatArray | None] = []
    for one in tried:
        exact = one.dynamics
        alone, over_all = exact.allowed(asked), ReferenceTorques(exact.arm, peaks, exact.uncertainty)
        # A share of a torque that a joint does not need along this motion would be one of nothing.
        needs = one.errors.peak_torque > 0.0
        most.append(alone if needs.all() else np.where(needs, alone, allowed_by(asked, over_all)))
    return most
