"""Evaluating a model: its quantities, the shapes it takes, and what it refuses."""

from __future__ import annotations

import csv

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.decomposition import decompose_states
from gd_analyze.errors import ModelError, TrajectoryError
from gd_analyze.models import ElementModel, ErrorTable, evaluate, parts_of, torque_csv
from gd_analyze.operations import OperationCount
from gd_analyze.pinocchio_check import round_off_bounds
from gd_analyze.simplification import Budget, simplify
from strategies import arms_with_states, examples, random_states


def model_keeping(arm, kept) -> ElementModel:
    nothing = np.zeros(arm.n_joints)
    return ElementModel(
        arm=arm,
        level="element",
        kept=tuple(kept),
        drives=False,
        budget=nothing,
        budget_stated="none",
        promise=ErrorTable.nothing(arm.n_joints),
        made_for={},
        operations_full=OperationCount(0, 0, 0),
    )


@pytest.fixture(scope="module")
def model(puma, pick_and_place_dataset) -> ElementModel:
    return simplify(puma, pick_and_place_dataset, Budget.parse("5%"), level="element")


@examples(25)
@given(arms_with_states(max_joints=4), st.integers(0, 2**32 - 1))
def test_a_model_is_the_sum_of_what_it_keeps(case, seed):
    arm, states = case
    parts = parts_of(arm.n_joints)
    kept = [
        p for p, keep in zip(parts, np.random.default_rng(seed).random(len(parts)) < 0.5, strict=True) if keep
    ]
    model = model_keeping(arm, [p.label for p in kept])
    found = decompose_states(arm, states.q, states.qd, states.qdd)
    n, count = arm.n_joints, len(states.q)
    inertia, h, c = np.zeros((count, n, n)), np.zeros((count, n)), np.zeros((count, n))
    for part in kept:
        i, j, e = part.element.i, part.element.j, ("translation", "rotation").index(part.effect)
        if part.element.quantity == "gravity_loading":
            c[:, i] = found["gravity_loading"][:, i]
        elif j is None:
            h[:, i] += found["coriolis_centrifugal"][:, e, i]
        else:
            inertia[:, i, j] += found["inertia"][:, e, i, j]
            inertia[:, j, i] = inertia[:, i, j]
    torque = np.einsum("tij,tj->ti", inertia, states.qdd) + h + c
    bounds = round_off_bounds(arm, states.q, states.qd, states.qdd)  # two correct programs
    assert np.abs(model.inertia(states.q) - inertia).max() <= bounds["inertia"]
    assert np.abs(model.coriolis_centrifugal(states.q, states.qd) - h).max() <= bounds["coriolis_centrifugal"]
    assert np.abs(model.gravity_loading(states.q) - c).max() <= bounds["gravity_loading"]
    assert np.abs(model.torque(states.q, states.qd, states.qdd) - torque).max() <= bounds["torque"]


def test_simplified_inertia_is_symmetric(model, rng):
    inertia = model.inertia(rng.uniform(-3, 3, (50, 6)))
    np.testing.assert_array_equal(inertia, inertia.swapaxes(1, 2))


def test_drives_stand_on_the_diagonal_of_inertia(puma_findings, puma):
    bare = model_keeping(puma, puma_findings.element_model.kept)
    q = puma_findings.trajectory.q
    added = puma_findings.element_model.inertia(q) - bare.inertia(q)
    np.testing.assert_allclose(
        added, np.diag(puma.drive_inertia) + 0 * added, rtol=0, atol=1e-14
    )  # eps of 6 kg m^2


def test_leading_axes(model):
    states = random_states(6, 6, 9)
    flat = model.torque(states.q, states.qd, states.qdd)
    nested = model.torque(*(x.reshape(2, 3, 6) for x in (states.q, states.qd, states.qdd)))
    np.testing.assert_array_equal(nested.reshape(6, 6), flat)
    single = model.torque(states.q[2], states.qd[2], states.qdd[2])
    assert single.shape == (6,)
    # cos and sin of one number and of several may take different paths: an ulp, as between two programs.
    bound = round_off_bounds(model.arm, states.q, states.qd, states.qdd)["torque"]
    assert np.abs(single - flat[2]).max() <= bound
    assert model.inertia(states.q[2]).shape == (6, 6)
    assert model.gravity_loading(np.empty((0, 6))).shape == (0, 6)


def test_states_broadcast_against_each_other(model):
    states = random_states(6, 5, 10)
    still = model.torque(states.q, np.zeros(6), np.zeros(6))
    np.testing.assert_array_equal(still, model.torque(states.q, np.zeros((5, 6)), np.zeros((5, 6))))


def test_lists_will_do(model):
    assert model.gravity_loading([0.0, 0.1, 0.2, 0.3, 0.4, 0.5]).shape == (6,)


@pytest.mark.parametrize("shape", [(), (5,), (7,), (4, 5), (0,)])
def test_states_of_another_arm_are_refused(model, shape):
    with pytest.raises(ModelError, match="does not fit") as caught:
        model.gravity_loading(np.zeros(shape))
    assert caught.value.details["expected"] == "shape (..., 6)"
    assert caught.value.details["found"] == str(shape)


def test_unknown_parts_are_refused(puma):
    with pytest.raises(ModelError, match=r"'D17 rotation' is not a part") as caught:
        model_keeping(puma, ["D17 rotation"])
    assert "D11 translation" in caught.value.details["expected"]


def test_parts_are_counted():
    assert len(parts_of(2)) == 12
    assert len(parts_of(6)) == 2 * 21 + 2 * 6 + 6
    assert len({p.label for p in parts_of(6)}) == 60


def test_error_table_by_hand():
    table = ErrorTable.of(np.array([[1.0, 0.0], [-4.0, 0.0]]), np.array([[1.0, 2.0], [-1.0, 0.0]]))
    assert table.peak_torque.tolist() == [4.0, 0.0]
    assert table.largest.tolist() == [3.0, 2.0]
    assert table.rms.tolist() == [np.sqrt(4.5), np.sqrt(2.0)]
    assert table.largest_share.tolist() == [0.75, np.inf]
    assert ErrorTable.of(np.ones((2, 2)), np.ones((2, 2))).largest_share.tolist() == [0.0, 0.0]


def test_round_off_is_no_error():
    exact = np.array([[1000.0, 0.0]])
    assert not ErrorTable.of(exact, exact + 1e-10).largest.any()
    assert ErrorTable.of(exact, exact + 1e-8).largest.all()


def test_evaluation_along_the_trajectory_it_was_made_for(model, pick_and_place, pick_and_place_dataset):
    found = evaluate(model, pick_and_place)
    np.testing.assert_array_equal(found.table.largest, model.promise.largest)
    np.testing.assert_array_equal(found.exact, pick_and_place_dataset.torque)
    assert found.within(model.budget).all()
    assert not found.within(0 * model.budget).all()


def test_evaluation_along_another_arms_trajectory_is_refused(model, swing):
    with pytest.raises(TrajectoryError, match="of another arm"):
        evaluate(model, swing)


def test_torques_as_csv_lose_no_digit(model, pick_and_place):
    found = evaluate(model, pick_and_place)
    header, *rows = csv.reader(torque_csv(pick_and_place, found).splitlines())
    assert header == ["time", *(f"exact{i}" for i in range(1, 7)), *(f"simplified{i}" for i in range(1, 7))]
    numbers = np.array([[float(cell) for cell in row] for row in rows])
    expected = np.column_stack([pick_and_place.time, found.exact, found.simplified])
    np.testing.assert_array_equal(numbers, expected)
