"""Simplification by harmonic terms: the budget promised is the error measured, and the count is small."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from budgets import of_shares
from few_tries import few_tries
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.errors import ArmError
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.robots.parts import Drive, LinkUncertainty
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.budget import Budget, ReferenceTorques
from gd_analyze.simplification.candidates import candidates_of
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.elimination import eliminate
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.ranking import rank_terms
from gd_analyze.simplification.simplify import simplify
from gd_analyze.simplification.term import TERM
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


@pytest.mark.slow
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


@examples(5)
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


def test_a_budget_in_newton_metres_per_joint(puma, pick_and_place):
    states = states_of(pick_and_place)
    model = simplify(puma, states, Budget.parse("1,2,0.5,0.1,0.1,0.1"), level="energy")
    assert_promise_holds(model, states, np.array([1.0, 2.0, 0.5, 0.1, 0.1, 0.1]))
    assert model.operations.total < model.operations_full.total
    assert model.accuracy.budget.startswith("1 N m, 2 N m, 0.5 N m")


@pytest.mark.parametrize("level", ["term", "energy"])
def test_an_arm_without_mass_has_nothing_to_simplify(level) -> None:
    arm = two_link_of(1.0, 0.0, 0.0)
    with pytest.raises(ArmError, match=r"D is singular: joint 1 \(1\) moves no mass"):
        simplify(arm, States(*np.ones((3, 3, 2))), level=level)


@pytest.fixture(scope="module")
def along(puma, pick_and_place) -> ExactDynamics:
    return ExactDynamics.of(puma, pick_and_place)


@pytest.mark.parametrize("level", [TERM, ENERGY], ids=str)
def test_ranks_count_and_shares_are_of_peak_torque(along, level):
    ranking = rank_terms(along, level)
    assert [term.rank for term in ranking.terms] == list(range(1, len(ranking.terms) + 1))
    exact_terms = level.terms(along.form)
    assert {term.term: term.weight for term in ranking.terms} == exact_terms
    assert len(ranking.terms) == len(exact_terms) == ranking.total
    for term in ranking.terms:
        peak = along.peak_torque[term.alone_joint - 1]
        assert term.alone_torque == pytest.approx(term.alone_share * peak, rel=1e-12)
    # Without anything the error is the torque itself, at every joint: the worst share is 1.
    assert ranking.terms[0].without_share == pytest.approx(1.0, rel=1e-12)
    assert ranking.terms[-1].without_share == pytest.approx(ranking.terms[-1].alone_share, rel=1e-9)
    assert {term.term.quantity for term in ranking.terms} == (
        {"inertia", "coriolis_centrifugal", "gravity_loading"} if level is TERM else {"kinetic", "potential"}
    )


@examples(4)
@given(arms_with_states(max_joints=3, count=12, massive=True), st.sampled_from([TERM, ENERGY]))
def test_the_error_without_the_last_terms_is_measured_on_their_model(case, level):
    exact = ExactDynamics.of(*case)
    ranking = rank_terms(exact, level)
    whole = np.maximum(exact.peak_torque, 1e-12 * exact.peak_torque.max())
    candidates = candidates_of(exact, level, whole)
    order = eliminate(candidates, by_cost=False).order
    count = len(order)
    for kept_count in {0, count // 3, count - 1}:
        kept = np.zeros(count, dtype=bool)
        kept[list(order[count - kept_count :])] = True
        program = level.write(exact.form, candidates.keep(kept, np.ones(count)), ROUGH)
        inputs = {
            f"{name}{i + 1}": getattr(exact.states, name)[:, i]
            for name in ("q", "qd", "qdd")
            for i in range(exact.arm.n_joints)
        }
        error = np.abs(program.run(inputs).T - exact.torque).max(axis=0) / whole
        stated = ranking.terms[kept_count]
        # Identification and two orders of summing: some hundred eps of the largest torque of all joints, over
        # the smallest joint's.
        slack = 1e-11 * exact.peak_torque.max() / whole.min()
        assert abs(stated.without_share - error.max()) <= slack


def test_what_lies_below_the_uncertainty(swing):
    arm = two_link_of(1.0, 1.0, 1.0)
    vague = dataclasses.replace(arm, drives=(Drive(1.0, inertia_uncertainty=1e3),) * 2)
    everything = rank_terms(ExactDynamics.of(vague, swing, drives=True))
    assert everything.not_worth_keeping == len(everything.terms)
    assert all(term.below_uncertainty for term in everything.terms)
    links = tuple(dataclasses.replace(link, uncertainty=LinkUncertainty(mass=1e-9)) for link in arm.links)
    nothing = rank_terms(ExactDynamics.of(dataclasses.replace(arm, links=links), swing))
    assert nothing.not_worth_keeping == 0
    assert not any(term.below_uncertainty for term in nothing.terms)


def test_terms_not_listed_that_are_beyond_the_uncertainty_already(puma, pick_and_place):
    """With all but the largest unlisted, none of those listed may go, and not one fewer than none."""
    exact = ExactDynamics.of(
        with_payload(puma, 2.0, np.array([0.05, 0.0, 0.1])), pick_and_place, drives=False
    )
    ranking = rank_terms(exact)
    assert ranking.unlisted > 0
    assert (np.array(ranking.unlisted_share * exact.peak_torque) > ranking.uncertainty).any()
    assert ranking.not_worth_keeping == 0
