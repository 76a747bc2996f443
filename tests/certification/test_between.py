"""Between two set points: the motions looked at are what they are said to be, and lie in their range."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import BPoly

from gd_analyze import Trajectory
from gd_analyze.certification.between import Between
from strategies import examples

EXACTLY = np.zeros((2, 3))


def drawn(seed: int, count: int = 4) -> Trajectory:
    """Set points that contradict one another: each number is drawn on its own."""
    rng = np.random.default_rng(seed)
    return Trajectory(np.cumsum(rng.uniform(0.05, 1.0, count)), *rng.uniform(-2.0, 2.0, (3, count, 3)))


def motions(motion: Trajectory, interval: int, joint: int, s: np.ndarray) -> np.ndarray:
    """q, qd and qdd of all three motions by SciPy, shape (3, 3, S)."""
    width = motion.time[interval + 1] - motion.time[interval]
    ends = np.array([x[interval : interval + 2, joint] for x in (motion.q, motion.qd, motion.qdd)])
    quintic, cubic = (BPoly.from_derivatives([0.0, width], ends.T[:, :known]) for known in (3, 2))
    smooth = [[path(width * s, order) for order in range(3)] for path in (quintic, cubic)]
    return np.array([*smooth, ends[:, :1] + (ends[:, 1:] - ends[:, :1]) * s])


@examples(40)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.9), st.floats(0.01, 1.0))
def test_motions_through_all_numbers_lie_in_the_range(seed, begin, width):
    motion = drawn(seed)
    end = min(1.0, begin + width)
    between = Between.of(motion, EXACTLY, slice(0, 3))
    lower, upper = between.ranges(np.full(3, begin), np.full(3, end))
    s = np.linspace(begin, end, 30)
    for interval in range(3):
        for joint in range(3):
            values = motions(motion, interval, joint, s)
            # Accelerations are of fourth order in 1 / T = 20 times a few numbers of size 2.
            slack = 1e-9
            assert (values >= lower[interval, :, joint, None] - slack).all()
            assert (values <= upper[interval, :, joint, None] + slack).all()
            values = motions(motion, interval, joint, np.linspace(0.0, 1.0, 9))
            apart = np.ptp(values, axis=0).max(axis=1)
            np.testing.assert_allclose(between.differences[interval, :, joint], apart, atol=1e-9)


@examples(40)
@given(st.integers(0, 2**32 - 1))
def test_limits_along_lines_hold_all_motions(seed):
    motion, s = drawn(seed), np.linspace(0.0, 1.0, 30)
    low, high, differences = Between.along_lines(motion, EXACTLY, slice(0, 3))
    # Some tens of roundings of accelerations over a width of 0.05 s.
    slack = 1e-12 * float(np.abs(high).max())
    for interval, joint in np.ndindex(3, 3):
        taken = motions(motion, interval, joint, s)
        assert (taken.min(axis=(0, 2)) >= low[interval, :, joint] - slack).all()
        assert (taken.max(axis=(0, 2)) <= high[interval, :, joint] + slack).all()
    assert (differences >= Between.of(motion, EXACTLY, slice(0, 3)).differences - slack).all()


def test_limits_along_lines_are_close_where_set_points_are_near():
    time = np.arange(200) * 1e-3
    motion = Trajectory(time, *(np.sin(2.0 * time + k * np.pi / 2)[:, None] * 2.0**k for k in range(3)))
    lower, upper = Between.of(motion, np.zeros((2, 1)), slice(0, 199)).ranges(np.zeros(199), np.ones(199))
    low, high, _ = Between.along_lines(motion, np.zeros((2, 1)), slice(0, 199))
    # A thousandth of an interval of 1 ms is of the order of its time.
    assert np.abs(low - lower).max() <= 1e-3 * np.ptp(upper)
    assert np.abs(high - upper).max() <= 1e-3 * np.ptp(upper)


def test_a_range_is_close_to_what_the_motions_take():
    """In a tenth of an interval Bernstein coefficients leave hardly anything free."""
    motion = drawn(3, 2)
    begins = np.arange(10) / 10
    between = Between.of(motion, EXACTLY, np.zeros(10, dtype=int))
    lower, upper = between.ranges(begins, begins + 0.1)
    for piece, begin in enumerate(begins):
        for joint in range(3):
            values = motions(motion, 0, joint, np.linspace(begin, begin + 0.1, 50))
            span = np.ptp(values, axis=(0, 2))
            assert (upper[piece, :, joint] - lower[piece, :, joint] <= 1.05 * span + 1e-9).all()


@pytest.mark.parametrize("width", [1e-3, 0.1])
def test_what_counts_as_rounding_makes_no_acceleration(width):
    """The last digit of a position over a millisecond is an acceleration of many rad/s^2."""
    rest = np.zeros((2, 1))
    motion = Trajectory(np.array([0.0, width]), np.array([[0.0], [1e-6]]), rest, rest)
    for rounding, moves in ((2e-6, False), (0.5e-6, True)):
        lower, upper = Between.of(motion, np.full((2, 1), rounding), slice(0, 1)).ranges(
            np.zeros(1), np.ones(1)
        )
        assert (upper[0, 2, 0] > 1e-6 / width**2) == moves
        assert (lower[0, 2, 0] < -1e-6 / width**2) == moves
        assert (lower[0, 0, 0], upper[0, 0, 0]) == pytest.approx((0.0, 1e-6), abs=1e-12)
