"""The curve of operations against error."""

from __future__ import annotations

from dataclasses import replace

import pytest

from budgets import of_shares
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.term import TERM
from gd_analyze.simplification.trade_off import FACTORS, KINDS, curves, kinds_for, trade_off


@pytest.fixture(scope="module")
def swinging(two_link, swing) -> ExactDynamics:
    return ExactDynamics.of(two_link, swing)


@pytest.mark.parametrize("thorough", [True, False])
def test_every_point_is_within_its_budget(swinging, thorough):
    told: list[int] = []
    points = trade_off(swinging, thorough=thorough, progress=told.append)
    assert sum(told) == len(points) == len(KINDS) * len(FACTORS)
    for point in points:
        assert point.error_share <= 0.01 * point.factor * (1 + 1e-9)
        assert point.budget == str(of_shares(0.01 * point.factor))
        assert point.operations.total <= swinging.form.operations.total
    by_kind = curves(points)
    assert tuple(by_kind) == KINDS
    for kind, curve in by_kind.items():
        assert tuple(point.factor for point in curve) == FACTORS
        counts = [point.operations.total for point in curve]
        assert counts == sorted(counts, reverse=True) or kind[1]  # a refit is not nested


def test_a_thorough_point_is_the_model_that_simplify_makes(swinging):
    [point] = trade_off(swinging, factors=(5.0,), kinds=((TERM, False),))
    model = simplify_exact(swinging, of_shares(0.05), SearchOptions(TERM))
    assert point.operations == model.operations
    assert point.error_share == model.accuracy.errors.largest_share.max()


def test_quick_points_of_the_puma(puma, pick_and_place):
    exact = ExactDynamics.of(puma, pick_and_place)
    points = {(p.level, p.refit, p.factor): p for p in trade_off(exact, thorough=False, factors=(0.5, 5.0))}
    for (level, refit, _), point in points.items():
        assert point.operations.total <= exact.form.operations.total
        assert not refit or level is not ELEMENT
    for factor in (0.5, 5.0):
        by_level = [points[level, False, factor].operations.total for level in (TERM, ENERGY, ELEMENT)]
        assert by_level == sorted(by_level)


def test_every_level_has_its_curves():
    assert {level for level, _ in KINDS} == set(LEVELS.values())
    assert {level for level, refit in KINDS if refit} == {TERM, ENERGY}


def test_levels_of_many_terms_are_left_out(swinging, monkeypatch):
    assert kinds_for(swinging.form) == KINDS
    monkeypatch.setattr("gd_analyze.simplification.exact_form.MOST_TERMS", 3)
    assert kinds_for(swinging.form) == ((ELEMENT, False), (RECURSIVE, False))
    points = trade_off(swinging, thorough=False, factors=(1.0, 5.0))
    assert {point.level for point in points} == {ELEMENT, RECURSIVE}


def test_where_too_many_terms_matter_the_exact_torque_is_every_point(swinging, monkeypatch):
    monkeypatch.setattr("gd_analyze.simplification.candidates._MOST", 3)
    for point in trade_off(swinging, thorough=False, factors=(1.0, 5.0), kinds=((TERM, False), (TERM, True))):
        assert (point.operations, point.error_share) == (swinging.form.operations, 0.0)


def test_fitted_numbers_count_for_the_budget_they_were_fitted_to(two_link, swing):
    exact = ExactDynamics.of(two_link, swing)
    model = simplify_exact(exact, "2%", SearchOptions(RECURSIVE, thorough=False))
    none = simplify_exact(exact, "1%", SearchOptions(RECURSIVE, operations=10**6)).accuracy.errors
    lucky = replace(model, accuracy=replace(model.accuracy, errors=none))
    kind = RECURSIVE, False
    half, whole = trade_off(exact, "2%", factors=[0.5, 1.0], kinds=[kind], through={kind: [lucky]})
    assert half.operations == model.operations_full
    assert whole.operations == model.operations != half.operations
