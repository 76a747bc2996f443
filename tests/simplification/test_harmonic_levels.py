"""Simplification by harmonic terms: the budget promised is the error measured, and the count is small."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.decomposition import decompose_states
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.harmonics.lagrangian import energy_terms
from gd_analyze.simplification import simplify
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.states import States, states_in_box, states_of
from strategies import arms_with_states, examples, two_link_of


def measured(model, states) -> np.ndarray:
    """Largest error per joint against the numeric formulas, not against anything the search used."""
    exact = decompose_states(model.arm, states.q, states.qd, states.qdd, coupling=False, drives=model.drives)[
        "torque"
    ]
    return np.abs(model.torque(states.q, states.qd, states.qdd) - exact).max(axis=0)


def assert_promise_holds(model, states, allowed) -> None:
    error = measured(model, states)
    # What is round-off counts as no error in the promise: 1e-9 of the largest torque.
    slack = 1e-9 * model.promise.peak_torque.max()
    assert (error <= allowed + slack).all()
    assert np.abs(error - model.promise.largest).max() <= slack
    assert (model.promise.largest <= model.budget).all()


def test_puma_with_drives_within_one_percent_at_a_hundred_operations(puma):
    """The hand-made model of 1986 takes 305 operations."""
    states = states_in_box(puma)
    assert states.q.shape == (4000, 6)
    model = simplify(puma, states, drives=True)
    assert model.operations.total <= 100
    exact = decompose_states(puma, states.q, states.qd, states.qdd, coupling=False, drives=True)["torque"]
    assert (measured(model, states) <= 0.01 * np.abs(exact).max(axis=0)).all()


@pytest.mark.parametrize("refit", [False, True])
def test_puma_at_the_energy_level(puma, refit):
    states = states_in_box(puma)
    model = simplify(puma, states, level="energy", refit=refit, drives=True)
    assert_promise_holds(model, states, 0.01 * model.promise.peak_torque)
    # Terms of the energies act in several joints at once: more operations than torque terms one by one, and
    # still less than half of the hand-made model's 305.
    assert model.operations.total <= 150
    assert (model.level, model.refitted, model.drives) == ("energy", refit, True)
    original = {
        (t.i, t.j, t.product): t.coefficient for t in energy_terms(gd.harmonics_of(puma), puma.drive_inertia)
    }
    changed = [t for t in model.energy if t.coefficient != original[t.i, t.j, t.product]]
    assert bool(changed) == refit


@examples(10)
@given(
    arms_with_states(max_joints=3, count=30, massive=True),
    st.lists(st.floats(0.002, 0.4), min_size=1, max_size=3),
    st.booleans(),
)
def test_the_budget_promised_is_the_error_measured(case, shares, refit):
    arm, drawn = case
    assume(len(shares) in (1, arm.n_joints))
    states = States(drawn.q, drawn.qd, drawn.qdd, {"box": "drawn", "states": 30, "seed": 0})
    budget = Budget(tuple(shares), (True,) * len(shares))
    model = simplify(arm, states, budget, level="energy", refit=refit)
    exact = decompose_states(arm, drawn.q, drawn.qd, drawn.qdd, coupling=False)["torque"]
    assert_promise_holds(model, states, budget.allowed(np.abs(exact).max(axis=0)))
    assert len(model.energy) <= len(energy_terms(gd.harmonics_of(arm)))


@examples(5)
@given(arms_with_states(max_joints=2, count=20, massive=True), st.floats(0.01, 0.4))
def test_so_it_is_at_the_term_level(case, share):
    arm, drawn = case
    states = States(drawn.q, drawn.qd, drawn.qdd, {"box": "drawn", "states": 20, "seed": 0})
    budget = Budget((share,), (True,))
    model = simplify(arm, states, budget)
    exact = decompose_states(arm, drawn.q, drawn.qd, drawn.qdd, coupling=False)["torque"]
    assert_promise_holds(model, states, budget.allowed(np.abs(exact).max(axis=0)))
    assert model.energy == ()


def test_a_budget_in_newton_metres_per_joint(puma, pick_and_place):
    states = states_of(pick_and_place)
    model = simplify(puma, states, Budget.parse("1,2,0.5,0.1,0.1,0.1"), level="energy")
    assert_promise_holds(model, states, np.array([1.0, 2.0, 0.5, 0.1, 0.1, 0.1]))
    assert model.operations.total < model.operations_full.total
    assert model.budget_stated.startswith("1 N m, 2 N m, 0.5 N m")


def test_more_budget_drops_more(puma):
    states = states_in_box(puma, 500)
    counts = [
        simplify(puma, states, Budget.parse(b), level="energy", drives=True).operations.total
        for b in ("0.1%", "1%", "10%")
    ]
    assert counts[0] > counts[1] > counts[2]


def test_progress_tells_every_term_that_went(puma):
    gone: list[int] = []
    states = states_in_box(puma, 200)
    model = simplify(puma, states, level="energy", drives=True, progress=gone.append)
    every = energy_terms(gd.harmonics_of(puma), puma.drive_inertia)
    # The first sweep, of terms too small to weigh, is not told.
    assert 0 < sum(gone) <= len(every) - len(model.energy)


def test_an_arm_without_drives(two_link, swing):
    with pytest.raises(ArmError, match="describes no drives"):
        simplify(two_link, states_of(swing), drives=True)


def test_a_budget_for_another_number_of_joints(two_link, swing):
    with pytest.raises(UsageError, match="wrong number of entries"):
        simplify(two_link, states_of(swing), Budget.parse("1%,1%,1%"))


def test_states_in_the_box(puma):
    states, again, other = states_in_box(puma, 300), states_in_box(puma, 300), states_in_box(puma, 300, 1)
    for name, low, high in (
        ("q", puma.limits("lower"), puma.limits("upper")),
        ("qd", -puma.limits("rate_limit"), puma.limits("rate_limit")),
        ("qdd", -puma.limits("acceleration_limit"), puma.limits("acceleration_limit")),
    ):
        values = getattr(states, name)
        assert ((low <= values) & (values <= high)).all()
        # Even: of 300 draws, all within the inner 90 % has a chance of 0.9^300 = 2e-14.
        assert (np.ptp(values, axis=0) > 0.9 * (high - low)).all()
        np.testing.assert_array_equal(values, getattr(again, name))
        assert not np.array_equal(values, getattr(other, name))
    assert states.described["states"] == 300


def test_a_box_without_a_limit(puma):
    joints = (dataclasses.replace(puma.joints[0], rate_limit=None), *puma.joints[1:])
    with pytest.raises(UsageError, match="does not state all its limits") as caught:
        states_in_box(dataclasses.replace(puma, joints=joints))
    assert "trajectory" in caught.value.details["next"]


def test_states_of_a_trajectory(pick_and_place):
    states = states_of(pick_and_place)
    np.testing.assert_array_equal(states.qd, pick_and_place.qd)
    assert states.described["trajectory_fingerprint"] == pick_and_place.fingerprint


@pytest.mark.parametrize("level", ["term", "energy"])
def test_an_arm_without_mass_needs_no_terms(level) -> None:
    arm = two_link_of(1.0, 0.0, 0.0)
    states = States(np.ones((3, 2)), np.ones((3, 2)), np.ones((3, 2)), {"states": 3})
    model = simplify(arm, states, level=level)
    assert model.torques == {}
    assert model.operations.total == 0
    assert (model.torque(states.q, states.qd, states.qdd) == 0.0).all()
