"""Evaluating a model: its quantities, the shapes it takes, and what it refuses."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.errors import ModelError
from gd_analyze.motions.states import states_of
from gd_analyze.simplification.accuracy import ErrorTable
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import parts_of
from gd_analyze.simplification.evaluation import evaluate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from made_models import by_elements, model_of_parts
from strategies import arms_with_states, examples, random_states


@pytest.fixture(scope="module", params=LEVELS)
def model(request, two_link, swing) -> SimplifiedModel:
    how = SearchOptions(LEVELS[request.param], dearer=True)
    return simplify_exact(ExactDynamics.of(two_link, swing), Budget.parse("50%"), how)


@pytest.fixture(scope="module")
def model_of_puma(puma, pick_and_place_dataset) -> SimplifiedModel:
    return by_elements(puma, pick_and_place_dataset, Budget.parse("5%"))


@examples(25)
@given(arms_with_states(max_joints=4), st.integers(0, 2**32 - 1))
def test_a_model_is_the_sum_of_what_it_keeps(case, seed):
    arm, states = case
    parts = parts_of(arm.n_joints)
    kept = [
        p for p, keep in zip(parts, np.random.default_rng(seed).random(len(parts)) < 0.5, strict=True) if keep
    ]
    model = model_of_parts(arm, [p.label for p in kept])
    found = decompose_states(arm, states)
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
    bounds = round_off_bounds(arm, *states.arrays)  # two correct programs
    assert np.abs(model.inertia(states.q) - inertia).max() <= bounds["inertia"]
    assert np.abs(model.coriolis_centrifugal(states.q, states.qd) - h).max() <= bounds["coriolis_centrifugal"]
    assert np.abs(model.gravity_loading(states.q) - c).max() <= bounds["gravity_loading"]
    assert np.abs(model.torque(*states.arrays) - torque).max() <= bounds["torque"]


def test_inertia_of_parts_is_symmetric(model_of_puma, rng):
    inertia = model_of_puma.inertia(rng.uniform(-3, 3, (50, 6)))
    np.testing.assert_array_equal(inertia, inertia.swapaxes(1, 2))


def test_drives_stand_on_the_diagonal_of_inertia(model_of_puma, puma, pick_and_place):
    kept = [part.label for part in model_of_puma.terms]
    bare, driven = (model_of_parts(puma, kept, drives) for drives in (False, True))
    added = driven.inertia(pick_and_place.q) - bare.inertia(pick_and_place.q)
    np.testing.assert_allclose(
        added, np.diag(puma.drive_inertia) + 0 * added, rtol=0, atol=1e-14
    )  # eps of 6 kg m^2


def test_leading_axes(model):
    states = random_states(2, 6, 9)
    flat = model.torque(*states.arrays)
    nested = model.torque(*(x.reshape(2, 3, 2) for x in states.arrays))
    np.testing.assert_array_equal(nested.reshape(6, 2), flat)
    single = model.torque(states.q[2], states.qd[2], states.qdd[2])
    assert single.shape == (2,)
    # cos and sin of one number and of several may take different paths: an ulp, as between two programs.
    assert np.abs(single - flat[2]).max() <= round_off_bounds(model.arm, *states.arrays)["torque"]
    assert model.inertia(states.q[2]).shape == (2, 2)
    assert model.inertia(states.q.reshape(2, 3, 2)).shape == (2, 3, 2, 2)
    assert model.gravity_loading(np.empty((0, 2))).shape == (0, 2)


def test_states_broadcast_against_each_other(model):
    states = random_states(2, 5, 10)
    still = model.torque(states.q, np.zeros(2), np.zeros(2))
    np.testing.assert_array_equal(still, model.torque(states.q, np.zeros((5, 2)), np.zeros((5, 2))))


def test_lists_will_do(model):
    assert model.gravity_loading([0.0, 0.1]).shape == (2,)


@pytest.mark.parametrize("shape", [(), (1,), (3,), (4, 5), (0,)])
def test_states_of_another_arm_are_refused(model, shape):
    with pytest.raises(ModelError, match="does not fit") as caught:
        model.gravity_loading(np.zeros(shape))
    assert caught.value.details["expected"] == "shape (..., 2)"
    assert caught.value.details["found"] == str(shape)


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


def test_it_errs_by_what_it_promises_where_it_was_made(model, swing):
    found = evaluate(model, swing)
    np.testing.assert_array_equal(found.errors.largest, model.accuracy.errors.largest)
    assert found.within(model.accuracy.allowed).all()
    assert not found.within(0 * model.accuracy.allowed).all()
    assert model.accuracy.fitted_on == states_of(swing).described
