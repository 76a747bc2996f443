"""The tube: every state it is said to hold it holds, in few boxes, and where it is wide it says so."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.certification.tube import Margin, Tube
from gd_analyze.errors import TrajectoryError, UsageError
from gd_analyze.motions.between import Between
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from strategies import examples, motions


def states_at(motion: Trajectory, interval: int, share: float) -> np.ndarray:
    """The states of the three motions between set points, shape (3 motions, 3, n)."""
    between = Between.of(motion, np.zeros((2, motion.n_joints)), slice(interval, interval + 1))
    return np.einsum("j,jmon->mon", share ** np.arange(6), between.coefficients[0])


def holds(tube: Tube, time: float, states: np.ndarray, slack: float = 0.0) -> bool:
    """Whether the boxes about an instant hold states of shape (.., 3, n)."""
    there = (tube.begin <= time + 1e-12) & (tube.end >= time - 1e-12)
    lower, upper = tube.lower[there].min(axis=0), tube.upper[there].max(axis=0)
    return bool(((states >= lower - slack) & (states <= upper + slack)).all())


def is_a_chain(tube: Tube, motion: Trajectory) -> bool:
    ends = (tube.begin[0], tube.end[-1]) == (motion.time[0], motion.time[-1])
    return ends and bool((tube.begin[1:] == tube.end[:-1]).all() and (tube.begin <= tube.end).all())


@examples(40)
@given(motions(), st.integers(0, 2**32 - 1), st.sampled_from([3, 40, 2048]))
def test_states_within_the_margins_of_what_is_between_set_points_are_in_it(
    case, seed: int, most: int
) -> None:
    arm, motion = case
    rng = np.random.default_rng(seed)
    tube = Tube.along(arm, motion, most=most)
    assert len(tube) <= most
    assert is_a_chain(tube, motion)
    # Numbers of 1e4 rad/s^2, between set points that contradict one another, are off by some of their eps.
    slack = 1e-9 * float(np.abs(tube.upper).max())
    for interval in rng.integers(0, motion.n_set_points - 1, 6):
        share = rng.choice([0.0, 1.0, rng.random()])
        time = motion.time[interval] + share * (motion.time[interval + 1] - motion.time[interval])
        off = rng.choice([-1.0, 1.0], (3, 3, arm.n_joints)) * tube.margins
        assert holds(tube, time, states_at(motion, int(interval), share) + off, slack)


@pytest.mark.parametrize("side", [0, 1])
def test_accelerations_that_jump_at_a_set_point_are_in_it_from_both_sides(two_link: RobotArm, side) -> None:
    """A trapezoidal profile, its set points at the corners: either acceleration of a corner may be given."""
    time, pushes = np.array([0.0, 1.0, 3.0, 4.0]), np.array([2.0, 0.0, -2.0])
    velocities = np.concatenate([[0.0], np.cumsum(pushes * np.diff(time))])
    positions = np.concatenate([[0.0], np.cumsum((velocities[1:] + velocities[:-1]) / 2 * np.diff(time))])
    given_pushes = np.append(pushes, -2.0) if side else np.insert(pushes, 0, 2.0)
    q, qd, qdd = (np.outer(x, [1.0, 0.5]) for x in (positions, velocities, given_pushes))
    motion = Trajectory(time, q, qd, qdd)
    tube = Tube.along(two_link, motion)
    for interval, push in enumerate(pushes):
        for share in np.linspace(0.0, 1.0, 41):
            t = share * (time[interval + 1] - time[interval])
            state = np.array([positions[interval] + velocities[interval] * t + push * t**2 / 2, 0.0, push])
            state[1] = velocities[interval] + push * t
            states = state[:, None] * [1.0, 0.5]
            off = np.stack([tube.margins, -tube.margins])
            assert holds(tube, time[interval] + t, states + off, 1e-12)


def wave(count: int, duration: float = 2.0) -> Trajectory:
    time = np.linspace(0.0, duration, count)
    w = np.array([2.0, 3.0])
    angle = np.outer(time, w)
    return Trajectory(time, np.sin(angle), w * np.cos(angle), -(w**2) * np.sin(angle))


@pytest.mark.parametrize("count", [12, 60, 1000])
def test_a_smooth_motion_is_in_it(two_link: RobotArm, count: int) -> None:
    motion, closely = wave(count), wave(4001)
    tube = Tube.along(two_link, motion)
    states = np.stack([closely.q, closely.qd, closely.qdd], axis=1)
    for time, state in zip(closely.time, states, strict=True):
        assert holds(tube, time, state)


def test_a_coarse_trajectory_is_told_and_its_tube_is_wider(two_link: RobotArm) -> None:
    fine, coarse = Tube.along(two_link, wave(60)), Tube.along(two_link, wave(6))
    assert (fine.coarse, fine.note) == (0, "")
    assert coarse.coarse == 5
    for words in ("too far apart", "5 of 5 intervals", "every joint", "the tube is wider there"):
        assert words in coarse.note
    widths = [np.mean(tube.upper - tube.lower, axis=0) for tube in (fine, coarse)]
    assert (widths[1] > 2 * widths[0]).all()


def test_one_interval_that_is_open_is_named(two_link: RobotArm) -> None:
    motion = wave(61)
    bent = motion.qdd.copy()
    bent[30, 1] += 0.4 * np.abs(bent[:, 1]).max()
    tube = Tube.along(two_link, Trajectory(motion.time, motion.q, motion.qd, bent))
    assert tube.coarse == 2
    assert "acceleration of joint 2" in tube.note
    open_ = (tube.begin >= motion.time[29] - 1e-9) & (tube.end <= motion.time[31] + 1e-9)
    widths = (tube.upper - tube.lower)[:, 2, 1]
    assert widths[open_].min() > 2 * np.median(widths[~open_])


def test_pieces_are_about_as_large_as_the_margins(two_link: RobotArm) -> None:
    tube = Tube.along(two_link, wave(60))
    widths = (tube.upper - tube.lower) / (2 * tube.margins)
    # Of two margins one is the tube's own, the other what the motion changes by; to this comes a few per cent
    # by which the motions between set points differ.
    assert (widths <= 2.2).all()
    assert len(tube) < 400


def test_a_long_recording_has_few_boxes(two_link: RobotArm) -> None:
    """Set points in the same box have it in common, and so do more of them where boxes are few."""
    motion = wave(100_000)
    usual, few = Tube.along(two_link, motion), Tube.along(two_link, motion, most=50)
    assert 50 < len(usual) < 1000
    assert len(few) <= 50
    for tube in (usual, few):
        assert is_a_chain(tube, motion)
        for k in range(0, motion.n_set_points, 997):
            state = np.stack([motion.q[k], motion.qd[k], motion.qdd[k]])
            assert holds(tube, motion.time[k], np.stack([state + tube.margins, state - tube.margins]), 1e-12)


def test_rounded_numbers_at_a_thousand_a_second_are_not_coarse(two_link: RobotArm) -> None:
    """A last digit of 1e-6 rad over a millisecond would be an acceleration of many rad/s^2."""
    motion = wave(2001)
    rounded = Trajectory(motion.time, *(np.round(x, 6) for x in (motion.q, motion.qd, motion.qdd)))
    tube = Tube.along(two_link, rounded)
    assert tube.coarse == 0
    assert np.abs(tube.upper[:, 2] - tube.lower[:, 2]).max() <= 4 * tube.margins[2].max() + 1e-9


def test_a_joint_that_stands_still_is_still_but_for_its_position(two_link: RobotArm) -> None:
    motion = wave(60)
    still = [np.stack([x[:, 0], 0.0 * x[:, 0]], axis=1) for x in (motion.q, motion.qd, motion.qdd)]
    tube = Tube.along(two_link, Trajectory(motion.time, *still))
    assert not tube.lower[:, 1:, 1].any()
    assert not tube.upper[:, 1:, 1].any()
    np.testing.assert_allclose(tube.upper[:, 0, 1], np.radians(1.0))


def test_no_margins_leave_the_motion(two_link: RobotArm) -> None:
    motion = wave(60)
    tube = Tube.along(two_link, motion, Margin(0.0, 0.0, 0.0, 0.0))
    for k in range(motion.n_set_points):
        assert holds(tube, motion.time[k], np.stack([motion.q[k], motion.qd[k], motion.qdd[k]]), 1e-12)
    assert len(tube) <= 2048


def test_a_single_set_point_is_a_box(two_link: RobotArm) -> None:
    state = np.array([[0.3, -0.4]])
    tube = Tube.along(two_link, Trajectory(np.zeros(1), state, 2 * state, 3 * state))
    assert len(tube) == 1
    np.testing.assert_allclose(tube.upper[0, 1] - tube.lower[0, 1], 0.04 * np.abs(2 * state[0]))


def test_set_points_with_no_motion_between_are_refused(two_link: RobotArm) -> None:
    q = np.array([[0.0, 0.0], [1.0, 1.0]])
    motion = Trajectory(np.array([0.0, 1e-9]), q, 0 * q, 0 * q)
    with pytest.raises(TrajectoryError, match="no possible motion") as caught:
        Tube.along(two_link, motion)
    assert "set points 1 and 2" in str(caught.value)


def test_a_trajectory_of_another_arm_is_refused(puma: RobotArm) -> None:
    with pytest.raises(UsageError, match="does not fit arm"):
        Tube.along(puma, wave(10))
