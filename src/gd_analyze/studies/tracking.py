"""A budget in tracking error: the allowed torque errors, a model within them, and how it tracks."""

from __future__ import annotations

import math
import re
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple, Self

import numpy as np

from gd_analyze.arguments import strict
from gd_analyze.arrays import FloatArray, cross
from gd_analyze.certification.held import Held
from gd_analyze.dynamics.kinematics import joint_motions, solve_kinematics
from gd_analyze.errors import UsageError
from gd_analyze.motions.pool import trajectory_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.result import Fact, Result
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_with_masses
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.studies import control_bounds as bounds
from gd_analyze.studies.control import ControlStudy, control, followable
from gd_analyze.studies.control_law import (
    CONTINUOUS,
    EXACT,
    FIXED_GAINS,
    SIMPLIFIED,
    Controller,
    ControlSettings,
    Reference,
    Tolerance,
)
from gd_analyze.text import UNSIGNED, number, rounded_up
from gd_analyze.threads import one_thread
from gd_analyze.units import Quantity

_WORDS = re.compile(
    r"\s*tracking\s+(?P<error>.+?)(?P<tip>\s+(?:at|of)\s+(?:the\s+)?(?:end[ -]effector|tip))?"
    rf"(?:\s+at\s+(?P<bandwidth>{UNSIGNED})\s*rad/s)?(?:\s+damping\s+(?P<damping>{UNSIGNED}))?\s*",
    re.IGNORECASE,
)
# What follows the error, where it is not understood; "at the end effector" is of the error.
_LOOP = re.compile(r"\b(?:at(?!\s+(?:the\s+)?(?:end|tip)\b)|damping\b).*", re.IGNORECASE)
_NOT_RAD = re.compile(rf"at\s+({UNSIGNED})\s*(hz|damping\b|$)", re.IGNORECASE)


@dataclass(frozen=True, kw_only=True)
class _TrackingSettings:
    """The loop of a tracking budget, and the search for a model that keeps it."""

    usual_rate_hz: float = 500.0  # usual loop rate
    periods_per_radian: float = 25.0  # least number of loop periods per radian of the bandwidth
    most_searches: int = 4  # most searches for a model
    # Share of the allowed error that the next search aims at if a model tracks worse than asked for.
    aimed_share: float = 0.9


_SETTINGS = _TrackingSettings()


