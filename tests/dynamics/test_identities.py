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
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics import generalized_dalembert as dalembert
from gd_analyze.dynamics.kinematics import Kinematics, solve_kinematics
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from strategies import States, arms_with_states, examples, random_states

every_arm = st.one_of(
    arms_with_states(),
    st.builds(
        lambda name, seed: (load_arm(name), random_states(load_arm(name).n_joints, 6, seed)),
        st.sampled_from(["puma560", "stanford", "two_link"]),
        st.integers(0, 2**32 - 1),
    ),
)


class Solved:
    """One arm at some states: its elements by both paths, and the bounds."""

    def __init__(self, arm: RobotArm, states: States) -> None:
        self.arm, self.states, self.n = arm, states, arm.n_joints
        self.q, self.qd, self.qdd = states.last
        self.bounds = round_off_bounds(arm, states.q, states.qd, states.qdd)
        self.kinematics = solve_kinematics(arm, self.q)
        moments = composite.composite_moments(arm, self.kinematics)
        self.inertia = composite.inertia(moments)
        pairs = composite.brackets(moments)
        self.christoffel = composite.christoffel(moments, pairs)
        self.h, self.centrifugal = composite.coriolis_centrifugal(moments, pairs, self.qd)
        self.c = composite.gravity_loading(arm, moments)

    @property
    def christoffel_bound(self) -> float:
        """h_ijk sums the same products of masses and two levers as D_ij does."""
        return self.bounds["inertia"]


def literal_h(arm: RobotArm, kinematics: Kinematics, qd: FloatArray) -> FloatArray:
    """h by effect, the text's terms summed over terms and links."""
    itemised = dalembert.coriolis_centrifugal_by_link(arm, kinematics, qd)
    effects = np.array([term.effect for term in dalembert.terms_of(arm)])
    return np.stack([itemised[effects == effect].sum(axis=(0, 1)) for effect in dalembert.EFFECTS])


@examples(40)
@given(every_arm)
def test_inertia_of_each_effect_is_symmetric_and_positive_semidefinite(case):
    solved = Solved(*case)
    literal = dalembert.inertia_by_link(solved.arm, solved.kinematics).sum(axis=1)
    for inertia in (solved.inertia, literal):
        # x . y and y . x round alike; only the order of the sum over links could differ, and it does not.
        assert np.abs(inertia - inertia.swapaxes(1, 2)).max() <= solved.bounds["inertia"]
        # A perturbation of every entry by at most b moves an eigenvalue by at most n b.
        smallest = np.linalg.eigvalsh(np.moveaxis(inertia, -1, 0))[..., 0].min()
        assert smallest >= -solved.n * solved.bounds["inertia"]


@examples(40)
@given(arms_with_states(massive=True))
def test_inertia_is_positive_definite_where_every_link_has_mass_and_inertia(case):
    solved = Solved(*case)
    smallest = np.linalg.eigvalsh(np.moveaxis(solved.inertia.sum(axis=0), -1, 0))[:, 0].min()
    # Beyond what round-off could have lifted above zero.
    assert smallest > solved.n * solved.bounds["inertia"]


@examples(40)
@given(every_arm)
def test_composites_give_what_the_sums_over_links_give(case):
    solved = Solved(*case)
    literal = dalembert.inertia_by_link(solved.arm, solved.kinematics).sum(axis=1)
    gravity = dalembert.gravity_loading_by_link(solved.arm, solved.kinematics).sum(axis=0)
    h = literal_h(solved.arm, solved.kinematics, solved.qd)
    assert np.abs(solved.inertia - literal).max() <= solved.bounds["inertia"]
    assert np.abs(solved.c - gravity).max() <= solved.bounds["gravity_loading"]
    assert np.abs(solved.h - h).max() <= solved.bounds["coriolis_centrifugal"]


@examples(40)
@given(every_arm)
def test_christoffel_is_what_the_texts_terms_give_for_pairs_of_velocities(case):
    """Polarisation: h(e_j + e_k) - h(e_j) - h(e_k) = h_ijk + h_ikj."""
    solved = Solved(*case)
    n, count = solved.n, solved.q.shape[1]

    def h(velocities: FloatArray) -> FloatArray:
        return literal_h(solved.arm, solved.kinematics, np.repeat(velocities[:, None], count, axis=1))

    unit = [h(np.eye(n)[j]) for j in range(n)]
    for j in range(n):
        for k in range(j + 1):
            expected = unit[j] if j == k else 0.5 * (h(np.eye(n)[j] + np.eye(n)[k]) - unit[j] - unit[k])
            for found in (solved.christoffel[:, :, j, k], solved.christoffel[:, :, k, j]):
                # h(e_j + e_k) holds four products of velocities, the others one each: half of six, and ours.
                assert np.abs(found - expected).max() <= 4 * solved.christoffel_bound
        assert np.abs(unit[j][:, j]).max() <= solved.christoffel_bound  # h_jjj = 0, in the text's own terms


