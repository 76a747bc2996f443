"""A payload in the last link: exact, and what Pinocchio makes of it."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from arm_files import link
from gd_analyze import load_arm, save_arm
from gd_analyze.dynamics.pinocchio_check import pinocchio_model, round_off_bounds
from gd_analyze.errors import ArmError, GdAnalyzeError, GdAnalyzeWarning, UsageError
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.robots.description import describe, fingerprint
from gd_analyze.robots.payload import parse_payload
from gd_analyze.tables import decompose_states, torque_uncertainty, with_payload
from gd_analyze.types import Joint, RobotArm
from strategies import arms_with_states, examples, random_inertia, random_states

EPS = float(np.finfo(float).eps)


@examples(20)
@given(arms_with_states(max_joints=6), st.integers(0, 2**32 - 1))
def test_pinocchio_agrees_when_the_body_is_hung_onto_its_model(case, seed):
    arm, states = case
    rng = np.random.default_rng(seed)
    # Within 0.05 m: an arm of no reach would call a farther one suspicious.
    mass, place, inertia = rng.uniform(0.1, 5.0), rng.uniform(-0.05, 0.05, 3), random_inertia(rng)
    model, frame = pinocchio_model(arm), arm.links[-1].frame
    turn, offset = np.array(frame.rotation), np.array(frame.translation)
    model.appendBodyToJoint(arm.n_joints, pin.Inertia(mass, place, inertia), pin.SE3(turn, offset))
    data = model.createData()
    theirs = np.array([pin.rnea(model, data, *state).copy() for state in zip(*states.arrays, strict=True)])
    loaded = with_payload(arm, mass, place, inertia)
    # Merging rounds some ten times more than either program.
    bound = round_off_bounds(loaded, states.q, states.qd, states.qdd)["torque"]
    assert np.abs(decompose_states(loaded, states, drives=False)["torque"] - theirs).max() <= 2 * bound
    before, after = arm.links[-1], loaded.links[-1]
    assert after.mass == before.mass + mass
    moment = before.mass * before.com + mass * place
    np.testing.assert_allclose(after.mass * after.com, moment, atol=20 * EPS * np.abs(moment).max())


def test_a_payload_of_nothing_changes_nothing(puma):
    assert fingerprint(with_payload(puma, 0.0, [0.1, 0.2, 0.3])) == fingerprint(puma)


def test_uncertainties_remain_those_of_the_link_without_its_payload(puma):
    last = puma.links[-1]
    once = with_payload(puma, 1.5, [0, 0, 0.1]).links[-1].uncertainty
    np.testing.assert_array_equal(once.inertia, last.uncertainty.inertia)
    twice = with_payload(with_payload(puma, 1.5, [0, 0, 0.1]), 0.5, [0.1, 0, 0]).links[-1]
    assert twice.bare is last
    for name, value in vars(once).items():
        np.testing.assert_array_equal(getattr(twice.uncertainty, name), value)


def test_uncertainties_of_a_loaded_arm_survive_its_description_and_its_file(puma, tmp_path):
    loaded = with_payload(puma, 1.5, [0, 0, 0.1])
    save_arm(loaded, tmp_path / "loaded.toml")
    states = random_states(6, 5, 3)
    for again in (arm_in(describe(loaded)), load_arm(tmp_path / "loaded.toml")):
        assert describe(again) == describe(loaded)
        np.testing.assert_array_equal(torque_uncertainty(again, states), torque_uncertainty(loaded, states))


def test_the_ways_to_give_an_inertia():
    tensor = np.array([[0.3, -0.01, 0.02], [-0.01, 0.2, 0.03], [0.02, 0.03, 0.25]])
    six = [0.3, 0.2, 0.25, -0.01, 0.02, 0.03]
    arm = RobotArm("a", (Joint("1"),), (link(mass=0.0, inertia_com=np.zeros((3, 3))),))
    body = parse_payload(" 1.5, 0, -0.02 ,1e-1," + ",".join(map(str, six)))
    assert (body.mass, body.com.tolist()) == (1.5, [0.0, -0.02, 0.1])
    for inertia in (tensor, six, body.inertia_com):
        np.testing.assert_array_equal(with_payload(arm, 1.0, np.zeros(3), inertia).inertia_com[0], tensor)
    assert parse_payload("1.5,0,0,0.1,0.3,0.2,0.25").inertia_com.tolist() == np.diag(six[:3]).tolist()
    assert not parse_payload("1.5,0,0,0.1").inertia_com.any()


@pytest.mark.parametrize(
    ("text", "error", "fact"),
    [
        ("1.5,0,0,0.1,0.2", UsageError, "5 numbers"),
        ("1.5,0,zero,0.1", UsageError, "'zero'"),
        ("nan,0,0,0.1", UsageError, "'nan'"),
        ("-1,0,0,0.1", ArmError, "mass of link payload is negative"),
        ("1e300,0,0,0.1", ArmError, "too large for any arm"),
    ],
)
def test_text_that_is_no_payload(text, error, fact):
    with pytest.raises(GdAnalyzeError, match=fact) as caught:
        parse_payload(text)
    assert type(caught.value) is error


def test_shapes_that_do_not_fit(puma):
    for place, inertia in (([0.0, 0.0], None), ([0.0, 0.0, 0.1], [0.1, 0.1])):
        with pytest.raises(ArmError, match="wrong shape"):
            with_payload(puma, 1.0, place, inertia)


@pytest.mark.parametrize(
    ("given_payload", "fact"),
    [
        ((2500.0, [0.0, 0.0, 0.1]), "in grams"),
        ((1.5, [0.0, 0.0, 100.0]), "metres"),
        ((1.0, [0.0, 0.0, 0.1], [0.1, 0.1, 0.3]), "by 33 %"),
        ((1.0, [0.0, 0.0, 0.1], [-0.1, 0.1, 0.1]), "by 100 %"),
    ],
)
def test_an_implausible_payload_is_warned_of(puma, given_payload, fact):
    with pytest.warns(GdAnalyzeWarning, match=fact) as caught:
        with_payload(puma, *given_payload)
    assert len(caught) == 1
