"""Denavit-Hartenberg tables into placements, standard (FGL87's) and modified (Craig's)."""

from __future__ import annotations

import math

import numpy as np

from gd_analyze.robots.parts import DHRow, JointKind, Placement
from gd_analyze.vectors import FloatArray


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


def about_z(angle: float) -> FloatArray:
    """Rotation about z."""
    c, s = exact_cos_sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def standard_placements(kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame of A_i = Rot_z(theta) Trans_z(d) Trans_x(a) Rot_x(alpha).

    The constant part of the joint's own motion (theta for a revolute, d for a prismatic joint) commutes
    with the motion and is put behind it, so that the joint frame's origin stays FGL87's p_{i-1}; a
    prismatic joint's constant theta turns the joint frame. [FGL87] Eq. (3.2-5).
    """
    behind = Placement(about_x(row.alpha), np.array([row.a, 0.0, row.d]))
    if kind == "prismatic":
        return Placement(about_z(row.theta)), behind
    turn = about_z(row.theta)
    return Placement(), Placement(turn @ behind.rotation, turn @ behind.translation)


def modified_placements(kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame of Rot_x(alpha) Trans_x(a) Rot_z(theta) Trans_z(d).

    Here alpha and a lead to the joint's axis, so the joint frame's origin lies on it.
    """
    before = Placement(about_x(row.alpha), np.array([row.a, 0.0, 0.0]))
    turn = about_z(row.theta)
    return before, Placement(turn, np.array([0.0, 0.0, row.d]))