@dataclass(frozen=True)
class TrackingBudget:
    """Largest tracking error along a motion, of every joint or of the end effector's position.

    Parameters
    ----------
    settings
        The loop, and the joints' tolerance.
    tip
        Tolerance of the end effector's position, m, in place of the joints'; None for the joints'.
    text
        The budget as given.
    """

    settings: ControlSettings
    tip: float | None
    text: str

    @classmethod
    def parse(cls, text: str) -> Self | None:
        """Read "tracking 0.1deg", "tracking 1mm at the end effector at 30 rad/s damping 0.7".

        None if the first word is another. Defaults: bandwidth 20 rad/s, damping ratio 1.

        Raises
        ------
        UsageError
            If the rest is not understood or out of range.

        Examples
        --------
        >>> TrackingBudget.parse("tracking 1mm at the end effector").tip
        0.001
        """
        if not re.match(r"\s*tracking\b", text, re.IGNORECASE):
            return None
        match = _WORDS.fullmatch(text)
        loop = _LOOP.search(match["error"]) if match else None
        if loop is not None:
            raise _loop_not_understood(loop[0].strip())
        quantity = Quantity.parse(match["error"]) if match and match["tip"] else None
        tip = quantity.si if quantity is not None and quantity.kind == "length" else None
        if match is None or (match["tip"] and not (tip and 0.0 < tip < math.inf)):
            raise UsageError(
                "the budget is not understood",
                where="--budget",
                expected='"tracking 0.1deg" (prismatic joints: 1mm) or "tracking 1mm at the end effector", '
                'then "at 20 rad/s" and "damping 1" of the loop',
                found=repr(text),
            )
        bandwidth, damping = float(match["bandwidth"] or 20.0), float(match["damping"] or 1.0)
        joints = Tolerance() if tip is not None else Tolerance.parse(match["error"], "--budget")
        rates = (CONTINUOUS, max(_SETTINGS.usual_rate_hz, _SETTINGS.periods_per_radian * bandwidth))
        settings = ControlSettings(bandwidth, damping, rates, (1.0,), tolerance=joints)
        return cls(settings, tip, " ".join(text.split()))

    def torques(self, form: ExactForm, motion: Trajectory) -> FloatArray:
        """Allowed torque errors, N m (N), shape (n,), see `control_bounds.torque_for`."""
        reference = Reference.of(followable(motion))

        def errors(proportions: FloatArray) -> FloatArray:
            if self.tip is None:
                return self.settings.tolerance.of(form.arm)
            moved = np.abs(tip_columns(form.arm, reference.sampled()[0]))
            farthest = np.einsum("ik,i->k", moved, proportions).max()
            return np.asarray(self.tip * proportions / farthest)

        return bounds.torque_for(form.program, reference, self.settings.gains, errors)

    def share(self, study: ControlStudy, controller: Controller) -> float:
        """Largest tracking error over the allowed one, simulated at the loop rate."""
        loop = study.loop(controller, self.settings.usual_rate, 1.0)
        if self.tip is None or loop.lost_at is not None:
            return float((loop.peak_error / study.tolerance).max())
        q, _, _ = Reference.of(followable(study.motion)).at(loop.time)
        deviation = tip_position(study.arm, q) - tip_position(study.arm, q - loop.error.T)
        return float(np.linalg.norm(deviation, axis=0).max() / self.tip)

    def bound(self, study: ControlStudy) -> float | None:
        """Proven bound on this share for the continuous loop with the model's D; None if there is none."""
        certified = study.certified.get(1.0)
        if certified is None:
            return None
        if self.tip is None:
            return float((certified.error / study.tolerance).max())
        q, _, _ = Reference.of(followable(study.motion)).sampled()
        # First order is enough: a tolerance of a millimetre is about a thousandth of a radian.
        return float(np.einsum("ik,i->k", tip_columns(study.arm, q), certified.error).max() / self.tip)

    def amount(self, share: float, arm: RobotArm) -> str:
        """Write a share of the allowed error."""
        if self.tip is not None:
            return f"{number(1e3 * share * self.tip)} mm"
        joints = self.settings.tolerance
        return Tolerance(share * joints.revolute, share * joints.prismatic).in_words(arm)


def _loop_not_understood(words: str) -> UsageError:
    """Error for the words after the tracking error, in rad/s where they state a bandwidth."""
    match = _NOT_RAD.match(words)
    if match is None:
        message = "the loop of the budget is not understood"
        next_step = 'write the bandwidth first: "at 20 rad/s damping 1"'
    else:
        rate = float(match[1]) * (math.tau if match[2].lower() == "hz" else 1.0)
        message = "the bandwidth needs its unit, rad/s"
        next_step = f'write "at {rate:.4g} rad/s"'
    expected = '"at 20 rad/s", then "damping 1", or one of these'
    return UsageError(message, where="--budget", expected=expected, found=repr(words), next_step=next_step)


class Tracked(NamedTuple):
    """A model made for a tracking error."""

    held: Held
    budget: TrackingBudget
    study: ControlStudy
    controller: Controller  # by which it tracks best
    searches: int

    def beside(self, result: Result) -> Result:
        """Add the requested, simulated and bounded tracking error to the facts of the model."""
        share, bound = self.budget.share(self.study, self.controller), self.budget.bound(self.study)
        error_text, arm = self.budget.amount(share, self.study.arm), self.study.arm
        simulated = f"{error_text}, {self.controller.title}, {self.budget.settings.usual_rate:g} Hz"
        proven = "none: no margins around the motion enclose the error"
        if bound is not None:
            proven = f"at most {self.budget.amount(rounded_up(bound), arm)}, continuous loop, D sampled"
        facts = (
            Fact("tracking", "Asked for", self.budget.text),
            Fact("tracking_simulated", "Tracking error, simulated", share, text=simulated),
            Fact("tracking_bound", "Tracking error, bound", bound, text=proven),
            Fact("tracking_searches", "", self.searches),
        )
        remark = "" if share <= 1.0 else f", more than the {self.budget.amount(1.0, arm)} asked for"
        line = f"Tracking error {error_text}, simulated{remark}."
        return replace(result, headline=f"{result.headline} {line}", facts=(*result.facts, *facts))


