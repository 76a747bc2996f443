"""Budgets: how they are read, what they allow, and when one is too small; norms of a model's error."""

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
from gd_analyze.dynamics.drivetrain import least_friction
from gd_analyze.errors import UsageError
from gd_analyze.simplification.accuracy import kept_states, norm_shares, share_at
from gd_analyze.simplification.budget import Allowance, ReferenceTorques
from gd_analyze.simplification.harmonic import TERM
from gd_analyze.simplification.model_file import document_of
from gd_analyze.simplification.search import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.tables import states_in_box
from gd_analyze.types import Budget, ExactDynamics
from made_models import signed
from parallel_axes import scara
from strategies import examples

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
    "3 N": [[(3.0, "force")]],
    "1%,0.2,.5%": [[(0.01, "peak")], [(0.2, "torque")], [(0.005, "peak")]],
    "10% of Friction": [[(0.1, "friction")]],
    "1%  OR uncertainty": [[(0.01, "peak"), (1.0, "uncertainty")]],
    "1% or 0.5% limit or 0.05 N m": [[(0.01, "peak"), (0.005, "limit"), (0.05, "torque")]],
}


def test_what_is_understood():
    for text, entries in UNDERSTOOD.items():
        assert [[tuple(one) for one in entry] for entry in Budget.parse(text).entries] == entries


def test_a_force_is_no_budget_of_a_joint_that_turns(by):
    scara = gd.load_arm("scara")
    with pytest.raises(UsageError) as caught:
        Budget.parse("5 N").allowed(by)
    assert "joint 1" in caught.value.details["where"]
    with pytest.raises(UsageError):
        Budget.parse("5 MN m")  # not 5 mN m
    slides = [not revolute for revolute in scara.is_revolute]
    allowed = Budget.parse("0.5 N m or 5 N").allowed(ReferenceTorques(scara, np.ones(scara.n_joints)))
    np.testing.assert_array_equal(allowed, np.where(slides, 5.0, 0.5))


REFUSED = ("", "%", "one", "-1%", "nan", "1e999", "1% 2%", "1 kg", "1%,", "1% or", "1 friction", "10% rust")


@pytest.mark.parametrize("text", [*REFUSED, "1%,2%,1% or x"])
def test_what_is_refused(text):
    with pytest.raises(UsageError) as caught:
        Budget.parse(text)
    assert caught.value.details["where"] == f"budget, entry {text.count(',') + 1}"
    assert "next" in caught.value.details


@pytest.mark.parametrize("text", ["norm", "1% norm", "1% of the norm at 95% of states", "1% NORM, 2%"])
def test_a_share_of_the_norm_is_not_a_budget(text):
    with pytest.raises(UsageError) as caught:
        Budget.parse(text, "fail_over")
    assert caught.value.details["where"] == "fail_over"
    assert "norms" in caught.value.details["next"]


@pytest.mark.parametrize(
    "entries", [((Allowance(-0.1),),), ((Allowance(float("inf")),),), ((Allowance(0.1, "rust"),),), (), ((),)]
)
def test_an_impossible_budget_is_refused(entries):
    with pytest.raises(UsageError) as caught:
        Budget(entries)
    assert caught.value.details["where"] == "Budget"


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
    assert caught.value.details["where"] == "budget, joint 3, elbow, of puma560"
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
    exact = gd.types.ExactDynamics.of(puma, pick_and_place)
    return lambda budget: simplify_exact(exact, budget, SearchOptions(thorough=False))


@pytest.mark.parametrize("budget", ["1%", "1%,1%,1%,0.1,0.1,0.1"])
def test_the_flag_of_a_notice_settles_it(of_budget, budget):
    model = of_budget(budget)
    [_, flag] = shlex.split(re.search(r'--budget ".*?"', model.notice)[0])
    settled = of_budget(flag)
    assert settled.notice == ""
    assert (settled.accuracy.allowed >= model.accuracy.allowed * (1 - 1e-12)).all()


def test_how_many_states_a_share_is():
    for share, count, kept in ((0.95, 4000, 3800), (0.999, 4000, 3996), (0.95, 10, 10), (0.5, 3, 2)):
        assert kept_states(share, count) == kept


