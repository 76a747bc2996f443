"""Tubes and margins: they hold every state they should, in few boxes, and state where they are wide."""

from __future__ import annotations

import math
from dataclasses import astuple, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze import pool
from gd_analyze.certification import tube as module
from gd_analyze.certification.between import Between
from gd_analyze.errors import TrajectoryError, UsageError
from strategies import examples, motions


def holds(tube: gd.types.Tube, time: float, states: np.ndarray, slack: float = 0.0) -> bool:
    """Whether the boxes about an instant hold states of shape (.., 3, n), and all within the margins."""
    there = (tube.begin <= time + 1e-12) & (tube.end >= time - 1e-12)
    lower, upper = tube.lower[there].min(axis=0), tube.upper[there].max(axis=0)
    reach = states - tube.margins, states + tube.margins
    return bool((reach[0] >= lower - slack).all() and (reach[1] <= upper + slack).all())


def states_of(motion: gd.Trajectory) -> np.ndarray:
    return np.stack([motion.q, motion.qd, motion.qdd], axis=1)


def holds_all(tube: gd.types.Tube, motion: gd.Trajectory, slack: float = 0.0) -> bool:
    states = zip(motion.time, states_of(motion), strict=True)
    return all(holds(tube, time, state, slack) for time, state in states)


def is_a_chain(tube: gd.types.Tube, motion: gd.Trajectory) -> bool:
    ends = (tube.begin[0], tube.end[-1]) == (motion.time[0], motion.time[-1])
    return ends and bool((tube.begin[1:] == tube.end[:-1]).all() and (tube.begin <= tube.end).all())


def sine(count: int) -> gd.Trajectory:
    time, w = np.linspace(0.0, 2.0, count), np.array([2.0, 3.0])
    angle = np.outer(time, w)
    return gd.Trajectory(time, np.sin(angle), w * np.cos(angle), -(w**2) * np.sin(angle))


@pytest.mark.parametrize("most", [3, 40, 2048])
@examples(12)
@given(case=motions(), seed=st.integers(0, 2**32 - 1))
def test_states_of_all_motions_between_set_points_are_in_it(case, seed, most):
    arm, motion = case
    rng = np.random.default_rng(seed)
    tube = gd.types.Tube.along(arm, motion, most=most)
    assert len(tube) <= most
    assert is_a_chain(tube, motion)
    # Numbers of 1e4 rad/s^2, between set points that contradict one another, are off by some of their eps.
    slack = 1e-9 * float(np.abs(tube.upper).max())
    for interval in rng.integers(0, motion.n_set_points - 1, 6):
        share = rng.choice([0.0, 1.0, rng.random()])
        time = motion.time[interval] + share * (motion.time[interval + 1] - motion.time[interval])
        between = Between.of(motion, np.zeros((2, motion.n_joints)), slice(interval, interval + 1))
        states = np.einsum("j,jmon->mon", share ** np.arange(6), between.coefficients[0])
        assert holds(tube, time, states, slack)


@pytest.mark.parametrize("gaps", [(), (1, 700, 701, 1500)])
def test_a_motion_in_groups_of_intervals_is_in_it(two_link, gaps, monkeypatch):
    fine = replace(sine(2001), gaps=gaps)
    each = gd.types.Tube.along(two_link, fine, most=60)
    monkeypatch.setattr(module, "_MOST_GROUPS", 300)
    grouped = gd.types.Tube.along(two_link, fine, most=60)
    assert len(grouped) <= 60
    assert holds_all(grouped, fine, 1e-12)
    assert (grouped.coarse, grouped.note) == (each.coarse, each.note)
    if not gaps:
        assert is_a_chain(grouped, fine)
        # Groups of eight intervals of 1 ms are short against boxes of a thirtieth of a second.
        size = [(tube.upper - tube.lower).prod(axis=(1, 2)).mean() for tube in (grouped, each)]
        assert size[0] <= 1.5 * size[1]
    coarse = gd.Trajectory(fine.time * 100.0, fine.q, fine.qd, fine.qdd)
    assert gd.types.Tube.along(two_link, coarse).coarse == len(coarse.time) - 1


