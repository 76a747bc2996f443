"""What physics demands of the formulation, on arms of every make, each effect by itself.

Unit of every tolerance: `round_off_bounds`, argued there, is how far two correct programs may differ in an
element of D, h, c or torque. An identity that combines k such elements may fail by k of them.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import transforms as tf
from gd_analyze import load_arm
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics import generalized_dalembert as dalembert
from gd_analyze.dynamics.kinematics import kinetic_energy, potential_energy, solve_kinematics
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.types import RobotArm
from parallel_axes import arm_of
from strategies import States, arms_with_states, examples, explicitly, random_states

BUILT_IN = ["puma560", "stanford", "two_link"]

TURNS = ["askew", "slides", "same", "slides across", "opposite"]
ARMS = [*map(load_arm, BUILT_IN), arm_of(TURNS, np.random.default_rng(3))]

every_arm = st.one_of(
    arms_with_states(),
    st.builds(
        lambda arm, seed: (arm, random_states(arm.n_joints, 6, seed)),
        st.sampled_from(ARMS[:-1]),
        st.integers(0, 2**32 - 1),
    ),
)


class Solved:
    """One arm at some states: its elements by composite moments, set points last, and the bounds."""

    def __init__(self, arm: RobotArm, states: States) -> None:
        self.arm, self.states, self.n = arm, states, arm.n_joints
        self.q, self.qd, self.qdd = states.last
        self.bounds = round_off_bounds(arm, *states.arrays)
        # h_ijk sums the same products of masses and two levers as D_ij does.
        self.christoffel_bound = self.bounds["inertia"]
        self.kinematics = solve_kinematics(arm, self.q)
        moments = composite.composite_moments(arm, self.kinematics)
        self.inertia = composite.inertia(moments)
        pairs = composite.brackets(moments)
        self.christoffel = composite.christoffel(moments, pairs)
        self.h, self.centrifugal = composite.coriolis_centrifugal(moments, pairs, self.qd)
        self.c = composite.gravity_loading(arm, moments)


@explicitly(ARMS, states=6)
@examples(40)
@given(every_arm)
def test_inertia_of_each_effect_is_symmetric_and_positive_semidefinite(case):
    solved = Solved(*case)
    literal = dalembert.inertia_by_link(solved.arm, solved.kinematics).sum(axis=1)
    assert np.abs(solved.inertia - literal).max() <= solved.bounds["inertia"]
    for inertia in (solved.inertia, literal):
        # x . y and y . x round alike; only the order of the sum over links could differ, and it does not.
        assert np.abs(inertia - inertia.swapaxes(1, 2)).max() <= solved.bounds["inertia"]
        # A perturbation of every entry by at most b moves an eigenvalue by at most n b.
        smallest = np.linalg.eigvalsh(np.moveaxis(inertia, -1, 0))[..., 0].min()
        assert smallest >= -solved.n * solved.bounds["inertia"]


@explicitly(ARMS, states=6)
@examples(40)
@given(every_arm)
def test_symmetries_and_contractions_of_the_christoffel(case):
    solved = Solved(*case)
    christoffel, qd = solved.christoffel, solved.qd
    np.testing.assert_array_equal(christoffel, christoffel.swapaxes(2, 3))
    for i in range(solved.n):
        assert not christoffel[:, i, i, i].any()
        for m in range(i, solved.n):
            for k in range(i + 1):
                np.testing.assert_array_equal(christoffel[:, m, k, i], -christoffel[:, i, k, m])
    contracted = np.einsum("eijkN,jN,kN->eiN", christoffel, qd, qd)
    assert np.abs(solved.h - contracted).max() <= solved.bounds["coriolis_centrifugal"]
    centrifugal = np.einsum("eijjN,jN->eiN", christoffel, qd**2)
    assert np.abs(solved.centrifugal - centrifugal).max() <= solved.bounds["coriolis_centrifugal"]
    doubled = Solved(solved.arm, States(solved.states.q, 2 * solved.states.qd, solved.states.qdd))
    np.testing.assert_array_equal(doubled.h, 4 * solved.h)  # exact in binary


@explicitly(ARMS, states=6)
@examples(15)
@given(every_arm)
def test_lagrange_euler_gives_the_same_inertia_christoffel_and_gravity_by_effect(case):
    """Two truly different derivations. The complex step adds no error of its own: nothing cancels."""
    solved = Solved(*case)
    q = solved.states.q
    # 4x4 products take as many roundings again as the vectors do.
    assert np.abs(solved.inertia - tf.inertia(solved.arm, q)).max() <= 2 * solved.bounds["inertia"]
    assert np.abs(solved.christoffel - tf.h_ikm(solved.arm, q)).max() <= 2 * solved.christoffel_bound
    # D is at most quadratic in cos, sin, or a slide: its slope is at most twice as large; three make h_ijk.
    assert np.abs(solved.christoffel - tf.christoffel(solved.arm, q)).max() <= 6 * solved.christoffel_bound
    units = np.eye(solved.n)
    gradient = np.array([tf.derivative(lambda x: tf.potential_energy(solved.arm, x), q, e) for e in units])
    assert np.abs(solved.c - gradient).max() <= 2 * solved.bounds["gravity_loading"]


@explicitly(ARMS, states=6)
@examples(40)
@given(every_arm)
def test_derivative_of_inertia_less_twice_coriolis_matrix_is_skew_for_each_effect(case):
    solved = Solved(*case)

    def inertia(x):
        return dalembert.inertia_by_link(solved.arm, solve_kinematics(solved.arm, x.T)).sum(axis=1)

    change = tf.derivative(inertia, solved.states.q, solved.states.qd)
    skew = change - 2 * np.einsum("eijkN,kN->eijN", solved.christoffel, solved.qd)
    # dD/dt sums n slopes of D times a velocity, C n coefficients; the transpose doubles it.
    tolerance = 2 * (2 + 2) * np.abs(solved.qd).sum(axis=0).max() * solved.christoffel_bound
    assert np.abs(skew + skew.swapaxes(1, 2)).max() <= tolerance


@explicitly(ARMS, states=6)
@examples(40)
@given(every_arm)
def test_power_balance(case):
    """d/dt (kinetic + potential energy) = qd . tau along any motion, and per effect for its own energy."""
    solved = Solved(*case)
    arm, states = solved.arm, solved.states
    both = np.concatenate([states.q, states.qd], axis=1)
    along = np.concatenate([states.qd, states.qdd], axis=1)
    n = solved.n
    kinetic = tf.derivative(lambda x: tf.kinetic_energy(arm, x[:, :n], x[:, n:]), both, along)
    potential = tf.derivative(lambda x: tf.potential_energy(arm, x), states.q, states.qd)
    torque = np.einsum("eijN,jN->eiN", solved.inertia, solved.qdd) + solved.h
    power = np.einsum("iN,eiN->eN", solved.qd, torque)
    # Each row of torque may be off by its bound on either side.
    tolerance = 2 * np.abs(solved.qd).sum(axis=0).max() * solved.bounds["torque"]
    assert np.abs(kinetic - power).max() <= tolerance
    assert np.abs(potential - np.einsum("iN,iN->N", solved.qd, solved.c)).max() <= tolerance


@examples(30)
@given(arms_with_states())
def test_energies_are_those_of_pinocchios_inertia_and_of_the_transforms(case):
    arm, states = case
    inertia = pinocchio_dynamics(arm, *states.arrays)["inertia"]
    expected = 0.5 * np.einsum("Ni,Nij,Nj->N", states.qd, inertia, states.qd)
    bounds = round_off_bounds(arm, *states.arrays)
    # Each D_ij within its bound, times the squared sum of velocities.
    tolerance = bounds["inertia"] * np.abs(states.qd).sum(axis=1) ** 2
    assert (np.abs(kinetic_energy(arm, states.q, states.qd) - expected) <= tolerance).all()
    difference = potential_energy(arm, states.q) - tf.potential_energy(arm, states.q)
    assert np.abs(difference).max() <= 2 * bounds["gravity_loading"]


@explicitly(ARMS, states=6, i=1, seed=0)
@examples(40)
@given(every_arm, st.integers(0, 7), st.integers(0, 2**32 - 1))
def test_inertia_does_not_depend_on_the_joints_below(case, i, seed):
    arm, states = case
    i = min(i, arm.n_joints - 1)
    solved = Solved(arm, states)
    moved = states.q.copy()
    moved[:, : i + 1] = np.random.default_rng(seed).uniform(-np.pi, np.pi, moved[:, : i + 1].shape)
    other = Solved(arm, States(moved, states.qd, states.qdd))
    tolerance = solved.bounds["inertia"] + other.bounds["inertia"]
    assert np.abs(solved.inertia[:, i, i:] - other.inertia[:, i, i:]).max() <= tolerance


@explicitly(ARMS, states=6)
@examples(40)
@given(every_arm)
def test_the_texts_terms_sum_to_h_and_vanish_where_they_must(case):
    """A link acts on no joint beyond it; T2, T4 and R1 need two different velocities."""
    solved = Solved(*case)
    bound = solved.bounds["coriolis_centrifugal"]

    def terms(qd):
        return dalembert.coriolis_centrifugal_by_link(solved.arm, solved.kinematics, qd)

    found = terms(solved.qd)
    assert len(found) == (6 if all(solved.arm.is_revolute) else 7)
    effects = np.array([term.effect for term in dalembert.terms_of(solved.arm)])
    literal = np.stack([found[effects == effect].sum(axis=(0, 1)) for effect in dalembert.EFFECTS])
    assert np.abs(solved.h - literal).max() <= bound
    for s in range(solved.n):
        assert not found[:, s, s + 1 :].any()
        alone = terms(solved.qd * (np.arange(solved.n) == s)[:, None])
        # b is sums of z x z, zero to the last bit for a cross product with itself.
        assert np.abs(alone[[1, 3, 4]]).max() <= bound


@pytest.mark.parametrize("name", BUILT_IN)
def test_round_off_bounds_are_neither_hit_nor_idle(name):
    """A bound a million times what is seen, or not small beside the numbers, would prove nothing."""
    solved = Solved(load_arm(name), random_states(load_arm(name).n_joints, 200, 7))
    theirs = pinocchio_dynamics(solved.arm, *solved.states.arrays)
    largest = np.abs(np.moveaxis(solved.inertia.sum(axis=0), -1, 0) - theirs["inertia"]).max()
    assert 1e-6 * solved.bounds["inertia"] <= largest <= solved.bounds["inertia"]
    for quantity, values in theirs.items():
        assert solved.bounds[quantity] <= 1e-9 * np.abs(values).max(), quantity
