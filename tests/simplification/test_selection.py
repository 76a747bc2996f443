"""Selections keep their errors within the budget, and are about as cheap as trying all finds."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.simplification.effects import Effects
from gd_analyze.simplification.search_time import SearchTime
from gd_analyze.simplification.selection import (
    Selection,
    TermChoice,
    descend,
    improve,
    repair,
)
from strategies import examples

# Errors are sums of at most eleven numbers of some tens: their rounding.
ROUND_OFF = 1e-13


@st.composite
def choices(draw: st.DrawFn) -> TermChoice:
    """Effects some budgets large, on some joints each, costs of random groups, and some error before."""
    count, joints, states = draw(st.integers(1, 8)), draw(st.integers(1, 3)), draw(st.integers(1, 12))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    costs = {frozenset([k]): int(rng.integers(1, 4)) for k in range(count)}
    for _ in range(draw(st.integers(0, 3))):
        members = frozenset(np.flatnonzero(rng.random(count) < 0.5).tolist())
        if len(members) > 1:
            costs[members] = int(rng.integers(1, 5))
    acts = rng.random((count, joints)) < 0.7
    acts[np.arange(count), rng.integers(joints, size=count)] = True
    joint, term = np.nonzero(acts.T)
    size = rng.choice([0.3, 1.0, 3.0], count)
    torque = rng.normal(size=(len(term), states)) * size[term, None]
    base = rng.uniform(-0.3, 0.3, (joints, states))
    return TermChoice(Effects(count, joints, term, joint, torque), base, costs)


def cost_of(choice: TermChoice, selected: np.ndarray) -> int:
    return sum(price for members, price in choice.costs.items() if any(selected[k] for k in members))


def error_of(choice: TermChoice, selected: np.ndarray) -> float:
    lost = (~np.asarray(selected)[:, None, None] * choice.effects.dense()).sum(axis=0)
    return float(np.abs(choice.base + lost).max())


def searched(choice: TermChoice, stays: np.ndarray, seed: int = 0) -> list[Selection]:
    selection = Selection(choice, np.ones(len(choice), dtype=bool))
    descend(selection, stays)
    return [selection, *improve(selection, stays, seed=seed)]


@examples(60)
@given(choices(), st.integers(0, 255))
def test_a_search_keeps_the_budget_and_what_stays(choice, bits):
    stays = np.array([bits >> k & 1 for k in range(len(choice))], dtype=bool)
    first, *found = searched(choice, stays)
    for selection in (first, *found):
        assert error_of(choice, selection.selected) <= 1.0 + ROUND_OFF
        assert selection.selected[stays].all()
        # What a selection notes on the way is what it is.
        assert selection.cost == cost_of(choice, selection.selected)
        assert selection.largest == pytest.approx(error_of(choice, selection.selected), abs=ROUND_OFF)
    assert found[0].cost <= first.cost
    assert [each.cost for each in found] == sorted(each.cost for each in found)
    again = searched(choice, stays)
    assert [each.selected.tolist() for each in again] == [each.selected.tolist() for each in (first, *found)]


@pytest.mark.slow
def test_of_few_terms_the_cheapest_selection_is_found():
    """All selections of up to eight terms are tried: of 60 draws, the search misses the cheapest of none."""
    missed = []
    for seed in range(60):
        choice = drawn(seed)
        best = min(
            cost_of(choice, np.array(selected))
            for selected in itertools.product([False, True], repeat=len(choice))
            if error_of(choice, np.array(selected)) <= 1.0
        )
        _, found, *_ = searched(choice, np.zeros(len(choice), dtype=bool))
        missed.append(found.cost > best)
    assert sum(missed) == 0


def test_terms_that_cost_nothing_return_only_within_the_budget():
    """The first two cancel the third together: without it, they leave an error of 2.4 budgets."""
    torque = np.array([[1.2], [1.2], [-2.4], [5.0]])
    effects = Effects(4, 1, np.arange(4), np.zeros(4, dtype=np.intp), torque)
    choice = TermChoice(effects, np.zeros((1, 1)), {frozenset([0, 1, 3]): 2, frozenset([2]): 3})
    selection = Selection(choice, np.array([False, False, False, True]))
    for improved in improve(selection, np.array([False, False, False, True])):
        assert improved.largest <= 1.0


def drawn(seed: int) -> TermChoice:
    rng = np.random.default_rng(seed)
    count, joints, states = 8, 2, 6
    joint, term = np.nonzero(np.ones((joints, count), dtype=bool))
    torque = rng.normal(size=(len(term), states)) * rng.choice([0.1, 0.3, 1.0], count)[term, None]
    costs = {frozenset([k]): int(rng.integers(1, 4)) for k in range(count)}
    costs[frozenset(rng.choice(count, 3, replace=False).tolist())] = 4
    return TermChoice(Effects(count, joints, term, joint, torque), np.zeros((joints, states)), costs)


@examples(40)
@given(choices(), st.integers(0, 255))
def test_a_repair_ends_within_the_budget(choice, bits):
    selected = np.array([bits >> k & 1 for k in range(len(choice))], dtype=bool)
    selection = Selection(choice, selected)
    repair(selection)
    assert error_of(choice, selection.selected) <= 1.0 + ROUND_OFF
    assert selection.selected[selected].all()


def test_more_effort_costs_no_more():
    for seed in range(10):
        choice = drawn(seed)
        stays = np.zeros(len(choice), dtype=bool)
        start = Selection(choice, ~stays)
        descend(start, stays)
        costs = [improve(start.copy(), stays, effort=effort)[0].cost for effort in (0.01, 1.0)]
        assert costs[1] <= costs[0] <= start.cost


def test_when_a_search_closes_there_are_no_attempts(monkeypatch):
    monkeypatch.setattr(SearchTime, "is_closing", True)
    choice = drawn(0)
    start = Selection(choice, np.ones(len(choice), dtype=bool))
    assert improve(start, np.zeros(len(choice), dtype=bool), SearchTime(1.0)) == [start]
