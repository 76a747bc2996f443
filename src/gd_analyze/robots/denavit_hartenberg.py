"""Denavit-Hartenberg tables into placements, standard (FGL87's) and modified (Craig's)."""

from __future__ import annotations

import numpy as np

from gd_analyze.robots.parts import DHRow, JointKind, Placement
from gd_analyze.robots.turns import about_x, about_z


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


# By the word of an arm file, what the convention is called.
CONVENTIONS = {name: f"{name} Denavit-Hartenberg" for name in ("standard", "modified")}


def placements_of(convention: str, kind: JointKind, row: DHRow) -> tuple[Placement, Placement]:
    """Joint placement and link frame by the convention that an arm file names."""
    return (standard_placements if convention == "standard" else modified_placements)(kind, row)
