"""A budget over several motions: an error that is within it on each of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.levels.budget import Budget
from gd_analyze.levels.yardsticks import Yardsticks
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray


@dataclass(frozen=True, eq=False)
class OnMotion:
    """What one of several motions asks of the joints, N m (N for a sliding joint), shape (n,).

    Parameters
    ----------
    name, fingerprint, set_points
        The motion's name and fingerprint, and how many set points it has.
    peak
        Largest magnitude of the exact torque along it.
    uncertainty
        Largest standard uncertainty of the torque along it; None where none is stated.
    """

    name: str
    fingerprint: str
    set_points: int
    peak: FloatArray
    uncertainty: FloatArray | None = None


def allowed_on_each(budget: Budget, arm: RobotArm, motions: Sequence[OnMotion]) -> FloatArray:
    """Error that a budget allows on every motion, N m, shape (motions, n).

    Infinite at a joint that needs no torque along a motion: there a share of it is a share of nothing, and
    any error is that of terms which cancel.
    """
    return np.array(
        [
            np.where(one.peak > 0.0, budget.allowed(Yardsticks(arm, one.peak, one.uncertainty)), np.inf)
            for one in motions
        ]
    )


def least_allowed(
    budget: Budget, motions: Sequence[OnMotion], by: Yardsticks
) -> tuple[FloatArray, list[OnMotion | None]]:
    """Error that a budget allows on all motions, and at each joint the motion that allows the least.

    Parameters
    ----------
    budget, motions
        The budget, and the motions; none where there is only one.
    by
        What it is measured by over all motions together, which counts where none of them decides.

    Returns
    -------
    allowed, deciding
        N m, shape (n,); and one entry per joint, None where all motions allow the same.
    """
    over_all = budget.allowed(by)
    if not motions:
        return over_all, [None] * len(over_all)
    each = allowed_on_each(budget, by.arm, motions)
    least, first = each.min(axis=0), each.argmin(axis=0)
    known = np.isfinite(least)
    differs = known & (np.where(np.isfinite(each), each, 0.0).max(axis=0) > least)
    deciding = [motions[k] if d else None for k, d in zip(first, differs, strict=True)]
    return np.where(known, least, over_all), deciding
