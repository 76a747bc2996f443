"""What opposes a motion: damping at the joints and the drives' friction."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from gd_analyze.drives import coulomb_friction, viscous_coefficients
from gd_analyze.errors import UsageError
from gd_analyze.robots import RobotArm
from gd_analyze.simulation.states import checked_states
from gd_analyze.vectors import FloatArray

REST_RATE = 1e-2
"""Rate, rad/s (m/s), below which Coulomb friction fades out in a simulation: its tanh is 0.76 there."""


@dataclass(frozen=True, eq=False)
class Resistance:
    """Torque that opposes motion: b_i qd_i, and Coulomb friction that fades out at rest.

    Parameters
    ----------
    arm
        The arm.
    friction
        Whether the drives' viscous and Coulomb friction act.
    damping
        Further viscous damping b_i at the joints, N m s (N s/m where the joint slides), shape (n,).
    rest_rate
        Width of the step of Coulomb friction, as in `gd_analyze.drives.drive_contributions`. A joint held by
        Coulomb friction alone creeps, at a rate below a few of these.

    Raises
    ------
    UsageError
        If the damping does not fit the arm or is negative, or the rest rate is not positive.
    ArmError
        If friction is asked for and the arm describes no drives.
    """

    arm: RobotArm
    friction: bool = False
    damping: FloatArray | None = None
    rest_rate: float = REST_RATE
    _viscous: FloatArray = field(init=False)

    def __post_init__(self) -> None:
        viscous = np.zeros(self.arm.n_joints)
        if self.damping is not None:
            leading, (damping,) = checked_states(self.arm, damping=self.damping)
            if leading or (damping < 0).any():
                raise UsageError(
                    "damping must oppose motion, one coefficient per joint",
                    where="damping",
                    expected=f"{self.arm.n_joints} numbers of 0 or more",
                    found=str(damping.tolist()),
                )
            viscous = viscous + damping
        if self.friction:
            if not (np.isfinite(self.rest_rate) and self.rest_rate > 0):
                raise UsageError(
                    "the rest rate must be positive: an integrator cannot step over a jump",
                    where="rest_rate",
                    expected="a positive number of rad/s (m/s)",
                    found=str(self.rest_rate),
                )
            viscous = viscous + viscous_coefficients(self.arm)
        viscous.flags.writeable = False
        object.__setattr__(self, "_viscous", viscous)

    def torque(self, qd: FloatArray) -> FloatArray:
        """What the actuators have to overcome at rates qd, shape (..., n); it never has the other sign."""
        out: FloatArray = self._viscous * qd
        return out + coulomb_friction(self.arm, qd, rest_rate=self.rest_rate) if self.friction else out
