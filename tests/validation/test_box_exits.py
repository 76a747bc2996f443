"""Set points outside a box: which, when, by how much, and the longest stretch of them."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.box import Box
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.studies import box_exits

TWO_LINK = load_arm("two_link")
BOX = Box(np.array([-1.0, -2.0]), np.array([1.0, 2.0]), np.array([3.0, 4.0]), np.array([5.0, 6.0]))


def motion(count: int = 11, gaps: tuple[int, ...] = (), **columns: list[float]) -> Trajectory:
    """At rest in the middle of the box every tenth of a second, but for columns such as q1, qd2."""
    states = {name: np.zeros((count, 2)) for name in ("q", "qd", "qdd")}
    for column, values in columns.items():
        states[column[:-1]][:, int(column[-1]) - 1] = values
    return Trajectory(np.arange(count) / 10, *states.values(), gaps=gaps)


def test_within_the_box_there_is_no_exit():
    edge = [1.0] * 5 + [-1.0] * 6
    exits, outside = box_exits(TWO_LINK, motion(q1=edge, qd2=[-4.0] * 11, qdd1=[5.0] * 11), BOX)
    assert exits == ()
    assert not outside.any()


def test_a_rounded_digit_beyond_a_limit_is_none():
    exits, _ = box_exits(TWO_LINK, motion(q1=[1.0 + 1e-10] * 11, qd1=[-3.0 - 1e-10] * 11), BOX)
    assert exits == ()


def test_a_ramp_leaves_at_a_known_instant():
    ramp = [0.0, 0.3, 0.6, 0.9, 1.2, 1.5, 1.1, 0.8, 0.5, 0.2, 0.0]
    (found,), outside = box_exits(TWO_LINK, motion(q1=ramp), BOX)
    farthest = found.farthest
    assert (farthest.joint, farthest.name, farthest.quantity) == (1, "shoulder", "position")
    assert (farthest.value, farthest.limit, farthest.time, farthest.unit) == (1.5, 1.0, 0.5, "rad")
    assert (found.set_points, found.first, found.begin, found.end) == (3, 0.4, 0.4, 0.6)
    assert np.flatnonzero(outside).tolist() == [4, 5, 6]


def test_rates_and_accelerations_count_by_magnitude_and_each_limit_by_itself():
    there = motion(q2=[-2.5, 2.5, *[0.0] * 9], qd1=[*[0.0] * 9, -3.5, 3.1], qdd2=[0.0, -7.0, 6.5, *[0.0] * 8])
    exits, outside = box_exits(TWO_LINK, there, BOX)
    told = [
        (e.farthest.joint, e.farthest.quantity, e.farthest.value, e.farthest.limit, e.farthest.unit)
        for e in exits
    ]
    assert told == [
        (1, "rate", 3.5, 3.0, "rad/s"),
        (2, "position", -2.5, -2.0, "rad"),
        (2, "position", 2.5, 2.0, "rad"),
        (2, "acceleration", 7.0, 6.0, "rad/s^2"),
    ]
    assert np.flatnonzero(outside).tolist() == [0, 1, 2, 9, 10]


def test_the_longest_stretch_ends_at_a_gap():
    beyond = [0.0, 2.0, 2.0, 2.0, 2.0, 0.0, 0.0, 2.0, 2.0, 2.0, 0.0]
    whole, parted = (box_exits(TWO_LINK, motion(q1=beyond, gaps=gaps), BOX)[0][0] for gaps in ((), (3,)))
    assert (whole.begin, whole.end, whole.set_points) == (0.1, 0.4, 7)
    # 1, 2 | 3, 4 and 7 to 9.
    assert (parted.begin, parted.end, parted.set_points, parted.first) == (0.7, 0.9, 7, 0.1)


def test_a_box_of_no_rate_at_all():
    still = Box(np.full(2, -1.0), np.full(2, 1.0), np.zeros(2), np.zeros(2))
    exits, _ = box_exits(TWO_LINK, motion(qd1=[0.0] * 10 + [0.5]), still)
    assert [(e.farthest.quantity, e.farthest.limit, e.first) for e in exits] == [("rate", 0.0, 1.0)]


@given(
    st.lists(st.floats(-2.0, 2.0), min_size=1, max_size=40),
    st.sets(st.integers(1, 39)),
)
def test_as_found_one_by_one(values, gaps):
    gaps = tuple(sorted(gap for gap in gaps if gap < len(values)))
    there = motion(len(values), gaps=gaps, q1=values)
    exits, outside = box_exits(TWO_LINK, there, BOX)
    # The rounded digit is 1e-9, and a limit of 1.
    expected = [abs(value) - 1.0 > 1e-9 for value in values]
    assert outside.tolist() == expected
    assert sum(e.set_points for e in exits) == sum(expected)
    for e in exits:
        side = 1.0 if e.farthest.limit > 0 else -1.0
        beyond = [side * value - 1.0 > 1e-9 for value in values]
        assert e.first == there.time[beyond.index(True)]
        assert e.farthest.value == side * max(side * value for value in values)
        lengths, run = [], None
        for k, is_beyond in enumerate(beyond):
            run = None if not is_beyond else k if run is None or k in gaps else run
            if run is not None:
                lengths.append(there.time[k] - there.time[run])
        assert e.end - e.begin == pytest.approx(max(lengths), abs=1e-15)
