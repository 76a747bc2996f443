"""States of an arm: drawn ones lie within its limits, and every state knows where it comes from."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.tables import states_in_box
from gd_analyze.types import States


def test_states_in_the_box(puma):
    states, again, other = states_in_box(puma, 300), states_in_box(puma, 300), states_in_box(puma, 300, 1)
    for name, low, high in (
        ("q", puma.limits("lower"), puma.limits("upper")),
        ("qd", -puma.limits("velocity_limit"), puma.limits("velocity_limit")),
        ("qdd", -puma.limits("acceleration_limit"), puma.limits("acceleration_limit")),
    ):
        values = getattr(states, name)
        assert ((low <= values) & (values <= high)).all()
        # Even: of 300 draws, all within the inner 90 % has a chance of 0.9^300 = 2e-14.
        assert (np.ptp(values, axis=0) > 0.9 * (high - low)).all()
        np.testing.assert_array_equal(values, getattr(again, name))
        assert not np.array_equal(values, getattr(other, name))
    assert states.described["states"] == 300


def test_a_box_that_is_assumed(puma):
    """Only what is not stated: the other joints keep their limits, and what is assumed is said."""
    joints = (dataclasses.replace(puma.joints[0], velocity_limit=None, upper=None), *puma.joints[1:])
    arm = dataclasses.replace(puma, joints=joints)
    assumed = "a range of +-3.142 rad of joint waist; a velocity of 2 rad/s of joint waist"
    with pytest.warns(GdAnalyzeWarning, match=re.escape(assumed)):
        drawn = states_in_box(arm, 500)
    assert assumed in drawn.described["box"]
    assert assumed in drawn.in_words
    as_stated = states_in_box(puma, 500)
    np.testing.assert_array_equal(drawn.q[:, 1:], as_stated.q[:, 1:])
    np.testing.assert_array_equal(drawn.qd[:, 1:], as_stated.qd[:, 1:])
    np.testing.assert_array_equal(drawn.qdd, as_stated.qdd)
    assert np.abs(drawn.q[:, 0]).max() <= np.pi
    assert np.abs(drawn.qd[:, 0]).max() <= 2.0


def test_some_of_them(puma):
    states = states_in_box(puma, 50, 4)
    np.testing.assert_array_equal(states.at(slice(3, 7)).qd, states.qd[3:7])
    assert states.at([1, 2]).described == states.described
    joined = states.joined_by(*(x[:2] for x in states.arrays))
    assert len(joined) == 52
    np.testing.assert_array_equal(joined.qdd[50:], states.qdd[:2])
    assert len(states.evenly(7)) == 7
    np.testing.assert_array_equal(states.evenly(7).q[[0, -1]], states.q[[0, -1]])
    assert len(states.evenly(80)) == 50
    for last, first in zip(states.last, states.arrays, strict=True):
        np.testing.assert_array_equal(last.T, first)
    assert states.in_words.endswith("seed 4")
    assert States(*np.zeros((3, 5, 2))).in_words == "5 states"
