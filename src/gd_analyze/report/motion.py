"""Where the arm is along a trajectory, for drawing."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray, set_points_last
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint
from gd_analyze.schema import UNITS


def skeleton(arm: RobotArm, q: FloatArray) -> FloatArray:
    """Where the arm is at every set point of q, shape (N, n), for drawing.

    Returns
    -------
    numpy.ndarray
        Base origin, then for every joint its origin and its link frame's origin, m, shape (N, 2 n + 1, 3);
        the last is the hand.
    """
    kinematics = solve_kinematics(arm, set_points_last(q))
    points = np.zeros((len(q), 2 * arm.n_joints + 1, 3))
    for i in range(arm.n_joints):
        points[:, 2 * i + 1] = kinematics.joint_origins[i].T
        points[:, 2 * i + 2] = kinematics.link_origins[i].T
    return points


def motion_curve(trajectory: Trajectory, joint: Joint, name: str, i: int) -> FloatArray:
    """Position "q", rate "qd" or acceleration "qdd" of joint i as plots show it: angles in degrees."""
    values: FloatArray = getattr(trajectory, name)[:, i]
    return np.degrees(values) if joint.kind == "revolute" else values


def motion_unit(joint: Joint, name: str) -> str:
    """Unit of that."""
    slides, turns = UNITS[{"q": "position", "qd": "rate", "qdd": "acceleration"}[name]]
    return turns.replace("rad", "deg") if joint.kind == "revolute" else slides
