"""Rotations, exact at right angles, and Denavit-Hartenberg rows, standard (FGL87) and modified (Craig)."""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.robots.parts import DHRow, JointKind, Placement

# By the word of an arm file, the name of the convention.
CONVENTIONS = {name: f"{name} Denavit-Hartenberg" for name in ("standard", "modified")}


def exact_cos_sin(angle: float) -> tuple[float, float]:
    """Cosine and sine with exact zeros and ones at multiples of a right angle.

    cos(pi/2) in floating point is 6e-17, which would turn structural zeros of the dynamics into noise.
    """
    quarter_turns = angle / (math.pi / 2)
    nearest = round(quarter_turns)
    if abs(quarter_turns - nearest) <= 4 * np.finfo(float).eps * max(1.0, abs(quarter_turns)):
        return ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[nearest % 4]
    return math.cos(angle), math.sin(angle)


def about_x(angle: float) -> FloatArray:
    """Rotation about x."""
    c, s = exact_cos_sin(angle)
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_y(angle: float) -> FloatArray:
    """Rotation about y."""
    c, s = exact_cos_sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def about_z(angle: float) -> FloatArray:
    """Rotation about z."""
    c, s = exact_cos_sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def roll_pitch_yaw(roll: float, pitch: float, yaw: float) -> FloatArray:
    """Rotation about x, then y, then z of the fixed frame, as in URDF; no negative zeros."""
    return about_z(yaw) @ about_y(pitch) @ about_x(roll) + 0.0


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

    The constant part of the joint's own motion (theta for a revolute, d for a prismatic joint) commutes
    with the motion and is put behind it, so that the joint frame's origin stays FGL87's p_{i-1}; a
    prismatic joint's constant theta turns the joint frame. [FGL87] Eq. (3.2-5).
    """
    behind = Placement(about_x(row.alpha), np.array([row.a, 0.0, row.d]))
    turn = about_z(row.theta)
    if kind == "prismatic":
        return Placement(turn), behind
    return Placement(), Placement(turn @ behind.rotation, turn @ behind.translation)


def modified_placements(kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame of Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d).

    Here alpha and a lead to the joint's axis, so the joint frame's origin lies on it.
    """
    before = Placement(about_x(row.alpha), np.array([row.a, 0.0, 0.0]))
    return before, Placement(about_z(row.theta), np.array([0.0, 0.0, row.d]))


def placements_of(convention: str, kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame by the convention that an arm file names."""
    return (standard_placements if convention == "standard" else modified_placements)(kind, row)
