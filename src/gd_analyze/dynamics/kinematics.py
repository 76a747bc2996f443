"""Where every axis, origin and centre of mass is, in the base frame, at every set point."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from gd_analyze.arrays import Array, turn_about
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
    """w_i and u_i of every joint, shape (n, 3, N): z_{i-1} as it turns, or slides, and zero otherwise."""
    revolute = np.array(arm.is_revolute, dtype=float)[:, None, None]
    return kinematics.joint_axes * revolute, kinematics.joint_axes * (1.0 - revolute)


def solve_kinematics(arm: RobotArm, q: Array) -> Kinematics:
    """Forward kinematics of every joint and link at q, shape (n, N)."""
    n, count = arm.n_joints, q.shape[-1]
    cos_q, sin_q = np.cos(q), np.sin(q)
    dtype = np.result_type(q, float)
    axes, origins, link_origins, com_from_joint = (np.empty((n, 3, count), dtype) for _ in range(4))
    rotations = np.empty((n, 3, 3, count), dtype)

    rotation: Array = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, count))
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
# most have zeros and ones only, and what is absent shall neither take time nor leave arithmetic in a trace.
_Sparse = tuple[tuple[int, float], ...]
_Columns = tuple[_Sparse, ...] | None


@lru_cache(maxsize=64)
def _constants(arm: RobotArm) -> list[tuple[_Sparse, _Columns, _Sparse, _Sparse, _Columns, _Sparse]]:
    """To each joint's frame and its axis, from there to the link's frame and its centre of mass."""

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
