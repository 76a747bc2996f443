"""Arms for logs: what matters of them is how their joints are called."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from gd_analyze.types import Joint, Link, RobotArm

UR = (
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
)


def arm_of(*names: str, kinds: Sequence[str] = (), name: str = "made") -> RobotArm:
    """An arm whose joints are called so; without limits, so that nothing is suspicious."""
    of_kind = kinds or ["revolute"] * len(names)
    joints = tuple(Joint(name, kind=kind) for name, kind in zip(names, of_kind, strict=True))
    return RobotArm(name, joints, tuple(Link(name, 1.0, np.zeros(3), 0.1 * np.eye(3)) for name in names))


def log_of(names: str, time: str = "time", at: Sequence[object] = (0.0, 0.1)) -> str:
    """A log in which column k of these holds k, from 0."""
    values = ",".join(str(k) for k in range(len(names.split())))
    return "\n".join([",".join([time, *names.split()]), *(f"{instant},{values}" for instant in at), ""])
