"""The curve of operations against error."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given

from few_tries import few_tries
from gd_analyze import trade_off
from gd_analyze.simplification.budget import BUDGET_FACTORS
from gd_analyze.simplification.budget_path import budget_path
from gd_analyze.simplification.candidates import TooManyTermsError
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.harmonic import ENERGY, HARMONIC_LEVELS, TERM
from gd_analyze.simplification.model import exactly
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.trade_off import curves
from gd_analyze.types import Budget, ExactDynamics, SimplifiedModel
from made_models import of_shares
from strategies import examples, motions


@pytest.fixture(scope="module")
def swinging(two_link, swing) -> ExactDynamics:
    return ExactDynamics.of(two_link, swing)


def test_every_point_is_within_its_budget(swinging):
    points = trade_off(swinging, thorough=False)
    assert len(points) == len(HARMONIC_LEVELS) * len(BUDGET_FACTORS)
    for point in points:
        assert point.error_share <= 0.01 * point.factor * (1 + 1e-9)
        assert point.budget == str(of_shares(0.01 * point.factor))
        assert point.operations.total <= swinging.form.operations.total
    by_level = curves(points)
    assert tuple(by_level) == (TERM, ENERGY)
    for curve in by_level.values():
        assert tuple(point.factor for point in curve) == BUDGET_FACTORS
        counts = [point.operations.total for point in curve]
        assert counts == sorted(counts, reverse=True)


def test_a_thorough_point_is_the_model_that_simplify_makes(swinging):
    [point] = trade_off(swinging, factors=(5.0,), levels=(TERM,))
    model = simplify_exact(swinging, of_shares(0.05), SearchOptions(TERM))
    assert point.operations == model.operations
    assert point.error_share == model.accuracy.errors.largest_share.max()


ONE_PERCENT = Budget()
Path = tuple[SimplifiedModel, ...]


def require_sound(exact: ExactDynamics, given: SimplifiedModel, path: Path) -> None:
    """What is said of every path: errors as measured here, within each budget, nested, budgets growing."""
    for model in path:
        error = np.abs(model.torque(*exact.states.arrays) - exact.torque).max(axis=0)
        # What is only round-off is stated as no error.
        np.testing.assert_allclose(model.accuracy.errors.largest, error, rtol=1e-9, atol=exact.round_off)
        assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
        assert model.operations == model.program.count
    for smaller, larger in itertools.pairwise(path):
        assert (smaller.accuracy.allowed < larger.accuracy.allowed).all()
        assert larger.terms.keys() <= smaller.terms.keys()
    (own,) = (model for model in path if (model.accuracy.allowed == given.accuracy.allowed).all())
    assert own.terms == given.terms
    assert own.program is given.program
    for model, factor in zip(path, BUDGET_FACTORS, strict=True):
        np.testing.assert_array_equal(model.accuracy.allowed, factor * given.accuracy.allowed)


def test_a_model_of_parts_stands_alone(swinging):
    model = exactly(swinging, ELEMENT, swinging.allowed("50%"), "50%")
    assert budget_path(swinging, Budget.parse("50%"), model) == (model,)


def test_an_arm_of_too_many_terms_is_refused(swinging, monkeypatch):
    monkeypatch.setattr("gd_analyze.simplification.exact.MOST_TERMS", 3)
    with pytest.raises(TooManyTermsError):
        trade_off(swinging, "20%")


@pytest.mark.parametrize("level", HARMONIC_LEVELS.values(), ids=str)
def test_the_path_leads_through_the_model(two_link, swing, level):
    exact = ExactDynamics.of(two_link, swing)
    model = simplify_exact(exact, ONE_PERCENT, SearchOptions(level))
    require_sound(exact, model, budget_path(exact, ONE_PERCENT, model))


@pytest.mark.parametrize("level", HARMONIC_LEVELS.values(), ids=str)
@pytest.mark.parametrize("share", [0.001, 0.02, 0.2])
@examples(2)
@given(moved=motions(max_joints=3, massive=True))
@few_tries()
def test_of_any_arm_and_motion(moved, level, share):
    exact, budget = ExactDynamics.of(*moved), Budget.parse(f"{100 * share:g}%")
    model = simplify_exact(exact, budget, SearchOptions(level, thorough=False))
    require_sound(exact, model, budget_path(exact, budget, model))
