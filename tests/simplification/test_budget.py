"""Budgets, of joints and of the norm: how they are read, what they allow, and when one is too small."""

from __future__ import annotations

import json
import math
import re
import shlex
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.certification.holding import simplify_certified
from gd_analyze.dynamics.drivetrain import least_friction
from gd_analyze.errors import ModelError, UsageError
from gd_analyze.motions.states import states_in_box
from gd_analyze.simplification.budget import (
    Allowance,
    Budget,
    NormMeasure,
    NormShare,
    ReferenceTorques,
    kept_states,
)
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.harmonic import ENERGY, TERM
from gd_analyze.simplification.levels import SearchOptions
from gd_analyze.simplification.model_file import document_of
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.simplification.trade_off import trade_off
from made_models import signed
from parallel_axes import scara
from strategies import examples, random_states, two_link_of

WHOLES = ("peak", "limit", "friction", "uncertainty", "torque")
PEAK = np.array([10.0, 20.0, 5.0, 1.0, 0.5, 0.0])
UNCERTAINTY = np.array([1.0, 2.0, 0.3, 0.2, 0.1, 0.05])


@pytest.fixture
def by(puma):
    return ReferenceTorques(puma, PEAK, UNCERTAINTY)


UNDERSTOOD = {
    " 2.5 % ": [[(0.025, "peak")]],
    "0.5": [[(0.5, "torque")]],
    "0.5Nm": [[(0.5, "torque")]],
    "3 N": [[(3.0, "torque")]],
    "1%,0.2,.5%": [[(0.01, "peak")], [(0.2, "torque")], [(0.005, "peak")]],
    "10% of Friction": [[(0.1, "friction")]],
    "1%  OR uncertainty": [[(0.01, "peak"), (1.0, "uncertainty")]],
    "1% or 0.5% limit or 0.05 N m": [[(0.01, "peak"), (0.005, "limit"), (0.05, "torque")]],
}


def test_what_is_understood():
    for text, entries in UNDERSTOOD.items():
        assert [[tuple(one) for one in entry] for entry in Budget.parse(text).entries] == entries
    assert Budget.parse("0.1% of norm at 99.9% of the states") == Budget((), NormShare(0.001, 0.999))
    assert Budget.parse(" 2.5% NORM AT ALL STATES ") == Budget((), NormShare(0.025, 1.0))


REFUSED = ("", "%", "one", "-1%", "nan", "1e999", "1% 2%", "1 kg", "1%,", "1% or", "1 friction", "10% rust")
REFUSED_NORMS = ("norm", "0.5 N m norm", "-1% norm", "1% norm at 101%", "1% norm, 2%", "1% norm or 2%")


@pytest.mark.parametrize("text", [*REFUSED, "1%,2%,1% or x", *REFUSED_NORMS])
def test_what_is_refused(text):
    with pytest.raises(UsageError, match="budget is not understood") as caught:
        Budget.parse(text)
    entry = "" if "norm" in text else f", entry {text.count(',') + 1}"
    assert caught.value.details["where"] == f"--budget{entry}"


@pytest.mark.parametrize(
    "entries", [((Allowance(-0.1),),), ((Allowance(float("inf")),),), ((Allowance(0.1, "rust"),),), (), ((),)]
)
def test_an_impossible_budget_is_refused(entries):
    with pytest.raises(UsageError, match=r"this is not a budget|allows nothing"):
        Budget(entries)


def test_each_joint_is_allowed_the_larger_of_its_amounts(puma, by):
    limit = np.array([drive.torque_limit for drive in puma.drives])
    assert Budget.parse("10%,0.5,1,1,0,100%").allowed(by).tolist() == [1.0, 0.5, 1.0, 1.0, 0.0, 0.0]
    assert Budget.parse("uncertainty").allowed(by).tolist() == UNCERTAINTY.tolist()
    found = Budget.parse("5% or 0.5% limit or 0.11 N m").allowed(by)
    np.testing.assert_array_equal(found, np.maximum(np.maximum(0.05 * PEAK, 0.005 * limit), 0.11))
    # Each of them is the larger one somewhere.
    assert all((found == part).any() for part in (0.05 * PEAK, 0.005 * limit, np.full(6, 0.11)))
    found = Budget.parse("1% or 10% friction").allowed(by)
    np.testing.assert_array_equal(found, np.maximum(0.01 * PEAK, 0.1 * least_friction(puma)))
    with pytest.raises(UsageError, match="wrong number of entries"):
        Budget.parse("1%,2%").allowed(by)


