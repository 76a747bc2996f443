"""The dynamics of an arm: Pinocchio's numbers, any leading shape, parts that sum to the whole."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.types import ArmDynamics
from strategies import arms_with_states, examples, random_states

EPS = float(np.finfo(float).eps)


@examples(30)
@given(arms_with_states())
def test_they_are_pinocchios(case):
    arm, states = case
    dynamics = ArmDynamics(arm)
    expected, bounds = (f(arm, *states.arrays) for f in (pinocchio_dynamics, round_off_bounds))
    q, qd, qdd = states.arrays
    computed = {
        "inertia": dynamics.inertia(q),
        "coriolis_centrifugal": dynamics.coriolis_centrifugal(q, qd),
        "gravity_loading": dynamics.gravity_loading(q),
        "torque": dynamics.torque(q, qd, qdd),
    }
    for name, value in computed.items():
        # The bound on the difference of two correct programs.
        np.testing.assert_allclose(value, expected[name], rtol=0, atol=bounds[name], err_msg=name)


@examples(30)
@given(arms_with_states())
def test_parts_sum_to_the_whole(case):
    arm, states = case
    dynamics = ArmDynamics(arm)
    q, qd = states.q, states.qd
    bounds = round_off_bounds(arm, *states.arrays)
    inertia = dynamics.inertia(q, by_effect=True).sum(axis=-3)
    # The same two numbers are added in both.
    np.testing.assert_array_equal(inertia, dynamics.inertia(q))
    coefficients = dynamics.christoffel(q, by_effect=True).sum(axis=-4)
    np.testing.assert_array_equal(coefficients, dynamics.christoffel(q))
    h = dynamics.coriolis_centrifugal(q, qd, by_effect=True).sum(axis=-2)
    np.testing.assert_array_equal(h, dynamics.coriolis_centrifugal(q, qd))
    # The bound covers h as a sum over all j and k.
    summed = np.einsum("...ijk,...j,...k->...i", coefficients, qd, qd)
    np.testing.assert_allclose(summed, h, rtol=0, atol=bounds["coriolis_centrifugal"])


@examples(30)
@given(
    arms_with_states(max_joints=4, massive=True, count=1),
    st.lists(st.integers(0, 3), max_size=3),
    st.integers(0, 2**32 - 1),
)
def test_leading_axes_are_those_given(case, leading, seed):
    arm, n, shape = case[0], case[0].n, tuple(leading)
    dynamics = ArmDynamics(arm)
    count = int(np.prod(shape))
    drawn = random_states(n, count, seed)
    q, qd, qdd = (x.reshape(*shape, n) for x in drawn.arrays)
    results = {
        "inertia": dynamics.inertia(q),
        "christoffel": dynamics.christoffel(q),
        "coriolis_centrifugal": dynamics.coriolis_centrifugal(q, qd),
        "gravity_loading": dynamics.gravity_loading(q),
        "torque": dynamics.torque(q, qd, qdd),
    }
    axes = {"inertia": 2, "christoffel": 3}
    for name, value in results.items():
        assert value.shape == shape + (n,) * axes.get(name, 1), name
    assert dynamics.inertia(q, by_effect=True).shape == (*shape, 2, n, n)
    assert dynamics.forward_dynamics(q, qd, results["torque"]).shape == (*shape, n)
    if count:
        first = tuple(0 for _ in shape)
        # Sums over other states run side by side, in any order: within the bound of two programs.
        bounds = round_off_bounds(arm, *(x.reshape(-1, n) for x in (q, qd, qdd)))
        alone = dynamics.torque(q[first], qd[first], qdd[first])
        np.testing.assert_allclose(results["torque"][first], alone, rtol=0, atol=bounds["torque"])
        # A single velocity and acceleration for all positions.
        spread = dynamics.torque(q, qd[first], qdd[first])
        whole = dynamics.torque(q, np.broadcast_to(qd[first], q.shape), np.broadcast_to(qdd[first], q.shape))
        np.testing.assert_array_equal(spread, whole)


@pytest.mark.parametrize("drives", [None, True, False])
def test_drives_and_names_are_those_of_the_arm_and_of_a_model(puma, pick_and_place, drives):
    q, qd, qdd = pick_and_place.q, pick_and_place.qd, pick_and_place.qdd
    assert puma.n == 6
    assert puma.joint_names == ("waist", "shoulder", "elbow", "wrist roll", "wrist bend", "flange")
    dynamics = ArmDynamics(puma)
    inertia, torque = dynamics.inertia(q, drives=drives), dynamics.torque(q, qd, qdd, drives=drives)
    added = np.zeros(6) if drives is False else puma.drive_inertia
    np.testing.assert_array_equal(inertia, dynamics.inertia(q, by_effect=True).sum(axis=1) + np.diag(added))
    bounds = round_off_bounds(puma, q, qd, qdd)
    summed = np.einsum("...ij,...j->...i", inertia, qdd)
    summed += dynamics.coriolis_centrifugal(q, qd) + dynamics.gravity_loading(q)
    np.testing.assert_allclose(torque, summed, rtol=0, atol=2 * bounds["torque"])
    # A backward error of n^2 eps |D| |qdd| and two torques' round-off, times the condition number of D.
    back = dynamics.forward_dynamics(q, qd, torque, drives=drives)
    inverse = np.linalg.norm(np.linalg.inv(inertia), axis=(-2, -1)).max()
    size = np.linalg.norm(inertia, axis=(-2, -1)).max() * np.abs(qdd).max()
    np.testing.assert_allclose(back, qdd, rtol=0, atol=inverse * (4 * bounds["torque"] + 36 * EPS * size))


def test_an_exact_model_has_the_same_methods(two_link, swing):
    model = gd.simplify(two_link, swing, "0")
    q, qd, qdd = swing.q, swing.qd, swing.qdd
    bounds = round_off_bounds(two_link, q, qd, qdd)
    for name, states in {
        "inertia": (q,),
        "gravity_loading": (q,),
        "coriolis_centrifugal": (q, qd),
        "torque": (q, qd, qdd),
    }.items():
        values = (getattr(each, name)(*states) for each in (ArmDynamics(two_link), model))
        # Its program multiplies coefficients out, which takes some more roundings than the bound counts.
        np.testing.assert_allclose(*values, rtol=0, atol=4 * bounds[name], err_msg=name)


def test_wrong_states_are_refused(puma, two_link):
    q, of_puma, of_two_links = np.zeros(6), ArmDynamics(puma), ArmDynamics(two_link)
    for call, told in (
        (lambda: of_puma.inertia(np.zeros(5)), "q does not fit arm puma560"),
        (lambda: of_puma.inertia("D"), "q is not made of numbers"),
        (lambda: of_puma.gravity_loading(np.full(6, np.nan)), "q is not finite"),
        (lambda: of_puma.christoffel(None), "q is not made of numbers"),
        (lambda: of_puma.torque(np.zeros((2, 6)), np.zeros((3, 6)), q), "differ in shape"),
        (lambda: of_puma.inertia(q, by_effect=True, drives=True), "neither effect"),
        (lambda: of_puma.forward_dynamics(q, q, np.zeros(7)), "torque does not fit"),
    ):
        with pytest.raises(UsageError, match=told):
            call()
    for call in (
        lambda: of_two_links.torque([0, 0], [0, 0], [0, 0], drives=True),
        lambda: of_two_links.inertia([0, 0], drives=True),
    ):
        with pytest.raises(ArmError, match="describes no drives"):
            call()
