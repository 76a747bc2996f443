"""Arms for the harmonic form: with runs of parallel axes, and how far two exact forms may differ."""

from __future__ import annotations

import numpy as np
from hypothesis import strategies as st

from gd_analyze.harmonics import Harmonics
from gd_analyze.robots import Joint, Link, Placement, RobotArm
from strategies import States, random_inertia, random_rotation, random_states


def flipped() -> np.ndarray:
    return np.diag([1.0, -1.0, -1.0])


@st.composite
def arms_with_runs(draw: st.DrawFn, max_joints: int = 6) -> RobotArm:
    """Arms whose next axis often is parallel to the one before, the same way or opposite."""
    turns = draw(
        st.lists(st.sampled_from(["same", "opposite", "askew", "slides"]), min_size=1, max_size=max_joints)
    )
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    return arm_of(turns, rng)


def arm_of(turns: list[str], rng: np.random.Generator) -> RobotArm:
    """Joint i stands to the one before as turns[i] says; the first to the base."""
    joints, links = [], []
    for i, turn in enumerate(turns):
        kind = "prismatic" if turn == "slides" else "revolute"
        rotation = {"same": np.eye(3), "opposite": flipped()}.get(turn)
        before = Placement(random_rotation(rng) if rotation is None else rotation, rng.uniform(-0.5, 0.5, 3))
        # About z, or it would not leave the next axis parallel.
        angle = rng.uniform(-np.pi, np.pi)
        c, s = np.cos(angle), np.sin(angle)
        behind = Placement(np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]), rng.uniform(-0.5, 0.5, 3))
        joints.append(Joint(f"{i + 1}", kind, before))
        com = rng.uniform(-0.05, 0.05, 3)
        links.append(Link(f"{i + 1}", rng.uniform(0.5, 3.0), com, random_inertia(rng), behind))
    return RobotArm("drawn", tuple(joints), tuple(links), rng.uniform(-10, 10, 3))


def states_of(arm: RobotArm, count: int, seed: int) -> States:
    """Random states; sliding joints within 1 m, where their powers are at most 1 as sines are."""
    states = random_states(arm.n_joints, count, seed)
    scale = np.where(arm.is_revolute, 1.0, 1.0 / np.pi)
    return States(states.q * scale, states.qd, states.qdd)


def tolerances(harmonics: Harmonics) -> dict[str, float]:
    """How far the harmonic form may be from the numeric one at a state of `states_of`.

    `noise` is 2^runs g, where g bounds the error of a value on the grid. Parseval: the squares of the errors
    of all exponentials sum to at most g^2, and those of the waves, twice an exponential for half of them, to
    2 g^2; the inverse Vandermonde matrix of a sliding axis makes 6 of it (its squared norm, 2, times 3
    places), for which the noise allows 4. By Cauchy and Schwarz K waves of at most 1 make an error of at most
    sqrt(K) noise, times sqrt(6 / 4) per sliding joint. The numeric value adds g < noise. h is half of three
    slopes, each at most twice as steep; c_i is one.
    """
    arm = harmonics.arm
    sliding = 1.5 ** (arm.is_revolute.count(False) / 2)
    kept = max((len(part) for part in harmonics.inertia_by_link.values()), default=0)
    inertia = harmonics.noise[0] * (sliding * np.sqrt(arm.n_joints * kept) + 1)
    gravity = harmonics.noise[1] * (sliding * np.sqrt(len(harmonics.potential_by_link)) + 1)
    return {"inertia": inertia, "coupling": 3 * inertia, "gravity_loading": gravity}
