"""Whether an arm's exact torque has too many terms, without writing all of them out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.exact_form import ExactForm

# Outer joints looked at first: tens of milliseconds.
_FEW = 4
# Torque terms up to which terms are worth choosing from: a seven-joint arm of general make has tens of
# thousands, and any model of them takes more operations than its recursion.
MOST_TERMS = 2000
# Joints up to which identifying the exact form takes no more than a second.
MOST_JOINTS = 8


def has_many_terms(form: ExactForm) -> bool:
    """Whether an arm has too many joints, or its exact equations too many terms, to choose from them."""
    return form.arm.n_joints > MOST_JOINTS or has_more_terms(form, MOST_TERMS)


def many_terms_told(form: ExactForm) -> str:
    """Say what there is too much of, for an arm of which `has_many_terms` is true."""
    n = form.arm.n_joints
    return f"{n} joints" if n > MOST_JOINTS else f"more than {MOST_TERMS} torque terms"


def has_more_terms(form: ExactForm, most: int) -> bool:
    """Whether the exact torque has more than `most` terms.

    What the outer joints alone move among themselves, the joints before them at rest, is part of the whole
    torque, term by term: where that are more already, the time for all others is saved.
    """
    if "torques" in vars(form):
        return len(form.torques) > most
    n = form.arm.n_joints
    outer = (ExactForm(_outer(form.arm, count)) for count in range(_FEW, n))
    return any(len(each.torques) > most for each in outer) or len(form.torques) > most


def _outer(arm: RobotArm, count: int) -> RobotArm:
    """The last joints of an arm, on a base without gravity."""
    return replace(
        arm,
        joints=arm.joints[-count:],
        links=arm.links[-count:],
        gravity=np.zeros(3),
        drives=(),
        dh_table=(),
        convention="",
    )
