"""A model held against its own arm and against another, along trajectories and at drawn states."""

from __future__ import annotations

import csv
import dataclasses

import numpy as np
import pytest

from gd_analyze.dynamics.decomposition import decompose, decompose_states
from gd_analyze.errors import ArmError, ModelError, TrajectoryError
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.evaluation import evaluate, torque_csv
from made_models import exact_model


@pytest.fixture(scope="module")
def model(puma):
    return exact_model(puma, drives=False)


@pytest.fixture(scope="module")
def carrying(puma):
    return with_payload(puma, 1.5, [0.0, 0.0, 0.1])


def test_drawn_states(model, puma):
    states = states_in_box(puma, 50)
    found = evaluate(model, states)
    expected = decompose_states(puma, states, christoffel=False, drives=False)["torque"]
    np.testing.assert_array_equal(found.dynamics.torque, expected)
    np.testing.assert_array_equal(found.torque, model.torque(*states.arrays))
    # Identification is exact to a few hundred roundings of the largest torque.
    assert (found.errors.largest <= 1e-10 * found.errors.peak_torque.max()).all()


def test_a_trajectory_its_set_points_and_its_decomposition_are_the_same(
    model, pick_and_place, pick_and_place_dataset
):
    along = evaluate(model, pick_and_place)
    for again in (evaluate(model, states_of(pick_and_place)), evaluate(model, pick_and_place_dataset)):
        np.testing.assert_array_equal(again.dynamics.torque, along.dynamics.torque)
        np.testing.assert_array_equal(again.torque, along.torque)
        assert again.dynamics.states.described == along.dynamics.states.described
    np.testing.assert_array_equal(along.dynamics.torque, pick_and_place_dataset.torque)


def test_another_arms_torque_counts(model, carrying, pick_and_place):
    found = evaluate(model, pick_and_place, carrying)
    own = evaluate(model, pick_and_place)
    np.testing.assert_array_equal(
        found.dynamics.torque, decompose(carrying, pick_and_place, drives=False).torque
    )
    np.testing.assert_array_equal(found.torque, own.torque)
    assert found.errors.largest_share.max() > 0.1
    again = evaluate(model, decompose(carrying, pick_and_place, christoffel=False, drives=False), carrying)
    np.testing.assert_array_equal(again.errors.largest, found.errors.largest)


def test_drives_of_the_other_arm_count_where_the_model_has_them(puma, carrying, pick_and_place):
    model = exact_model(puma, drives=True)
    found = evaluate(model, pick_and_place, carrying)
    expected = decompose(carrying, pick_and_place, drives=True).torque
    np.testing.assert_array_equal(found.dynamics.torque, expected)
    without = dataclasses.replace(carrying, drives=())
    with pytest.raises(ArmError, match="describes no drives"):
        evaluate(model, pick_and_place, without)


def test_an_arm_of_other_joints_is_refused(model, two_link, pick_and_place):
    with pytest.raises(ModelError, match="not of arm two_link") as caught:
        evaluate(model, pick_and_place, two_link)
    assert caught.value.details["found"] == "2 joints"


def test_a_decomposition_of_another_arm_is_refused(model, carrying, pick_and_place, pick_and_place_dataset):
    with pytest.raises(ModelError, match="another arm") as caught:
        evaluate(model, pick_and_place_dataset, carrying)
    assert caught.value.details["where"] == "arm_fingerprint"
    with pytest.raises(ModelError, match="another arm"):
        evaluate(model, decompose(carrying, pick_and_place, christoffel=False, drives=False))
    with pytest.raises(ModelError, match="differs from the model in its drives"):
        evaluate(model, decompose(model.arm, pick_and_place, christoffel=False))


def test_states_of_another_arm_are_refused(model, swing):
    for given in (swing, States(*np.zeros((3, 2, 5)))):
        with pytest.raises(TrajectoryError):
            evaluate(model, given)


def test_torques_as_csv_lose_no_digit(model, pick_and_place):
    found = evaluate(model, pick_and_place)
    header, *rows = csv.reader(torque_csv(pick_and_place, found).splitlines())
    assert header == ["time", *(f"exact{i}" for i in range(1, 7)), *(f"simplified{i}" for i in range(1, 7))]
    numbers = np.array([[float(cell) for cell in row] for row in rows])
    expected = np.column_stack([pick_and_place.time, found.dynamics.torque, found.torque])
    np.testing.assert_array_equal(numbers, expected)