@st.composite
def errors(draw):
    """Torques, N m or N, of some joints that turn or slide, and errors, (N, n) each; which turn."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    turning = np.array(draw(st.lists(st.booleans(), min_size=1, max_size=5)))
    shape = draw(st.integers(1, 60)), len(turning)
    return 0.02 * rng.standard_cauchy(size=shape), rng.normal(size=shape), turning


@given(errors(), st.sampled_from([0.5, 0.9, 0.95, 0.999, 1.0]))
def test_as_many_states_keep_the_share_and_no_smaller_one(case, states):
    error, torque, turning = case
    norms = [
        np.linalg.norm(error[:, of], axis=1) / np.linalg.norm(torque[:, of], axis=1)
        for of in (turning, ~turning)
        if of.any()
    ]
    by_hand, share = np.max(norms, axis=0), share_at(norm_shares(error, torque, turning), states)
    # A quotient and a product, rounded once each.
    beyond, at_least = by_hand > share * (1 + 4e-16), by_hand >= share * (1 - 4e-16)
    exempt = len(by_hand) - kept_states(states, len(by_hand))
    assert beyond.sum() <= exempt < at_least.sum()
    assert exempt <= (1.0 - states) * len(by_hand) + 1e-9


@given(errors(), st.floats(1e-3, 1e3))
def test_the_unit_of_sliding_joints_does_not_count_and_one_norm_of_all_is_no_larger(case, unit):
    error, torque, turning = case
    scale = np.where(turning, 1.0, unit)
    shares = norm_shares(error, torque, turning)
    # Sums of up to five squares, rounded.
    np.testing.assert_allclose(norm_shares(scale * error, scale * torque, turning), shares, rtol=1e-14)
    mixed = np.linalg.norm(scale * error, axis=1) / np.linalg.norm(scale * torque, axis=1)
    assert (mixed <= shares * (1 + 1e-14)).all()


def test_round_off_and_rest_count_as_no_error():
    torque, turning = np.array([[1.0, 0.0], [0.0, 0.0]]), np.array([True, True])
    assert norm_shares(np.full((2, 2), 1e-13), torque, turning, 1e-12).tolist() == [0.0, 0.0]
    assert norm_shares(np.array([[0.0, 0.0], [1e-3, 0.0]]), torque, turning).tolist() == [0.0, math.inf]


@pytest.fixture(scope="module")
def exact() -> ExactDynamics:
    limits = {"lower": -np.pi, "upper": np.pi, "velocity_limit": 1.0, "acceleration_limit": 10.0}
    arm = scara()
    arm = replace(arm, joints=tuple(replace(joint, **limits) for joint in arm.joints))
    return ExactDynamics.of(arm, states_in_box(arm, 300))


@pytest.fixture(scope="module")
def model(exact) -> gd.types.SimplifiedModel:
    return simplify_exact(exact, "2%", SearchOptions(TERM))


def shares_by_hand(model: gd.types.SimplifiedModel, exact: ExactDynamics) -> np.ndarray:
    """Share of the norm at every state, of joints of one unit each."""
    error = model.torque(*exact.states.arrays) - exact.torque
    turning = np.array(exact.arm.is_revolute)
    norms = ([np.linalg.norm(x[:, of], axis=1) for x in (error, exact.torque)] for of in (turning, ~turning))
    with np.errstate(invalid="ignore"):  # of no sliding joint
        return np.fmax.reduce([lost / whole for lost, whole in norms])


def test_the_norms_are_those_of_what_the_program_does(exact, model):
    by_hand = np.sort(shares_by_hand(model, exact))
    assert model.operations.total < exact.form.operations.total
    for share, states in model.accuracy.norms:
        # What is below round-off of the largest torque counts as no error, and may be a share of a small one.
        assert share == pytest.approx(by_hand[kept_states(states, len(by_hand)) - 1], rel=1e-9, abs=1e-9)


def test_a_file_tells_the_norms_again(exact, model, tmp_path):
    gd.save_model(model, tmp_path / "model.json")
    again = gd.load_model(tmp_path / "model.json")
    assert again.accuracy.norms == model.accuracy.norms
    assert again.accuracy.measured
    assert gd.evaluate(again, exact.states).motions[0].norms == model.accuracy.norms


def test_norms_that_a_file_tells_are_measured_again(model, tmp_path):
    document = document_of(model).model_dump(mode="json")
    document["accuracy"]["norms"] = [[0.5 * share, states] for share, states in document["accuracy"]["norms"]]
    (tmp_path / "model.json").write_text(json.dumps(signed(document)))
    assert gd.load_model(tmp_path / "model.json").accuracy.norms == model.accuracy.norms
