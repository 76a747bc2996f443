"""Torque as what it is linear in: ten inertial parameters of every link.

They are a link's mass m, its first moment m r and the inertia about the origin of its frame, (xx, xy, yy, xz,
yz, zz), all along the axes of that frame. In that frame a link that moves with angular velocity w, angular
acceleration w' and acceleration a of its origin (gravity included) needs

    force     m a + (w' x + w x w x) m r
    moment    m r x a + I w' + w x I w

about its origin, and both are carried to the joints below by the power they do there. C. G. Atkeson,
C. H. An, J. M. Hollerbach (1986).
"""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import Array, FloatArray, apply, cross, outer, rigid_acceleration
from gd_analyze.dynamics.kinematics import joint_motions, solve_kinematics
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import of_point_mass

# Entries of a symmetric tensor in the order of the parameters.
_ENTRIES = ((0, 0), (0, 1), (1, 1), (0, 2), (1, 2), (2, 2))
_TENSORS = np.zeros((6, 3, 3))
for _k, (_a, _b) in enumerate(_ENTRIES):
    _TENSORS[_k, _a, _b] = _TENSORS[_k, _b, _a] = 1.0

PARAMETERS = ("m", "mx", "my", "mz", "Ixx", "Ixy", "Iyy", "Ixz", "Iyz", "Izz")


def inertial_parameters(mass: float, first_moment: FloatArray, inertia: FloatArray) -> FloatArray:
    """Put m, m r and the inertia about the frame's origin into the order of `PARAMETERS`, shape (10,)."""
    return np.array([mass, *first_moment, *(inertia[entry] for entry in _ENTRIES)])


def parameters_of(arm: RobotArm) -> FloatArray:
    """Parameters of every link of an arm, shape (n links, 10)."""
    return np.array(
        [
            inertial_parameters(mass, mass * com, inertia + of_point_mass(mass, com))
            for mass, com, inertia in zip(arm.mass, arm.com, arm.inertia_com, strict=True)
        ]
    )


def regressor(arm: RobotArm, q: Array, qd: Array, qdd: Array) -> FloatArray:
    """Torque of every joint per unit of every parameter; times `parameters_of` and summed it is the torque.

    N m (N for a prismatic joint) per unit of each of `PARAMETERS`, shape (n joints, n links, 10, N): zero for
    joints behind the link. Of the links only the frames matter.
    """
    n, count = q.shape
    kinematics = solve_kinematics(arm, q)
    revolute, prismatic = joint_motions(arm, kinematics)
    out = np.zeros((n, n, len(PARAMETERS), count))
    omega = omega_dot = np.zeros((3, count))
    acceleration = -arm.gravity[:, None]
    frame_below = np.zeros((3, 1))
    for s in range(n):
        # [FGL87] Table 3.2, but for the frames' origins in place of the centres of mass.
        axis, origin = kinematics.joint_axes[s], kinematics.joint_origins[s]
        acceleration = acceleration + rigid_acceleration(omega, omega_dot, origin - frame_below)
        if arm.is_revolute[s]:
            omega_dot = omega_dot + axis * qdd[s] + cross(omega, axis * qd[s])
            omega = omega + axis * qd[s]
        else:
            acceleration = acceleration + axis * qdd[s] + 2.0 * cross(omega, axis * qd[s])
        frame_below = kinematics.link_origins[s]
        acceleration = acceleration + rigid_acceleration(omega, omega_dot, frame_below - origin)
        into_frame = np.swapaxes(kinematics.link_rotations[s], 0, 1)
        force, moment = _wrench(*(apply(into_frame, vector) for vector in (omega, omega_dot, acceleration)))
        # What each joint's unit velocity makes of the frame: its turning and its origin's velocity.
        lever = frame_below - kinematics.joint_origins[: s + 1]
        velocity = cross(revolute[: s + 1], lever) + prismatic[: s + 1]
        out[: s + 1, s] = np.einsum("ian,pan->ipn", apply(into_frame, revolute[: s + 1]), moment)
        out[: s + 1, s, :4] += np.einsum("ian,pan->ipn", apply(into_frame, velocity), force)
    return out


def _wrench(omega: Array, omega_dot: Array, acceleration: Array) -> tuple[Array, Array]:
    """Force of the first four parameters (4, 3, N) and moment of all (10, 3, N), in the link frame."""
    count = omega.shape[-1]
    turning = outer(omega, omega)
    speed = np.einsum("an,an->n", omega, omega)
    for a, b, c in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        turning[a, a] -= speed
        turning[a, b] -= omega_dot[c]
        turning[b, a] += omega_dot[c]
    force = np.concatenate([acceleration[None], np.swapaxes(turning, 0, 1)])
    spin = np.einsum("pab,bn->pan", _TENSORS, omega)
    of_inertia = np.einsum("pab,bn->pan", _TENSORS, omega_dot) + cross(omega, spin)
    of_first = cross(np.eye(3)[:, :, None], acceleration)
    return force, np.concatenate([np.zeros((1, 3, count)), of_first, of_inertia])
