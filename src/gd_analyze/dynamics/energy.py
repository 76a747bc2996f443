"""Kinetic and potential energy, link by link from velocities and heights.

No element of D, h or c is used: what the formulations say about energy can be held against this.
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray, cross, dot, set_points_last
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.motions.states import checked_states
from gd_analyze.robots.arm import RobotArm


def kinetic_energy(arm: RobotArm, q: FloatArray, qd: FloatArray, *, drives: bool = False) -> FloatArray:
    """Kinetic energy, J, (...), of states (..., n): sum_s (m_s v_s . v_s + w_s . I_s w_s) / 2.

    `drives` adds sum_i J_i qd_i^2 / 2; each drive turns with its own joint only: what its rotor has because
    the link under it turns is part of that link.
    """
    leading, (q, qd) = checked_states(arm, q=q, qd=qd)
    states, velocities = set_points_last(q), set_points_last(qd)
    kinematics = solve_kinematics(arm, states)
    count = states.shape[-1]
    omega, velocity, out = np.zeros((3, count)), np.zeros((3, count)), np.zeros(count)
    origin = kinematics.joint_origins[0]
    for s in range(arm.n_joints):
        # The next joint's origin moves with the link before it.
        velocity = velocity + cross(omega, kinematics.joint_origins[s] - origin)
        origin = kinematics.joint_origins[s]
        motion = kinematics.joint_axes[s] * velocities[s]
        if arm.is_revolute[s]:
            omega = omega + motion
        else:
            velocity = velocity + motion
        of_com = velocity + cross(omega, kinematics.com_from_joint[s])
        in_link = np.einsum("abn,an->bn", kinematics.link_rotations[s], omega)
        out += 0.5 * arm.mass[s] * dot(of_com, of_com)
        out += 0.5 * np.einsum("an,ab,bn->n", in_link, arm.inertia_com[s], in_link)
    if drives:
        out += 0.5 * np.einsum("i,in->n", arm.drive_inertia, velocities**2)
    return out.reshape(leading)


def potential_energy(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Potential energy in gravity, J, (...): - sum_s m_s g . r_s, zero for a mass at the base's origin."""
    leading, (q,) = checked_states(arm, q=q)
    com = solve_kinematics(arm, set_points_last(q)).com_positions
    return -np.einsum("s,a,san->n", arm.mass, arm.gravity, com).reshape(leading)
