"""Arms with runs of parallel axes, across sliding joints, too."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

import published_arms
from gd_analyze.types import Joint, Link, Placement, RobotArm
from strategies import explicitly, random_inertia, random_rotation

# How a joint may stand to the one before.
TURNS = ("same", "opposite", "askew", "slides", "slides along", "slides across")


def of_every_turn(*, states: int = 0, **others: Any) -> Callable[[Any], Any]:
    """Two arms that have every turn between them, beside those drawn; `others` are further arguments.

    The argument is `arm`, or with a number of states `case`, the arm and states.
    """
    rng = np.random.default_rng(7)
    chains = (["same", "opposite", "askew", "same"], ["slides", "slides along", "same", "slides across"])
    return explicitly([arm_of(list(turns), rng) for turns in chains], states=states, **others)


@st.composite
def arms_with_runs(draw: st.DrawFn, max_joints: int = 6) -> RobotArm:
    """Arms whose axes often are parallel, the same way or opposite, across sliding joints, too."""
    turns = draw(
        st.lists(
            st.sampled_from(TURNS),
            min_size=1,
            max_size=max_joints,
        )
    )
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return arm_of(turns, rng)


def arm_of(turns: list[str], rng: np.random.Generator) -> RobotArm:
    """Joint i stands to the one before as turns[i] says; the first to the base.

    What slides turns the next joint only where it stands askew itself: plainly "slides".
    """
    joints, links = [], []
    for i, turn in enumerate(turns):
        kind = "prismatic" if turn.startswith("slides") else "revolute"
        rotation = (
            np.diag([1.0, -1.0, -1.0])
            if turn == "opposite"
            else None
            if turn in ("askew", "slides")
            else np.eye(3)
        )
        before = Placement(random_rotation(rng) if rotation is None else rotation, rng.uniform(-0.5, 0.5, 3))
        # About z, or it would not leave the next axis parallel.
        angle = rng.uniform(-np.pi, np.pi)
        c, s = np.cos(angle), np.sin(angle)
        behind = Placement(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), rng.uniform(-0.5, 0.5, 3))
        axis = np.array([0.6, 0.0, 0.8] if turn == "slides across" else [0.0, 0.0, 1.0])
        joints.append(Joint(f"{i + 1}", kind, before, axis))
        com = rng.uniform(-0.05, 0.05, 3)
        links.append(Link(f"{i + 1}", rng.uniform(0.5, 3.0), com, random_inertia(rng), behind))
    return RobotArm("drawn", tuple(joints), tuple(links), rng.uniform(-10, 10, 3))


def scara() -> RobotArm:
    """Fanuc SR-6iA, Lloyd et al. 2021, Table 1: two turns, a slide, and a roll whose axis is opposite."""
    arm = published_arms.arm_of("SCARA")
    return replace(arm, joints=tuple(Joint(joint.name, joint.kind) for joint in arm.joints))
