"""Budgets of the torque's norm: how they are read, and what they measure."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import UsageError
from gd_analyze.simplification.budget import Allowance, Budget, ReferenceTorques
from gd_analyze.simplification.measures import NormMeasure, NormShare, kept_states, share_at
from parallel_axes import scara


@pytest.mark.parametrize(
    ("text", "share", "states"),
    [
        ("1% norm", 0.01, 1.0),
        ("1% of norm", 0.01, 1.0),
        ("1 % of the norm at 95 %", 0.01, 0.95),
        ("1% norm at 95% of states", 0.01, 0.95),
        ("0.1% of norm at 99.9% of the states", 0.001, 0.999),
        (" 2.5% NORM AT ALL STATES ", 0.025, 1.0),
        ("1% norm at every state", 0.01, 1.0),
        ("1% norm at 100%", 0.01, 1.0),
        ("0% norm", 0.0, 1.0),
    ],
)
def test_what_is_understood(text, share, states):
    budget = Budget.parse(text)
    assert budget == Budget((), NormShare(share, states))
    assert Budget.parse(str(budget)) == budget
    assert (budget.wholes, budget.shares_of) == ({"norm"}, "peak torque")


def test_how_it_is_put():
    assert str(Budget.parse("1% of norm at 95%")) == "1% norm at 95% of states"
    assert str(Budget.parse(".1% norm")) == "0.1% norm at all states"
    assert str(Budget.parse("1% norm at 99.9%").scaled(0.5)) == "0.5% norm at 99.9% of states"


@given(st.floats(0.0, 10.0), st.floats(1e-6, 1.0))
def test_what_is_put_is_read_again(share, states):
    again = Budget.parse(str(Budget((), NormShare(share, states)))).norm
    assert again is not None
    # Twelve digits are written, and what is read is rounded to fifteen decimals.
    np.testing.assert_allclose(again, (share, states), rtol=1e-11, atol=1e-15)


@pytest.mark.parametrize(
    "text",
    [
        "norm",
        "1 norm",
        "0.5 N m norm",
        "-1% norm",
        "1% norm at",
        "1% norm at 0%",
        "1% norm at 101%",
        "1% norm at 95",
        "1% norm at 95% of time",
        "1e13% norm",
        "1% norm of 95%",
    ],
)
def test_what_is_refused(text):
    with pytest.raises(UsageError, match="the budget is not understood") as caught:
        Budget.parse(text)
    assert caught.value.details["where"] == "--budget"
    assert '"1% norm at 95% of states"' in caught.value.details["expected"]
    assert caught.value.details["found"] == repr(text)


@pytest.mark.parametrize("text", ["1% norm, 2%", "1% norm or 10% friction", "1%, 1% norm at 95%"])
def test_it_stands_alone(text):
    with pytest.raises(UsageError) as caught:
        Budget.parse(text)
    assert caught.value.details["next"] == "give one entry for all joints, without commas and `or`"


def test_a_misspelt_norm_is_recognised():
    with pytest.raises(UsageError) as caught:
        Budget.parse("1% nrom")
    assert caught.value.details["next"] == "did you mean norm?"


@pytest.mark.parametrize("norm", [(-0.1, 0.95), (0.1, 0.0), (0.1, 1.5), (math.nan, 0.5), (math.inf, 0.5)])
def test_an_impossible_share_is_refused(norm):
    with pytest.raises(UsageError, match="a budget of the norm cannot be that"):
        Budget((), NormShare(*norm))


def test_it_goes_without_entries():
    with pytest.raises(UsageError, match="a budget of the norm cannot be that"):
        Budget(((Allowance(0.01),),), NormShare(0.01))


def test_it_allows_no_joint_more_than_the_norm_of_the_peaks():
    arm = scara()
    by = ReferenceTorques(arm, np.array([3.0, 4.0, 7.0, 0.0]))
    # The third joint slides: it is alone with its newtons.
    np.testing.assert_allclose(Budget.parse("10% norm").allowed(by), [0.5, 0.5, 0.7, 0.5], rtol=1e-15)


@pytest.mark.parametrize(
    ("states", "count", "kept"),
    [(0.95, 4000, 3800), (0.999, 4000, 3996), (0.95, 10, 10), (0.9, 10, 9), (0.5, 3, 2), (1.0, 7, 7)],
)
def test_how_many_states_a_share_is(states, count, kept):
    assert kept_states(states, count) == kept


@given(st.integers(1, 300_000), st.integers(1, 1000))
def test_no_more_states_may_break_it_than_the_rest(count, thousandths):
    kept = kept_states(thousandths / 1000, count)
    # In whole numbers, which nothing rounds.
    assert (count - kept) * 1000 <= count * (1000 - thousandths) < (count - kept + 1) * 1000


@st.composite
def measured(draw):
    """A measure of some joints that turn or slide, and an error."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    turning = np.array(draw(st.lists(st.booleans(), min_size=1, max_size=5)))
    shape = len(turning), draw(st.integers(1, 60))
    torque, error = rng.normal(size=shape), 0.02 * rng.standard_cauchy(size=shape)
    return NormMeasure(0.01, draw(st.sampled_from([0.5, 0.9, 0.95, 0.999, 1.0])), torque, turning), error