@pytest.mark.parametrize(("whole", "key"), [("friction", "coulomb"), ("limit", "torque_limit")])
def test_what_an_arm_does_not_state_cannot_be_shared(puma, whole, key):
    drives = list(puma.drives)
    drives[2] = replace(drives[2], coulomb=(0.0, 0.0), torque_limit=None)
    by, entry = ReferenceTorques(replace(puma, drives=tuple(drives)), PEAK), f"1% or 10% {whole}"
    with pytest.raises(UsageError, match=f"cannot be a share of {whole}") as caught:
        Budget.parse(entry).allowed(by)
    assert caught.value.details["where"] == "--budget, joint 3, elbow, of puma560"
    assert f"`{key}`" in caught.value.details["expected"]
    allowed = Budget.parse(",".join([entry, entry, "1%", entry, entry, entry])).allowed(by)
    assert allowed[2] == 0.01 * PEAK[2]


ALLOWANCES = st.lists(st.tuples(st.floats(0, 1e6), st.sampled_from(WHOLES)), min_size=1, max_size=4)


@examples(50)
@given(st.lists(ALLOWANCES, min_size=1, max_size=6))
def test_what_is_printed_can_be_read_back(entries):
    budget = Budget(tuple(tuple(Allowance(*one) for one in entry) for entry in entries))
    again = Budget.parse(str(budget))
    assert str(again) == str(budget)
    for entry, own in zip(again.entries, budget.entries, strict=True):
        assert [one.of for one in entry] == [one.of for one in own]
        # Printed to 6 significant digits, for the eye: half a unit of the sixth.
        np.testing.assert_allclose([one.amount for one in entry], [one.amount for one in own], rtol=5.1e-6)


@pytest.fixture(scope="module")
def of_budget(puma, pick_and_place):
    exact = gd.ExactDynamics.of(puma, pick_and_place)
    return lambda budget: simplify_exact(exact, budget, SearchOptions(thorough=False, write=False))


@pytest.mark.parametrize("budget", ["1%", "1%,1%,1%,0.1,0.1,0.1"])
def test_the_flag_of_a_notice_settles_it(of_budget, budget):
    model = of_budget(budget)
    [_, flag] = shlex.split(re.search(r'--budget ".*?"', model.notice)[0])
    settled = of_budget(flag)
    assert settled.notice == ""
    assert (settled.accuracy.allowed >= model.accuracy.allowed * (1 - 1e-12)).all()


@given(st.floats(0.0, 10.0), st.floats(1e-6, 1.0))
def test_a_norm_is_read_again(share, states):
    again = Budget.parse(str(Budget((), NormShare(share, states)))).norm
    assert again is not None
    # Twelve digits are written, and what is read is rounded to fifteen decimals.
    np.testing.assert_allclose(again, (share, states), rtol=1e-11, atol=1e-15)


def test_it_allows_no_joint_more_than_the_norm_of_the_peaks():
    arm = scara()
    by = ReferenceTorques(arm, np.array([3.0, 4.0, 7.0, 0.0]))
    # The third joint slides: it is alone with its newtons.
    np.testing.assert_allclose(Budget.parse("10% norm").allowed(by), [0.5, 0.5, 0.7, 0.5], rtol=1e-15)


def test_how_many_states_a_share_is():
    for share, count, kept in ((0.95, 4000, 3800), (0.999, 4000, 3996), (0.95, 10, 10), (0.5, 3, 2)):
        assert kept_states(share, count) == kept


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


def test_round_off_and_rest_count_as_no_error():
    torque = np.array([[1.0, 0.0], [0.0, 0.0]])
    measure = NormMeasure(0.01, 1.0, torque, np.array([True, True]), round_off=1e-12)
    assert measure.share(np.full((2, 2), 1e-13)) == 0.0
    assert measure.shares(np.array([[0.0, 1e-3], [0.0, 0.0]])).tolist() == [0.0, math.inf]
    nothing = NormMeasure(0.0, 1.0, torque, np.array([True, True]))
    assert (nothing.share(np.zeros((2, 2))), nothing.share(torque)) == (0.0, math.inf)


BUDGET = "2% norm at 95% of states"


@pytest.fixture(scope="module")
def exact() -> ExactDynamics:
    limits = {"lower": -np.pi, "upper": np.pi, "velocity_limit": 1.0, "acceleration_limit": 10.0}
    arm = scara()
    arm = replace(arm, joints=tuple(replace(joint, **limits) for joint in arm.joints))
    return ExactDynamics.of(arm, states_in_box(arm, 300))


@pytest.fixture(scope="module")
def model(exact) -> gd.SimplifiedModel:
    return simplify_exact(exact, BUDGET, SearchOptions(TERM))