@strict
@one_thread()
def tracking_budget(
    arm: RobotArm | str | Path, trajectory: Trajectory | str, text: str, *, drives: bool | None = None
) -> Budget:
    """Convert an allowed tracking error along a motion to allowed torque errors, to first order.

    Parameters
    ----------
    arm, trajectory
        The arm and one motion, or their names or files.
    text
        "0.1deg" of every joint (prismatic ones: "1mm"), or "1mm at the end effector"; then "at 20 rad/s", the
        loop's bandwidth, and "damping 1".
    drives
        Include the drives' inertia; by default if the arm describes drives.

    Returns
    -------
    Budget
        N m (N) for every joint, in proportion to the mean of D's diagonal. With torque errors of any sign
        within it, fixed gains keep the tracking error.

    Raises
    ------
    UsageError
        If the text is not understood.
    TrajectoryError
        If the motion has gaps.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> budget = gd.tracking_budget("two_link", "two-link-swing", "0.1deg at 20 rad/s")
    >>> str(gd.tracking_budget("two_link", "two-link-swing", "0.2deg at 20 rad/s")) == str(budget.scaled(2.0))
    True
    """
    robot, budget = arm_with_masses(arm), TrackingBudget.parse(f"tracking {text}")
    assert budget is not None  # of that word
    form, motion = ExactForm(robot, robot.counts_drives(drives)), trajectory_of(trajectory, robot)
    return Budget.of_torques(budget.torques(form, motion).tolist())


def simplify_for_tracking(
    budget: TrackingBudget, form: ExactForm, motion: Trajectory | None, search: Callable[[Budget], Held]
) -> Tracked:
    """Search a model within the torque errors that a tracking error allows, and simulate control with it.

    If the model tracks worse than asked for, which first order does not exclude, a tighter budget follows.

    Raises
    ------
    UsageError
        If there is not exactly one motion, or the exact model tracks worse than asked for.
    """
    if motion is None or motion.motions:
        message, expected = "a tracking budget needs one motion", "one trajectory"
        raise UsageError(message, where="--budget", expected=expected, found="several" if motion else "none")
    torques, searches, share = budget.torques(form, motion), 0, np.inf
    while share > 1.0 and searches < _SETTINGS.most_searches:
        torques = torques * min(1.0, _SETTINGS.aimed_share / share if np.isfinite(share) else 1.0)
        searches += 1
        held_model = search(Budget.of_torques(-rounded_up(-x) for x in torques.tolist()))
        study = control(held_model.model, motion, budget.settings)
        possible = (SIMPLIFIED, FIXED_GAINS) if study.feedback.is_enough else (FIXED_GAINS,)
        controller = min(possible, key=lambda law: budget.share(study, law))
        share, least = budget.share(study, controller), budget.share(study, EXACT)
        if share > 1.0 and least >= _SETTINGS.aimed_share:
            rate = budget.settings.usual_rate
            raise UsageError(
                "no model can track this well: the exact one does not",
                where="--budget",
                expected=f"{number(least / _SETTINGS.aimed_share)} times as much or more, "
                "or a loop of more bandwidth",
                found=f"{budget.text!r}, at {rate:g} Hz",
            )
    return Tracked(held_model, budget, study, controller, searches)


def tip_position(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Position of the end effector in the base frame, m, shape (3, K), at q (n, K)."""
    kinematics = solve_kinematics(arm, q)
    beyond = np.einsum("abk,b->ak", kinematics.link_rotations[-1], arm.tip_frame.translation)
    return np.asarray(kinematics.link_origins[-1] + beyond)


def tip_columns(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Length of the Jacobian's columns: motion of the end effector per joint, m per rad (m), shape (n, K)."""
    kinematics = solve_kinematics(arm, q)
    turning, sliding = joint_motions(arm, kinematics)
    from_joint = tip_position(arm, q) - kinematics.joint_origins
    columns = [cross(w, r) + u for w, r, u in zip(turning, from_joint, sliding, strict=True)]
    return np.asarray(np.linalg.norm(columns, axis=1))
