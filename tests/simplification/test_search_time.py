"""A search ends in its time with a model that holds, and at once where nothing can be saved."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

import gd_analyze as gd
from attacks import errors_at
from gd_analyze.certification import holding
from gd_analyze.cli import options
from gd_analyze.errors import UsageError
from gd_analyze.simplification import simplify
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.search_time import SEARCH_SECONDS, SearchTime
from gd_analyze.types import Budget, ExactDynamics


@pytest.fixture
def exact(puma, pick_and_place) -> ExactDynamics:
    return ExactDynamics.of(puma, pick_and_place, drives=False)


def with_share_spent(monkeypatch: pytest.MonkeyPatch, share: float) -> SearchTime:
    """A time of which a share is spent, whatever the clock says."""
    monkeypatch.setattr(SearchTime, "share_spent", share)
    return SearchTime(1.0)


def calls_of(monkeypatch: pytest.MonkeyPatch, module: Any, name: str) -> list[Any]:
    """First arguments of all calls of a function."""
    function, calls = getattr(module, name), list[Any]()

    def counted(*arguments: Any, **keywords: Any) -> Any:
        calls.append(arguments[0])
        return function(*arguments, **keywords)

    monkeypatch.setattr(module, name, counted)
    return calls


def test_time_is_that_of_the_processor(monkeypatch):
    clock = [5.0]
    monkeypatch.setattr("gd_analyze.simplification.search_time.time.process_time", lambda: clock[0])
    time = SearchTime(4.0)
    for clock[0], share in ((5.0, 0.0), (6.0, 0.25), (9.0, 1.0), (13.0, 2.0)):
        assert (time.share_spent, time.is_over) == (share, share >= 1.0)
    assert not SearchTime().is_over
    assert options.seconds(lambda: None).__click_params__[0].default == SEARCH_SECONDS


@pytest.mark.parametrize("wrong", [0.0, -1.0, math.nan])
def test_no_time_is_refused(wrong):
    with pytest.raises(UsageError, match="no time to search"):
        SearchTime(wrong)


@pytest.mark.parametrize("certified", [False, True])
def test_a_closing_search_has_no_attempts_and_its_model_holds(
    puma, pick_and_place, exact, certified, monkeypatch
):
    time, tube = with_share_spent(monkeypatch, 0.7), gd.types.Tube.along(puma, pick_and_place)
    with pytest.warns(gd.GdAnalyzeWarning, match="1 s of processor time ended the search; a longer one may"):
        held = holding.simplify_held(exact, "1%", tube, SearchOptions(TERM, time=time), certified=certified)
    model = held.model
    assert model.saves
    assert "search" not in [step.name for step in model.accuracy.steps]
    assert held.certificate is not None
    assert held.certificate.within(model.accuracy.allowed).all()
    is_upper = np.random.default_rng(0).integers(0, 2, tube.lower.shape)
    corners = np.where(is_upper, tube.upper, tube.lower)
    errors = errors_at(model, *corners.transpose(1, 0, 2)).max(axis=0)
    assert (errors <= held.certificate.certified).all()


def test_without_time_the_exact_torque_is_the_answer(puma, pick_and_place, exact, monkeypatch):
    time = with_share_spent(monkeypatch, 1.0)
    searches = calls_of(monkeypatch, simplify, "selected_terms")
    outcome = simplify.until_it_holds(
        exact, Budget.parse("1%"), exact.allowed("1%"), SearchOptions(TERM, time=time), []
    )
    assert (outcome.model.is_exact, searches) == (True, [])


def test_the_end_of_the_time_is_told(two_link, monkeypatch):
    """At the first looks at the time, those of the first round, nothing is spent, at every later one all."""
    looks = iter([0.0, 0.0])
    monkeypatch.setattr(SearchTime, "share_spent", property(lambda time: next(looks, 2.0)))
    exact = ExactDynamics.of(two_link, gd.read_trajectory("two-link-swing", two_link))

    def never(model: Any, turn: int) -> simplify.Excess:
        states = np.stack(exact.states.arrays)[:, :1]
        return simplify.Excess(states, np.ones((1, 2)), 2.0 * exact.allowed("20%"), is_of_region=True)

    with pytest.warns(gd.GdAnalyzeWarning, match="no model was found that holds: the exact torque stands"):
        model = simplify.simplify_exact(
            exact, "20%", SearchOptions(TERM, time=SearchTime(1.0)), everywhere=[never]
        )
    assert model.is_exact


def test_a_hopeless_search_ends_after_its_first_draft(exact, monkeypatch):
    searches = calls_of(monkeypatch, simplify, "selected_terms")
    monkeypatch.setattr(simplify, "_HOPELESS_RATIO", 0.1)
    model = simplify.simplify_exact(exact, "1%", SearchOptions(TERM))
    assert (model.is_exact, len(searches)) == (True, 1)


def test_only_what_no_state_breaks_is_proven(puma, pick_and_place, exact, monkeypatch):
    proofs = calls_of(monkeypatch, holding, "certify")
    searches = calls_of(monkeypatch, simplify, "selected_terms")
    held = holding.simplify_held(exact, "1%", gd.types.Tube.along(puma, pick_and_place))
    assert held.certificate is not None
    assert 1 <= len(proofs) < len(searches)
    assert len(proofs[-1].terms) == len(held.model.terms)


def test_an_arm_of_too_many_terms_is_refused_before_anything_is_computed(two_link, monkeypatch):
    exact = ExactDynamics.of(two_link, gd.tables.states_in_box(two_link, 5))
    monkeypatch.setattr("gd_analyze.simplification.exact.MOST_JOINTS_WITH_TERMS", 1)
    for search in (
        lambda: simplify.simplify_exact(exact),
        lambda: holding.simplify_held(exact, "1%", gd.types.Box.of(exact.arm)),
    ):
        searches = calls_of(monkeypatch, simplify, "exactly")
        with pytest.raises(UsageError, match="too many terms to choose from"):
            search()
        assert searches == []
