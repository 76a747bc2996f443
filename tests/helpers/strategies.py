"""Hypothesis strategies: arms of every make, and states for them.

Hypothesis chooses the structure, which is what breaks code: how many joints, of which kind, axes along z or
askew, plain or general placements, massless links. The numbers inside come from a seed it chooses as well.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import example, settings
from hypothesis import strategies as st

from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.types import Joint, Link, Placement, RobotArm, States

PROFILE = "gd-analyze"
settings.register_profile(PROFILE, derandomize=True, deadline=None, database=None, print_blob=True)


# With this variable `.ci/long` asks for all examples; otherwise a quarter is drawn, but at least so many.
ALL_EXAMPLES = "GD_ANALYZE_ALL_EXAMPLES"
FEWEST = 4


def examples(count: int) -> Callable[[Any], Any]:
    """Number of examples of one test, on the project's own profile whichever is loaded."""
    drawn = count if os.environ.get(ALL_EXAMPLES) else min(count, max(FEWEST, count // 4))
    return settings(settings.get_profile(PROFILE), max_examples=drawn)


def names_in(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.iterdir())


def random_rotation(rng: np.random.Generator) -> FloatArray:
    q, r = np.linalg.qr(rng.normal(size=(3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.linalg.det(q).round()


def random_inertia(rng: np.random.Generator, thickness: float = 0.01) -> FloatArray:
    """I = tr(P) 1 - P of a second moment P: exactly the inertias that matter can have."""
    root = rng.normal(scale=0.3, size=(3, 3))
    second = root @ root.T + thickness * np.eye(3)
    second = 0.5 * (second + second.T)
    return np.trace(second) * np.eye(3) - second


def random_states(n: int, count: int, seed: int) -> States:
    rng = np.random.default_rng(seed)
    q = rng.uniform(-np.pi, np.pi, (count, n))
    drawn = {"box": "drawn", "states": count, "seed": seed}
    return States(q, rng.uniform(-3, 3, (count, n)), rng.uniform(-10, 10, (count, n)), drawn)


def explicitly(arms: Iterable[RobotArm], *, states: int = 0, **others: Any) -> Callable[[Any], Any]:
    """Try these arms beside those drawn; the argument is `arm`, or `case`, the arm with so many states."""

    def decorated(function: Any) -> Any:
        for arm in arms:
            case = {"case": (arm, random_states(arm.n_joints, states, 1))} if states else {"arm": arm}
            function = example(**case, **others)(function)
        return function

    return decorated


@st.composite
def arms(draw: st.DrawFn, max_joints: int = 8, massive: bool = False, revolute: bool = False) -> RobotArm:
    """Arms of 1 to `max_joints` joints; `massive` ones have mass and inertia in every link.

    Kind, placement, axis and mass are drawn joint by joint: a few arms have all of them, and side by side.
    """
    kinds = st.just("revolute") if revolute else st.sampled_from(["revolute", "prismatic"])
    masses = st.just(False) if massive else st.sampled_from([False, False, True])
    makes = st.tuples(kinds, st.booleans(), st.booleans(), masses)
    drawn = draw(st.lists(makes, min_size=1, max_size=max_joints))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    joints, links = [], []
    for i, (kind, general, askew, massless) in enumerate(drawn):
        axis = rng.normal(size=3) if askew else np.array([0.0, 0.0, 1.0])
        before = Placement(random_rotation(rng), rng.uniform(-0.5, 0.5, 3)) if general else Placement()
        quarter = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])
        turned = random_rotation(rng) if general else quarter if rng.random() < 0.5 else np.eye(3)
        behind = Placement(turned, rng.uniform(-0.5, 0.5, 3))
        size = max(0.1, float(np.linalg.norm(behind.translation)))
        com = random_rotation(rng)[0] * rng.uniform(0, 1) * size
        mass = 0.0 if massless else rng.uniform(0.5, 3.0)
        inertia = np.zeros((3, 3)) if massless else random_inertia(rng)
        joints.append(Joint(f"joint {i}", kind, before, axis / np.linalg.norm(axis)))
        links.append(Link(f"link {i}", mass, com, inertia, behind))
    return RobotArm("drawn", tuple(joints), tuple(links), rng.uniform(-10, 10, 3))


@st.composite
def arms_with_states(
    draw: st.DrawFn, max_joints: int = 8, count: int = 6, massive: bool = False, revolute: bool = False
) -> tuple[RobotArm, States]:
    arm = draw(arms(max_joints, massive, revolute))
    return arm, random_states(arm.n_joints, count, draw(st.integers(0, 2**32 - 1)))


@st.composite
def motions(
    draw: st.DrawFn, max_joints: int = 4, count: int = 12, massive: bool = False
) -> tuple[RobotArm, Trajectory]:
    """An arm and set points of unrelated states: harder than any motion."""
    arm, states = draw(arms_with_states(max_joints, count, massive))
    return arm, Trajectory(0.1 * np.arange(count), states.q, states.qd, states.qdd, "drawn")


def two_link_of(length: float, m1: float, m2: float, g: float = 9.8062) -> RobotArm:
    """The text's two rods in a vertical plane, [FGL87] section 3.2.6."""

    def rod(name: str, mass: float) -> Link:
        across = mass * length**2 / 12
        behind = Placement(np.eye(3), np.array([length, 0.0, 0.0]))
        return Link(name, mass, np.array([-length / 2, 0.0, 0.0]), np.diag([0.0, across, across]), behind)

    return RobotArm(
        "two rods", (Joint("1"), Joint("2")), (rod("1", m1), rod("2", m2)), np.array([0.0, -g, 0.0])
    )
