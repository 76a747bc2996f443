"""Torque errors in words, in the terms in which their budget was given; once for every view."""

from __future__ import annotations

from collections.abc import Sequence
from math import isinf
from typing import NamedTuple

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.states import in_words
from gd_analyze.results.words import drives_told
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.measures import NormShare
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.text import amount, at_most, rounded_up, share_up


class WorstError(NamedTuple):
    """The error of the joint that is off most.

    Parameters
    ----------
    joint
        Which one, from 1.
    size
        "0.94 %" or "0.93 N m".
    of
        What the size is a share of: "peak torque", "allowed error"; "" for a torque.
    """

    joint: int
    size: str
    of: str

    @property
    def in_words(self) -> str:
        """The error and where it is: "0.94 % of the peak torque (joint 3)"."""
        return f"{self.size}{self.of and f' of the {self.of}'} (joint {self.joint})"


def worst_error(model: SimplifiedModel, bound: FloatArray | None = None) -> WorstError:
    """Name the joint that is off most, and by how much, in the terms of the model's budget.

    A budget in shares of peak torque is answered in these, one in N m for all joints in N m; of any other,
    such as the larger of several, it is said how much of the allowed error is used.

    Parameters
    ----------
    model
        The model that errs.
    bound
        What its joints' errors do not exceed, N m, shape (n,), which is rounded up; by default the largest
        errors that the model states.
    """
    accuracy, asked, arm = model.accuracy, model.accuracy.asked, model.arm
    error = accuracy.errors.largest if bound is None else bound
    if asked.wholes == {"torque"} and len(set(asked.entries)) == 1 and len(set(arm.is_revolute)) == 1:
        joint = int(error.argmax())
        return WorstError(joint + 1, _torques(model, bound)[joint], "")
    shares = accuracy.shares_of(error)
    joint = int(shares.argmax())
    share = float(shares[joint]) if bound is None else share_up(float(shares[joint]))
    return WorstError(joint + 1, at_most(share), asked.shares_of)


def off_by(model: SimplifiedModel, bound: FloatArray | None = None) -> str:
    """Say how far the torques are off at most: "no joint's torque is off by more than 0.94 % of its peak".

    Parameters are those of `worst_error`.
    """
    worst, wholes, torques = worst_error(model, bound), model.accuracy.asked.wholes, _torques(model, bound)
    if wholes == {"torque"} and worst.of:
        return f"the torques of joints 1 to {len(torques)} are off by at most {', '.join(torques)}"
    at_most_so = f"no joint's torque is off by more than {worst.size}"
    if not worst.of:
        return at_most_so
    if wholes in ({"peak"}, {"norm"}):
        return f"{at_most_so} of its peak"
    unit = model.arm.joints[worst.joint - 1].effort_unit
    allowed = amount(float(model.accuracy.allowed[worst.joint - 1]), unit)
    return (
        f"{at_most_so} of what a budget of {model.accuracy.budget} allows it (joint {worst.joint}: "
        f"{torques[worst.joint - 1]} of {allowed})"
    )


def errs_by(model: SimplifiedModel) -> str:
    """Say in a few words how far the model is off, in the terms of its budget: "largest error 0.94 % ..."."""
    asked = model.accuracy.asked_norm
    if asked is None:
        return f"largest error {worst_error(model).in_words}"
    return f"error within {at_most(asked.share)} of the torque's norm at {_these_states(asked)}"


def norms_told(norms: Sequence[NormShare], arm: RobotArm) -> str:
    """Say which share of the torque's norm the error's is, by the share of the states; "" where unknown."""
    if not norms:
        return ""
    apart = " (joints that turn and joints that slide apart)" if len(set(arm.is_revolute)) > 1 else ""
    return f"Norm of the error over norm of the torque{apart}: at most {norms_in_words(norms)}"


def norms_in_words(norms: Sequence[NormShare]) -> str:
    """Such shares alone: "0.91 % at 95 % of the states, 2.1 % at 99.9 %"."""
    shares = [
        f"{'∞' if isinf(norm.share) else at_most(norm.share)} at {_these_states(norm, of=not i)}"
        for i, norm in enumerate(norms)
    ]
    return ", ".join(shares)


def _these_states(norm: NormShare, of: bool = True) -> str:
    return "all states" if norm.states == 1.0 else f"{100 * norm.states:.10g} %{' of the states' * of}"


def measure_told(model: SimplifiedModel) -> str:
    """Say over which states the peak torque, or the uncertainty, is that the budget takes shares of.

    "" where it takes shares of neither.
    """
    told = {"peak": "peak torque", "uncertainty": "uncertainty"}
    wholes = [words for name, words in told.items() if name in model.accuracy.asked.wholes]
    over = (
        in_words(model.accuracy.fitted_on)
        if model.accuracy.fitted_on
        else "the states the model was made for"
    )
    return f"{' and '.join(wholes)} over {over}" if wholes else ""


def nothing_gained(model: SimplifiedModel, searched: str = "model found") -> str:
    """Say so where nothing can be dropped and the model given is the exact one; "" where something is.

    `searched` names what was looked at.
    """
    if model.saves:
        return ""
    told = drives_told(model.arm, model.drives)
    told = f" ({told})" if told else ""
    return (
        f"Nothing is saved within the budget of {model.accuracy.budget}: no {searched} takes fewer "
        f"operations than the {model.operations_full.total} of the exact torque{told}, which is given."
    )


def _torques(model: SimplifiedModel, bound: FloatArray | None) -> list[str]:
    """The joints' errors, or their bounds, with units."""
    if bound is None:
        sizes = [float(error) for error in model.accuracy.errors.largest]
    else:
        sizes = [rounded_up(float(error)) for error in bound]
    return [amount(s, joint.effort_unit) for s, joint in zip(sizes, model.arm.joints, strict=True)]
