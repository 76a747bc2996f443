"""What the torque error of a joint is measured by: peak torque, torque limit, friction, uncertainty."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drives import least_friction
from gd_analyze.errors import UsageError
from gd_analyze.robots.arm import RobotArm

# What to state in an arm file, by what a budget may be a share of.
_TO_STATE = {
    "limit": "`torque_limit` in the joint's [[drives]] table",
    "friction": "`coulomb` in the joint's [[drives]] table, for both directions",
    "uncertainty": "`mass_uncertainty`, `com_uncertainty` or `inertia_uncertainty` of the links",
}


@dataclass(frozen=True, eq=False)
class ReferenceTorques:
    """What a budget may be a share of, at each joint, N m (N for a sliding joint), shape (n,).

    Parameters
    ----------
    arm
        Whose joints they are; it states their torque limits and their friction.
    peak
        Largest magnitude of the exact torque.
    uncertainty
        Largest standard uncertainty of the torque; None where none is stated or asked for.
    """

    arm: RobotArm
    peak: FloatArray
    uncertainty: FloatArray | None = None

    def of(self, name: str, joint: int, option: str = "--budget") -> float:
        """One of them by its name, "peak", "limit", "friction" or "uncertainty", of a joint, from 0.

        `option` says in a message where it was asked for.

        Raises
        ------
        UsageError
            If the arm does not state it.
        """
        value = float(self.all(name)[joint])
        if np.isnan(value):
            raise UsageError(
                f"a budget cannot be a share of {name}, as the arm states none",
                where=f"{option}, joint {joint + 1}, {self.arm.joints[joint].name}, of {self.arm.name}",
                expected=_TO_STATE[name],
                found="none",
                next_step=f"state it in the arm file, or give this joint an entry without {name}: one entry "
                "per joint, comma-separated",
            )
        return value

    def all(self, name: str) -> FloatArray:
        """One of them at every joint, shape (n,); nan where the arm does not state it."""
        unknown = np.full(self.arm.n_joints, np.nan)
        if name == "peak":
            return self.peak
        if name == "uncertainty":
            return unknown if self.uncertainty is None else self.uncertainty
        if not self.arm.drives:
            return unknown
        if name == "friction":
            level = least_friction(self.arm)
            return np.where(level > 0.0, level, np.nan)
        return np.array([np.nan if d.torque_limit is None else d.torque_limit for d in self.arm.drives])
