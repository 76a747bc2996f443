"""Whether an arm's exact torque has too many terms, without writing all of them out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from gd_analyze.levels.exact_form import ExactForm
from gd_analyze.robots import RobotArm

# Outer joints looked at first: tens of milliseconds.
_FEW = 4


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
