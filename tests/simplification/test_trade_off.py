"""The curve of operations against error."""

from __future__ import annotations

import pytest

from gd_analyze.simplification import Budget, ExactDynamics, simplify_exact
from gd_analyze.simplification.trade_off import FACTORS, KINDS, trade_off


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
        assert point.budget == str(Budget((0.01 * point.factor,), (True,)))
        assert point.operations.total <= swinging.operations_full(point.level, thorough=thorough).total
    for kind in KINDS:
        counts = [p.operations.total for p in points if (p.level, p.refit) == kind]
        assert counts == sorted(counts, reverse=True) or kind[1]  # a refit is not nested


def test_a_thorough_point_is_the_model_that_simplify_makes(swinging):
    [point] = trade_off(swinging, factors=(5.0,), kinds=(("term", False),))
    model = simplify_exact(swinging, Budget((0.05,), (True,)))
    assert point.operations == model.operations
    assert point.error_share == model.promise.largest_share.max()


def test_quick_points_of_the_puma(puma, pick_and_place):
    exact = ExactDynamics.of(puma, pick_and_place)
    points = {(p.level, p.refit, p.factor): p for p in trade_off(exact, thorough=False, factors=(0.5, 5.0))}
    for (level, refit, _), point in points.items():
        assert point.operations.total < exact.operations_full(level, thorough=False).total
        assert not refit or level != "element"
    for factor in (0.5, 5.0):
        by_level = [points[level, False, factor].operations.total for level in ("term", "energy", "element")]
        assert by_level == sorted(by_level)