@pytest.mark.parametrize("side", [0, 1])
def test_accelerations_that_jump_at_a_set_point_are_in_it_from_both_sides(two_link, side):
    """A trapezoidal profile, its set points at the corners: either acceleration of a corner may be given."""
    time, pushes = np.array([0.0, 1.0, 3.0, 4.0]), np.array([2.0, 0.0, -2.0])
    velocities = np.concatenate([[0.0], np.cumsum(pushes * np.diff(time))])
    positions = np.concatenate([[0.0], np.cumsum((velocities[1:] + velocities[:-1]) / 2 * np.diff(time))])
    accelerations = np.append(pushes, -2.0) if side else np.insert(pushes, 0, 2.0)
    q, qd, qdd = (np.outer(x, [1.0, 0.5]) for x in (positions, velocities, accelerations))
    tube = gd.types.Tube.along(two_link, gd.Trajectory(time, q, qd, qdd))
    for interval, push in enumerate(pushes):
        for t in np.linspace(0.0, time[interval + 1] - time[interval], 41):
            velocity = velocities[interval] + push * t
            position = positions[interval] + velocities[interval] * t + push * t**2 / 2
            assert holds(tube, time[interval] + t, np.outer([position, velocity, push], [1.0, 0.5]), 1e-12)


def test_a_coarse_trajectory_has_a_wider_tube_that_says_so(two_link):
    fine, coarse = gd.types.Tube.along(two_link, sine(60)), gd.types.Tube.along(two_link, sine(6))
    closely = sine(1001)
    # The sine itself is no polynomial: it takes some of the margins between set points.
    near = replace(fine, margins=0.0 * fine.margins)
    assert holds_all(near, closely)
    assert (fine.coarse, fine.note) == (0, "")
    assert coarse.coarse == 5
    assert "5 of 5 intervals" in coarse.note
    widths = [np.mean(tube.upper - tube.lower, axis=0) for tube in (fine, coarse)]
    assert (widths[1] > 2 * widths[0]).all()
    # Boxes are as large as the margins, of which one is the tube's own and one the motion's.
    assert ((fine.upper - fine.lower) / (2 * fine.margins) <= 2.2).all()
    assert len(fine) < 400


def test_one_ambiguous_interval_is_named(two_link):
    motion = sine(61)
    bent = motion.qdd.copy()
    bent[30, 1] += 0.4 * np.abs(bent[:, 1]).max()
    tube = gd.types.Tube.along(two_link, replace(motion, qdd=bent))
    assert tube.coarse == 2
    assert "acceleration of joint 2" in tube.note
    there = (tube.begin >= motion.time[29] - 1e-9) & (tube.end <= motion.time[31] + 1e-9)
    widths = (tube.upper - tube.lower)[:, 2, 1]
    assert widths[there].min() > 2 * np.median(widths[~there])


def test_a_long_recording_has_few_boxes(two_link):
    motion = sine(20_000)
    assert len(gd.types.Tube.along(two_link, motion)) <= 1000
    tube = gd.types.Tube.along(two_link, motion, most=50)
    assert len(tube) <= 50
    assert is_a_chain(tube, motion)
    for k in range(0, motion.n_set_points, 499):
        assert holds(tube, motion.time[k], states_of(motion)[k], 1e-12)


def test_rounded_numbers_at_a_thousand_a_second_are_not_coarse(two_link):
    """A last digit of 1e-6 rad over a millisecond would be an acceleration of many rad/s^2."""
    motion = sine(2001)
    rounded = gd.Trajectory(motion.time, *(np.round(x, 6) for x in (motion.q, motion.qd, motion.qdd)))
    tube = gd.types.Tube.along(two_link, rounded)
    assert tube.coarse == 0
    assert np.abs(tube.upper[:, 2] - tube.lower[:, 2]).max() <= 4 * tube.margins[2].max() + 1e-9


