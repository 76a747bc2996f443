"""The default level is the one of fewest operations, and what each took is said."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from budgets import of_shares
from few_tries import few_tries
from gd_analyze.simplification import simplify as simplify_module
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import too_many_terms
from gd_analyze.simplification.model_file import load_model, save_model
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.term import TERM
from strategies import arms_with_states, examples


@few_tries()
@examples(5)
@given(arms_with_states(max_joints=3, count=30, massive=True), st.sampled_from([0.01, 0.1]))
def test_no_level_that_was_tried_takes_fewer_operations(case, share):
    exact = ExactDynamics.of(*case)
    quick = SearchOptions(thorough=False, effort=0.1)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(simplify_module, "_FEW_JOINTS", 0)
        patch.setattr(simplify_module, "_FEW", 0.0)
        model = simplify_exact(exact, of_shares(share), quick)
    took = {one.level: one.operations for one in model.accuracy.levels}
    assert list(took) == ["term", "recursive"]
    assert model.operations.total == min(count for count in took.values() if count is not None)
    assert took[model.level.name] == model.operations.total
    assert (model.accuracy.errors.counting <= model.accuracy.allowed).all()
    for name, count in took.items():
        if count is not None:
            alone = simplify_exact(exact, of_shares(share), dataclasses.replace(quick, level=gd.LEVELS[name]))
            assert alone.operations.total == count
            assert alone.accuracy.levels == ()


def test_where_terms_are_many_they_are_not_tried(two_link, swing, monkeypatch):
    monkeypatch.setattr("gd_analyze.simplification.exact_form.MOST_TERMS", 3)
    exact = ExactDynamics.of(two_link, swing)
    assert too_many_terms(exact.form)
    begun: list[str] = []
    model = simplify_exact(exact, "20%", stage=begun.append)
    assert begun == ["searching at level recursive"]
    assert model.level is RECURSIVE
    assert [(one.level, one.operations) for one in model.accuracy.levels] == [
        ("term", None),
        ("recursive", model.operations.total),
    ]


def test_where_a_search_finds_too_many_to_weigh_the_other_level_is_taken(two_link, swing, monkeypatch):
    monkeypatch.setattr("gd_analyze.simplification.candidates.MANY", 2)
    monkeypatch.setattr("gd_analyze.simplification.candidates._MOST", 3)
    model = gd.simplify(two_link, swing, "1%")
    assert model.level is RECURSIVE
    assert [one.level for one in model.accuracy.levels if one.operations is None] == ["term"]
    assert "matter within that budget" in str(model.accuracy.levels)


def test_where_terms_take_few_the_recursion_is_not_tried(two_link, swing, monkeypatch):
    model = gd.simplify(two_link, swing, "20%")
    assert "at most 4 joints" in model.accuracy.levels[1].why
    monkeypatch.setattr(simplify_module, "_FEW_JOINTS", 0)
    monkeypatch.setattr(simplify_module, "_FEW", 2.0)
    model = gd.simplify(two_link, swing, "20%")
    assert model.level is TERM
    assert model.accuracy.levels[1].operations is None
    assert "operations are few" in model.accuracy.levels[1].why


def test_where_the_terms_left_take_too_many_they_are_not_searched(two_link, swing, monkeypatch):
    monkeypatch.setattr(simplify_module, "_FEW_JOINTS", 0)
    monkeypatch.setattr(simplify_module, "_MANY", 0.01)
    exact = ExactDynamics.of(two_link, swing)
    begun: list[str] = []
    model = simplify_exact(exact, "1%", SearchOptions(effort=0.01), stage=begun.append)
    assert begun == ["searching at level recursive"]
    term, recursive = model.accuracy.levels
    assert term.operations is None
    full = model.operations_full.total
    assert term.why == f"the terms left take about {full} operations, the exact torque {full}"
    assert recursive.operations == model.operations.total
    monkeypatch.setattr("gd_analyze.simplification.candidates.MANY", 2)
    monkeypatch.setattr("gd_analyze.simplification.candidates._MOST", 3)
    model = simplify_exact(exact, "1%", SearchOptions(effort=0.01))
    assert "matter within that budget" in str(model.accuracy.levels)


def test_what_was_tried_is_in_the_file(two_link, swing, tmp_path):
    model = gd.simplify(two_link, swing, "20%")
    save_model(model, tmp_path / "model.json")
    assert load_model(tmp_path / "model.json").accuracy.levels == model.accuracy.levels


@pytest.mark.parametrize("operations", [0, 9, 14])
def test_of_so_many_operations_it_is_the_smallest_budget(two_link, swing, operations):
    exact = ExactDynamics.of(two_link, swing)
    model = simplify_exact(exact, "1%", SearchOptions(operations=operations, effort=0.1))
    assert model.operations.total <= operations
    for level in (TERM, RECURSIVE):
        other = simplify_exact(exact, "1%", SearchOptions(level, operations=operations, effort=0.1))
        assert other.operations.total <= operations
        assert model.accuracy.allowed.max() <= other.accuracy.allowed.max()
