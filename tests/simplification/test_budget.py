"""A budget below what the machine shows is noticed once, with the budget that takes it into account."""

from __future__ import annotations

import dataclasses
import re
import shlex

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.dynamics.drivetrain import least_friction
from gd_analyze.errors import UsageError
from gd_analyze.simplification.accuracy import budget_notice
from gd_analyze.simplification.budget import Allowance, Budget, ReferenceTorques
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.text import amount
from strategies import examples

WHOLES = ("peak", "limit", "friction", "uncertainty", "torque")
PEAK = np.array([10.0, 20.0, 5.0, 1.0, 0.5, 0.0])
UNCERTAINTY = np.array([1.0, 2.0, 0.3, 0.2, 0.1, 0.05])


@pytest.fixture
def by(puma):
    return ReferenceTorques(puma, PEAK, UNCERTAINTY)


@pytest.mark.parametrize(
    ("text", "entries"),
    [
        (" 2.5 % ", [[(0.025, "peak")]]),
        ("1% of peak", [[(0.01, "peak")]]),
        ("0.5", [[(0.5, "torque")]]),
        ("0.5Nm", [[(0.5, "torque")]]),
        ("3 N", [[(3.0, "torque")]]),
        ("1e-3", [[(1e-3, "torque")]]),
        ("1%,0.2,.5%", [[(0.01, "peak")], [(0.2, "torque")], [(0.005, "peak")]]),
        ("10% of Friction", [[(0.1, "friction")]]),
        ("1%  OR uncertainty", [[(0.01, "peak"), (1.0, "uncertainty")]]),
        ("1% or 0.5% limit or 0.05 N m", [[(0.01, "peak"), (0.005, "limit"), (0.05, "torque")]]),
    ],
)
def test_what_is_understood(text, entries):
    assert [[tuple(one) for one in entry] for entry in Budget.parse(text).entries] == entries


REFUSED = ("", "%", "one", "-1%", "nan", "1e999", "1..2", "1% 2%", "1 kg", "1%,", "or", "1% or", "1 friction")


@pytest.mark.parametrize("text", [*REFUSED, "10% rust", "1% and 2", "1%,2%,1% or x"])
def test_what_is_refused(text):
    with pytest.raises(UsageError, match="budget is not understood") as caught:
        Budget.parse(text)
    assert caught.value.details["where"] == f"--budget, entry {text.count(',') + 1}"


@pytest.mark.parametrize(
    "entries", [((Allowance(-0.1),),), ((Allowance(float("inf")),),), ((Allowance(0.1, "rust"),),), (), ((),)]
)
def test_an_impossible_budget_is_refused(entries):
    with pytest.raises(UsageError, match=r"cannot be that|allows nothing"):
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


@pytest.mark.parametrize(
    ("whole", "silent", "key"),
    [("friction", {"coulomb": (0.0, 0.0)}, "coulomb"), ("limit", {"torque_limit": None}, "torque_limit")],
)
def test_what_an_arm_does_not_state_cannot_be_shared(puma, whole, silent, key):
    drives = list(puma.drives)
    drives[2] = dataclasses.replace(drives[2], **silent)
    by = ReferenceTorques(dataclasses.replace(puma, drives=tuple(drives)), PEAK)
    with pytest.raises(UsageError, match=f"cannot be a share of {whole}") as caught:
        Budget.parse(f"1% or 10% {whole}").allowed(by)
    details = caught.value.details
    assert details["where"] == "--budget, joint 3, elbow, of puma560"
    assert f"`{key}`" in details["expected"]
    entry = f"1% or 10% {whole}"
    allowed = Budget.parse(",".join([entry, entry, "1%", entry, entry, entry])).allowed(by)
    assert allowed[2] == 0.01 * PEAK[2]


def test_one_entry_or_one_per_joint(by):
    with pytest.raises(UsageError, match="wrong number of entries") as caught:
        Budget.parse("1%,2%").allowed(by)
    assert caught.value.details["expected"] == "1 or 6"


@examples(50)
@given(
    st.lists(
        st.lists(st.tuples(st.floats(0, 1e6), st.sampled_from(WHOLES)), min_size=1, max_size=4),
        min_size=1,
        max_size=6,
    )
)
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


def changed(arm, *joints, **values):
    """The arm with other drives at some joints, from 1."""
    drives = list(arm.drives)
    for joint in joints:
        drives[joint - 1] = dataclasses.replace(drives[joint - 1], **values)
    return dataclasses.replace(arm, drives=tuple(drives))


def test_a_budget_below_friction_is_noticed_with_both_numbers_and_the_flag(puma, of_budget):
    model = of_budget("1%")
    friction = least_friction(puma)
    joint = int((model.accuracy.allowed / friction).argmin())
    assert (model.accuracy.allowed < friction).all()
    assert model.notice == (
        f"Budget below the friction at every joint (joint {joint + 1}: "
        f"{amount(model.accuracy.allowed[joint], 'N m')}, friction {amount(friction[joint], 'N m')}); "
        '--budget "1% or 10% friction" takes that into account.'
    )


@pytest.mark.parametrize("budget", ["1%", "0.05 N m", "0.1% limit", "1%,1%,1%,0.1,0.1,0.1"])
def test_the_flag_settles_it(of_budget, budget):
    model = of_budget(budget)
    [_, flag] = shlex.split(re.search(r'--budget ".*?"', model.notice)[0])
    settled = of_budget(flag)
    assert settled.notice == ""
    assert (settled.accuracy.allowed >= model.accuracy.allowed * (1 - 1e-12)).all()


def test_nothing_is_noticed_where_nothing_is_stated_or_the_budget_is_larger(puma, two_link, swing, of_budget):
    assert gd.simplify(two_link, swing).notice == ""
    assert of_budget("1000 N m").notice == ""
    known = dataclasses.replace(of_budget("1%").accuracy, uncertainty=None)
    assert budget_notice(changed(puma, 1, 2, 3, 4, 5, 6, coulomb=(0.0, 0.0)), known) == ""
