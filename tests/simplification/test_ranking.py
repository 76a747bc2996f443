"""Ranking of single terms: what it says of an error is what a model without them makes."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.robots.parts import Drive, LinkUncertainty
from gd_analyze.robots.payload import with_payload
from gd_analyze.simplification.candidates import candidates_of
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.elimination import eliminate
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.ranking import rank_terms
from gd_analyze.simplification.term import TERM
from strategies import arms_with_states, examples, two_link_of


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


@examples(8)
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


def test_without_stated_uncertainty_nothing_is_said(two_link, swing):
    ranking = rank_terms(ExactDynamics.of(two_link, swing))
    assert ranking.uncertainty is None
    assert ranking.not_worth_keeping == 0
    assert all(term.below_uncertainty is None for term in ranking.terms)


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


def test_the_puma_has_terms_below_its_uncertainty(along):
    """Its link inertias are known to 10 %: most of the small terms are not worth their operations."""
    ranking = rank_terms(along)
    assert 0 < ranking.not_worth_keeping < len(ranking.terms)
    kept = len(ranking.terms) - ranking.not_worth_keeping
    limit = np.array(ranking.uncertainty)
    last = ranking.terms[kept]
    assert last.without_share * along.peak_torque[last.without_joint - 1] <= limit[last.without_joint - 1]


def test_terms_not_listed_that_are_beyond_the_uncertainty_already(puma, pick_and_place):
    """With all but the largest unlisted, none of those listed may go, and not one fewer than none."""
    exact = ExactDynamics.of(
        with_payload(puma, 2.0, np.array([0.05, 0.0, 0.1])), pick_and_place, drives=False
    )
    ranking = rank_terms(exact)
    assert ranking.unlisted > 0
    assert (np.array(ranking.unlisted_share * exact.peak_torque) > ranking.uncertainty).any()
    assert ranking.not_worth_keeping == 0
