"""Trigonometric polynomials and runs of parallel joints: derivatives, sums, terms and back."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.harmonics.products import to_products
from gd_analyze.harmonics.trigonometric_polynomial import DEGREE, TrigonometricPolynomial, numbers
from gd_analyze.types import RobotArm
from harmonic_arms import states_of, to_polynomial
from parallel_axes import arm_of, arms_with_runs, of_every_turn
from strategies import examples

EPS = float(np.finfo(float).eps)


def random_polynomial(
    arm: RobotArm, rng: np.random.Generator, count: int = 12, polynomials: int = 2
) -> TrigonometricPolynomial:
    """Harmonics of degree 2 of any multiples, distinct, of m and -m one."""
    prismatic = ~np.array(arm.is_revolute)
    multiples = rng.integers(-DEGREE, DEGREE + 1, (count, arm.n_joints))
    multiples[:, prismatic] = np.abs(multiples[:, prismatic])
    mirrored = numbers(multiples * ~prismatic) < 0
    multiples = np.where(mirrored[:, None] & ~prismatic, -multiples, multiples)
    multiples = np.unique(multiples, axis=0)
    real, imaginary = rng.normal(size=(2, polynomials, len(multiples)))
    # Where nothing turns there is no phase.
    turns = (multiples * ~prismatic).any(axis=1)
    return TrigonometricPolynomial(tuple(prismatic.tolist()), multiples, real + 1j * imaginary * turns)


def size(polynomial: TrigonometricPolynomial) -> float:
    return float(polynomial.sizes(np.ones(len(polynomial.prismatic))).sum())


@of_every_turn(seed=1)
@examples(15)
@given(arms_with_runs(max_joints=5), st.integers(0, 2**32 - 1))
def test_derivatives_against_central_differences(arm, seed):
    polynomial = random_polynomial(arm, np.random.default_rng(seed))
    q = states_of(arm, 4, seed).q.T
    step = 1e-4
    for joint in range(arm.n_joints):
        shift = step * np.eye(arm.n_joints)[:, [joint]]
        difference = (polynomial(q + shift) - polynomial(q - shift)) / (2 * step)
        # step^2 / 6 times the third derivative, at most 2^3 of the harmonic (a power has none), and eps /
        # step from the difference: 1.4e-8 and 1e-12 of the sum of amplitudes. Powers near 1 may exceed 1.
        allowed = 3e-8 * 1.01 ** (2 * arm.n_joints) * size(polynomial)
        np.testing.assert_allclose(polynomial.derivative(joint)(q), difference, rtol=0, atol=allowed)


@of_every_turn(seed=1)
@examples(10)
@given(arms_with_runs(max_joints=4), st.integers(0, 2**32 - 1))
def test_sums_and_stacks_are_those_of_the_values(arm, seed):
    rng = np.random.default_rng(seed)
    parts = [random_polynomial(arm, rng) for _ in range(3)]
    q = states_of(arm, 5, seed).q.T
    values = [part(q) for part in parts]
    # Sums of some forty harmonics, angles of up to 2 pi n.
    allowed = 100 * 8 * arm.n_joints * EPS * sum(map(size, parts))
    each, first = np.array([2.0, -1.0]), values[0]
    for found, expected in (
        (TrigonometricPolynomial.summed(parts), sum(values)),
        (parts[0] + parts[1], first + values[1]),
        (TrigonometricPolynomial.stacked(parts), np.vstack(values)),
        (parts[0].total(), first.sum(axis=0, keepdims=True)),
        (3.0 * parts[0], 3 * first),
        (each * parts[0], each[:, None] * first),
        (parts[0].added([1, 1], 3), np.array([0 * first[0], first.sum(axis=0), 0 * first[0]])),
    ):
        np.testing.assert_allclose(found(q), expected, rtol=0, atol=3 * allowed)


@of_every_turn(seed=1)
@examples(20)
@given(arms_with_runs(max_joints=4), st.integers(0, 2**32 - 1))
def test_to_terms_and_back(arm, seed):
    polynomial = random_polynomial(arm, np.random.default_rng(seed), polynomials=1)
    # Draws may come close to each other by chance; 1e-14 apart never.
    terms = to_products(polynomial, AbsoluteVelocities.of(arm), 1e-14)
    back = to_polynomial([{monomial: float(row[0]) for monomial, row in terms.items()}], polynomial.prismatic)
    # A harmonic goes through a sum of some 2^runs products and back: as many roundings of numbers below 5.
    rest = (polynomial + -1.0 * back).above(1e3 * EPS)
    assert len(rest) == 0


@pytest.mark.parametrize(
    ("turns", "runs", "signs"),
    [
        (["same"] * 3, ((0, 1, 2),), (1, 1, 1)),
        (["same", "opposite", "same", "opposite"], ((0, 1, 2, 3),), (1, -1, -1, 1)),
        (["askew", "same", "askew"], ((0, 1), (2,)), (1, 1, 1)),
        (["same", "slides", "same", "same"], ((0,), (1,), (2, 3)), (1, 1, 1, 1)),
        (["slides", "slides"], ((0,), (1,)), (1, 1)),
        # SCARA: the slide is across the angles' sum; where its axis is opposite the roll is subtracted.
        (["same", "same", "slides along", "same"], ((0, 1, 3), (2,)), (1, 1, 1, 1)),
        (["same", "same", "slides along", "opposite"], ((0, 1, 3), (2,)), (1, 1, 1, -1)),
        (["same", "slides across", "slides along", "opposite"], ((0, 3), (1,), (2,)), (1, 1, 1, -1)),
        (["slides across", "same", "slides along"], ((0,), (1,), (2,)), (1, 1, 1)),
        # What stands between turns about another axis.
        (["same", "askew", "slides along", "askew"], ((0,), (1,), (2,), (3,)), (1, 1, 1, 1)),
    ],
)
def test_runs(turns, runs, signs, rng):
    velocities = AbsoluteVelocities.of(arm_of(turns, rng))
    assert (velocities.runs, velocities.signs) == (runs, signs)


@of_every_turn(seed=1)
@examples(10)
@given(arms_with_runs(max_joints=6), st.integers(0, 2**32 - 1))
def test_absolute_velocities_and_rows_are_those_of_the_matrix(arm, seed):
    """qd = A p, tau = A^-T tau'."""
    velocities, own = AbsoluteVelocities.of(arm), np.random.default_rng(seed).normal(size=(arm.n_joints, 4))
    back = np.linalg.inv(velocities.matrix)
    # Sums of at most six numbers.
    np.testing.assert_allclose(velocities.absolute(own), back @ own, rtol=0, atol=100 * EPS)
    np.testing.assert_allclose(velocities.joint_rows(own), back.T @ own, rtol=0, atol=100 * EPS)
    for joint in range(arm.n_joints):
        velocity = np.zeros(arm.n_joints)
        for inner, sign in velocities.inboard(joint):
            velocity[inner] = sign
        np.testing.assert_array_equal(back[joint], velocity)


@of_every_turn(seed=1)
@examples(20)
@given(arms_with_runs(max_joints=6), st.integers(0, 2**32 - 1))
def test_absolute_velocities_are_those_of_the_links_about_their_axes(arm, seed):
    velocities, states = AbsoluteVelocities.of(arm), states_of(arm, 3, seed)
    axes = solve_kinematics(arm, states.q.T).joint_axes
    own = states.qd.T
    absolute = velocities.absolute(own)
    for run in (run for run in velocities.runs if arm.is_revolute[run[0]]):
        omega = np.zeros((3, own.shape[1]))
        for joint in run:
            omega = omega + axes[joint] * own[joint]
            # A run turns a link about one direction, at this velocity. Axes are parallel to 1e-9; some six
            # velocities below 3 add up.
            np.testing.assert_allclose(axes[joint] * absolute[joint], omega, rtol=0, atol=1e-9 * 6 * 3)
