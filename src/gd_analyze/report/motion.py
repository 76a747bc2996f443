"""Where the arm is along a trajectory, for drawing."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from gd_analyze.kinematics import solve_kinematics
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray, set_points_last


@dataclass(frozen=True, eq=False)
class Motion:
    """Where the arm is along the trajectory, for drawing; m.

    Parameters
    ----------
    points
        Base origin, then for every joint its origin and its link frame's origin, shape (N, 2 n + 1, 3).
    hand
        Origin of the last link frame, shape (N, 3).
    """

    points: FloatArray
    hand: FloatArray


def motion(arm: RobotArm, q: FloatArray) -> Motion:
    """Skeleton of the arm at every set point of q, shape (N, n)."""
    kinematics = solve_kinematics(arm, set_points_last(q))
    count = len(q)
    points = np.zeros((count, 2 * arm.n_joints + 1, 3))
    for i in range(arm.n_joints):
        points[:, 2 * i + 1] = kinematics.joint_origins[i].T
        points[:, 2 * i + 2] = kinematics.link_origins[i].T
    return Motion(points, points[:, -1])
