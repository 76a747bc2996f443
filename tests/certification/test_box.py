"""A box of states: from an arm, around states, and what is no box."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.box import Box
from gd_analyze.errors import GdAnalyzeWarning, UsageError
from gd_analyze.robots.arm import RobotArm
from strategies import examples, random_states, two_link_of


def test_the_arms_limits(puma: RobotArm) -> None:
    box = Box.of(puma)
    assert box.n_joints == 6
    assert box.lower == pytest.approx([joint.lower for joint in puma.joints], abs=0.0)
    assert box.acceleration == pytest.approx([joint.acceleration_limit for joint in puma.joints], abs=0.0)


def test_an_arm_without_limits_has_assumed_ones_and_says_so() -> None:
    with pytest.warns(GdAnalyzeWarning, match="does not state all limits"):
        box = Box.of(two_link_of(1.0, 1.0, 1.0))
    assert (box.upper == np.pi).all()
    assert box.where.startswith(
        "the arm's limits (assumed, as none are stated: a range of +-3.142 rad of every"
    )


@examples(20)
@given(st.integers(1, 8), st.integers(1, 30), st.integers(0, 2**32 - 1))
def test_around_states_holds_all_of_them_and_no_more(n: int, count: int, seed: int) -> None:
    states = random_states(n, count, seed)
    box = Box.around(states.q, states.qd, states.qdd)
    assert ((box.lower <= states.q) & (states.q <= box.upper)).all()
    assert (np.abs(states.qd) <= box.velocity).all()
    assert (np.abs(states.qdd) <= box.acceleration).all()
    # Every limit is met by a state, so nothing smaller would do.
    for limits, seen in ((box.lower, states.q), (box.upper, states.q)):
        assert (limits == seen).any(axis=0).all()
    assert (box.velocity == np.abs(states.qd)).any(axis=0).all()
    assert (box.acceleration == np.abs(states.qdd)).any(axis=0).all()


def test_it_cannot_be_changed() -> None:
    limits = np.ones(2)
    box = Box(-limits, limits, limits, limits)
    limits[0] = 7.0
    assert box.upper[0] == 1.0
    with pytest.raises(ValueError, match="read-only"):
        box.upper[0] = 7.0


GOOD = ([-1.0, 0.0], [1.0, 0.0], [1.0, 2.0], [3.0, 0.0])


@pytest.mark.parametrize(
    ("place", "value", "message"),
    [
        (0, [2.0, 0.0], "lower, joint 1"),
        (2, [1.0, -0.5], "velocity, joint 2"),
        (3, [-1.0, 0.0], "acceleration, joint 1"),
        (1, [1.0, np.inf], "upper, joint 2"),
        (0, [np.nan, 0.0], "lower, joint 1"),
        (2, [1.0, 2.0, 3.0], "expected: 2 numbers"),
        (1, [[1.0, 0.0]], "shape"),
    ],
)
def test_what_is_no_box(place: int, value: list[float], message: str) -> None:
    limits = [np.array(limit) for limit in GOOD]
    Box(*limits)
    limits[place] = np.array(value)
    with pytest.raises(UsageError) as caught:
        Box(*limits)
    assert message in str(caught.value)


def test_an_empty_box() -> None:
    with pytest.raises(UsageError, match="one limit of each kind per joint"):
        Box(*(np.zeros(0) for _ in range(4)))


@pytest.mark.parametrize("shapes", [((0, 2),) * 3, ((3, 2), (3, 2), (2, 2)), ((3,),) * 3])
def test_states_that_are_none(shapes: tuple[tuple[int, ...], ...]) -> None:
    with pytest.raises(UsageError, match="around at least one state"):
        Box.around(*(np.zeros(shape) for shape in shapes))


def test_states_that_are_not_finite() -> None:
    with pytest.raises(UsageError, match="not finite"):
        Box.around(np.array([[0.0, np.nan]]), np.zeros((1, 2)), np.zeros((1, 2)))
