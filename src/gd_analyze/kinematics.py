"""Where every axis, origin and centre of mass is, in the base frame, at every set point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from gd_analyze.robots import RobotArm
from gd_analyze.vectors import Array


@dataclass(frozen=True)
class Kinematics:
    """Base-frame vectors of an arm, set points last (N); names as in the notation table.

    Parameters
    ----------
    joint_axes
        z_{i-1}, shape (n, 3, N).
    joint_origins
        p_{i-1}, a point on each joint's axis, m, shape (n, 3, N).
    link_rotations
        Base from link frame s, the transpose of sR0, shape (n, 3, 3, N).
    link_origins
        p_s, origin of each link frame, m, shape (n, 3, N).
    com_from_joint
        c_s, centre of mass of link s from p_{s-1}, m, shape (n, 3, N).
    """

    joint_axes: Array
    joint_origins: Array
    link_rotations: Array
    link_origins: Array
    com_from_joint: Array

    @property
    def com_positions(self) -> Array:
        """r_s, centre of mass of link s from the base origin, m, shape (n, 3, N)."""
        return self.joint_origins + self.com_from_joint


def solve_kinematics(
    arm: RobotArm,
    q: Array,
    cos: Callable[[Array], Array] = np.cos,
    sin: Callable[[Array], Array] = np.sin,
) -> Kinematics:
    """Forward kinematics of every joint and link.

    Parameters
    ----------
    arm
        The arm.
    q
        Joint variables, set points last, shape (n, N).
    cos, sin
        Elementwise functions of an array; replaced when q holds something other than numbers.
    """
    n, count = arm.n_joints, q.shape[-1]
    cos_q, sin_q = cos(q), sin(q)
    dtype = np.result_type(q, float)
    axes, origins, link_origins, com_from_joint = (np.empty((n, 3, count), dtype) for _ in range(4))
    rotations = np.empty((n, 3, 3, count), dtype)

    rotation: Array = np.broadcast_to(np.eye(3)[:, :, None], (3, 3, count))
    origin: Array = np.zeros((3, count))
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True)):
        origins[i] = origin + _along(rotation, joint.placement.translation)
        joint_rotation = _turned(rotation, joint.placement.rotation)
        axes[i] = _along(joint_rotation, joint.axis)
        if joint.kind == "revolute":
            joint_rotation = _rotate_about(joint_rotation, joint.axis, cos_q[i], sin_q[i])
            slid = origins[i]
        else:
            slid = origins[i] + axes[i] * q[i]
        link_origins[i] = slid + _along(joint_rotation, link.frame.translation)
        rotations[i] = _turned(joint_rotation, link.frame.rotation)
        com_from_joint[i] = (link_origins[i] - origins[i]) + _along(rotations[i], link.com)
        rotation, origin = rotations[i], link_origins[i]
    return Kinematics(axes, origins, rotations, link_origins, com_from_joint)


def _along(rotation: Array, constant: Array) -> Array:
    """Turn a constant vector into the base frame; absent and unit components cost no product."""
    terms = [
        rotation[:, b] if constant[b] == 1.0 else rotation[:, b] * constant[b]
        for b in np.flatnonzero(constant)
    ]
    return sum(terms[1:], start=terms[0]) if terms else np.zeros((3, 1))


def _turned(rotation: Array, constant: Array) -> Array:
    """Compose with a constant rotation; most placements have zeros and ones only."""
    if np.array_equal(constant, np.eye(3)):
        return rotation
    return np.stack([_along(rotation, constant[:, b]) for b in range(3)], axis=1)


def _rotate_about(rotation: Array, axis: Array, cos_q: Array, sin_q: Array) -> Array:
    """Compose with a turn about a constant axis."""
    if np.array_equal(axis, (0.0, 0.0, 1.0)):
        x, y, z = rotation[:, 0], rotation[:, 1], rotation[:, 2]
        return np.stack([x * cos_q + y * sin_q, y * cos_q - x * sin_q, z], axis=1)
    ux, uy, uz = axis
    skew = np.array([[0.0, -uz, uy], [uz, 0.0, -ux], [-uy, ux, 0.0]])
    turn = np.eye(3)[:, :, None] + skew[:, :, None] * sin_q + (skew @ skew)[:, :, None] * (1.0 - cos_q)
    return np.einsum("acn,cbn->abn", rotation, turn)
