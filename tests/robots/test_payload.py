"""A payload in the last link: exact, linear in its moments, and what Pinocchio makes of it."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.dynamics.pinocchio_check import pinocchio_model, round_off_bounds
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import fingerprint
from gd_analyze.robots.parts import Joint, Link
from gd_analyze.robots.payload import Payload, parse_payload, with_payload
from strategies import arms_with_states, examples, random_inertia

EPS = float(np.finfo(float).eps)


@st.composite
def payloads(draw: st.DrawFn) -> Payload:
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    inertia = random_inertia(rng) if draw(st.booleans()) else np.zeros((3, 3))
    # Within 0.05 m: an arm of no reach would call a farther one suspicious.
    return Payload(rng.uniform(0.1, 5.0), rng.uniform(-0.05, 0.05, 3), inertia)


def carrying(arm: RobotArm, payload: Payload) -> RobotArm:
    return with_payload(arm, payload.mass, payload.position, payload.inertia)


def massless(arm: RobotArm) -> RobotArm:
    links = tuple(dataclasses.replace(link, mass=0.0, inertia_com=np.zeros((3, 3))) for link in arm.links)
    return dataclasses.replace(arm, links=links)


def second_moment(mass: float, com: FloatArray, inertia: FloatArray) -> FloatArray:
    """4x4 pseudo-inertia about the link frame: masses, first and second moments, all of which add up."""
    out = np.empty((4, 4))
    out[:3, :3] = 0.5 * np.trace(inertia) * np.eye(3) - inertia + mass * np.outer(com, com)
    out[:3, 3] = out[3, :3] = mass * com
    out[3, 3] = mass
    return out


@examples(30)
@given(arms_with_states(max_joints=3), payloads())
def test_moments_add_up(case, payload):
    arm, _ = case
    before, after = arm.links[-1], carrying(arm, payload).links[-1]
    assert arm.links[-1] is before
    expected = second_moment(before.mass, before.com, before.inertia_com) + second_moment(
        payload.mass, payload.position, payload.inertia
    )
    found = second_moment(after.mass, after.com, after.inertia_com)
    # Some ten roundings of the largest of the numbers added.
    np.testing.assert_allclose(found, expected, atol=20 * EPS * np.abs(expected).max())


@examples(15)
@given(arms_with_states(max_joints=6), payloads())
def test_torque_is_that_of_the_arm_and_of_the_payload_alone(case, payload):
    arm, states = case
    q, qd, qdd = states.last
    loaded, alone = carrying(arm, payload), carrying(massless(arm), payload)
    bound = round_off_bounds(loaded, states.q, states.qd, states.qdd)["torque"]
    for name, method in METHODS.items():
        with_it, without, its = (method.torque(which, q, qd, qdd) for which in (loaded, arm, alone))
        # Three torques, each within twice the bound as in the agreement of the formulations.
        assert np.abs(with_it - without - its).max() <= 6 * bound, name


@examples(15)
@given(arms_with_states(max_joints=6), payloads())
def test_pinocchio_agrees_when_the_body_is_hung_onto_its_model(case, payload):
    import pinocchio as pin

    arm, states = case
    model = pinocchio_model(arm)
    frame = arm.links[-1].frame
    body = pin.Inertia(payload.mass, np.array(payload.position), np.array(payload.inertia))
    model.appendBodyToJoint(
        arm.n_joints, body, pin.SE3(np.array(frame.rotation), np.array(frame.translation))
    )
    data = model.createData()
    theirs = np.array([pin.rnea(model, data, *state).copy() for state in zip(*states.arrays, strict=True)])
    loaded = carrying(arm, payload)
    method = METHODS["composite_moments"]
    ours = method.torque(loaded, *states.last).T
    # Merging rounds some ten times more than either program.
    bound = round_off_bounds(loaded, states.q, states.qd, states.qdd)["torque"]
    assert np.abs(ours - theirs).max() <= 2 * bound


def test_a_payload_of_nothing_changes_nothing(puma):
    loaded = with_payload(puma, 0.0, [0.1, 0.2, 0.3])
    assert fingerprint(loaded) == fingerprint(puma)


def test_uncertainties_remain_those_of_the_link_without_its_payload(puma):
    last = puma.links[-1]
    once = with_payload(puma, 1.5, [0, 0, 0.1]).links[-1].uncertainty
    np.testing.assert_array_equal(once.inertia, last.uncertainty.inertia)
    assert once.body_mass == last.mass
    np.testing.assert_array_equal(once.body_com, last.com)
    twice = with_payload(with_payload(puma, 1.5, [0, 0, 0.1]), 0.5, [0.1, 0, 0]).links[-1].uncertainty
    for name, value in vars(once).items():
        np.testing.assert_array_equal(getattr(twice, name), value)
    silent = RobotArm("a", (Joint("1"),), (Link("l", 1.0, np.zeros(3), np.eye(3)),))
    assert with_payload(silent, 1.0, [0, 0, 0.05]).links[-1].uncertainty is None


def test_the_three_ways_to_give_an_inertia():
    tensor = np.array([[0.3, -0.01, 0.02], [-0.01, 0.2, 0.03], [0.02, 0.03, 0.25]])
    six = [0.3, 0.2, 0.25, -0.01, 0.02, 0.03]
    text = ",".join(map(str, [1.0, 0, 0, 0, *six]))
    arm = RobotArm("a", (Joint("1"),), (Link("l", 0.0, np.zeros(3), np.zeros((3, 3))),))
    for found in (
        with_payload(arm, 1.0, np.zeros(3), tensor).inertia_com[0],
        with_payload(arm, 1.0, np.zeros(3), six).inertia_com[0],
        parse_payload(text).inertia,
    ):
        np.testing.assert_array_equal(found, tensor)
    diagonal = with_payload(arm, 1.0, np.zeros(3), [0.3, 0.2, 0.25]).inertia_com[0]
    np.testing.assert_array_equal(diagonal, np.diag([0.3, 0.2, 0.25]))


def test_parsing():
    payload = parse_payload(" 1.5, 0, -0.02 ,1e-1")
    assert payload.mass == 1.5
    assert payload.position.tolist() == [0.0, -0.02, 0.1]
    assert not payload.inertia.any()
    assert parse_payload("1.5,0,0,0.1,0.01,0.02,0.03").inertia.diagonal().tolist() == [0.01, 0.02, 0.03]
    with pytest.raises(ValueError, match="read-only"):
        payload.position[0] = 1.0


@pytest.mark.parametrize(
    ("text", "what", "found"),
    [
        ("1.5,0,0", "not 4, 7 or 10", "3 numbers"),
        ("1.5,0,0,0.1,0.2", "not 4, 7 or 10", "5 numbers"),
        ("1.5,0,zero,0.1", "not 4, 7 or 10", "'zero'"),
        ("", "not 4, 7 or 10", "''"),
        ("nan,0,0,0.1", "not 4, 7 or 10", "'nan'"),
        ("1_0,0,0,0.1", "not 4, 7 or 10", "'1_0'"),
        ("1.5;0;0;0.1", "not 4, 7 or 10", "'1.5;0;0;0.1'"),
    ],
)
def test_text_that_is_no_payload(text, what, found):
    with pytest.raises(UsageError, match=what) as caught:
        parse_payload(text)
    assert caught.value.details["found"] == found
    assert "mass,x,y,z" in caught.value.details["expected"]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("-1,0,0,0.1", "mass of link payload is negative"),
        ("1e300,0,0,0.1", "too large for any arm"),
    ],
)
def test_payloads_that_cannot_be(text, what):
    with pytest.raises(ArmError, match=what):
        parse_payload(text)


def test_shapes_that_do_not_fit(puma):
    with pytest.raises(ArmError, match="wrong shape"):
        with_payload(puma, 1.0, [0.0, 0.0])
    with pytest.raises(ArmError, match="inertia of the payload has the wrong shape") as caught:
        with_payload(puma, 1.0, [0.0, 0.0, 0.1], [0.1, 0.1])
    assert caught.value.details["found"] == "shape (2,)"