@examples(40)
@given(every_arm)
def test_christoffel_symmetries(case):
    christoffel = Solved(*case).christoffel
    n = christoffel.shape[1]
    np.testing.assert_array_equal(christoffel, christoffel.swapaxes(2, 3))
    for i in range(n):
        assert not christoffel[:, i, i, i].any()
        for m in range(i, n):
            for k in range(i + 1):
                np.testing.assert_array_equal(christoffel[:, m, k, i], -christoffel[:, i, k, m])


@examples(40)
@given(every_arm)
def test_h_and_its_centrifugal_share_are_contractions_of_the_christoffel(case):
    solved = Solved(*case)
    contracted = np.einsum("eijkN,jN,kN->eiN", solved.christoffel, solved.qd, solved.qd)
    assert np.abs(solved.h - contracted).max() <= solved.bounds["coriolis_centrifugal"]
    centrifugal = np.einsum("eijjN,jN->eiN", solved.christoffel, solved.qd**2)
    assert np.abs(solved.centrifugal - centrifugal).max() <= solved.bounds["coriolis_centrifugal"]


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
    gradient = np.array(
        [tf.derivative(lambda x: tf.potential_energy(solved.arm, x), q, e) for e in np.eye(solved.n)]
    )
    assert np.abs(solved.c - gradient).max() <= 2 * solved.bounds["gravity_loading"]


@examples(40)
@given(every_arm)
def test_rate_of_inertia_less_twice_coriolis_matrix_is_skew_for_each_effect(case):
    solved = Solved(*case)
    rate = tf.derivative(lambda x: _literal_inertia(solved.arm, x.T), solved.states.q, solved.states.qd)
    coriolis_matrix = np.einsum("eijkN,kN->eijN", solved.christoffel, solved.qd)
    skew = rate - 2 * coriolis_matrix
    # Ddot sums n slopes of D times a rate, C n coefficients; the transpose doubles it.
    tolerance = 2 * (2 + 2) * np.abs(solved.qd).sum(axis=0).max() * solved.christoffel_bound
    assert np.abs(skew + skew.swapaxes(1, 2)).max() <= tolerance


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


@pytest.mark.parametrize("name", ["puma560", "stanford", "two_link"])
def test_round_off_bounds_are_neither_hit_nor_idle(name):
    """A bound a million times what is seen, or not small beside the numbers, would prove nothing."""
    solved = Solved(load_arm(name), random_states(load_arm(name).n_joints, 200, 7))
    states = solved.states
    theirs = pinocchio_dynamics(solved.arm, states.q, states.qd, states.qdd)
    largest = np.abs(np.moveaxis(solved.inertia.sum(axis=0), -1, 0) - theirs["inertia"]).max()
    assert 1e-6 * solved.bounds["inertia"] <= largest <= solved.bounds["inertia"]
    scales = {
        "inertia": np.abs(theirs["inertia"]).max(),
        "coriolis_centrifugal": np.abs(theirs["coriolis_centrifugal"]).max(),
        "gravity_loading": np.abs(theirs["gravity_loading"]).max(),
        "torque": np.abs(theirs["torque"]).max(),
    }
    for quantity, scale in scales.items():
        assert solved.bounds[quantity] <= 1e-9 * scale, quantity


@examples(30)
@given(arms_with_states())
def test_h_is_quadratic_in_the_velocities(case):
    """Doubling is exact in binary, and so must be the fourfold h."""
    solved = Solved(*case)
    states = solved.states
    doubled = Solved(solved.arm, States(states.q, 2 * states.qd, states.qdd))
    np.testing.assert_array_equal(doubled.h, 4 * solved.h)


def _literal_inertia(arm: RobotArm, q: FloatArray) -> FloatArray:
    return dalembert.inertia_by_link(arm, solve_kinematics(arm, q)).sum(axis=1)


def itemised(arm, q, qd):
    return dalembert.coriolis_centrifugal_by_link(arm, solve_kinematics(arm, q), qd)


@examples(20)
@given(arms_with_states())
def test_a_link_acts_on_no_joint_beyond_it(case):
    arm, states = case
    q, qd, _ = states.last
    terms = itemised(arm, q, qd)
    for s in range(arm.n_joints):
        assert not terms[:, s, s + 1 :].any()
    assert len(terms) == (6 if all(arm.is_revolute) else 7)


@examples(20)
@given(arms_with_states(revolute=True))
def test_purely_coriolis_terms_vanish_when_one_joint_moves(case):
    """T2, T4 and R1 need two different velocities; T1, T3, R2 are centrifugal too."""
    arm, states = case
    q, qd, _ = states.last
    bound = round_off_bounds(arm, states.q, states.qd, states.qdd)["coriolis_centrifugal"]
    for j in range(arm.n_joints):
        terms = itemised(arm, q, qd * (np.arange(arm.n_joints) == j)[:, None])
        for t in (1, 3, 4):
            # b is sums of z x z, zero to the last bit for a cross product with itself.
            assert np.abs(terms[t]).max() <= bound
