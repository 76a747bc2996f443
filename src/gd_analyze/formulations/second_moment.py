"""Second moments of a link's matter: what the inertia tensor is to vectors, to matrices of positions."""

from __future__ import annotations

import numpy as np

from gd_analyze.robots import RobotArm
from gd_analyze.vectors import Array


def about_com(inertia_com: Array) -> Array:
    """tr(I) / 2 - I: second moment about the centre of mass from the inertia tensor about it, (3, 3)."""
    return 0.5 * np.trace(inertia_com) * np.eye(3) - inertia_com


def about_origin(arm: RobotArm, link: int) -> Array:
    """Second moment about the origin of the link's frame, along its axes: shifted by m r r^T, (3, 3)."""
    com = arm.com[link]
    return about_com(arm.inertia_com[link]) + arm.mass[link] * np.outer(com, com)
