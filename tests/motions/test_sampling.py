"""Rows of a log: order, repetition, gaps, clocks that start again, and jumps of full turns."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.sampling import sampling_of, unwrapped

EVEN = np.arange(100) / 100


def sampling(time, readable=None, gap=None, fewest=16):
    time = np.asarray(time, dtype=float)
    readable = np.ones(len(time), dtype=bool) if readable is None else readable
    return sampling_of(time, readable, gap, "log.csv", fewest)


def test_even_stamps_are_unchanged():
    found = sampling(EVEN)
    assert (found.time == EVEN).all()
    assert (found.gaps, found.notes) == ((), ())
    assert found.step == pytest.approx(0.01)


@pytest.mark.parametrize("apart", [0.0, 1e-6])
def test_of_repeated_stamps_the_last_reading_is_kept(apart):
    time = EVEN.copy()
    time[20] = time[21] - apart
    found = sampling(time)
    assert 20 not in found.rows
    assert 21 in found.rows
    assert len(found.notes) == 1


def test_rows_are_put_in_the_order_of_time():
    time = EVEN.copy()
    time[[30, 31]] = time[[31, 30]]
    found = sampling(time)
    assert (found.time == EVEN).all()
    assert found.rows[30] == 31
    both = sampling(np.concatenate([EVEN + 5, EVEN]))
    assert (both.rows[0], both.gaps) == (100, (100,))


@pytest.mark.parametrize(("rate", "missing", "gaps"), [(1000, 20, 0), (1000, 60, 1), (30, 3, 0), (30, 6, 1)])
def test_a_logger_that_stumbles_leaves_no_gap(rate, missing, gaps):
    time = np.concatenate([np.arange(100), np.arange(100) + 100 + missing]) / rate
    assert len(sampling(time).gaps) == gaps
    assert sampling(time, gap=1.0).gaps == ()


def test_short_stretches_and_empty_rows_are_left_out():
    found = sampling(np.concatenate([np.arange(50), np.arange(5) + 80, np.arange(50) + 120]) / 100)
    assert (found.gaps, len(found.time), len(found.notes)) == ((50,), 100, 2)
    readable = np.ones(200, dtype=bool)
    readable[100:120] = False
    assert sampling(np.arange(200) / 100, readable).gaps == (100,)


def test_a_clock_that_starts_again_begins_a_motion_of_its_own():
    found = sampling(np.concatenate([EVEN, EVEN]))
    assert found.gaps == (100,)
    assert found.rows.tolist() == list(range(200))
    assert (np.diff(found.time) > 0).all()
    assert "row 101" in found.notes[0]


def test_dates_count_from_the_first_reading():
    assert sampling(1.7e9 + EVEN).time[0] == 0.0


@pytest.mark.parametrize(
    ("time", "found"),
    [
        (np.arange(10) / 100, "10"),
        (np.cumsum(np.tile([0.01, 0.01, 5.0], 20)), "3 at most, in 21 stretches between gaps"),
        (np.zeros(30), "30 at one instant"),
    ],
)
def test_too_few_readings_are_refused(time, found):
    with pytest.raises(TrajectoryError, match="too few readings in a row") as error:
        sampling(time)
    assert error.value.details["where"] == "log.csv"
    assert error.value.details["found"] == found
    assert ("--largest-gap" in error.value.details.get("next", "")) == ("gaps" in found)


@pytest.fixture(scope="module")
def free(puma):
    """An arm whose joints turn without limits."""
    return replace(puma, joints=tuple(replace(joint, lower=None, upper=None) for joint in puma.joints))


TURNING = np.linspace(0.0, 2.9 * np.pi, 200)[:, None] * np.ones(6)
WHOLE, HALVES = [slice(0, 200)], [slice(0, 100), slice(100, 200)]


def stepped(size: float) -> np.ndarray:
    q = np.zeros((200, 6))
    q[100:] = size
    return q


def test_wrapped_angles_go_on(free):
    out, notes = unwrapped((TURNING + np.pi) % (2 * np.pi) - np.pi, free, WHOLE)
    np.testing.assert_allclose(out, TURNING, atol=1e-12)
    assert len(notes) == 1
    assert "6" in notes[0]


@pytest.mark.parametrize(
    ("q", "stretches"), [(TURNING, WHOLE), (stepped(3.5), WHOLE), (stepped(2 * np.pi), HALVES)]
)
def test_what_is_no_wrapping_stays(q, stretches, free):
    out, notes = unwrapped(q, free, stretches)
    assert (out == q).all()
    assert notes == ()


def test_prismatic_joints_are_unchanged(free):
    joints = (free.joints[0], replace(free.joints[1], kind="prismatic"), *free.joints[2:])
    out, _ = unwrapped(stepped(2 * np.pi), replace(free, joints=joints), WHOLE)
    assert (out[100:, 1] == 2 * np.pi).all()
    assert not out[:, 0].any()


def test_a_stretch_outside_the_limits_is_put_within_where_full_turns_do(puma):
    q = np.zeros((200, 6))
    q[100:, 0] = 2 * np.pi + 0.1
    out, _ = unwrapped(q, puma, HALVES)
    np.testing.assert_allclose(out[100:, 0], 0.1, atol=1e-12)
