"""Torque that actuators need beyond the links': the drives' inertia and friction, and damping.

FGL87's D, h and c are those of the links. Motors and gears add the torque that accelerates them and their
friction; neither is part of D, and both are seen at the joint here. Friction is described at the motor: seen
at the joint, its torque is |ratio| times larger, and a viscous coefficient ratio^2 times. P. Corke and B.
Armstrong-Helouvry (1994).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arguments import require_flags_of
from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.motions.states import broadcast_states
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Drive


@dataclass(frozen=True, eq=False)
class Drivetrain:
    """Properties of the drives to include, and damping at the joints."""

    inertia: bool = False  # whether the drives' inertia J adds to the diagonal of D
    friction: bool = False  # whether the drives' viscous and Coulomb friction act
    # Further viscous damping b_i at the joints, N m s (N s/m for a prismatic joint), shape (n,)
    damping: FloatArray | None = None
    # Velocity, rad/s (m/s), below which Coulomb friction fades out as tanh(qd / rest_velocity): an integrator
    # cannot step over a jump. A joint held by Coulomb friction alone creeps at a few of these
    rest_velocity: float = 1e-2

    def __post_init__(self) -> None:
        require_flags_of(self)

    def inertia_of(self, arm: RobotArm) -> FloatArray:
        """Addition to D's diagonal, shape (n,); raises ArmError if the arm describes no drives."""
        return arm.drive_inertia if self.inertia else np.zeros(arm.n_joints)

    def resistance_of(self, arm: RobotArm) -> Callable[[FloatArray], FloatArray]:
        """Resisting torque at velocities qd, shape (..., n); it never drives."""
        viscous = np.zeros(arm.n_joints)
        if self.damping is not None:
            (viscous,) = broadcast_states(arm, damping=self.damping)
            if viscous.ndim > 1 or (viscous < 0).any():
                message = "damping must oppose motion, one coefficient per joint"
                expected, coefficients = f"{arm.n_joints} numbers of 0 or more", str(viscous.tolist())
                raise UsageError(message, where="damping", expected=expected, found=coefficients)
        if not self.friction:
            return lambda qd: viscous * qd
        if not (np.isfinite(self.rest_velocity) and self.rest_velocity > 0):
            message, expected = "the rest velocity is not positive", "a positive number of rad/s (m/s)"
            raise UsageError(message, where="rest_velocity", expected=expected, found=str(self.rest_velocity))
        slope = viscous + viscous_coefficients(arm)
        return lambda qd: slope * qd + coulomb_friction(arm, qd, rest_velocity=self.rest_velocity)


NO_DRIVES = Drivetrain()


def viscous_coefficients(arm: RobotArm) -> FloatArray:
    """B_i = ratio^2 times the motor's viscous friction, N m s (N s/m of a prismatic joint), shape (n,)."""
    _require_drives(arm)
    return np.array([drive.gear_ratio**2 * drive.viscous for drive in arm.drives])


def coulomb_friction(arm: RobotArm, qd: FloatArray, *, rest_velocity: float = 0.0) -> FloatArray:
    """Coulomb friction at the joints, N m (N of a prismatic joint), shape (..., n).

    |ratio| times the motor's value for the direction in which the joint moves, and 0 at rest; a positive rest
    velocity replaces the jump by tanh(qd / rest_velocity).
    """
    _require_drives(arm)
    forward, backward = np.array([[abs(d.gear_ratio) * level for level in d.coulomb] for d in arm.drives]).T
    level = np.where(qd > 0, forward, np.where(qd < 0, -backward, 0.0))
    with np.errstate(over="ignore"):  # far beyond the rest velocity: the tanh of infinity is 1
        return level * (np.tanh(qd / rest_velocity) if rest_velocity else np.sign(qd))


def rubbing(drive: Drive, coulomb: float, viscous: float, offset: float) -> Drive:
    """The drive with friction coulomb sign(qd) + viscous qd + offset at its joint, as far as that brakes."""
    ratio = abs(drive.gear_ratio)
    levels = max(coulomb + offset, 0.0) / ratio, min(offset - coulomb, 0.0) / ratio
    return replace(drive, viscous=max(viscous, 0.0) / ratio**2, coulomb=levels)


def with_friction(arm: RobotArm, terms: FloatArray) -> RobotArm:
    """The arm with fitted friction, `Friction.terms` of shape (n, 3); a joint with a nan keeps its own.

    Terms that the log does not tell apart are not mixed with others: of a joint that moved one way only, the
    offset is Coulomb friction.
    """
    drives = arm.drives or (Drive(),) * arm.n_joints
    return replace(
        arm,
        drives=tuple(
            drive if np.isnan(fitted).any() else rubbing(drive, *fitted)
            for drive, fitted in zip(drives, terms.tolist(), strict=True)
        ),
    )


def has_friction(arm: RobotArm) -> bool:
    """Whether the arm states friction of any drive."""
    return any(drive.viscous or any(drive.coulomb) for drive in arm.drives)


def least_friction(arm: RobotArm) -> FloatArray:
    """Coulomb friction at the joints in the direction with less friction, (n,); the same ArmErrors."""
    once = np.ones(arm.n_joints)
    return np.minimum(coulomb_friction(arm, once), -coulomb_friction(arm, -once))


def _require_drives(arm: RobotArm) -> None:
    _ = arm.drive_inertia  # refuses an arm without drives
    for joint, drive in zip(arm.joints, arm.drives, strict=True):
        forward, backward = drive.coulomb
        if not (drive.viscous >= 0 and forward >= 0 >= backward):
            raise ArmError(
                f"the friction of joint {joint.name} would drive it",
                where=f"arm {arm.name}, drive of joint {joint.name}",
                expected="viscous 0 or more; coulomb 0 or more forwards and 0 or less backwards",
                found=f"viscous {drive.viscous:g}, coulomb {forward:g} and {backward:g}",
                next_step="check the signs in the arm file's [[drives]] table",
            )