@given(measured())
def test_as_many_states_keep_the_share_and_no_smaller_one(case):
    measure, error = case
    norms = [
        np.linalg.norm(error[of], axis=0) / np.linalg.norm(measure.torque[of], axis=0)
        for of in (measure.revolute, ~measure.revolute)
        if of.any()
    ]
    by_hand, found = np.max(norms, axis=0), measure.share(error) * measure.allowed
    # A quotient and a product, rounded once each.
    beyond, at_least = by_hand > found * (1 + 4e-16), by_hand >= found * (1 - 4e-16)
    assert beyond.sum() <= measure.exempt < at_least.sum()
    assert measure.exempt <= (1.0 - measure.states) * len(by_hand) + 1e-9


@given(measured(), st.floats(1e-3, 1e3))
def test_the_unit_of_sliding_joints_does_not_count_and_one_norm_of_all_is_no_larger(case, unit):
    measure, error = case
    scale = np.where(measure.revolute, 1.0, unit)[:, None]
    other = NormMeasure(measure.allowed, measure.states, scale * measure.torque, measure.revolute)
    np.testing.assert_allclose(other.shares(scale * error), measure.shares(error), rtol=1e-14)
    mixed = np.linalg.norm(scale * error, axis=0) / np.linalg.norm(scale * measure.torque, axis=0)
    assert (mixed <= measure.shares(error) * (1 + 1e-14)).all()


@given(measured(), st.floats(1e-6, 1e6))
def test_it_grows_with_the_error(case, factor):
    measure, error = case
    np.testing.assert_allclose(measure.share(factor * error), factor * measure.share(error), rtol=1e-14)


def test_round_off_and_rest_count_as_no_error():
    torque = np.array([[1.0, 0.0], [0.0, 0.0]])
    measure = NormMeasure(0.01, 1.0, torque, np.array([True, True]), round_off=1e-12)
    assert measure.share(np.full((2, 2), 1e-13)) == 0.0
    assert measure.shares(np.array([[0.0, 1e-3], [0.0, 0.0]])).tolist() == [0.0, math.inf]
    nothing = NormMeasure(0.0, 1.0, torque, np.array([True, True]))
    assert (nothing.share(np.zeros((2, 2))), nothing.share(torque)) == (0.0, math.inf)


def test_share_at_counts_from_the_least():
    assert share_at(np.array([3.0, 1.0, 2.0, math.inf]), 0.75) == 3.0
    assert share_at(np.array([3.0, 1.0, 2.0, math.inf]), 0.5) == 2.0
