"""Findings at the edges of what a report must show."""

from __future__ import annotations

import numpy as np

from few_tries import few_tries
from gd_analyze import Trajectory
from gd_analyze.robots.parts import JointKind
from gd_analyze.studies.main_job import find
from gd_analyze.types import Findings, Joint, Link, Placement, RobotArm, Settings
from strategies import random_inertia

HOSTILE = '#strong[x] $x^2$ "quoted" <script>alert(1)</script> *b* = @ref \\n'


def made_arm(kinds: list[JointKind], title: str = "made up") -> RobotArm:
    rng = np.random.default_rng(7)
    turned = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
    return RobotArm(
        "made_up",
        tuple(Joint(f"joint {i}", kind) for i, kind in enumerate(kinds)),
        tuple(
            Link(
                f"link {i}",
                rng.uniform(0.5, 3.0),
                rng.uniform(-0.1, 0.1, 3),
                random_inertia(rng),
                Placement(turned if i % 2 else np.eye(3), rng.uniform(0.1, 0.4, 3)),
            )
            for i in range(len(kinds))
        ),
        title=title,
    )


@few_tries()
def made_findings(
    kinds: list[JointKind], set_points: int = 9, title: str = "made up", level: str = "term"
) -> Findings:
    arm = made_arm(kinds, title)
    time = np.linspace(0.0, 2.0, set_points) if set_points > 1 else np.zeros(1)
    phase = 2 * time[:, None] + np.arange(len(kinds))
    motion = Trajectory(time, np.sin(phase), 2 * np.cos(phase), -4 * np.sin(phase), "wave")
    return find(arm, motion, Settings(level=level), command="gd-analyze made_up wave")