def test_still_joints_no_margins_and_a_single_set_point(two_link):
    motion = sine(60)
    half = gd.Trajectory(motion.time, *(x * [1.0, 0.0] for x in (motion.q, motion.qd, motion.qdd)))
    still = gd.types.Tube.along(two_link, half)
    assert not still.lower[:, 1:, 1].any()
    assert not still.upper[:, 1:, 1].any()
    np.testing.assert_allclose(still.upper[:, 0, 1], np.radians(1.0))
    bare = gd.types.Tube.along(two_link, motion, gd.types.Margin(0.0, 0.0, 0.0, 0.0))
    assert holds_all(bare, motion, 1e-12)
    state = np.array([[0.3, -0.4]])
    one = gd.types.Tube.along(two_link, gd.Trajectory(np.zeros(1), state, 2 * state, 3 * state))
    np.testing.assert_allclose(one.upper[0, 1] - one.lower[0, 1], 0.04 * np.abs(2 * state[0]))


def joined(*motions: gd.Trajectory) -> gd.Trajectory:
    """Motions one after the other, with gaps of a second between."""
    count = motions[0].n_set_points
    times = [motion.time + k * (motion.time[-1] + 1.0) for k, motion in enumerate(motions)]
    states = (np.concatenate([getattr(motion, name) for motion in motions]) for name in ("q", "qd", "qdd"))
    gaps = tuple(range(count, count * len(motions), count))
    return gd.Trajectory(np.concatenate(times), *states, name="joined", gaps=gaps)


def test_each_stretch_between_gaps_has_its_own_boxes(two_link, swing):
    motion = joined(swing, swing)
    alone, both = gd.types.Tube.along(two_link, swing), gd.types.Tube.along(two_link, motion)
    # Time was shifted, which rounds the steps in their last digits.
    np.testing.assert_allclose(both.lower, np.tile(alone.lower, (2, 1, 1)), rtol=0, atol=1e-9)
    np.testing.assert_allclose(both.upper, np.tile(alone.upper, (2, 1, 1)), rtol=0, atol=1e-9)
    before, after = motion.time[motion.gaps[0] - 1], motion.time[motion.gaps[0]]
    assert not ((both.begin < after) & (both.end > before)).any()
    assert "Gaps in the motion: 1" in both.note
    whole = gd.types.Tube.along(two_link, replace(motion, gaps=()))
    assert ((whole.begin < after) & (whole.end > before)).any()


def test_every_stretch_has_a_box_and_single_set_points_are_boxes(two_link, swing):
    motion = joined(swing, swing, swing)
    tube = gd.types.Tube.along(two_link, motion, most=1)
    for part, lower, upper in zip(motion.stretches, tube.lower, tube.upper, strict=True):
        assert ((states_of(motion)[part] >= lower) & (states_of(motion)[part] <= upper)).all()
    q, qd, qdd = (getattr(swing, name)[:3] for name in ("q", "qd", "qdd"))
    single = gd.types.Tube.along(two_link, gd.Trajectory([0.0, 1.0, 2.0], q, qd, qdd, gaps=(1, 2)))
    np.testing.assert_allclose((single.lower + single.upper)[:, 0] / 2, q, atol=1e-12)
    mixed = gd.types.Tube.along(two_link, gd.Trajectory([0.0, 0.01, 2.0], q, qd, qdd, gaps=(2,)))
    assert mixed.begin[-1] == mixed.end[-1] == 2.0


