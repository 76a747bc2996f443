"""A chain of joints with nothing left to save but its right-angled twists."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from gd_analyze.robots.frames import standard_placements
from gd_analyze.types import DHRow, Joint, Link, RobotArm


@cache
def generic_chain(n: int) -> RobotArm:
    """Arm of n revolute joints whose link frames turn by +90 and -90 degrees in turn.

    Every link has an offset, a length, a full inertia tensor and a centre of mass off every axis, and
    gravity has three components: what remains to be saved is what every Denavit-Hartenberg arm with
    right-angled twists has.
    """
    # Any seed will do: counts depend on which numbers are zero, not on their values.
    random = np.random.default_rng(1987)
    joints, links = [], []
    for i in range(n):
        row = DHRow(0.0, 0.2 + 0.01 * i, 0.3 + 0.01 * i, (-1) ** i * math.pi / 2)
        before, behind = standard_placements("revolute", row)
        root = random.normal(scale=0.1, size=(3, 3))
        second = root @ root.T
        inertia = np.trace(second) * np.eye(3) - 0.5 * (second + second.T)
        joints.append(Joint(str(i + 1), placement=before))
        links.append(Link(str(i + 1), 1.0 + 0.1 * i, random.uniform(-0.1, 0.1, 3), inertia, behind))
    gravity, title = np.array([1.0, 2.0, -9.5]), f"Generic chain of {n} joints"
    return RobotArm(f"chain{n}", tuple(joints), tuple(links), gravity_vector=gravity, title=title)
