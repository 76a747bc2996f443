"""Jumps of full turns: undone where a joint turns, within a stretch; limits decide across gaps."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gd_analyze.motions.unwrapping import unwrapped

WHOLE = [slice(0, 200)]


@pytest.fixture(scope="module")
def free(puma):
    """An arm whose joints turn without limits."""
    return replace(puma, joints=tuple(replace(joint, lower=None, upper=None) for joint in puma.joints))


def turning(n=6):
    return np.linspace(0.0, 2.9 * np.pi, 200)[:, None] * np.ones(n)


def test_wrapped_angles_go_on(free):
    q = turning()
    wrapped = (q + np.pi) % (2 * np.pi) - np.pi
    out, told = unwrapped(wrapped, free, WHOLE)
    np.testing.assert_allclose(out, q, atol=1e-12)
    assert told == ("6 jumps of full turns undone (every joint)",)


def test_angles_that_do_not_jump_stay_as_they_are(free):
    out, told = unwrapped(turning(), free, WHOLE)
    assert (out == turning()).all()
    assert told == ()


def test_half_turns_are_no_wrapping(free):
    q = np.zeros((200, 6))
    q[100:, 2] = 3.5
    assert (unwrapped(q, free, WHOLE)[0] == q).all()


def test_sliding_joints_are_left_alone(free):
    joints = (free.joints[0], replace(free.joints[1], kind="prismatic"), *free.joints[2:])
    sliding = replace(free, joints=joints)
    q = np.zeros((200, 6))
    q[100:, :2] = 2 * np.pi
    out, told = unwrapped(q, sliding, WHOLE)
    assert (out[:, 1] == q[:, 1]).all()
    assert np.abs(out[:, 0]).max() == 0.0
    assert told == ("1 jump of full turns undone (joint 1)",)


def test_nothing_is_undone_across_a_gap(free):
    q = np.zeros((200, 6))
    q[100:] = 2 * np.pi
    out, told = unwrapped(q, free, [slice(0, 100), slice(100, 200)])
    assert (out == q).all()
    assert told == ()


def test_a_stretch_outside_the_limits_is_put_within_where_full_turns_do(puma):
    q = np.zeros((200, 6))
    q[100:, 0] = 2 * np.pi + 0.1
    out, _ = unwrapped(q, puma, [slice(0, 100), slice(100, 200)])
    np.testing.assert_allclose(out[100:, 0], 0.1, atol=1e-12)
