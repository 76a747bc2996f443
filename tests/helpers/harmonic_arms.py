"""States for the harmonic form, and how far two exact forms may differ."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from gd_analyze.harmonics.terms import Factor, Monomial
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial, numbers
from gd_analyze.types import RobotArm
from strategies import States, random_states

# cos x = (e^ix + e^-ix) / 2, sin x = -i (e^ix - e^-ix) / 2; a power is itself.
_EXPONENTIALS = {"cos": (0.5, 0.5), "sin": (-0.5j, 0.5j), "power": (1.0, 0.0)}


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


def to_polynomial(
    polynomials: Sequence[Mapping[Monomial, float]], prismatic: Sequence[bool]
) -> TrigonometricPolynomial:
    """Multiply products of sines and cosines out: sums of monomials with their weights."""
    pairs = [(p, *item) for p, polynomial in enumerate(polynomials) for item in polynomial.items()]
    rows = np.array([p for p, _, _ in pairs], dtype=np.int64)
    multiples = np.zeros((len(pairs), len(prismatic)), dtype=np.int64)
    weights = np.array([weight for _, _, weight in pairs], dtype=complex)
    source = np.arange(len(pairs))
    for place in range(max((len(monomial) for _, monomial, _ in pairs), default=0)):
        nothing = Factor("power", (0,) * len(prismatic))
        factors = [monomial[place] if place < len(monomial) else nothing for _, monomial, _ in pairs]
        step = np.array([factor[1] for factor in factors], dtype=np.int64)[source]
        up, down = np.array([_EXPONENTIALS[factor[0]] for factor in factors])[source].T
        weights = np.concatenate([weights * up, weights * down])
        there = weights != 0.0
        multiples = np.concatenate([multiples + step, multiples - step])[there]
        weights, source = weights[there], np.tile(source, 2)[there]
    revolute = ~np.array(prismatic)
    mirrored = numbers(multiples * revolute) < 0
    multiples = np.where(mirrored[:, None] & revolute, -multiples, multiples)
    weights = np.where(mirrored, weights.conj(), weights)
    _, first, column = np.unique(numbers(multiples), return_index=True, return_inverse=True)
    out = np.zeros((len(polynomials), len(first)), dtype=complex)
    np.add.at(out, (rows[source], column), weights)
    return TrigonometricPolynomial(tuple(prismatic), multiples[first], out)
