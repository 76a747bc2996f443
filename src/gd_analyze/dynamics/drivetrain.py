"""What actuators have to overcome besides the links: the drives' inertia and friction, and damping.

FGL87's D, h and c are those of the links. Motors and gears add the torque that accelerates them and what
their friction takes away; none of it is part of D, and all of it is seen at the joint here.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.motions.states import checked_states
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True, eq=False)
class DriveTorque:
    """Torque at the joints that the drives need, by cause, N m (N where the joint slides), shape (..., n).

    Parameters
    ----------
    inertia
        J_i qdd_i: accelerates motor and gears.
    viscous
        B_i qd_i, with B_i = ratio^2 times the value at the motor.
    coulomb
        |ratio| times the motor's value for the direction in which the joint moves; 0 at rest.
    """

    inertia: FloatArray
    viscous: FloatArray
    coulomb: FloatArray

    @property
    def friction(self) -> FloatArray:
        """Viscous and Coulomb friction together."""
        return self.viscous + self.coulomb

    @property
    def total(self) -> FloatArray:
        """All three together."""
        return self.inertia + self.friction


def drive_contributions(
    arm: RobotArm, qd: FloatArray, qdd: FloatArray, *, rest_rate: float = 0.0
) -> DriveTorque:
    """Torque that the drives need at given rates and accelerations.

    Friction is described at the motor and seen at the joint through the gears: a torque grows by |ratio|, and
    a rate is |ratio| times faster at the motor, hence ratio^2 for what is proportional to the rate. P. Corke
    and B. Armstrong-Helouvry (1994).

    Parameters
    ----------
    arm
        An arm that describes its drives.
    qd, qdd
        Rates and accelerations, of one shape (..., n).
    rest_rate
        Coulomb friction jumps at rest, where no rate decides its sign. A positive rest rate replaces the jump
        by tanh(qd / rest_rate), which an integrator can follow.

    Raises
    ------
    ArmError
        If the arm describes no drives, or friction that would drive instead of brake.
    UsageError
        If qd and qdd are not finite or not of one shape (..., n), or the rest rate is negative or not finite.
    """
    _, (qd, qdd) = checked_states(arm, qd=qd, qdd=qdd)
    return DriveTorque(
        arm.drive_inertia * qdd,
        viscous_coefficients(arm) * qd,
        coulomb_friction(arm, qd, rest_rate=rest_rate),
    )


def viscous_coefficients(arm: RobotArm) -> FloatArray:
    """B_i = ratio^2 times the motor's viscous friction, N m s (N s/m where the joint slides), shape (n,).

    Raises
    ------
    ArmError
        If the arm describes no drives, or friction that would drive instead of brake.
    """
    _require_drives(arm)
    return np.array([drive.gear_ratio**2 * drive.viscous for drive in arm.drives])


def coulomb_friction(arm: RobotArm, qd: FloatArray, *, rest_rate: float = 0.0) -> FloatArray:
    """Coulomb friction at the joints; parameters and errors as for `drive_contributions`, shape (..., n)."""
    _require_drives(arm)
    if not (np.isfinite(rest_rate) and rest_rate >= 0):
        raise UsageError(
            "the rest rate is not a rate",
            where="rest_rate",
            expected="0, or a positive number of rad/s (m/s)",
            found=str(rest_rate),
        )
    forward, backward = np.array([[abs(d.gear_ratio) * level for level in d.coulomb] for d in arm.drives]).T
    level = np.where(qd > 0, forward, np.where(qd < 0, -backward, 0.0))
    with np.errstate(over="ignore"):  # far beyond the rest rate: the tanh of infinity is 1
        return level * (np.tanh(qd / rest_rate) if rest_rate else np.sign(qd))


def least_friction(arm: RobotArm) -> FloatArray:
    """Coulomb friction at the joints in the direction that has less of it, (n,); errors as above."""
    once = np.ones(arm.n_joints)
    return np.minimum(coulomb_friction(arm, once), -coulomb_friction(arm, -once))


def _require_drives(arm: RobotArm) -> None:
    _ = arm.drive_inertia  # which refuses an arm without drives
    for joint, drive in zip(arm.joints, arm.drives, strict=True):
        forward, backward = drive.coulomb
        if not (drive.viscous >= 0 and forward >= 0 >= backward):
            raise ArmError(
                f"the friction of joint {joint.name} would drive it",
                where=f"arm {arm.name}, drive of joint {joint.name}",
                expected="viscous of 0 or more; coulomb of 0 or more forwards and of 0 or less backwards",
                found=f"viscous {drive.viscous:g}, coulomb {forward:g} and {backward:g}",
                next_step="check the signs in the arm file's [[drives]] table",
            )


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
        Width of the step of Coulomb friction, as in `gd_analyze.dynamics.drivetrain.drive_contributions`. A
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
