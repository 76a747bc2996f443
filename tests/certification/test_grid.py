"""Grids, and velocities at their nodes: nothing larger than proven anywhere between."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.certification.grid import Grid, Reached, grid_of, shared_out
from gd_analyze.certification.motion import MotionFactors
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from harmonic_arms import to_polynomial
from strategies import examples

EPS = float(np.finfo(float).eps)
COSINE = [{(("cos", (1,)),): 1.0}]


def positions(lower, upper) -> gd.types.Box:
    return gd.types.Box(np.array(lower), np.array(upper), np.zeros(len(lower)), np.zeros(len(lower)))


def drawn(seed: int, joints: int) -> tuple[TrigonometricPolynomial, gd.types.Box]:
    """Three polynomials of degree at most 2, and a box that may be a circle, narrow or a point."""
    rng = np.random.default_rng(seed)
    prismatic = rng.random(joints) < 0.3
    multiples = np.unique(rng.integers(np.where(prismatic, 0, -2), 3, (12, joints)), axis=0)
    real, imaginary = rng.normal(size=(2, 3, len(multiples)))
    polynomial = TrigonometricPolynomial(tuple(prismatic.tolist()), multiples, real + 1j * imaginary)
    middle, half = rng.uniform(-2.0, 2.0, joints), rng.choice([0.0, 0.2, 1.5, 3.5], joints)
    return polynomial, positions(middle - half, middle + half)


def round_off(polynomial: TrigonometricPolynomial, box: gd.types.Box) -> float:
    """Some hundred roundings of terms no larger than the amplitudes, angles of up to 20 rad."""
    return 100 * 20 * EPS * max(1.0, float(polynomial.sizes(box.farthest).sum(axis=1).max()))


def attacked(box: gd.types.Box, count: int, seed: int) -> np.ndarray:
    """Positions of a box, shape (n, count), many of their coordinates at its ends."""
    rng = np.random.default_rng(seed)
    q = rng.uniform(box.lower, box.upper, (count, box.n_joints)).T
    ends = np.where(rng.random(q.shape) < 0.5, box.lower[:, None], box.upper[:, None])
    return np.where(rng.random(q.shape) < 0.3, ends, q)


@pytest.mark.parametrize("effort", [30, 3000])
@examples(20)
@given(seed=st.integers(0, 2**32 - 1), joints=st.integers(1, 3), guess=st.floats(1e-3, 10.0))
def test_nothing_larger_hides_between_the_nodes(seed, joints, effort, guess):
    """By amplitudes, and by Bernstein's inequality whatever was guessed of what is reached."""
    polynomial, box = drawn(seed, joints)
    slack, q = round_off(polynomial, box), attacked(box, 3000, seed)
    values = polynomial(q)
    assert (np.abs(values) <= polynomial.sizes(box.farthest).sum(axis=1)[:, None] + slack).all()
    largest, total = np.abs(values).max(axis=1), float(polynomial.sizes(box.farthest).sum())
    for reached in (None, Reached(guess * total, 2.0 * guess * total)):
        grid = grid_of(polynomial, box, effort, reached)
        if grid is None:
            continue
        assert grid.size <= effort
        on_grid = np.concatenate(list(polynomial.on_grid(grid.nodes)), axis=1)
        at_nodes = polynomial(grid.positions(np.arange(grid.size)))
        np.testing.assert_allclose(on_grid, at_nodes, rtol=0, atol=slack)
        tops = np.abs(on_grid).max(axis=1)
        assert largest.max() <= grid.over_box(polynomial, box, float(tops.max())) + slack
        if reached is None:
            assert (largest <= tops + grid.between(polynomial, box) + slack).all()


def test_the_loss_between_nodes_is_what_a_cosine_needs():
    """cos q about q = 0 with the nodes at +-h: the bound 1 <= cos h + h^2 / 2 is met to fourth order."""
    polynomial, box = to_polynomial(COSINE, [False]), positions([-0.1], [0.1])
    grid = grid_of(polynomial, box, 2)
    bound = np.abs(next(polynomial.on_grid(grid.nodes))).max() + grid.between(polynomial, box)[0]
    assert 1.0 <= bound <= 1.0 + 0.1**4 / 24


def test_around_a_circle_the_bound_is_that_of_its_degree():
    """Nine nodes of cos q: the loss is h^2 / 2 of the bound itself, h = pi / 9, not of the amplitudes."""
    turn, polynomial = positions([-np.pi], [np.pi]), to_polynomial(COSINE, [False])
    grid = grid_of(polynomial, turn, 9, Reached(1.0, 1.0))
    assert grid.counts == (9,)
    loss = (np.pi / 9) ** 2 / 2
    by_itself, by_amplitudes = (Grid(grid.nodes, grid.reaches, degrees) for degrees in ((1,), ()))
    assert by_itself.over_box(polynomial, turn, 0.9) == pytest.approx(0.9 / (1.0 - loss), rel=1e-12)
    assert by_amplitudes.over_box(polynomial, turn, 0.9) == pytest.approx(0.9 + loss, rel=1e-12)
    too_few = Grid((np.zeros(1),), np.full(1, 2.0), (1,))
    assert too_few.over_box(polynomial, turn, 0.9) == math.inf


