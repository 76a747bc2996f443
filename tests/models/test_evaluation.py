"""A model held against its own arm and against another, along trajectories and at drawn states."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from harmonic_models import exact_model

from gd_analyze.decomposition import decompose, decompose_states
from gd_analyze.errors import ArmError, ModelError, TrajectoryError
from gd_analyze.models import evaluate
from gd_analyze.models.evaluation import evaluate_states
from gd_analyze.robots import with_payload
from gd_analyze.simplification.states import States, states_in_box


@pytest.fixture(scope="module")
def model(puma):
    return exact_model(puma)


@pytest.fixture(scope="module")
def carrying(puma):
    return with_payload(puma, 1.5, [0.0, 0.0, 0.1])


def test_drawn_states(model, puma):
    states = states_in_box(puma, 50)
    found = evaluate_states(model, states)
    expected = decompose_states(puma, states.q, states.qd, states.qdd, coupling=False)["torque"]
    np.testing.assert_array_equal(found.exact, expected)
    np.testing.assert_array_equal(found.simplified, model.torque(states.q, states.qd, states.qdd))
    # Identification is exact to a few hundred roundings of the largest torque.
    assert (found.table.largest <= 1e-10 * found.table.peak_torque.max()).all()


def test_set_points_are_states_too(model, pick_and_place):
    along, at = evaluate(model, pick_and_place), evaluate_states(model, pick_and_place)
    np.testing.assert_array_equal(along.exact, at.exact)
    np.testing.assert_array_equal(along.simplified, at.simplified)


def test_another_arms_torque_counts(model, carrying, pick_and_place):
    found = evaluate(model, pick_and_place, arm=carrying)
    own = evaluate(model, pick_and_place)
    np.testing.assert_array_equal(found.exact, decompose(carrying, pick_and_place).torque)
    np.testing.assert_array_equal(found.simplified, own.simplified)
    assert found.table.largest_share.max() > 0.1
    dataset = decompose(carrying, pick_and_place, coupling=False)
    again = evaluate(model, pick_and_place, dataset, arm=carrying)
    np.testing.assert_array_equal(again.table.largest, found.table.largest)
    at = evaluate_states(model, pick_and_place, carrying)
    np.testing.assert_array_equal(at.table.largest, found.table.largest)


def test_drives_of_the_other_arm_count_where_the_model_has_them(puma, carrying, pick_and_place):
    model = exact_model(puma, drives=True)
    found = evaluate(model, pick_and_place, arm=carrying)
    np.testing.assert_array_equal(found.exact, decompose(carrying, pick_and_place, drives=True).torque)
    without = dataclasses.replace(carrying, drives=())
    with pytest.raises(ArmError, match="describes no drives"):
        evaluate(model, pick_and_place, arm=without)
    with pytest.raises(ArmError, match="describes no drives"):
        evaluate_states(model, pick_and_place, without)


def test_an_arm_of_other_joints_is_refused(model, two_link, pick_and_place):
    with pytest.raises(ModelError, match="not of arm two_link") as caught:
        evaluate(model, pick_and_place, arm=two_link)
    assert caught.value.details["found"] == "2 joints"
    with pytest.raises(ModelError, match="not of arm two_link"):
        evaluate_states(model, pick_and_place, two_link)


def test_a_decomposition_of_another_arm_is_refused(model, carrying, pick_and_place, pick_and_place_dataset):
    evaluate(model, pick_and_place, pick_and_place_dataset)
    with pytest.raises(ModelError, match="another arm") as caught:
        evaluate(model, pick_and_place, pick_and_place_dataset, arm=carrying)
    assert caught.value.details["where"] == "arm_fingerprint"
    with pytest.raises(ModelError, match="another arm"):
        evaluate(model, pick_and_place, decompose(carrying, pick_and_place, coupling=False))
    with pytest.raises(ModelError, match="differs from the model in its drives"):
        evaluate(model, pick_and_place, decompose(model.arm, pick_and_place, coupling=False, drives=True))


def test_states_of_another_arm_are_refused(model, swing):
    with pytest.raises(TrajectoryError):
        evaluate_states(model, swing)
    with pytest.raises(TrajectoryError):
        evaluate_states(model, States(np.zeros((2, 6)), np.zeros((2, 6)), np.zeros((3, 6)), {}))