def test_impossible_motions_and_other_arms_are_refused(two_link, puma):
    q = np.array([[0.0, 0.0], [1.0, 1.0]])
    with pytest.raises(TrajectoryError, match="set points 1 and 2"):
        gd.types.Tube.along(two_link, gd.Trajectory(np.array([0.0, 1e-9]), q, 0 * q, 0 * q))
    with pytest.raises(UsageError, match="does not fit arm"):
        gd.types.Tube.along(puma, sine(10))


@pytest.mark.parametrize(
    ("text", "margin"),
    [
        ("1deg,1mm,qd=2%,qdd=5%", gd.types.Margin()),
        (" 0.02 rad , 0.002 m", gd.types.Margin(revolute=0.02, prismatic=0.002)),
        ("qdd=10%,qd=0%", gd.types.Margin(velocity=0.0, acceleration=0.1)),
    ],
)
def test_margins_are_read_and_written(text, margin):
    assert gd.types.Margin.parse(text) == margin
    assert astuple(gd.types.Margin.parse(str(margin))) == pytest.approx(astuple(margin), rel=1e-11)


@pytest.mark.parametrize(
    ("text", "entry"),
    [("", 1), ("1", 1), ("-1deg", 1), ("nan deg", 1), ("1deg,,1mm", 2), ("qd=1deg", 1), ("1m,1mm", 2)],
)
def test_wrong_margins_are_refused(text, entry):
    with pytest.raises(UsageError, match=f"margin, entry {entry}"):
        gd.types.Margin.parse(text)


@pytest.mark.parametrize("values", [{"velocity": -0.1}, {"revolute": math.nan}, {"prismatic": math.inf}])
def test_margins_out_of_range_are_refused(values):
    with pytest.raises(UsageError, match=f"Margin, {next(iter(values))}"):
        gd.types.Margin(**values)


def test_velocities_and_accelerations_have_shares_of_their_largest():
    """Joint 3 of the Stanford arm is prismatic; joint 1 is held still and has a margin of position alone."""
    arm = gd.load_arm("stanford")
    qd, qdd = np.ones((3, 6)) * [0, 1, -2, 3, 4, 5], -2 * np.ones((3, 6)) * range(6)
    margins = gd.types.Margin().along(arm, gd.Trajectory(np.arange(3.0), np.zeros((3, 6)), qd, qdd))
    of_positions = [*np.radians([1, 1]), 1e-3, *np.radians([1, 1, 1])]
    np.testing.assert_allclose(margins, [of_positions, 0.02 * np.abs(qd[0]), 0.05 * np.abs(qdd[0])])


def test_around_several_motions_are_the_boxes_of_each(two_link, swing):
    """With their own margins and by the clock of the whole."""
    slow = gd.Trajectory(2.0 * swing.time + 1.0, swing.q, swing.qd / 2.0, swing.qdd / 4.0, "slow")
    whole = pool([swing, slow])
    both, parts = (
        gd.types.Tube.along(two_link, whole),
        [gd.types.Tube.along(two_link, one) for one in (swing, slow)],
    )
    for name in ("lower", "upper"):
        # Times of another clock are rounded elsewhere, by 1e-15 of some seconds, over intervals of 0.03 s.
        expected = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_allclose(getattr(both, name), expected, rtol=0.0, atol=1e-12)
    np.testing.assert_array_equal(both.motion, np.repeat([0, 1], [len(part) for part in parts]))
    np.testing.assert_array_equal(both.margins, parts[1].margins)
    begins = [whole.time[motion.first] for motion in whole.motions]
    np.testing.assert_allclose([both.begin[both.motion == k].min() for k in (0, 1)], begins, atol=1e-12)
    assert both.end.max() == pytest.approx(whole.time[-1])
    weighed = replace(
        both, weights=np.repeat([[1.0, 1.0], [2.0, 3.0]], [len(part) for part in parts], axis=0)
    )
    state = both.lower[[0, -1]].swapaxes(0, 1)
    np.testing.assert_array_equal(weighed.counts_at(state), [[1.0, 1.0], [2.0, 3.0]])