@pytest.mark.parametrize("effort", [1, 50, 5000])
@examples(12)
@given(seed=st.integers(0, 2**32 - 1), joints=st.integers(1, 4))
def test_groups_and_rest_are_the_whole(seed, joints, effort):
    polynomial, box = drawn(seed, joints)
    shares, rest = shared_out(polynomial, box, effort, groups=3)
    assert len(shares) <= 3
    assert all(grid.size <= effort for _, grid in shares)
    parts = [*(part for part, _ in shares), rest]
    assert sum(map(len, parts)) == len(polynomial)
    q = attacked(box, 20, seed)
    together = sum(part(q) for part in parts)
    np.testing.assert_allclose(together, polynomial(q), rtol=0, atol=round_off(polynomial, box))


def test_a_linear_function_is_largest_at_an_end():
    polynomial, box = to_polynomial([{(("power", (1,)),): 1.0}], [True]), positions([-4.0], [5.0])
    grid = grid_of(polynomial, box, 10)
    assert grid.between(polynomial, box).sum() == 0.0
    assert next(polynomial.on_grid(grid.nodes)).max() == 5.0


def error_at(
    motion: MotionFactors, values: np.ndarray, velocities: np.ndarray, pushes: np.ndarray
) -> np.ndarray:
    """Sum over the factors by their meaning; values (P,), velocities and accelerations (N, n)."""
    out = np.zeros(len(velocities))
    for (kind, joints), value in zip(motion.factors, values, strict=True):
        out += value * np.prod((pushes if kind == "qdd" else velocities)[:, list(joints)], axis=1)
    return np.abs(out)


@examples(40)
@given(st.integers(1, 8), st.integers(0, 2**32 - 1))
def test_no_velocities_exceed_the_bound_and_the_worst_is_reached(n, seed):
    rng = np.random.default_rng(seed)
    every = [("1", ()), *(("qdd", (i,)) for i in range(n))]
    every += [("qd", pair) for pair in itertools.combinations_with_replacement(range(n), 2)]
    motion = MotionFactors(n, tuple(factor for factor in every if rng.random() < 0.7))
    values = rng.normal(size=(len(motion.factors), 5))
    bound, reached = motion.bound(values), motion.reached(values)
    assert (bound <= motion.quick_bound(values)).all()
    velocities = rng.uniform(-1.0, 1.0, (2000, n))
    velocities[:1000] = np.sign(velocities[:1000])
    pushes = np.sign(rng.uniform(-1.0, 1.0, (2000, n)))
    # Sums of at most 45 products of numbers below 5.
    slack = 1e3 * EPS
    error, velocity, push = motion.worst(values)
    for column in range(values.shape[1]):
        found = error_at(motion, values[:, column], velocities, pushes).max()
        again = error_at(motion, values[:, column], velocity[:, column][None], push[:, column][None])[0]
        assert max(found, error[column]) <= bound[column] + slack
        # The ascent finds nearly all: no more than a few per mille are found by chance beyond.
        assert max(reached[column], 0.999 * found) <= error[column] + slack
        assert abs(again - error[column]) <= slack
    assert max(np.abs(velocity).max(), np.abs(push).max()) <= 1.0


def test_products_share_signs_and_squares_may_reduce_the_error():
    """qd1 qd2 + qd2 qd3 - qd1 qd3 is at least -3, but at most 1."""
    pairs = (("qd", (0, 1)), ("qd", (1, 2)), ("qd", (0, 2)))
    still = (("1", ()),)
    for factors, weights, largest in (
        (still + pairs, [2.0, 1.0, 1.0, -1.0], 3.0),
        ((*still, ("qd", (0, 0))), [2.0, -1.0], 2.0),
        ((("qd", (0, 1)), ("qd", (0, 0))), [1.0, -0.25], 1.25),
        ((*still, ("qd", (0, 1)), ("qd", (0, 0))), [5.0, 1.0, -0.25], 5.75),
    ):
        motion, values = MotionFactors(3, factors), np.array(weights)
        assert motion.bound(values[:, None])[0] == motion.worst(values[:, None])[0][0] == largest


def test_many_joints_are_bounded_without_trying_all_signs():
    pairs = tuple(("qd", pair) for pair in itertools.combinations(range(14), 2))
    motion, values = MotionFactors(14, pairs), np.random.default_rng(1).normal(size=(len(pairs), 3))
    np.testing.assert_allclose(motion.bound(values), np.abs(values).sum(axis=0), rtol=1e-15)
    assert (motion.worst(values)[0] <= np.abs(values).sum(axis=0)).all()
