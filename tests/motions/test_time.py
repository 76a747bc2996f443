"""The time of a log: unit by name, by size, by steps, by what the user says; precision of epochs."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze import read_log
from gd_analyze.errors import TrajectoryError
from gd_analyze.types import Reading
from gd_analyze.units import TIME_UNITS
from log_arms import arm_of
from strategies import examples

ONE = arm_of("hip")


def table(name: str, stamps: list[object]) -> str:
    return f"{name},q_0\n" + "".join(f"{stamp},{0.1 * k}\n" for k, stamp in enumerate(stamps))


@pytest.mark.parametrize(
    ("name", "stamps", "unit", "step"),
    [
        ("time", [0.5, 0.508], "s", 0.008),
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
def test_units(name, stamps, unit, step, read):
    logged = read(table(name, stamps), ONE)
    assert logged.columns[0].unit == unit
    assert logged.time[0] == 0.0
    # One subtraction of whole numbers and one product: nothing of an epoch's digits is lost.
    assert abs(logged.time[1] - step) <= 4e-16 * max(step, 1.0) + 1e-15 * step


STANDING = "time,/joints/header/stamp,q_0\n" + "".join(f"{0.5 * k},0,{k}\n" for k in range(4))
SET_POINTS = "time,q1\n0,0\n10,1\n20,2\n"
TWO_TIMES = "time,timestamp,q_0\n0,0,1\n0.1,0.2,2\n"


@pytest.mark.parametrize(
    ("content", "asked", "time"),
    [
        ("sec,nanosec,q_0\n1700000000,999999999,1\n1700000001,7,2\n", {}, [0, 8e-9]),
        (table("time", [5, 6, 8]), {"map": ["time=:ms"]}, [0, 0.001, 0.003]),
        (table("time", [5, 6, 8]), {"map": ["time=:1000Hz"]}, [0, 0.001, 0.003]),
        ("q_0\n1\n2\n3\n", {"map": ["time=4Hz"]}, [0, 0.25, 0.5]),
        ("time,q_0\n9,1\n7,2\n", {"map": ["time=4Hz"]}, [0, 0.25]),
        (
            "sample,q_0\n3,1\n4,2\n8,3\n",
            {"map": ["time=sample:4Hz"]},
            [0, 0.25, 1.25],
        ),  # what is missing stays missing
        (STANDING, {}, [0, 0.5, 1.0, 1.5]),  # a stamp that stands is no time
        (table("time", [0, 0.5, 0.5, 0.25]), {}, [0, 0.5, 0.5, 0.25]),  # it may repeat and fall here
        (SET_POINTS, {}, [0, 10, 20]),
        (SET_POINTS, {"measured": True, "map": ["time=:ms"]}, [0, 0.01, 0.02]),
        (TWO_TIMES, {"map": ["time=timestamp"]}, [0, 0.2]),
    ],
)
def test_instants(content, asked, time, read):
    # A second and what is taken off of it: an eps of 1.
    np.testing.assert_allclose(read(content, ONE, **asked).time, time, rtol=1e-15, atol=3e-16)


CASES: dict[str, tuple[str, dict[str, object], str]] = {
    "steps of 1": (table("Time", [0, 1, 2]), {}, "line 1, column 1"),
    "steps that may be anything": (table("time", [0, 500, 1000]), {}, "steps of 500"),
    "steps of 8": (table("time", [12, 20, 28]), {}, "--map time=time:ms"),
    "steps of 8.25": (table("time", [0.0, 8.25, 16.5]), {}, "--map time=time:ms"),
    "steps of 2000": (table("time", [0, 2000, 4000]), {}, "--map time=time:us"),
    "steps of 8 million": (table("time", [0, 8000000, 16000000]), {}, "--map time=time:ns"),
    # Uptimes of minutes to days whose size is that of a date in a unit a thousand times larger.
    "50 minutes of uptime in us": (
        table("stamp", [3e9 + 1000 * k for k in range(9)]),
        {},
        "--map time=stamp:us",
    ),
    "20 days of uptime in ms": (table("time", [1.7e9 + 8 * k for k in range(9)]), {}, "--map time=time:ms"),
    "14 days of uptime in ms, with fractions": (
        table("time", [1.2e9 + 8.1 * k for k in range(9)]),
        {},
        "time=time:ms",
    ),
    "10 days of uptime in us": (
        table("time", [864e9 + 2000 * k for k in range(9)]),
        {},
        "--map time=time:us",
    ),
    "10 days of uptime in ns": (
        table("time", [864e12 + 1e6 * k for k in range(9)]),
        {},
        "--map time=time:ns",
    ),
    "a date of whole seconds": (table("time", [1.7e9 + k for k in range(9)]), {}, "--map time=time:s"),
    "steps of an hour in ns": (table("time", [0, 36e11, 72e11]), {}, "--map time=time:s"),
    "set points read as a log": (SET_POINTS, {"measured": True}, "--map time=time:ms"),
    "a rate for milliseconds": (
        table("time_ms", [0, 10, 20]),
        {"map": ["time=time_ms:100Hz"]},
        "count the rows",
    ),
    "a rate for a pair": ("sec,nanosec,q_0\n1,0,1\n1,8,2\n", {"map": ["time=sec:100Hz"]}, "found: time in s"),
    "a unit that is none": (table("time [ticks]", [0, 0.1]), {}, "no column is recognized as time"),
    "a date of two meanings": (table("time", ["03/04/2025 10:00:00"]), {}, "found: '03/04/2025 10:00:00'"),
    "no time": ("q_0,temp\n1,2\n2,3\n", {}, "--map time=COLUMN"),
    "two times": (TWO_TIMES, {}, "--map time=time or --map time=timestamp"),
    "a rate for instants since 1970": (
        table("time", [1.7e12, 1.7e12 + 8]),
        {"map": ["time=time:125Hz"]},
        "found: time in ms",
    ),
    "an epoch of six digits": (table("time", ["1.7e+09"] * 9), {}, "found: 1700000000"),
    "a unit for dates": (
        table("time", ["2025-03-04T10:00:00Z"]),
        {"map": ["time=:ms"]},
        "omit the unit",
    ),
    "a rate for dates": (
        table("time", ["2025-03-04T10:00:00Z"]),
        {"map": ["time=time:9Hz"]},
        "count the rows",
    ),
    "a unit that no time has": (table("time", [0, 1]), {"map": ["time=:deg"]}, "'deg' is no unit of time"),
    "a rate of no motion": (table("time", [0, 1]), {"map": ["time=0.001Hz"]}, "give 1000Hz"),
    "empty": ("time,q_0\n,1\n,2\n", {}, "empty cells"),
}


@examples(40)
@given(st.integers(1, 4000), st.integers(0, 10**9), st.sampled_from([("ms", 1), ("us", 10), ("ns", 10**5)]))
def test_whole_numbers_are_dates_only_with_steps_of_a_log(step, start, unit):
    """An uptime of up to 23 days, with steps of over 0.1 ms as robots have, is never read as a date."""
    name, scale = unit
    size, step = TIME_UNITS[name], step * scale
    if not 1.01e-4 <= step * size <= 4.0:
        return
    first = round(start / size) // 500
    path = Path(tempfile.mkdtemp()) / "log.csv"
    path.write_text(table("time", [first + k * step for k in range(9)]))
    with pytest.raises(TrajectoryError) as caught:
        read_log(path, ONE)
    assert "`map='time=time:" in caught.value.details["next"]


@pytest.mark.parametrize(
    ("stamps", "times"),
    [
        (["2025-03-04T10:20:30.000000Z", "2025-03-04T10:20:30.016000Z"], [0, 0.016]),
        (["2025-03-04 10:20:30,016", "2025-03-04 10:20:30,017"], [0, 0.001]),
        (["2025-03-04T10:20:30.123456789+01:00", "2025-03-04T10:20:30.123456792+01:00"], [0, 3e-9]),
        (["31.12.2024 23:59:59.5", "01.01.2025 00:00:00.25"], [0, 0.75]),
        (["2025/3/4 9:59:59.9", "2025/3/4 10:00:00.0"], [0, 0.1]),
        (["2025-03-30T01:59:59.9+0100", "2025-03-30T03:00:00.0+0200"], [0, 0.1]),
        (["10:20:30.016", "10:20:30.032"], [0, 0.016]),
        (["10:20:30:016", "10:20:30:032"], [0, 0.016]),
        (["0:00:59", "0:01:00"], [0, 1.0]),  # whole seconds, but not samples
    ],
)
def test_dates_are_instants(stamps, times, read):
    quoted = [f'"{stamp}"' for stamp in stamps]
    for name in ("timestamp", "time"):
        logged = read(table(name, quoted), ONE)
        np.testing.assert_allclose(logged.time, times, rtol=1e-15)
        assert logged.measured
    lines = [f'{{"time": "{stamp}", "q": [{0.1 * k}]}}' for k, stamp in enumerate(stamps)]
    np.testing.assert_allclose(read("\n".join(lines), ONE, "log.jsonl").time, times, rtol=1e-15)
    # A file of set points with dates is a log.
    text = "time,q1\n" + "".join(f"{stamp},{k}\n" for k, stamp in enumerate(quoted))
    np.testing.assert_allclose(read(text, ONE).time, times, rtol=1e-15)


def test_a_cell_that_is_no_date_among_dates(refused):
    stamps = [f"2025-03-04T10:20:{k:02d}.5Z" for k in range(40)]
    for wrong in ("2025-03-04T10:2x:00Z", "2025-13-04T10:20:00Z", "17", "inf"):
        refused("line 22, column 1", table("time", [*stamps[:20], wrong, *stamps[21:]]), ONE)


@pytest.mark.parametrize("case", CASES)
def test_refusals(case, refused):
    content, asked, says = CASES[case]
    refused(says, content, ONE, **asked)


@pytest.mark.parametrize(
    ("head", "name", "option"),
    [
        ("# sampled at 250 Hz\n", "log.csv", "--map time=250Hz"),
        ("# rate: 500\n", "log.csv", "--map time=500Hz"),
        ("# robot: mine\n# fs=100\n", "log.csv", "--map time=100Hz"),
        ("# Sampling frequency [Hz] = 62.5\n", "log.csv", "--map time=62.5Hz"),
        ("# sample_rate_hz: 1000\n# 1 kHz\n", "log.csv", "--map time=1000Hz"),
        ("", "swing_125Hz.csv", "--map time=125Hz"),
        ("", "sine_2Hz_at_125Hz.csv", "--map time=125Hz"),
        ("# sampling rate: 5 Hz\n", "sine_2Hz.csv", "--map time=5Hz"),
        # Of two rates, of other frequencies, and of numbers that are none nothing is taken.
        ("# 250 Hz\n", "swing_125Hz.csv", "--map time=RATEHz"),
        ("# 250 Hz, low-pass at 20 Hz\n", "log.csv", "--map time=RATEHz"),
        ("# baud rate: 9600\n# rate: high\n# rate: 0\n", "log.csv", "--map time=RATEHz"),
    ],
)
@pytest.mark.parametrize(
    "columns", ["actual_q_0,actual_q_1,temp", "q1,q2", "sample,actual_q_0,actual_q_1", "0.1,0.2,0.3,0.4"]
)
def test_the_rate_that_a_log_states_is_proposed_and_never_taken(columns, head, name, option, refused):
    """Without a time, with a count of samples, and without a header; what is printed is typed."""
    rows = "".join(
        ",".join(str(k + c * (c + k)) for c in range(columns.count(",") + 1)) + "\n" for k in range(5)
    )
    says = option.replace("=", "=sample:") if columns.startswith("sample") else option
    refused(says, f"{head}{columns}\n{rows}", arm_of("hip", "knee"), name)


def test_a_number_beside_arrays_may_state_the_rate(tmp_path):
    path = tmp_path / "log.npz"
    np.savez(path, q=np.random.default_rng(0).normal(size=(50, 2)), fs=np.float64(125.0), n=3)
    with pytest.raises(TrajectoryError, match=r'`map=\'time=125Hz\'`, as "fs = 125\.0" says'):
        read_log(path, arm_of("hip", "knee"))
    logged = read_log(path, arm_of("hip", "knee"), Reading.of(map=["time=125Hz"]))
    np.testing.assert_allclose(logged.time, np.arange(50) / 125.0)
