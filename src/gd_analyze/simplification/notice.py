"""Whether a budget allows less than the machine shows: less than its friction, or its data's uncertainty."""

from __future__ import annotations

import numpy as np

from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.accuracy import Accuracy
from gd_analyze.simplification.budget import Allowance, Budget
from gd_analyze.simplification.reference_torques import ReferenceTorques
from gd_analyze.text import amount, named_joints

# What a budget may lie below, and what takes that into account.
_TAKEN_INTO_ACCOUNT = {
    "friction": Allowance(0.1, "friction"),
    "uncertainty": Allowance(1.0, "uncertainty"),
}


def budget_notice(arm: RobotArm, accuracy: Accuracy) -> str:
    """Say at which joints a budget lies below friction, or below the torque's uncertainty where that is all.

    Returns
    -------
    str
        A sentence with the numbers of the joint where it is most so, and the budget that takes it into
        account; "" where no joint is concerned, or the budget's entry for it does so already, or it is of the
        norm and has none.
    """
    if accuracy.asked.norm is not None:
        return ""
    by = ReferenceTorques(arm, accuracy.errors.peak_torque, accuracy.uncertainty)
    entries = list(accuracy.asked.of_joints(arm.n_joints))
    is_open = np.array([_TAKEN_INTO_ACCOUNT.keys().isdisjoint(of for _, of in entry) for entry in entries])
    clauses = []
    for name, allowance in _TAKEN_INTO_ACCOUNT.items():
        level = by.all(name)
        below = is_open & (accuracy.allowed < level)
        if not below.any():
            continue
        joint = int(np.argmin(np.where(below, accuracy.allowed / level, np.inf)))
        unit = arm.joints[joint].effort_unit
        clauses.append(
            f"below the {name} at {named_joints((1 + np.flatnonzero(below)).tolist(), arm.n_joints)} (joint "
            f"{joint + 1}: {amount(accuracy.allowed[joint], unit)}, {name} {amount(level[joint], unit)})"
        )
        # One entry for all joints is easier to write, where they all state it.
        alike = len(set(entries)) == 1 and is_open.all() and np.isfinite(level).all()
        wider = is_open if alike else below
        entries = [(*entry, allowance) if w else entry for entry, w in zip(entries, wider, strict=True)]
        is_open &= ~wider
    if not clauses:
        return ""
    wanted = Budget(tuple(entries[:1] if len(set(entries)) == 1 else entries))
    return f'The budget lies {" and ".join(clauses)}; --budget "{wanted}" takes that into account.'
