"""Larger budgets are advised only if their models were searched and can be read."""

from __future__ import annotations

import pytest

import gd_analyze as gd
from gd_analyze.certification.held import Held
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.studies import budget_stops
from gd_analyze.studies.budget_stops import stop_at, wider_stop
from gd_analyze.types import Budget, ExactDynamics


@pytest.fixture
def exact(puma, pick_and_place) -> ExactDynamics:
    return ExactDynamics.of(puma, pick_and_place, drives=False)


def test_the_smallest_budget_of_few_terms_is_searched_and_no_other(exact):
    asked = []

    def search(budget: Budget) -> Held:
        asked.append(str(budget))
        return Held(simplify_exact(exact, budget))

    stop = wider_stop(exact, TERM, Budget.parse("3%"), search)
    assert stop is not None
    assert stop.is_readable
    assert [str(stop.budget)] == asked == ["5%"]


def test_what_is_too_long_to_search_or_to_read_is_not_advised(exact, monkeypatch):
    asked = []

    def search(budget: Budget) -> Held:
        asked.append(str(budget))
        if budget == Budget.parse("2%"):
            raise TooManyTermsError("too many terms")
        return Held(simplify_exact(exact, budget))

    monkeypatch.setattr(budget_stops, "READABLE", 3)
    monkeypatch.setattr(budget_stops, "_LIKELY_SHARE", 100.0)
    assert wider_stop(exact, TERM, Budget.parse("1%"), search) is None
    assert asked == ["2%", "5%"]


def test_a_stop_says_why_it_has_no_model(exact):
    def refused(budget: Budget) -> Held:
        raise TooManyTermsError("too many terms")

    def unasked(budget: Budget) -> Held:
        raise AssertionError(budget)

    budget = Budget.parse("5%")
    assert stop_at(exact, TERM, budget, refused).unsearched == "terms"
    assert stop_at(exact, TERM, budget, unasked, most=0).unsearched == "terms"
    for reason in ("log", "time"):
        stop = stop_at(exact, TERM, budget, unasked, unsearched=reason)
        assert (stop.unsearched, stop.held) == (reason, None)
        assert stop.terms_beyond > 0


def test_no_budget_has_two_models_on_the_path(puma, pick_and_place):
    """Half of 2 % is a named budget, whose own model stands on the path."""
    budgets = gd.analyze(puma, pick_and_place, budget="2%", at_set_points=True).tables["budgets"]
    texts = budgets.budget.values.tolist()
    assert "1%" in texts
    assert len(texts) == len(set(texts))
    assert texts[budgets.attrs["asked"]] == "2%"
