"""Instants of a log: order, repetition, gaps, clocks that start again, rows without readings."""

from __future__ import annotations

import numpy as np
import pytest

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.stamps import Stamps


def stamps(time, readable=None, gap=None, fewest=16):
    time = np.asarray(time, dtype=float)
    readable = np.ones(len(time), dtype=bool) if readable is None else readable
    return Stamps.of(time, readable, gap, "log.csv", fewest)


def test_even_stamps_are_left_alone():
    time = np.arange(100) / 100
    found = stamps(time)
    assert (found.time == time).all()
    assert found.gaps == ()
    assert found.told == ()
    assert found.step == pytest.approx(0.01)


def test_of_repeated_stamps_the_last_reading_is_kept():
    time = np.arange(50) / 100
    time[20] = time[21]
    found = stamps(time)
    assert 20 not in found.rows
    assert 21 in found.rows
    assert "1 row left out whose stamp the next one repeats" in found.told


def test_stamps_hardly_apart_are_the_same():
    time = np.arange(50) / 100
    time[20] = time[21] - 1e-6
    assert len(stamps(time).time) == 49


def test_swapped_rows_are_put_in_order():
    time = np.arange(50) / 100
    time[[20, 21]] = time[[21, 20]]
    found = stamps(time)
    assert (np.diff(found.time) > 0).all()
    assert found.rows[20:22].tolist() == [21, 20]
    assert "stamps put in order: 1 stood after a later one" in found.told


def test_long_steps_are_gaps():
    time = np.concatenate([np.arange(50), np.arange(50) + 80]) / 100
    found = stamps(time)
    assert found.gaps == (50,)
    assert found.stretches == [slice(0, 50), slice(50, 100)]
    assert "1 gap longer than 0.0500 s: nothing is differentiated, smoothed or bounded across" in found.told


@pytest.mark.parametrize(("rate", "missing", "gaps"), [(1000, 20, 0), (1000, 60, 1), (30, 3, 0), (30, 6, 1)])
def test_a_logger_that_stumbles_leaves_no_gap(rate, missing, gaps):
    time = np.concatenate([np.arange(100), np.arange(100) + 100 + missing]) / rate
    assert len(stamps(time).gaps) == gaps


def test_the_user_says_what_a_gap_is():
    time = np.concatenate([np.arange(50), np.arange(50) + 80]) / 100
    assert stamps(time, gap=1.0).gaps == ()


def test_short_stretches_are_left_out_and_said():
    time = np.concatenate([np.arange(50), np.arange(5) + 80, np.arange(50) + 120]) / 100
    found = stamps(time)
    assert found.gaps == (50,)
    assert len(found.time) == 100
    assert "1 stretch of fewer than 16 readings between gaps left out (5 rows)" in found.told


def test_rows_with_empty_cells_are_left_out_and_may_leave_a_gap():
    readable = np.ones(200, dtype=bool)
    readable[100:120] = False
    found = stamps(np.arange(200) / 100, readable)
    assert found.gaps == (100,)
    assert "20 rows with empty cells left out" in found.told


def test_a_clock_that_starts_again_begins_a_motion_of_its_own():
    time = np.concatenate([np.arange(100), np.arange(100)]) / 100
    found = stamps(time)
    assert found.gaps == (100,)
    assert found.rows.tolist() == list(range(200))
    assert (np.diff(found.time) > 0).all()
    assert any("time starts again 1 time, first at row 101" in told for told in found.told)


def test_parts_in_the_wrong_order_are_sorted():
    time = np.concatenate([np.arange(100) + 500, np.arange(100)]) / 100
    found = stamps(time)
    assert found.rows[0] == 100
    assert found.gaps == (100,)


def test_dates_count_from_the_first_reading():
    found = stamps(1.7e9 + np.arange(100) / 100)
    assert found.time[0] == 0.0
    assert "time counts from the first reading" in found.told


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
        stamps(time)
    assert error.value.details["where"] == "log.csv"
    assert "at least 16 readings" in error.value.details["expected"]
    assert error.value.details["found"] == found
    assert ("--largest-gap" in error.value.details.get("next", "")) == ("gaps" in found)
