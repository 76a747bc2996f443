"""Axes, origins and centres of mass in the base frame at every set point, and energies.

The energies use no element of D, h or c, so that formulations can be checked against them.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gd_analyze.arrays import Array, FloatArray, cross, dot, set_points_last, turn_about
from gd_analyze.motions.states import broadcast_states
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True)
class Kinematics:
    """Base-frame vectors of an arm, set points last (N); names as in the notation table."""

    joint_axes: Array  # z_{i-1}, shape (n, 3, N)
    joint_origins: Array  # p_{i-1}, a point on each joint's axis, m, shape (n, 3, N)
    link_rotations: Array  # base from link frame s, the transpose of sR0, shape (n, 3, 3, N)
    link_origins: Array  # p_s, origin of each link frame, m, shape (n, 3, N)
    com_from_joint: Array  # c_s, centre of mass of link s from p_{s-1}, m, shape (n, 3, N)

    @property
    def com_positions(self) -> Array:
        """r_s, centre of mass of link s from the base origin, m, shape (n, 3, N)."""
        return self.joint_origins + self.com_from_joint


def joint_motions(arm: RobotArm, kinematics: Kinematics) -> tuple[Array, Array]:
    """w_i and u_i of every joint, shape (n, 3, N): z_{i-1} if it turns or slides, respectively, else zero."""
    revolute = np.array(arm.is_revolute, dtype=float)[:, None, None]
    return kinematics.joint_axes * revolute, kinematics.joint_axes * (1.0 - revolute)


def solve_kinematics(arm: RobotArm, q: Array) -> Kinematics:
    """Forward kinematics of every joint and link at q, shape (n, N)."""
    n, count = arm.n_joints, q.shape[-1]
    cos_q, sin_q = np.cos(q), np.sin(q)
    dtype = np.result_type(q, float)
    axes, origins, link_origins, com_from_joint = (np.empty((n, 3, count), dtype) for _ in range(4))
    rotations = np.empty((n, 3, 3, count), dtype)

    rotation: Array = np.broadcast_to(np.eye(3).astype(dtype)[:, :, None], (3, 3, count))
    origin: Array = np.zeros((3, count))
    for i, (to_joint, joint_columns, axis, to_link, link_columns, to_com) in enumerate(_constants(arm)):
        origins[i] = origin + _along(rotation, to_joint)
        before = _turned(rotation, joint_columns)
        axes[i] = _along(before, axis)
        if arm.is_revolute[i]:
            moved = _rotate_about(before, arm.joints[i].axis, cos_q[i], sin_q[i])
            com_from_joint[i] = _along(moved, to_link)
        else:
            moved = before
            com_from_joint[i] = axes[i] * q[i] + _along(moved, to_link)
        np.add(origins[i], com_from_joint[i], out=link_origins[i])
        rotations[i] = _turned(moved, link_columns)
        com_from_joint[i] += _along(rotations[i], to_com)
        rotation, origin = rotations[i], link_origins[i]
    return Kinematics(axes, origins, rotations, link_origins, com_from_joint)


# A constant vector as its non-zero components, and a constant rotation by its columns (None for no rotation):
# most are zeros and ones, which must neither take time nor leave arithmetic in a trace.
_Sparse = tuple[tuple[int, float], ...]
_Columns = tuple[_Sparse, ...] | None


@lru_cache(maxsize=64)
def _constants(arm: RobotArm) -> list[tuple[_Sparse, _Columns, _Sparse, _Sparse, _Columns, _Sparse]]:
    """Constants to each joint's frame and axis, and on to the link's frame and its centre of mass."""

    def sparse(vector: Array) -> _Sparse:
        values = vector.tolist()
        return tuple((int(b), values[b]) for b in np.flatnonzero(vector))

    def columns(rotation: Array) -> _Columns:
        return None if np.array_equal(rotation, np.eye(3)) else tuple(sparse(column) for column in rotation.T)

    return [
        (
            sparse(joint.placement.translation),
            columns(joint.placement.rotation),
            sparse(joint.axis),
            sparse(link.frame.translation),
            columns(link.frame.rotation),
            sparse(link.com),
        )
        for joint, link in zip(arm.joints, arm.links, strict=True)
    ]


def _along(rotation: Array, constant: _Sparse) -> Array:
    """Turn a constant vector into the base frame."""
    terms = [rotation[:, b] if value == 1.0 else rotation[:, b] * value for b, value in constant]
    return sum(terms[1:], start=terms[0]) if terms else np.zeros((3, 1))


def _turned(rotation: Array, columns: _Columns) -> Array:
    """Compose with a constant rotation, given by its columns."""
    if columns is None:
        return rotation
    turned = np.empty(rotation.shape, rotation.dtype)
    for b, column in enumerate(columns):
        turned[:, b] = _along(rotation, column)
    return turned


def _rotate_about(rotation: Array, axis: Array, cos_q: Array, sin_q: Array) -> Array:
    """Compose with a turn about a constant axis."""
    turned = np.empty(rotation.shape, np.result_type(rotation, cos_q))
    if np.array_equal(axis, (0.0, 0.0, 1.0)):
        np.multiply(rotation[:, :2], cos_q, out=turned[:, :2])
        turned[:, 0] += rotation[:, 1] * sin_q
        turned[:, 1] -= rotation[:, 0] * sin_q
        turned[:, 2] = rotation[:, 2]
        return turned
    return np.einsum("acn,cbn->abn", rotation, turn_about(axis, cos_q, sin_q), out=turned)


def kinetic_energy(arm: RobotArm, q: FloatArray, qd: FloatArray, *, drives: bool = False) -> FloatArray:
    """Kinetic energy, J, (...), of states (..., n): sum_s (m_s v_s . v_s + w_s . I_s w_s) / 2.

    `drives` adds sum_i J_i qd_i^2 / 2; each drive turns with its own joint only, as the rotor's motion with
    the link that carries it belongs to that link.
    """
    q, qd = broadcast_states(arm, q=q, qd=qd)
    states, velocities = set_points_last(q), set_points_last(qd)
    kinematics = solve_kinematics(arm, states)
    count = states.shape[-1]
    omega, velocity, out = np.zeros((3, count)), np.zeros((3, count)), np.zeros(count)
    origin = kinematics.joint_origins[0]
    for s in range(arm.n_joints):
        # The next joint's origin moves with this link.
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
    return out.reshape(q.shape[:-1])


def potential_energy(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Potential energy in gravity, J, (...): - sum_s m_s g . r_s, zero for a mass at the base's origin."""
    (q,) = broadcast_states(arm, q=q)
    com = solve_kinematics(arm, set_points_last(q)).com_positions
    return -np.einsum("s,a,san->n", arm.mass, arm.gravity_vector, com).reshape(q.shape[:-1])
