"""States for the harmonic form, and how far two exact forms may differ."""

from __future__ import annotations

import numpy as np

from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.robots.arm import RobotArm
from strategies import States, random_states


def states_of(arm: RobotArm, count: int, seed: int) -> States:
    """Random states; prismatic joints within 1 m, where their powers are at most 1 as sines are."""
    states = random_states(arm.n_joints, count, seed)
    scale = np.where(arm.is_revolute, 1.0, 1.0 / np.pi)
    return States(states.q * scale, states.qd, states.qdd)


def tolerances(harmonics: Harmonics) -> dict[str, float]:
    """How far the harmonic form may be from the numeric one at a state of `states_of`.

    `noise` is 2^runs g, where g bounds the error of a value on the grid. Parseval: the squares of the errors
    of all exponentials sum to at most g^2, and those of the waves, twice an exponential for half of them, to
    2 g^2; the inverse Vandermonde matrix of a prismatic axis makes 6 of it (its squared norm, 2, times 3
    places), for which the noise allows 4. By Cauchy and Schwarz K waves of at most 1 make an error of at most
    sqrt(K) noise, times sqrt(6 / 4) per prismatic joint. The numeric value adds g < noise. h is half of three
    slopes, each at most twice as steep; c_i is one.
    """
    arm = harmonics.arm
    prismatic = 1.5 ** (arm.is_revolute.count(False) / 2)
    kept = max((len(part) for part in harmonics.inertia_by_link.values()), default=0)
    inertia = harmonics.noise[0] * (prismatic * np.sqrt(arm.n_joints * kept) + 1)
    gravity = harmonics.noise[1] * (prismatic * np.sqrt(len(harmonics.potential_by_link)) + 1)
    return {"inertia": inertia, "christoffel": 3 * inertia, "gravity_loading": gravity}
