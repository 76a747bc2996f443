"""Small arms and a motion that reports are tried on."""

from __future__ import annotations

import numpy as np

from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

ONE_JOINT = """
format = "gd-analyze arm 1"
name = "pendulum"
gravity = [0.0, -9.81, 0.0]
[[joints]]
name = "pivot"
a = 0.8
[[links]]
name = "rod"
mass = 1.5
com = [-0.4, 0.0, 0.0]
inertia = { xx = 0.0, yy = 0.08, zz = 0.08 }
"""

SLIDING = """
format = "gd-analyze arm 1"
name = "gantry"
title = "Turning gantry"
[[joints]]
name = "column"
alpha_deg = -90.0
[[joints]]
name = "lift"
kind = "prismatic"
d = 0.2
alpha_deg = 90.0
[[joints]]
name = "reach"
kind = "prismatic"
range = [0.0, 0.9]
[[links]]
name = "1"
mass = 3.0
com = [0.0, 0.1, 0.0]
inertia = { xx = 0.02, yy = 0.02, zz = 0.01 }
[[links]]
name = "2"
mass = 2.0
com = [0.1, 0.0, 0.0]
inertia = { xx = 0.01, yy = 0.02, zz = 0.02 }
[[links]]
name = "3"
mass = 1.0
com = [0.0, 0.05, -0.2]
inertia = { xx = 0.01, yy = 0.01, zz = 0.002 }
"""


def swing(arm: RobotArm, count: int = 21) -> Trajectory:
    """All joints swing, each with its own phase, with the exact velocities."""
    time = np.linspace(0.0, 2.0, count) if count > 1 else np.zeros(1)
    phase = 0.3 + 0.7 * np.arange(arm.n_joints)
    angle = 2.0 * time[:, None] + phase
    return Trajectory(
        time, 0.4 * np.sin(angle), 0.8 * np.cos(angle), -1.6 * np.sin(angle), "swing", "made here"
    )
