"""What actuators have to overcome besides the links: the drives' inertia and friction, and damping."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drives import coulomb_friction, viscous_coefficients
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import checked_states
from gd_analyze.robots.arm import RobotArm

REST_RATE = 1e-2
"""Rate, rad/s (m/s), below which Coulomb friction fades out in a simulation: its tanh is 0.76 there."""


@dataclass(frozen=True, eq=False)
class Drivetrain:
    """Which properties of the drives act, and damping at the joints.

    Parameters
    ----------
    inertia
        Whether the drives' inertia J adds to the diagonal of D.
    friction
        Whether the drives' viscous and Coulomb friction act.
    damping
        Further viscous damping b_i at the joints, N m s (N s/m where the joint slides), shape (n,).
    rest_rate
        Width of the step of Coulomb friction, as in `gd_analyze.dynamics.drives.drive_contributions`. A
        joint held by
        Coulomb friction alone creeps, at a rate below a few of these.
    """

    inertia: bool = False
    friction: bool = False
    damping: FloatArray | None = None
    rest_rate: float = REST_RATE

    def inertia_of(self, arm: RobotArm) -> FloatArray:
        """What goes onto D's diagonal, shape (n,); raises ArmError if the arm describes no drives."""
        return arm.drive_inertia if self.inertia else np.zeros(arm.n_joints)

    def resistance_of(self, arm: RobotArm) -> Callable[[FloatArray], FloatArray]:
        """Torque that the actuators have to overcome at rates qd, shape (..., n); it never drives.

        Raises
        ------
        UsageError
            If the damping does not fit the arm or is negative, or the rest rate is not positive.
        ArmError
            If friction is asked for and the arm describes no drives.
        """
        viscous = np.zeros(arm.n_joints)
        if self.damping is not None:
            leading, (damping,) = checked_states(arm, damping=self.damping)
            if leading or (damping < 0).any():
                raise UsageError(
                    "damping must oppose motion, one coefficient per joint",
                    where="damping",
                    expected=f"{arm.n_joints} numbers of 0 or more",
                    found=str(damping.tolist()),
                )
            viscous = viscous + damping
        if not self.friction:
            return lambda qd: viscous * qd
        if not (np.isfinite(self.rest_rate) and self.rest_rate > 0):
            raise UsageError(
                "the rest rate must be positive: an integrator cannot step over a jump",
                where="rest_rate",
                expected="a positive number of rad/s (m/s)",
                found=str(self.rest_rate),
            )
        viscous = viscous + viscous_coefficients(arm)
        return lambda qd: viscous * qd + coulomb_friction(arm, qd, rest_rate=self.rest_rate)


NO_DRIVES = Drivetrain()
