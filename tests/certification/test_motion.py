"""The largest error over velocities and accelerations at one position."""

from __future__ import annotations

import itertools

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.motion import Motion
from strategies import examples


def drawn(n: int, seed: int) -> tuple[Motion, np.ndarray, np.random.Generator]:
    rng = np.random.default_rng(seed)
    every = [("1", ()), *(("qdd", (i,)) for i in range(n))]
    every += [("qd", pair) for pair in itertools.combinations_with_replacement(range(n), 2)]
    factors = tuple(factor for factor in every if rng.random() < 0.7)
    return Motion(n, factors), rng.normal(size=(len(factors), 5)), rng


def error_at(motion: Motion, values: np.ndarray, velocities: np.ndarray, pushes: np.ndarray) -> np.ndarray:
    """Sum over the factors, by their meaning; values (P,), velocities and accelerations (N, n)."""
    out = np.zeros(len(velocities))
    for (kind, joints), value in zip(motion.factors, values, strict=True):
        source = pushes if kind == "qdd" else velocities
        out += value * np.prod(source[:, list(joints)], axis=1)
    return np.abs(out)


@examples(60)
@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_no_rates_exceed_the_bound_and_the_worst_is_reached(n: int, seed: int) -> None:
    motion, values, rng = drawn(n, seed)
    bound, reached = motion.bound(values), motion.reached(values)
    velocities = rng.uniform(-1.0, 1.0, (2000, n))
    velocities[:1000] = np.sign(velocities[:1000])
    pushes = np.sign(rng.uniform(-1.0, 1.0, (2000, n)))
    # Sums of at most 45 products of numbers below 5.
    slack = 1e3 * np.finfo(float).eps
    for column in range(values.shape[1]):
        found = error_at(motion, values[:, column], velocities, pushes).max()
        error, velocity, push = motion.worst(values[:, column])
        again = error_at(motion, values[:, column], velocity[None], push[None])[0]
        assert found <= bound[column] + slack
        assert reached[column] <= error + slack
        assert error <= bound[column] + slack
        assert abs(again - error) <= slack
        assert (np.abs(velocity) <= 1.0).all()
        assert (np.abs(push) <= 1.0).all()


def test_signs_of_rates_are_shared() -> None:
    """qd1 qd2 + qd2 qd3 - qd1 qd3 cannot be 3 for velocities between -1 and 1, only 1."""
    motion = Motion(3, (("qd", (0, 1)), ("qd", (1, 2)), ("qd", (0, 2))))
    values = np.array([[1.0], [1.0], [-1.0]])
    assert motion.bound(-values)[0] == 3.0
    signs = np.array(list(itertools.product((1.0, -1.0), repeat=3)))
    largest = error_at(motion, values[:, 0], signs, signs).max()
    assert motion.bound(values)[0] == largest == 3.0


def test_a_square_that_takes_away_need_not_count() -> None:
    motion = Motion(1, (("1", ()), ("qd", (0, 0))))
    assert motion.bound(np.array([[2.0], [-1.0]]))[0] == 2.0
    error, velocity, _ = motion.worst(np.array([2.0, -1.0]))
    assert (error, velocity[0]) == (2.0, 0.0)


def test_many_joints_are_bounded_without_trying_all_signs() -> None:
    n = 14
    pairs = tuple(("qd", pair) for pair in itertools.combinations(range(n), 2))
    motion = Motion(n, pairs)
    values = np.random.default_rng(1).normal(size=(len(pairs), 3))
    assert motion.bound(values).tolist() == np.abs(values).sum(axis=0).tolist()
    for column in range(3):
        assert motion.worst(values[:, column])[0] <= motion.bound(values)[column]


def test_a_square_that_takes_from_the_error_counts() -> None:
    """qd1 qd2 - qd1^2 / 4 is 3/4 at most, where both velocities are at their limits."""
    motion = Motion(2, (("qd", (0, 1)), ("qd", (0, 0))))
    values = np.array([[1.0], [-0.25]])
    # The other sign reaches -5/4.
    assert motion.worst(values[:, 0])[0] == motion.bound(values)[0] == 1.25
    still = Motion(2, (("1", ()), ("qd", (0, 1)), ("qd", (0, 0))))
    values = np.array([[5.0], [1.0], [-0.25]])
    assert still.quick_bound(values)[0] == 6.0
    assert still.bound(values)[0] == still.worst(values[:, 0])[0] == 5.75
