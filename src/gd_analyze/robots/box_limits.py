"""Limits of a box of states: the arm's own, and stated defaults in the place of those it does not state."""

from __future__ import annotations

import warnings
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.robots.arm import RobotArm

# A full turn or half a metre each way, and brisk but ordinary rates, in rad or m and per s, s^2.
_RANGE = {"revolute": np.pi, "prismatic": 0.5}
_RATE, _ACCELERATION = 2.0, 5.0


@dataclass(frozen=True, eq=False)
class BoxLimits:
    """Finite limits of every joint, shape (n,) each.

    Parameters
    ----------
    lower, upper
        Of the joint variables, rad (m).
    rate, acceleration
        Largest magnitudes, per s and s^2.
    assumed
        Which of them the arm does not state, in words; "" where it states all.
    """

    lower: FloatArray
    upper: FloatArray
    rate: FloatArray
    acceleration: FloatArray
    assumed: str

    @property
    def behind(self) -> str:
        """What to add where these limits are named."""
        return f" (assumed, as none are stated: {self.assumed})" if self.assumed else ""


def box_limits(arm: RobotArm) -> BoxLimits:
    """Take an arm's limits; where it states none, ordinary ones, with a warning that says which.

    Warns
    -----
    GdAnalyzeWarning
        Of limits that are assumed.
    """
    lower, upper, rate, acceleration = (
        arm.limits(what) for what in ("lower", "upper", "rate_limit", "acceleration_limit")
    )
    ranges = np.array([_RANGE[joint.kind] for joint in arm.joints])
    ranged = np.isfinite(lower) & np.isfinite(upper)
    rated, accelerated = np.isfinite(rate), np.isfinite(acceleration)
    told = [
        *_told(arm, ranged, "a range of +-", ranges, ""),
        *_told(arm, rated, "a rate of ", np.full(arm.n_joints, _RATE), "/s"),
        *_told(arm, accelerated, "an acceleration of ", np.full(arm.n_joints, _ACCELERATION), "/s^2"),
    ]
    assumed = "; ".join(told)
    if assumed:
        warnings.warn(
            f"arm {arm.name} does not state all limits: for a box of states, {assumed} is assumed",
            GdAnalyzeWarning,
            stacklevel=3,
        )
    return BoxLimits(
        np.where(ranged, lower, -ranges),
        np.where(ranged, upper, ranges),
        np.where(rated, rate, _RATE),
        np.where(accelerated, acceleration, _ACCELERATION),
        assumed,
    )


def _told(arm: RobotArm, stated: NDArray[np.bool_], what: str, values: FloatArray, per: str) -> list[str]:
    """Say what is assumed of the joints that state nothing, those of one unit together."""
    found = []
    for unit in ("rad", "m"):
        chosen = [i for i, joint in enumerate(arm.joints) if joint.unit == unit and not stated[i]]
        if chosen:
            every = len(chosen) == arm.n_joints
            names = "every joint" if every else "joint " + ", ".join(arm.joints[i].name for i in chosen)
            found.append(f"{what}{values[chosen[0]]:.4g} {unit}{per} of {names}")
    return found
