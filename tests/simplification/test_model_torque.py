"""A model held against its own arm and against another, along trajectories and at drawn states."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from gd_analyze import decompose
from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, ModelError
from gd_analyze.simplification.element import parts_of
from gd_analyze.simplification.model_torque import model_torque
from gd_analyze.tables import decompose_states, payload_effect, states_of, with_payload
from gd_analyze.types import Joint, Link, Placement, RobotArm, SimplifiedModel, States
from made_models import allowing, exact_model, model_of_parts
from strategies import arms_with_states, examples


@pytest.fixture(scope="module")
def model(puma):
    return exact_model(puma, drives=False)


@pytest.fixture(scope="module")
def carrying(puma):
    return with_payload(puma, 1.5, [0.0, 0.0, 0.1])


def test_a_trajectory_its_set_points_and_its_decomposition_are_the_same(
    model, pick_and_place, pick_and_place_dataset
):
    along = model_torque(model, pick_and_place)
    for again in (
        model_torque(model, states_of(pick_and_place)),
        model_torque(model, pick_and_place_dataset),
    ):
        np.testing.assert_array_equal(again.dynamics.torque, along.dynamics.torque)
        np.testing.assert_array_equal(again.torque, along.torque)
        assert again.dynamics.states.described == along.dynamics.states.described
    np.testing.assert_array_equal(along.dynamics.torque, pick_and_place_dataset.torque)


def test_another_arms_torque_counts(model, carrying, pick_and_place):
    found = model_torque(model, pick_and_place, carrying)
    own = model_torque(model, pick_and_place)
    np.testing.assert_array_equal(
        found.dynamics.torque, decompose(carrying, pick_and_place, drives=False).torque
    )
    np.testing.assert_array_equal(found.torque, own.torque)
    assert found.errors.largest_share.max() > 0.1
    again = model_torque(
        model, decompose(carrying, pick_and_place, christoffel=False, drives=False), carrying
    )
    np.testing.assert_array_equal(again.errors.largest, found.errors.largest)


def test_another_arm_is_refused(model, carrying, two_link, pick_and_place, pick_and_place_dataset):
    with pytest.raises(ModelError) as caught:
        model_torque(model, pick_and_place, two_link)
    assert (caught.value.details["where"], caught.value.details["found"]) == ("arm", "2 joints")
    with pytest.raises(ModelError, match="another arm") as caught:
        model_torque(model, pick_and_place_dataset, carrying)
    assert caught.value.details["where"] == "arm_fingerprint"
    with pytest.raises(ModelError) as caught:
        model_torque(model, decompose(model.arm, pick_and_place, christoffel=False))
    assert caught.value.details["where"] == "drives"


EPS = float(np.finfo(float).eps)
HAND = [0.0, 0.0, 0.0]


def model_without(arm: RobotArm, allowed: FloatArray, *dropped: str) -> SimplifiedModel:
    """A model that lacks some parts, with any budget."""
    kept = {part.label for part in parts_of(arm.n_joints)} - {*dropped}
    return allowing(model_of_parts(arm, kept), allowed)


@examples(20)
@given(arms_with_states(max_joints=4, massive=True), st.integers(0, 2**32 - 1))
def test_each_joint_leaves_its_budget_at_its_own_mass(case, seed):
    arm, states = case
    rng = np.random.default_rng(seed)
    labels = [part.label for part in parts_of(arm.n_joints)]
    made = model_without(arm, np.full(arm.n_joints, np.inf), *rng.choice(labels, 2))
    left_out = model_torque(made, states).errors.largest
    scale = np.abs(decompose_states(arm, states, christoffel=False)["torque"]).max()
    assume(scale > 0.1)
    made = allowing(made, left_out + rng.uniform(0.01, 0.1) * scale)
    effect = payload_effect(made, states)
    assert effect.largest_mass == effect.mass_within_budget.min()
    for joint, mass in enumerate(effect.mass_within_budget):
        # A joint that hardly feels the mass takes tons, and then the masses' round-off is what is compared.
        if mass > 1e3:
            continue
        carrying = with_payload(arm, mass, HAND)
        found = model_torque(made, states, carrying).errors.largest[joint]
        loaded = decompose_states(carrying, states, christoffel=False)["torque"]
        # Some thousand roundings of the largest torque of the arm with this mass.
        assert found == pytest.approx(made.accuracy.allowed[joint], abs=1e4 * EPS * np.abs(loaded).max())


def horizontal(com: float = 0.5) -> RobotArm:
    """One rod of 1 m in a vertical plane."""
    hand = Placement(np.eye(3), np.array([1.0, 0.0, 0.0]))
    link = Link("rod", 1.0, np.array([com - 1.0, 0.0, 0.0]), np.diag([0.0, 0.1, 0.1]), hand)
    with warnings.catch_warnings():
        # A counterweight is farther from the hand than the arm reaches, which is what is warned about.
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        return RobotArm("rod", (Joint("1"),), (link,), np.array([0.0, -10.0, 0.0]))


def at(*angles: float) -> States:
    q = np.array(angles)[:, None]
    return States(q, np.zeros_like(q), np.zeros_like(q))


def test_closed_form_of_a_rod_at_rest():
    """A kilogram at 1 m asks for 10 cos q N m; without gravity loading the model lacks 5 cos q."""
    whole = model_without(horizontal(), np.array([6.0]))
    found = payload_effect(whole, at(0.0, np.pi / 3, np.pi))
    # Products and a quotient of a few numbers.
    assert found.torque_per_kg == pytest.approx([10.0], rel=8 * EPS)
    assert found.mass_within_budget == pytest.approx([0.6], rel=8 * EPS)
    assert found.limiting_joint == 1
    lacking = model_without(horizontal(), np.array([6.0]), "c1")
    assert payload_effect(lacking, at(0.0, np.pi)).largest_mass == pytest.approx(0.1, rel=100 * EPS)


def test_a_payload_may_undo_an_error_first():
    """A counterweight behind the joint: what the model lacks is opposite to what the mass asks for."""
    lacking = model_without(horizontal(com=-0.5), np.array([6.0]), "c1")
    assert payload_effect(lacking, at(0.0)).largest_mass == pytest.approx(1.1, rel=100 * EPS)


def test_round_off_is_no_effect(rng):
    """The hand lies on an askew last axis, where products cancel but for the last digits."""
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    ends = np.array([0.4, 0.0, 0.3]), 0.3 * axis
    links = tuple(
        Link(str(i), 1.0, np.zeros(3), 0.1 * np.eye(3), Placement(np.eye(3), x)) for i, x in enumerate(ends)
    )
    arm = RobotArm("askew", (Joint("1"), Joint("2", axis=axis)), links, np.array([1.0, -2.0, 9.0]))
    states = States(*rng.uniform(-3, 3, (3, 50, 2)))
    found = payload_effect(model_without(arm, np.full(2, 0.1)), states)
    assert found.torque_per_kg[0] > 1.0
    assert (found.torque_per_kg[1], found.mass_within_budget[1]) == (0.0, np.inf)
