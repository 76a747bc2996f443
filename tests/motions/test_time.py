"""The time of a log: unit by name, by size, by steps, by what the user says; precision of epochs."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from log_arms import arm_of

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.logged import Logged

Read = Callable[..., Logged]
ONE = arm_of("hip")


def table(name: str, stamps: list[object], extra: str = "") -> str:
    return f"{name},q_0{extra}\n" + "".join(f"{stamp},{0.1 * k}\n" for k, stamp in enumerate(stamps))


@pytest.mark.parametrize(
    ("name", "stamps", "unit", "step"),
    [
        ("time", [0.5, 0.508], "s", 0.008),
        ("time", [12, 20, 28], "ms", 0.008),
        ("time", [0.0, 8.25, 16.5], "ms", 0.00825),
        ("time", [0, 2000, 4000], "us", 0.002),
        ("time", [0, 8000000, 16000000], "ns", 0.008),
        ("time_us", [1, 2], "us", 1e-6),
        ("t [ms]", [1, 2], "ms", 1e-3),
        ("time_sec", [1, 2], "s", 1.0),
        ("stamp", ["1700000000.000000001", "1700000000.000000009"], "s", 8e-9),
        ("stamp", [1700000000123, 1700000000125], "ms", 2e-3),
        ("stamp", [1700000000123456, 1700000000123457], "us", 1e-6),
        ("stamp", [1700000000123456789, 1700000000123456792], "ns", 3e-9),
        ("stamp_ns", ["1.7e18", "1700000000000000003"], "ns", 3e-9),
    ],
)
def test_units(name: str, stamps: list[object], unit: str, step: float, read: Read) -> None:
    logged = read(table(name, stamps), ONE)
    assert logged.columns[0].unit == unit
    assert logged.time[0] == 0.0
    # One subtraction of whole numbers and one product: nothing of an epoch's digits is lost.
    assert abs(logged.time[1] - step) <= 4e-16 * max(step, 1.0) + 1e-15 * step


def test_seconds_and_nanoseconds(read: Read) -> None:
    logged = read("sec,nanosec,q_0\n1700000000,999999999,1\n1700000001,7,2\n", ONE)
    assert abs(logged.time[1] - 8e-9) < 3e-16  # a second and what is taken off: an eps of 1


@pytest.mark.parametrize("asked", [{"time_unit": "ms"}, {"rate": 1000.0}])
def test_what_the_user_says(asked: dict[str, object], read: Read) -> None:
    logged = read(table("time", [5, 6, 8]), ONE, **asked)
    np.testing.assert_allclose(logged.time, [0, 0.001, 0.003], rtol=1e-15)


def test_rows_without_time_have_a_rate(read: Read) -> None:
    np.testing.assert_array_equal(read("q_0\n1\n2\n3\n", ONE, rate=4.0).time, [0, 0.25, 0.5])
    np.testing.assert_array_equal(
        read("time,q_0\n9,1\n7,2\n", ONE, rate=4.0, map=["time=none"]).time, [0, 0.25]
    )


def test_samples_that_are_missing_stay_missing(read: Read) -> None:
    np.testing.assert_array_equal(read("sample,q_0\n3,1\n4,2\n8,3\n", ONE, rate=4.0).time, [0, 0.25, 1.25])


def test_a_stamp_that_stands_is_no_time(read: Read) -> None:
    text = "time,/joints/header/stamp,q_0\n" + "".join(f"{0.1 * k},0,{k}\n" for k in range(4))
    assert read(text, ONE).time[1] == 0.1


def test_time_may_repeat_and_fall(read: Read) -> None:
    """What is done about it is not for the reader to decide."""
    np.testing.assert_array_equal(read(table("time", [0, 0.5, 0.5, 0.25]), ONE).time, [0, 0.5, 0.5, 0.25])


def test_set_points_are_in_seconds_here_too(read: Read) -> None:
    """As they are where the file is analysed; of what is asked for its steps would tell milliseconds."""
    text = "time,q1\n0,0\n10,1\n20,2\n"
    assert read(text, ONE).time[1] == 10.0
    assert read(text, ONE, measured=True).time[1] == 0.01


MOVING = "".join(f"{k},{np.sin(0.01 * k)},{10 * np.cos(0.01 * k)}\n" for k in range(40))

CASES: dict[str, tuple[str, dict[str, object], list[str]]] = {
    "steps of 1": (table("Time", [0, 1, 2]), {}, ["line 1, column 1", "--rate HZ"]),
    "steps of 1, with velocities that tell": (
        "Time,q_0,qd_0\n" + MOVING,
        {},
        ["the log's own velocities say --time-unit ms"],
    ),
    "steps that may be anything": (table("time", [0, 500, 1000]), {}, ["steps of 500"]),
    "milliseconds or seconds": (table("time", [0, 0.998, 1.996]), {}, ["steps of 0.998"]),
    "a rate for milliseconds": (table("time_ms", [0, 10, 20]), {"rate": 100.0}, ["leave --rate out"]),
    "a rate for seconds and nanoseconds": (
        "sec,nanosec,q_0\n1,0,1\n1,8,2\n",
        {"rate": 100.0},
        ["found: time in s"],
    ),
    "a unit that is none": (table("time [ticks]", [0, 0.1]), {}, ["no column is known to be the time"]),
    "a date": (
        table("time", ["2024-01-01T00:00:00", "2024-01-01T00:00:01"]),
        {},
        ["line 1, column 1", "found: '2024-01-01T00:00:00'"],
    ),
    "no time": ("q_0,temp\n1,2\n2,3\n", {}, ["--map time=COLUMN"]),
    "two times": (
        "time,timestamp,q_0\n0,0,1\n0.1,0.2,2\n",
        {},
        ["--map 'time=time' or --map 'time=timestamp'"],
    ),
    "a rate for seconds": (
        table("time", [0, 0.008, 0.016]),
        {"rate": 125.0},
        ["--time-unit", "--map time=none"],
    ),
    "a rate for instants since 1970": (
        table("time", [1_700_000_000_000, 1_700_000_000_008, 1_700_000_000_016]),
        {"rate": 125.0},
        ["found: time in ms", "leave --rate out"],
    ),
    "both": (table("time", [0, 1]), {"time_unit": "s", "rate": 5.0}, ["5 Hz and s"]),
    "empty": ("time,q_0\n,1\n,2\n", {}, ["empty cells"]),
}


@pytest.mark.parametrize("case", CASES)
def test_message(case: str, read: Read) -> None:
    content, asked, says = CASES[case]
    with pytest.raises(TrajectoryError) as caught:
        read(content, ONE, **asked)
    for text in says:
        assert text in str(caught.value)


def test_two_times_settled(read: Read) -> None:
    logged = read("time,timestamp,q_0\n0,0,1\n0.1,0.2,2\n", ONE, map=["time=timestamp"])
    assert logged.time[1] == 0.2
    assert logged.columns[0].why == "another time"
