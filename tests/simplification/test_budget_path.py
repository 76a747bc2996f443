"""The path of models for smaller and larger budgets, through one that is given."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from few_tries import few_tries
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.trade_off import PATH_FACTORS, budget_path
from strategies import examples, motions

ONE_PERCENT = Budget()
Path = tuple[SimplifiedModel, ...]

KINDS = [
    ("term", False),
    ("term", True),
    ("energy", False),
    ("energy", True),
    ("element", False),
    ("recursive", False),
]


def require_sound(exact: ExactDynamics, given: SimplifiedModel, path: Path) -> None:
    """What is said of every path: errors as measured here, within each budget, nested, never dearer."""
    assert len(path) == len(PATH_FACTORS)
    for factor, model in zip(PATH_FACTORS, path, strict=True):
        error = np.abs(model.torque(*exact.states.arrays) - exact.torque).max(axis=0)
        # What is only round-off is stated as no error.
        np.testing.assert_allclose(model.accuracy.errors.largest, error, rtol=1e-9, atol=exact.round_off)
        np.testing.assert_allclose(model.accuracy.allowed, factor * given.accuracy.allowed, rtol=1e-12)
        assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()
        assert model.operations == model.program.count
        assert model.operations.total <= exact.form.operations.total
        assert model.saves or model.accuracy.errors.largest.max() == 0.0
    for smaller, larger in itertools.pairwise(path):
        if given.level is not RECURSIVE:
            assert larger.terms.keys() <= smaller.terms.keys()
        assert larger.operations.total <= smaller.operations.total
    shown = path[PATH_FACTORS.index(1.0)]
    assert shown.terms == given.terms
    assert shown.program is given.program


@pytest.mark.parametrize(("level", "refit"), KINDS)
def test_the_path_leads_through_the_model(two_link, swing, level, refit):
    exact = ExactDynamics.of(two_link, swing)
    model = simplify_exact(exact, ONE_PERCENT, SearchOptions(level, refit))
    require_sound(exact, model, budget_path(exact, ONE_PERCENT, model))


@pytest.fixture(scope="module")
def moving(puma, pick_and_place) -> ExactDynamics:
    return ExactDynamics.of(puma, pick_and_place, drives=True)


@pytest.mark.parametrize(("level", "refit"), [("term", False), ("term", True), ("element", False)])
def test_along_a_motion_of_the_puma(moving, level, refit):
    how = SearchOptions(level, refit, thorough=False)
    model = simplify_exact(moving, ONE_PERCENT, how)
    path = budget_path(moving, ONE_PERCENT, model)
    require_sound(moving, model, path)
    if level == "element":
        assert not any(other.saves for other in path)
    else:
        # A tenth of the budget takes more terms, ten times it fewer.
        assert len(path[0].terms) > len(model.terms) > len(path[-1].terms)


def test_where_nothing_can_be_dropped_the_path_begins_beyond(puma, pick_and_place):
    """Without drives level energy gives the exact model at 1 %, and saves something at ten times that."""
    exact = ExactDynamics.of(puma, pick_and_place, drives=False)
    model = simplify_exact(exact, ONE_PERCENT, SearchOptions("energy", thorough=False))
    assert not model.saves
    path = budget_path(exact, ONE_PERCENT, model)
    require_sound(exact, model, path)
    assert path[-1].saves
    assert {len(before.terms) for before in path[: PATH_FACTORS.index(1.0)]} == {len(model.terms)}


@examples(10)
@given(motions(max_joints=3, massive=True), st.sampled_from(KINDS), st.sampled_from([0.001, 0.02, 0.2]))
@few_tries()
def test_of_any_arm_and_motion(moved, kind, share):
    exact, budget = ExactDynamics.of(*moved), Budget.parse(f"{100 * share:g}%")
    model = simplify_exact(exact, budget, SearchOptions(*kind, thorough=False))
    require_sound(exact, model, budget_path(exact, budget, model))
