"""Simplification by harmonic terms: the budget promised is the error measured, and the count is small."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from budgets import of_shares
from few_tries import few_tries
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify, simplify_exact
from strategies import arms_with_states, examples, two_link_of


def measured(model, states) -> np.ndarray:
    """Largest error per joint against the numeric formulas, not against anything the search used."""
    exact = decompose_states(model.arm, states, christoffel=False, drives=model.drives)["torque"]
    return np.abs(model.torque(*states.arrays) - exact).max(axis=0)


def assert_promise_holds(model, states, allowed) -> None:
    error = measured(model, states)
    # What is round-off counts as no error in the promise: 1e-9 of the largest torque.
    slack = 1e-9 * model.accuracy.errors.peak_torque.max()
    assert (error <= allowed + slack).all()
    assert np.abs(error - model.accuracy.errors.largest).max() <= slack
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()


def test_puma_with_drives_within_one_percent_at_a_hundred_operations(puma):
    """The hand-made model of 1986 takes 305 operations."""
    states = states_in_box(puma)
    assert states.q.shape == (4000, 6)
    model = simplify(puma, states, drives=True)
    assert model.operations.total <= 100
    exact = decompose_states(puma, states, christoffel=False, drives=True)["torque"]
    assert (measured(model, states) <= 0.01 * np.abs(exact).max(axis=0)).all()


@pytest.mark.parametrize("refit", [False, True])
def test_puma_at_the_energy_level(puma, puma_energy, refit):
    states = states_in_box(puma)
    model = simplify(puma, states, level="energy", refit=True, drives=True) if refit else puma_energy
    assert_promise_holds(model, states, 0.01 * model.accuracy.errors.peak_torque)
    # Terms of the energies act in several joints at once: more operations than torque terms one by one, and
    # still less than half of the hand-made model's 305.
    assert model.operations.total <= 150
    assert (model.level, model.refitted, model.drives) == (ENERGY, refit, True)
    original = model.form.energies
    changed = [term for term, coefficient in model.terms.items() if coefficient != original[term]]
    assert bool(changed) == refit


@examples(10)
@given(
    arms_with_states(max_joints=3, count=30, massive=True),
    st.lists(st.floats(0.002, 0.4), min_size=1, max_size=3),
    st.booleans(),
)
@few_tries()
def test_the_budget_promised_is_the_error_measured(case, shares, refit):
    arm, states = case
    assume(len(shares) in (1, arm.n_joints))
    budget = of_shares(*shares)
    model = simplify(arm, states, budget, level="energy", refit=refit, effort=0.1)
    exact = decompose_states(arm, states, christoffel=False)["torque"]
    assert_promise_holds(model, states, budget.allowed(ReferenceTorques(arm, np.abs(exact).max(axis=0))))
    assert model.terms.keys() <= ENERGY.terms(ExactForm(arm)).keys()


@examples(5)
@given(arms_with_states(max_joints=2, count=20, massive=True), st.floats(0.01, 0.4))
@few_tries()
def test_so_it_is_at_the_term_level(case, share):
    arm, states = case
    budget = of_shares(share)
    model = simplify(arm, states, budget)
    exact = decompose_states(arm, states, christoffel=False)["torque"]
    assert_promise_holds(model, states, budget.allowed(ReferenceTorques(arm, np.abs(exact).max(axis=0))))
    assert model.terms == model.torques


def test_a_budget_in_newton_metres_per_joint(puma, pick_and_place):
    states = states_of(pick_and_place)
    model = simplify(puma, states, Budget.parse("1,2,0.5,0.1,0.1,0.1"), level="energy")
    assert_promise_holds(model, states, np.array([1.0, 2.0, 0.5, 0.1, 0.1, 0.1]))
    assert model.operations.total < model.operations_full.total
    assert model.accuracy.budget.startswith("1 N m, 2 N m, 0.5 N m")


def test_more_budget_drops_more(puma):
    exact = ExactDynamics.of(puma, states_in_box(puma, 300), drives=True)
    counts = [
        simplify_exact(exact, Budget.parse(b), SearchOptions(ENERGY, thorough=False)).operations.total
        for b in ("0.1%", "1%", "10%")
    ]
    assert counts[0] > counts[1] > counts[2]


def test_progress_tells_every_term_that_went(puma):
    gone: list[int] = []
    exact = ExactDynamics.of(puma, states_in_box(puma, 100), drives=True)
    model = simplify_exact(exact, Budget(), SearchOptions(ENERGY, thorough=False), progress=gone.append)
    # The first sweep, of terms too small to weigh, is not told.
    assert 0 < sum(gone) <= len(exact.form.energies) - len(model.terms)


def test_an_arm_without_drives(two_link, swing):
    with pytest.raises(ArmError, match="describes no drives"):
        simplify(two_link, swing, drives=True)


def test_a_budget_for_another_number_of_joints(two_link, swing):
    with pytest.raises(UsageError, match="wrong number of entries"):
        simplify(two_link, swing, Budget.parse("1%,1%,1%"))


@pytest.mark.parametrize("level", ["term", "energy"])
def test_an_arm_without_mass_has_nothing_to_simplify(level) -> None:
    arm = two_link_of(1.0, 0.0, 0.0)
    with pytest.raises(ArmError, match=r"D is singular: joint 1 \(1\) moves no mass"):
        simplify(arm, States(*np.ones((3, 3, 2))), level=level)
