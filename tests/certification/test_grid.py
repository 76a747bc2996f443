"""Waves and grids: the same values everywhere, and nothing larger between the nodes than proven."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.box import Box
from gd_analyze.certification.grid import Grid, Reached, grid_of, shared_out
from gd_analyze.harmonics.trigonometric_polynomial import TrigonometricPolynomial
from harmonic_arms import to_polynomial
from strategies import examples

EPS = float(np.finfo(float).eps)


def drawn(seed: int, joints: int, polynomials: int = 3) -> tuple[list[dict], TrigonometricPolynomial, Box]:
    """Polynomials of degree at most 2 in everything, and a box that may be a circle, narrow or a point."""
    rng = np.random.default_rng(seed)
    prismatic = [bool(rng.random() < 0.3) for _ in range(joints)]
    written = []
    for _ in range(polynomials):
        polynomial = {}
        for _ in range(rng.integers(1, 8)):
            monomial = []
            for k in range(joints):
                unit = tuple(int(j == k) for j in range(joints))
                kinds = ["power"] if prismatic[k] else ["cos", "sin"]
                monomial += [(str(rng.choice(kinds)), unit) for _ in range(rng.integers(0, 3))]
            polynomial[tuple(sorted(monomial))] = float(rng.normal())
        written.append(polynomial)
    middle, half = rng.uniform(-2.0, 2.0, joints), rng.choice([0.0, 0.2, 1.5, 3.5], joints)
    nothing = np.zeros(joints)
    return written, to_polynomial(written, prismatic), Box(middle - half, middle + half, nothing, nothing)


def directly(polynomials: list[dict], q: np.ndarray) -> np.ndarray:
    functions = {"cos": np.cos, "sin": np.sin, "power": lambda x: x}
    out = np.zeros((len(polynomials), q.shape[1]))
    for p, polynomial in enumerate(polynomials):
        for monomial, weight in polynomial.items():
            value = np.full(q.shape[1], weight)
            for kind, multiples in monomial:
                value = value * functions[kind](np.array(multiples) @ q)
            out[p] += value
    return out


def round_off(waves: TrigonometricPolynomial, box: Box) -> float:
    """Some hundred roundings of terms no larger than the amplitudes, angles of up to 20 rad."""
    return 100 * 20 * EPS * max(1.0, float(waves.sizes(box.farthest).sum(axis=1).max()))


@examples(40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4))
def test_waves_are_the_polynomials(seed: int, joints: int) -> None:
    polynomials, waves, box = drawn(seed, joints)
    q = np.random.default_rng(seed).uniform(box.lower, box.upper, (50, joints)).T
    # Sliding variables of up to 5.5 to the second power in 4 joints: products larger than the waves' sum.
    scale = 8.0 * 5.5**8
    assert waves(q) == pytest.approx(directly(polynomials, q), rel=0, abs=1e3 * EPS * scale)
    assert (np.abs(waves(q)) <= waves.sizes(box.farthest).sum(axis=1)[:, None] + round_off(waves, box)).all()


@examples(40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.sampled_from([30, 3000, 30_000]))
def test_values_on_a_grid_are_those_at_its_positions(seed: int, joints: int, effort: int) -> None:
    _, waves, box = drawn(seed, joints)
    grid = grid_of(waves, box, effort)
    if grid is None:
        return
    assert grid.size <= effort
    values = np.concatenate(list(waves.on_grid(grid.nodes)), axis=1)
    assert values.shape == (3, grid.size)
    q = grid.positions(np.arange(grid.size))
    assert ((q >= box.lower[:, None] - 1e-12) & (q <= box.upper[:, None] + 1e-12)).all()
    assert values == pytest.approx(waves(q), rel=0, abs=round_off(waves, box))


@examples(60)
@given(st.integers(0, 2**32 - 1), st.integers(1, 3), st.sampled_from([8, 60, 2000]))
def test_nothing_larger_hides_between_the_nodes(seed: int, joints: int, effort: int) -> None:
    _, waves, box = drawn(seed, joints)
    grid = grid_of(waves, box, effort)
    if grid is None:
        return
    on_grid = np.abs(np.concatenate(list(waves.on_grid(grid.nodes)), axis=1)).max(axis=1)
    rng = np.random.default_rng(seed)
    q = rng.uniform(box.lower, box.upper, (20_000, joints)).T
    q[:, :2000] = np.where(rng.random((joints, 2000)) < 0.5, box.lower[:, None], box.upper[:, None])
    largest = np.abs(waves(q)).max(axis=1)
    assert (largest <= on_grid + grid.between(waves, box) + round_off(waves, box)).all()


def test_the_loss_between_nodes_is_what_a_cosine_needs() -> None:
    """cos q around q = 0 with the nodes at +-h: the bound 1 <= cos h + h^2 / 2 is met to fourth order."""
    waves = to_polynomial([{(("cos", (1,)),): 1.0}], [False])
    box = Box(np.array([-0.1]), np.array([0.1]), np.zeros(1), np.zeros(1))
    grid = grid_of(waves, box, 2)
    assert grid is not None
    assert grid.counts == (2,)
    bound = np.abs(next(waves.on_grid(grid.nodes))).max() + grid.between(waves, box)[0]
    assert 1.0 <= bound <= 1.0 + 0.1**4 / 24


@examples(30)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.sampled_from([1, 50, 5000]))
def test_groups_and_rest_are_all_the_waves(seed: int, joints: int, effort: int) -> None:
    _, waves, box = drawn(seed, joints)
    shares, rest = shared_out(waves, box, effort, groups=3)
    assert len(shares) <= 3
    assert all(grid.size <= effort for _, grid in shares)
    parts = [*(part for part, _ in shares), rest]
    assert sum(len(part.multiples) for part in parts) == len(waves.multiples)
    q = np.random.default_rng(seed).uniform(box.lower, box.upper, (20, joints)).T
    together = sum(part(q) for part in parts)
    assert together == pytest.approx(waves(q), rel=0, abs=round_off(waves, box))


@pytest.mark.parametrize("prismatic", [False, True])
def test_more_positions_lose_less(prismatic: bool) -> None:
    """Twice as many nodes per joint: a quarter of the loss, within what whole numbers of nodes allow."""
    kind = "power" if prismatic else "cos"
    square = tuple((kind, tuple(int(j == k) for j in range(2))) for k in (0, 0, 1, 1))
    waves = to_polynomial([{square: 1.0}], [prismatic, prismatic])
    box = Box(*(sign * np.full(2, 1.5) for sign in (-1, 1)), np.zeros(2), np.zeros(2))
    losses = []
    for effort in (400, 1600, 6400):
        grid = grid_of(waves, box, effort)
        assert grid is not None
        losses.append(float(grid.between(waves, box).sum()))
    assert np.array(losses[:-1]) / losses[1:] == pytest.approx(4.0, rel=0.2)


def test_what_is_linear_is_largest_at_an_end() -> None:
    waves = to_polynomial([{(("power", (1,)),): 1.0}], [True])
    box = Box(np.array([-4.0]), np.array([5.0]), np.zeros(1), np.zeros(1))
    grid = grid_of(waves, box, 10)
    assert grid is not None
    assert grid.between(waves, box).sum() == 0.0
    assert next(waves.on_grid(grid.nodes)).max() == 5.0


def test_one_position_needs_no_more() -> None:
    grid = Grid.at(np.array([1.0, 2.0]))
    assert grid.size == math.prod(grid.counts) == 1
    assert grid.positions(np.array([0])).tolist() == [[1.0], [2.0]]


@examples(40)
@given(st.integers(0, 2**32 - 1), st.integers(1, 4), st.sampled_from([50, 3000]), st.floats(1e-3, 10.0))
def test_what_is_reached_bounds_what_lies_between(seed: int, joints: int, effort: int, guess: float) -> None:
    """By Bernstein's inequality, whatever was guessed of what is reached."""
    _, waves, box = drawn(seed, joints)
    amplitudes = float(waves.sizes(box.farthest).sum())
    grid = grid_of(waves, box, effort, Reached(guess * amplitudes, 2.0 * guess * amplitudes))
    if grid is None:
        return
    assert grid.size <= effort
    largest = max(float(np.abs(values).max()) for values in waves.on_grid(grid.nodes))
    bound = grid.over_box(waves, box, largest)
    rng = np.random.default_rng(seed)
    q = rng.uniform(box.lower, box.upper, (3000, joints)).T
    ends = np.where(rng.random(q.shape) < 0.5, box.lower[:, None], box.upper[:, None])
    q = np.where(rng.random(q.shape) < 0.3, ends, q)
    assert np.abs(waves(q)).max() <= bound + round_off(waves, box)


def test_around_a_circle_the_bound_is_that_of_its_degree() -> None:
    """Nine nodes of cos q: the loss is h^2 / 2 of the bound itself, h = pi / 9, not of the amplitudes."""
    count = 9
    turn = Box(np.array([-np.pi]), np.array([np.pi]), np.zeros(1), np.zeros(1))
    waves = to_polynomial([{(("cos", (1,)),): 1.0}], [False])
    grid = grid_of(waves, turn, count, Reached(1.0, 1.0))
    assert grid is not None
    assert grid.counts == (count,)
    by_itself = Grid(grid.nodes, grid.reaches, (1,))
    loss = (np.pi / count) ** 2 / 2
    assert by_itself.over_box(waves, turn, 0.9) == pytest.approx(0.9 / (1.0 - loss), rel=1e-12)
    assert Grid(grid.nodes, grid.reaches).over_box(waves, turn, 0.9) == pytest.approx(0.9 + loss, rel=1e-12)
    # Too few nodes tell nothing.
    assert Grid((np.zeros(1),), np.full(1, 2.0), (1,)).over_box(waves, turn, 0.9) == math.inf
