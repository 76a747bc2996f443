"""Searches find what trying all finds, promise what is measured, and each step gains; terms are ranked."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given

from chains import generic_chain
from few_tries import few_tries
from gd_analyze import decompose, simplify
from gd_analyze.arrays import ROUND_OFF_SHARE
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.parts import LinkUncertainty
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.element import ElementPart, parts_of, torque_by_part
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.tables import decompose_states, rank_terms, states_in_box
from gd_analyze.types import Budget, Drive, ExactDynamics, ExactForm, States
from made_models import by_elements, model_of
from strategies import arms_with_states, examples, motions, two_link_of


@pytest.mark.slow
def test_the_search_gains_on_the_puma(puma, pick_and_place):
    """What each step gains is stated with the model, in the order the steps are made."""
    exact = ExactDynamics.of(puma, pick_and_place, drives=False)
    model = simplify_exact(exact, Budget(), SearchOptions(TERM))
    names, counts = zip(*model.accuracy.steps, strict=True)
    assert names[:2] == ("descent", "search")
    assert counts == tuple(sorted(counts, reverse=True))
    assert counts[1] < counts[0]
    stated = ", ".join(f"{step.name} {step.operations}" for step in model.accuracy.steps)
    assert model.accuracy.search == stated


@pytest.mark.slow
def test_a_long_trajectory_is_held_at_every_state(puma, rng):
    """Some states stand for all while searching; what was promised is measured on all of them."""
    count = 6_000
    q, qd, qdd = (rng.uniform(-2.0, 2.0, (count, 6)) for _ in range(3))
    q[4444], qd[4444] = 3.0, 9.0  # one that no thinning by the clock would meet
    states = States(q, qd, qdd, {"box": "drawn", "states": count, "seed": 0})
    exact = ExactDynamics.of(puma, states, drives=True)
    assert len(exact.thinned().states) < 5100
    model = simplify_exact(exact, Budget.parse("4%"), SearchOptions(ENERGY, thorough=False))
    assert model.saves
    error = np.abs(model.torque(*states.arrays) - exact.torque).max(axis=0)
    assert (error <= 0.04 * exact.peak_torque).all()
    np.testing.assert_allclose(model.accuracy.errors.largest, error, rtol=1e-9)
    assert model.accuracy.fitted_on == states.described


@pytest.mark.slow
def test_of_terms_too_many_to_weigh_the_next_step_is_a_larger_error(rng):
    exact = ExactDynamics(ExactForm(generic_chain(6)), States(*rng.normal(size=(3, 40, 6))))
    with pytest.raises(TooManyTermsError, match="too many of the 11150 terms") as caught:
        simplify_exact(exact, Budget.parse("0.1%"), SearchOptions(TERM))
    assert "1% or 0.5% limit" in caught.value.details["next"]
    assert f"the exact torque, {exact.form.operations.in_words}" in caught.value.details["next"]


@examples(15)
@given(motions(max_joints=3, massive=True))
@few_tries()
def test_the_error_by_elements_is_the_torque_of_what_was_dropped(case):
    arm, motion = case
    dataset = decompose(arm, motion)
    model = by_elements(arm, dataset)
    # No error is stated below round-off of the largest torque.
    least = ROUND_OFF_SHARE * np.abs(dataset.torque.values).max()
    parts = dropped_by(model)
    lost = torque_by_part(dataset, dataset.qdd.values, parts).sum(axis=0).T
    error = dataset.torque.values - model.torque(motion.q, motion.qd, motion.qdd)
    # The model's arithmetic is folded, the dataset's is not: two correct programs.
    bound = round_off_bounds(arm, motion.q, motion.qd, motion.qdd)["torque"]
    assert np.abs(error - lost).max() <= bound
    assert np.abs(model.accuracy.errors.largest - np.abs(lost).max(axis=0)).max() <= bound + least
    assert set(model.terms.values()) <= {1.0}
    assert model.terms.keys() | {*parts} == {*parts_of(arm.n_joints)}


def dropped_by(model) -> tuple[ElementPart, ...]:
    return tuple(part for part in parts_of(model.arm.n_joints) if part not in model.terms)


def test_by_elements_a_budget_is_what_the_error_is_held_against(two_link, swing):
    """The verdicts alone say what is kept, and the model promises the error that it has."""
    model, wide = (simplify(two_link, swing, budget, level="element") for budget in (None, "20%"))
    assert model.terms == wide.terms
    assert (model.accuracy.budget, wide.accuracy.budget) == ("1%", "20%")
    np.testing.assert_allclose(20.0 * model.accuracy.allowed, wide.accuracy.allowed, rtol=1e-15)
    error = model.accuracy.errors.largest
    assert (error > model.accuracy.allowed).any()
    np.testing.assert_array_equal(model.promised(model.accuracy), np.maximum(model.accuracy.allowed, error))
    np.testing.assert_array_equal(wide.promised(wide.accuracy), wide.accuracy.allowed)
    with pytest.raises(UsageError, match="searches no model"):
        simplify(two_link, swing, level="element", certified=True)


def test_a_model_that_holds_nowhere_is_not_given_out(two_link, swing_dataset, monkeypatch):
    """Were all programs wrong, the exact torque would stand for every model."""
    write = type(TERM).write

    def write_nothing(self, form, terms, effort):
        return write(self, form, {}, effort)

    monkeypatch.setattr(type(TERM), "write", write_nothing)
    model = simplify(two_link, swing_dataset, "60%")
    assert model.drops_nothing
    assert not model.saves


@pytest.mark.slow
def test_puma_with_drives_within_one_percent_at_its_states(puma):
    """The hand-made model of 1986 takes 305 operations."""
    states = states_in_box(puma)
    assert states.q.shape == (4000, 6)
    model = simplify(puma, states, drives=True)
    assert model.functions.operations.total <= 95
    exact = decompose_states(puma, states, christoffel=False, drives=True)["torque"]
    error = np.abs(model.torque(*states.arrays) - exact).max(axis=0)
    assert (error <= 0.01 * np.abs(exact).max(axis=0)).all()
    # What is round-off counts as no error in the promise: 1e-9 of the largest torque.
    assert np.abs(error - model.accuracy.errors.largest).max() <= 1e-9 * np.abs(exact).max()


@pytest.mark.slow
def test_puma_at_the_energy_level(puma):
    states = states_in_box(puma)
    model = simplify(puma, states, level="energy", drives=True)
    assert (model.accuracy.errors.largest <= 0.01 * model.accuracy.errors.peak_torque).all()
    # Terms of the energies act in several joints at once: more operations than torque terms one by one, and
    # still less than half of the hand-made model's 305.
    assert model.operations.total <= 150
    assert (model.level, model.drives) == (ENERGY, True)


def test_an_arm_without_mass_has_nothing_to_simplify() -> None:
    arm = two_link_of(1.0, 0.0, 0.0)
    with pytest.raises(ArmError, match="has mass or inertia"):
        simplify(arm, States(*np.ones((3, 3, 2))))


@pytest.mark.parametrize("level", [TERM, ENERGY], ids=str)
def test_ranks_count_and_shares_are_of_peak_torque(puma, pick_and_place, level):
    along = ExactDynamics.of(puma, pick_and_place)
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


@pytest.mark.parametrize("level", [TERM, ENERGY], ids=str)
@examples(3)
@given(case=arms_with_states(max_joints=3, count=12, massive=True))
def test_the_error_without_the_last_terms_is_measured_on_their_model(case, level):
    exact = ExactDynamics.of(*case)
    ranking = rank_terms(exact, level)
    whole = np.maximum(exact.peak_torque, 1e-12 * exact.peak_torque.max())
    count = len(ranking.terms)
    for kept in {0, count // 3, count - 1}:
        terms = {ranked.term: ranked.weight for ranked in ranking.terms[:kept]}
        torque = model_of(exact.form, level, terms).torque(*exact.states.arrays)
        error = np.abs(torque - exact.torque).max(axis=0) / whole
        # Identification and two orders of summing: some hundred eps of the largest torque of all joints, over
        # the smallest joint's.
        slack = 1e-11 * exact.peak_torque.max() / whole.min()
        assert abs(ranking.terms[kept].without_share - error.max()) <= slack


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
