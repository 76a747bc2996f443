"""A budget below what the machine shows is noticed once, with the budget that takes it into account."""

from __future__ import annotations

import dataclasses
import re
import shlex
import warnings

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.drivetrain import least_friction
from gd_analyze.simplification.accuracy import budget_notice
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from gd_analyze.text import amount


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


def test_only_the_joints_concerned_are_named(of_budget):
    assert "at joints 1, 2 and 3 (joint 1: 1 N m, friction 24.7 N m)" in of_budget("1").notice
    said = of_budget("1% or 10% friction, 1, 100, 100, 100, 100").notice
    assert "at joint 2 (joint 2: 1 N m, friction 7.65 N m)" in said
    wider = ["1% or 10% friction", "1 N m or 10% friction", *["100 N m"] * 4]
    assert said.endswith(f'--budget "{", ".join(wider)}" takes that into account.')


def test_uncertainty_is_told_of_joints_without_friction(puma, of_budget):
    accuracy = of_budget("1%").accuracy
    bare = changed(puma, 1, 2, 3, 4, 5, 6, coulomb=(0.0, 0.0))
    said = budget_notice(bare, accuracy)
    assert "below the uncertainty at every joint" in said
    assert '--budget "1% or uncertainty"' in said
    some = budget_notice(changed(puma, 6, coulomb=(0.0, 0.0)), accuracy)
    assert "below the friction at joints 1, 2, 3, 4 and 5 (" in some
    assert " and below the uncertainty at joint 6 (joint 6: " in some
    assert some.count("10% friction") == 5
    assert '1% or uncertainty" takes' in some


def test_nothing_is_noticed_where_nothing_is_stated_or_the_budget_is_larger(puma, two_link, swing, of_budget):
    assert gd.simplify(two_link, swing).notice == ""
    assert of_budget("1000 N m").notice == ""
    known = dataclasses.replace(of_budget("1%").accuracy, uncertainty=None)
    assert budget_notice(changed(puma, 1, 2, 3, 4, 5, 6, coulomb=(0.0, 0.0)), known) == ""


def test_users_of_the_library_are_not_warned(puma, pick_and_place):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model = gd.simplify(puma, pick_and_place, "10%")
    assert model.notice


def test_uncertainty_is_kept_with_the_promise(puma, pick_and_place, of_budget):
    states = gd.states_of(pick_and_place)
    expected = gd.torque_uncertainty(puma, states).max(axis=0)
    np.testing.assert_array_equal(of_budget("1%").accuracy.uncertainty, expected)
    bare = gd.simplify(puma, states, "10%", drives=False).accuracy.uncertainty
    assert (bare < expected).any()
