"""An arm of any number of joints with nothing special about it, to count costs on."""

from __future__ import annotations

import math
from functools import cache

import numpy as np

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import standard_placements
from gd_analyze.robots.parts import DHRow, Joint, Link

# Any seed will do: counts depend on which numbers are zero, not on their values.
_SEED = 1987


@cache
def generic_chain(n: int) -> RobotArm:
    """Arm of n revolute joints whose link frames turn by +90 and -90 degrees in turn.

    Every link has an offset, a length, a full inertia tensor and a centre of mass off every axis, and
    gravity has three components: what remains to be saved is what every Denavit-Hartenberg arm with
    right-angled twists has.

    Parameters
    ----------
    n
        Number of joints, 1 or more.
    """
    random = np.random.default_rng(_SEED)
    joints, links = [], []
    for i in range(n):
        before, behind = standard_placements(
            "revolute", DHRow(0.0, 0.2 + 0.01 * i, 0.3 + 0.01 * i, (-1) ** i * math.pi / 2)
        )
        root = random.normal(scale=0.1, size=(3, 3))
        second = root @ root.T
        inertia = np.trace(second) * np.eye(3) - 0.5 * (second + second.T)
        joints.append(Joint(str(i + 1), placement=before))
        links.append(Link(str(i + 1), 1.0 + 0.1 * i, random.uniform(-0.1, 0.1, 3), inertia, behind))
    return RobotArm(
        f"chain{n}",
        tuple(joints),
        tuple(links),
        gravity=np.array([1.0, 2.0, -9.5]),
        title=f"Generic chain of {n} joints",
    )
