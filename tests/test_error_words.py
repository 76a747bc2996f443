"""An error is told in the terms in which its budget was given."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.results import summary
from gd_analyze.results.summary import nothing_gained, off_by, worst_error
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.text import amount


@pytest.fixture(scope="module")
def of_budget(puma, pick_and_place):
    exact = gd.ExactDynamics.of(puma, pick_and_place, True)
    return lambda budget: simplify_exact(exact, budget, SearchOptions(thorough=False, write=False))


def test_a_share_of_peak_torque_is_answered_in_these(of_budget):
    model = of_budget("1%")
    errors = model.accuracy.errors
    assert off_by(model) == f"no joint's torque is off by more than {worst_error(model).size} of its peak"
    told = float(worst_error(model).size.removesuffix(" %")) / 100
    # Two digits of a number of about 0.9 %.
    assert told == pytest.approx(errors.largest_share.max(), abs=5e-5)
    assert worst_error(model).joint == errors.worst + 1
    assert worst_error(model).of == "peak torque"


def test_torques_are_answered_in_torques(of_budget):
    model = of_budget("1")
    largest = model.accuracy.errors.largest
    assert "%" not in off_by(model)
    assert off_by(model) == f"no joint's torque is off by more than {largest.max():.3g} N m"
    assert worst_error(model).in_words == f"{largest.max():.3g} N m (joint {largest.argmax() + 1})"


def test_a_torque_for_every_joint_is_answered_joint_by_joint(of_budget):
    model = of_budget("1, 1, 1, 0.1, 0.1, 0.1")
    said = off_by(model)
    assert said.startswith("the torques of joints 1 to 6 are off by at most ")
    sizes = ", ".join(amount(error, "N m") for error in model.accuracy.errors.largest)
    assert said.endswith(f" at most {sizes}")


def test_the_larger_of_several_is_answered_by_what_is_used_of_it(of_budget):
    model = of_budget("1% or 10% friction")
    accuracy = model.accuracy
    used = accuracy.errors.largest / accuracy.allowed
    joint = int(used.argmax())
    worst = worst_error(model)
    assert (worst.joint, worst.of) == (joint + 1, "allowed error")
    assert float(worst.size.removesuffix(" %")) == pytest.approx(100 * used.max(), abs=0.5)  # no decimals
    assert f"of what a budget of 1% or 10% friction allows it (joint {joint + 1}: " in off_by(model)
    assert f" of {accuracy.allowed[joint]:.3g} N m)" in off_by(model)


def test_sliding_joints_err_in_newtons():
    stanford = gd.load_arm("stanford")
    swing = gd.states_in_box(stanford, 200)
    model = gd.simplify(stanford, swing, "50 N m", drives=False)
    assert re.search(r"off by at most .*[\d.]+ N m, [\d.]+ N m, [\d.]+ N, ", off_by(model))


def test_a_bound_is_never_told_smaller_than_it_is(of_budget):
    model = of_budget("1%")
    bound = 0.01001 * model.accuracy.errors.peak_torque
    assert off_by(model, bound) == "no joint's torque is off by more than 1.1 % of its peak"
    assert off_by(of_budget("1"), np.full(6, 1.0001)) == "no joint's torque is off by more than 1.01 N m"


def test_it_is_said_where_nothing_can_be_dropped(of_budget):
    assert nothing_gained(of_budget("1%")) == ""
    model = of_budget("0.0001%")
    assert not model.saves
    assert nothing_gained(model).startswith("Nothing is saved within the budget of 0.0001%: ")
    full = model.operations_full.total
    assert f"the {full} of the exact torque (drives included), which is given" in nothing_gained(model)


def test_a_certified_budget_is_told_as_the_same_one(of_budget):
    model = of_budget("1%")
    certified = replace(model, accuracy=replace(model.accuracy, budget="1%, certified"))
    assert off_by(certified) == off_by(model)


def test_the_exact_torque_is_not_told_to_err(swing_findings):
    assert not swing_findings.model.saves
    assert summary.facts(swing_findings)[0][0] == "≈ 0"
    assert summary.tube_sentence(swing_findings).endswith("beyond round-off, as nothing is dropped.")