def shares_by_hand(model: gd.SimplifiedModel, exact: ExactDynamics) -> np.ndarray:
    """Share of the norm at every state, of joints of one unit each."""
    error = model.torque(*exact.states.arrays) - exact.torque
    turning = np.array(exact.arm.is_revolute)
    norms = ([np.linalg.norm(x[:, of], axis=1) for x in (error, exact.torque)] for of in (turning, ~turning))
    with np.errstate(invalid="ignore"):  # of no sliding joint
        return np.fmax.reduce([lost / whole for lost, whole in norms])


def assert_kept(model: gd.SimplifiedModel, exact: ExactDynamics, share: float, states: float) -> None:
    by_hand, count = np.sort(shares_by_hand(model, exact)), len(exact.states)
    found = {norm.states: norm.share for norm in model.accuracy.norms}
    # What is below round-off of the largest torque counts as no error, and may be a share of a small one.
    for part, told in found.items():
        assert told == pytest.approx(by_hand[kept_states(part, count) - 1], rel=1e-9, abs=1e-9)
    assert found[states] <= share
    assert (by_hand > share * (1 + 1e-9)).sum() <= count - kept_states(states, count)
    assert model.accuracy.asked_norm is not None
    assert model.accuracy.asked_norm.share == found[states]


def test_the_promise_is_what_the_program_does(exact, model):
    assert model.operations.total < exact.form.operations.total
    assert_kept(model, exact, 0.02, 0.95)
    # The states it gives up are used: no budget for all states would leave as few operations.
    strict = simplify_exact(exact, "2% norm", SearchOptions(TERM))
    assert_kept(strict, exact, 0.02, 1.0)
    assert model.operations.total < strict.operations.total
    assert shares_by_hand(model, exact).max() > 0.02


@pytest.mark.parametrize("level", [ENERGY, pytest.param(RECURSIVE, marks=pytest.mark.slow)])
def test_every_level_keeps_it(exact, level):
    found = simplify_exact(exact, BUDGET, SearchOptions(level, effort=0.1))
    assert found.level is level
    assert_kept(found, exact, 0.02, 0.95)


@examples(4)
@given(
    st.floats(0.3, 2.0),
    st.sampled_from([0.0, 9.81]),
    st.sampled_from([0.5, 0.9, 0.95, 1.0]),
    st.floats(1e-3, 0.2),
    st.integers(0, 2**32 - 1),
)
def test_no_more_states_break_it_than_may(length, g, states, share, seed):
    arm = two_link_of(length, 1.0, 0.4, g)
    exact = ExactDynamics.of(arm, random_states(2, 60, seed))
    found = simplify_exact(exact, f"{share:%} norm at {states:%} of states", SearchOptions(TERM))
    asked = found.accuracy.asked.norm
    assert asked is not None
    assert_kept(found, exact, asked.share, states)


def test_a_file_tells_it_again(exact, model, tmp_path):
    gd.save_model(model, tmp_path / "model.json")
    again = gd.load_model(tmp_path / "model.json")
    assert again.accuracy.norms == model.accuracy.norms
    assert again.accuracy.budget == BUDGET
    assert again.accuracy.measured
    evaluation = gd.evaluate(again, exact.states)
    assert evaluation.norms == model.accuracy.norms


@pytest.mark.parametrize(
    ("share", "says"),
    [(0.0201, "at most 0.02, the budget"), (0.001, "as measured at 300 states"), (None, "at most")],
)
def test_a_file_that_tells_otherwise_is_refused(model, tmp_path, share, says):
    document = document_of(model).model_dump()
    document["norms"] = [(part, share if part == 0.95 else own) for part, own in document["norms"]]
    (tmp_path / "model.json").write_text(json.dumps(signed(document)))
    with pytest.raises(ModelError, match="the model file states impossible errors") as caught:
        gd.load_model(tmp_path / "model.json")
    assert "norms at 0.95 of the states" in caught.value.details["where"]
    assert says in caught.value.details["expected"]


def test_what_cannot_be_had_is_refused_by_name(exact, two_link, swing):
    twice, few = [swing, replace(swing, name="b")], SearchOptions(TERM, operations=20)
    refusals = {
        "a certified model": lambda: simplify_certified(exact, BUDGET, gd.Box.of(exact.arm)),
        "a limit on operations": lambda: simplify_exact(exact, BUDGET, few),
        "a trade-off": lambda: trade_off(exact, BUDGET),
        "the main job's results": lambda: gd.Settings(budget=BUDGET),
        "a model for several": lambda: gd.simplify(two_link, twice, BUDGET),
    }
    for what, ask in refusals.items():
        with pytest.raises(UsageError, match="is not possible with a budget of the norm") as caught:
            ask()
        assert caught.value.what.startswith(what)
        assert caught.value.details["found"] == f'"{BUDGET}", which is for all joints together'
        assert "next" in caught.value.details
