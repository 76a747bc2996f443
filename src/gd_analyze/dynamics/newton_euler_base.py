"""The recursive Newton-Euler algorithm (RNEA) with every vector in the base frame.

[FGL87] section 3.3, Table 3.2. Outward: angular velocity, angular acceleration, linear accelerations; inward:
forces, moments, torques. Inertia tensors are rotated into the base frame, which the link-frame version
avoids.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import Array, FloatArray, apply, cross, dot, rigid_acceleration, times_constant
from gd_analyze.dynamics.kinematics import Kinematics, solve_kinematics
from gd_analyze.robots.arm import RobotArm


def torque(
    arm: RobotArm,
    q: Array,
    qd: Array,
    qdd: Array,
    *,
    gravity: bool = True,
    external_wrench: FloatArray | None = None,
) -> Array:
    """Generalized torque by Newton-Euler, shape (n, N). [FGL87] Table 3.2.

    q, qd, qdd have shape (n, N). `external_wrench` is f_{n+1} and n_{n+1}, which the last link exerts on the
    world at its frame's origin, in the base frame, N and N m, shape (2, 3).
    """
    n, count = qd.shape
    kinematics = solve_kinematics(arm, q)
    omega = omega_dot = np.zeros((3, count))
    acceleration = np.broadcast_to(-int(gravity) * arm.gravity_vector[:, None], (3, count))
    forces, moments = [], []
    for i in range(n):
        z = kinematics.joint_axes[i]
        arm_vector = _link_vector(kinematics, i)
        if arm.is_revolute[i]:
            omega_dot = omega_dot + z * qdd[i] + cross(omega, z * qd[i])
            omega = omega + z * qd[i]
            along: Array | float = 0.0
        else:
            along = z * qdd[i] + 2.0 * cross(omega, z * qd[i])
        com = kinematics.com_from_joint[i]
        com_acceleration = acceleration + along + rigid_acceleration(omega, omega_dot, com)
        if arm_vector is not None:
            acceleration = acceleration + along + rigid_acceleration(omega, omega_dot, arm_vector)
        forces.append(arm.mass[i] * com_acceleration)
        rotation = kinematics.link_rotations[i]
        tensor = np.einsum("acn,dcn->adn", times_constant(rotation, arm.inertia_com[i]), rotation)  # R I R^T
        moments.append(apply(tensor, omega_dot) + cross(omega, apply(tensor, omega)))
    out = np.empty((n, count), np.result_type(qd, kinematics.joint_axes))
    force, moment = np.zeros((2, 3, 1)) if external_wrench is None else external_wrench[:, :, None]
    for i in reversed(range(n)):
        z = kinematics.joint_axes[i]
        arm_vector = _link_vector(kinematics, i)
        if arm_vector is None:
            arm_vector = kinematics.link_origins[i] - kinematics.joint_origins[i]
        moment = (
            moment + cross(arm_vector, force) + cross(kinematics.com_from_joint[i], forces[i]) + moments[i]
        )
        force = force + forces[i]
        out[i] = dot(z, moment) if arm.is_revolute[i] else dot(z, force)
    return out


def _link_vector(kinematics: Kinematics, i: int) -> Array | None:
    """p_i* from joint i's origin to the next joint's; None for the last link."""
    if i + 1 == len(kinematics.joint_axes):
        return None
    return kinematics.joint_origins[i + 1] - kinematics.joint_origins[i]
