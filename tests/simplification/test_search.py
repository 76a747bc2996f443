"""The search finds what trying all finds, and every step of it only gains."""

from __future__ import annotations

import dataclasses
import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from budgets import of_shares
from gd_analyze.motions.states import States, states_in_box
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.candidates import Candidates, TooManyTermsError
from gd_analyze.simplification.effort import Work
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.linear_programs import Refit
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search import search
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.studies.comparison_costs import generic_chain
from strategies import examples, two_link_of

_FORM = ExactForm(two_link_of(1.0, 1.0, 1.0))


@st.composite
def candidate_sets(draw: st.DrawFn) -> Candidates:
    """Effects some budgets large, costs shared by random groups."""
    count = draw(st.integers(1, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    joints, states = draw(st.integers(1, 3)), draw(st.integers(1, 12))
    costs = {frozenset([k]): int(rng.integers(1, 4)) for k in range(count)}
    for _ in range(draw(st.integers(0, 3))):
        members = frozenset(np.flatnonzero(rng.random(count) < 0.5).tolist())
        if len(members) > 1:
            costs[members] = int(rng.integers(1, 5))
    return Candidates(
        level=TERM,
        form=_FORM,
        terms=dict.fromkeys(range(count), 1.0),
        effects=rng.normal(size=(count, joints, states)) * rng.choice([0.3, 1.0, 3.0], (count, 1, 1)),
        costs=costs,
        parameter=rng.integers(0, count, count),
        magnitude=rng.uniform(0.5, 2.0, count),
        ratio=np.ones(count),
        total=count,
    )


def cost_of(candidates: Candidates, kept: np.ndarray) -> int:
    return sum(count for members, count in candidates.costs.items() if any(kept[k] for k in members))


def largest_error(candidates: Candidates, kept: np.ndarray, scale: np.ndarray | None = None) -> float:
    weights = (kept if scale is None else kept * scale) - 1.0
    return float(np.abs(weights @ candidates.flat).max(initial=0.0))


def cheapest(candidates: Candidates, budget: float) -> int:
    """Cost of the cheapest selection within a budget, by trying all."""
    return min(
        cost_of(candidates, np.array(kept))
        for kept in itertools.product([False, True], repeat=len(candidates.effects))
        if largest_error(candidates, np.array(kept)) <= budget
    )


@examples(30)
@given(candidate_sets())
def test_no_cheaper_selection_exists(candidates):
    steps, solved = search(candidates, lambda kept, scale: cost_of(candidates, kept))
    *_, (kept, scale) = steps.values()
    assert largest_error(candidates, kept) <= 1.0 + 1e-12
    assert (scale == 1.0).all()
    assert solved
    cost = cost_of(candidates, kept)
    # A first sweep may spend 2 % of the budget, and the integer program has what is left.
    assert cheapest(candidates, 1.0) <= cost <= cheapest(candidates, 0.98 * (1 - 2e-6))


@examples(20)
@given(candidate_sets())
def test_a_refit_costs_no_more_and_holds_the_budget(candidates):
    plain, refitted = (
        [*search(candidates, lambda kept, _: cost_of(candidates, kept), refit=refit)[0].values()]
        for refit in (False, True)
    )
    costs = [cost_of(candidates, kept) for kept, _ in refitted]
    assert costs == sorted(costs, reverse=True)
    assert costs[-1] <= cost_of(candidates, plain[-1][0])
    assert largest_error(candidates, *refitted[-1]) <= 1.0 + 1e-9


@examples(30)
@given(candidate_sets(), st.integers(0, 2**32 - 1))
def test_no_other_factors_have_a_smaller_largest_error(candidates, seed):
    rng = np.random.default_rng(seed)
    kept = rng.random(len(candidates.effects)) < 0.6
    scale = Refit(candidates, Work()).best(kept, np.ones(len(kept)))
    least = largest_error(candidates, kept, scale)
    assert least <= largest_error(candidates, kept) + 1e-9
    # The solver keeps its rows to 1e-7 of numbers up to some tens here.
    slack = 1e-5 * (1.0 + least)
    for _ in range(20):
        change = rng.normal(size=len(kept)) * rng.choice([1e-3, 0.1, 1.0])
        other = scale + change[candidates.parameter]
        assert largest_error(candidates, kept, other) >= least - slack
    for limit in (0.5 * least + 1e-9, 2.0 * least + 1e-3):
        scaled = dataclasses.replace(candidates, effects=candidates.effects / limit)
        found = Refit(scaled, Work()).within(kept)
        if limit < least - slack:
            assert found is None
        elif limit > least + slack:
            assert found is not None
            assert largest_error(candidates, kept, found) <= limit


@pytest.fixture(scope="module")
def in_box(puma) -> ExactDynamics:
    return ExactDynamics.of(puma, states_in_box(puma, 100), drives=True)


@pytest.mark.slow
def test_beyond_greedy_and_refit_gain_on_the_puma(puma, pick_and_place):
    """What each step gains is told with the model, in the order the steps are made."""
    exact = ExactDynamics.of(puma, pick_and_place, drives=False)
    model = simplify_exact(exact, Budget(), SearchOptions(TERM, refit=True))
    names, counts = zip(*model.accuracy.steps, strict=True)
    assert names[:2] == ("elimination", "integer program")
    assert names[-2:] == ("refit", "shared coefficients")
    # Along 31 set points the integer program saves an elimination's fifth, and a refit again: 173, 138, 119.
    assert counts[1] < 0.96 * counts[0]
    assert counts[-1] < 0.9 * counts[1]
    assert model.operations.total <= counts[-1]
    assert model.refitted
    told = ", ".join(f"{step.name} {step.operations}" for step in model.accuracy.steps)
    assert model.accuracy.search == told + ", optimum proven" * model.accuracy.solved


@pytest.mark.parametrize("asked", [0, 40, 10_000])
def test_as_many_operations_as_asked_for(in_box, asked):
    model = simplify_exact(in_box, Budget(), SearchOptions(ENERGY, operations=asked, thorough=asked == 40))
    assert model.operations.total <= asked
    if asked == 40:
        # The budget found cannot be much smaller: four fifths of it take more.
        share = model.accuracy.allowed[0] / in_box.peak_torque[0]
        tighter = simplify_exact(in_box, of_shares(0.7 * share), SearchOptions(ENERGY))
        assert tighter.operations.total > asked


@pytest.mark.slow
def test_a_long_trajectory_is_held_at_every_state(puma, rng):
    """Some states stand for all while searching; what was promised is measured on all of them."""
    count = 6_000
    q, qd, qdd = (rng.uniform(-2.0, 2.0, (count, 6)) for _ in range(3))
    q[4444], qd[4444] = 3.0, 9.0  # one that no thinning by the clock would meet
    states = States(q, qd, qdd, {"box": "drawn", "states": count, "seed": 0})
    exact = ExactDynamics.of(puma, states, drives=True)
    assert len(exact.thinned().states) < 5100
    model = simplify_exact(exact, Budget.parse("2%"), SearchOptions(ENERGY, thorough=False))
    error = np.abs(model.torque(*states.arrays) - exact.torque).max(axis=0)
    assert (error <= 0.02 * exact.peak_torque).all()
    np.testing.assert_allclose(model.accuracy.errors.largest, error, rtol=1e-9)
    assert model.accuracy.fitted_on == states.described


@pytest.mark.slow
@pytest.mark.parametrize(("refit", "effort"), [(False, 1e-7), (True, 1e-4), (True, 1e-2)])
def test_a_search_ends_at_its_effort(puma, refit, effort):
    """The work done is what was granted and the step begun last, and what is given keeps the budget."""
    exact = ExactDynamics.of(puma, states_in_box(puma, 200), drives=False)
    how = SearchOptions(ENERGY, refit, effort=effort, dearer=True)
    model = simplify_exact(exact, Budget.parse("1%"), how)
    assert model.accuracy.cut_short
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
    assert "effort used up" in model.accuracy.search


@pytest.mark.slow
def test_of_terms_too_many_to_weigh_the_next_step_is_the_recursion(rng):
    exact = ExactDynamics(ExactForm(generic_chain(6)), States(*rng.normal(size=(3, 40, 6))))
    with pytest.raises(TooManyTermsError, match="too many of the 12064 terms") as caught:
        simplify_exact(exact, Budget.parse("0.1%"), SearchOptions(TERM))
    assert "--level recursive" in caught.value.details["next"]


@pytest.mark.slow
@pytest.mark.parametrize("operations", [0, 9])
def test_of_so_many_operations_it_is_the_smallest_budget(two_link, swing, operations):
    exact = ExactDynamics.of(two_link, swing)
    model = simplify_exact(exact, "1%", SearchOptions(operations=operations, effort=0.1))
    assert model.operations.total <= operations
    for level in (TERM, RECURSIVE):
        other = simplify_exact(exact, "1%", SearchOptions(level, operations=operations, effort=0.1))
        assert other.operations.total <= operations
        assert model.accuracy.allowed.max() <= other.accuracy.allowed.max()
