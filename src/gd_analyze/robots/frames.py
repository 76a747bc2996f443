"""Rotations, exact at right angles, and Denavit-Hartenberg rows, standard (FGL87) and modified (Craig)."""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.parts import DHRow, JointKind, Placement


def exact_cos_sin(angle: float) -> tuple[float, float]:
    """Cosine and sine with exact zeros and ones at multiples of a right angle.

    cos(pi/2) in floating point is 6e-17, which would turn structural zeros of the dynamics into noise.
    """
    quarter_turns = angle / (math.pi / 2)
    nearest = round(quarter_turns)
    if abs(quarter_turns - nearest) <= 4 * np.finfo(float).eps * max(1.0, abs(quarter_turns)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[nearest % 4]
    return math.cos(angle), math.sin(angle)


def _about(axis: int, angle: float) -> FloatArray:
    """Rotation about x (0), y (1) or z (2)."""
    turn, j, k = np.eye(3), (axis + 1) % 3, (axis + 2) % 3
    cosine, sine = exact_cos_sin(angle)
    turn[j, j] = turn[k, k] = cosine
    turn[k, j], turn[j, k] = sine, -sine
    return turn


def roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Rotation about x, then y, then z of the fixed frame, as in URDF; no negative zeros."""
    return _about(2, yaw) @ _about(1, pitch) @ _about(0, roll) + 0.0


def angles_of(rotation: FloatArray) -> tuple[float, float, float]:
    """Roll, pitch and yaw of a rotation, rad, to round-off; pitch within a quarter turn."""
    cosine = math.hypot(rotation[0, 0], rotation[1, 0])
    pitch = math.atan2(-rotation[2, 0], cosine)
    if cosine < 1e-9:  # roll and yaw turn about one axis then
        return math.atan2(-rotation[1, 2], rotation[1, 1]), pitch, 0.0
    roll, yaw = math.atan2(rotation[2, 1], rotation[2, 2]), math.atan2(rotation[1, 0], rotation[0, 0])
    return roll, pitch, yaw


def standard_placements(kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame of A_i = Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha).

    The constant part of the joint's own motion commutes with it and is put behind it, so that the joint
    frame's origin stays FGL87's p_{i-1}; a prismatic joint's theta turns the frame. [FGL87] Eq. (3.2-5).
    """
    behind = Placement(_about(0, row.alpha), np.array([row.a, 0.0, row.d]))
    turn = _about(2, row.theta)
    if kind == "prismatic":
        return Placement(turn), behind
    return Placement(), Placement(turn @ behind.rotation, turn @ behind.translation)


def modified_placements(kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame of Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d)."""
    before = Placement(_about(0, row.alpha), np.array([row.a, 0.0, 0.0]))
    return before, Placement(_about(2, row.theta), np.array([0.0, 0.0, row.d]))


# By the word of an arm file: the convention's name, and the two placements of a row.
CONVENTIONS = {
    "standard": ("standard Denavit-Hartenberg", standard_placements),
    "modified": ("modified Denavit-Hartenberg", modified_placements),
}
