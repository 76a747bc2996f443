"""Mapping files: what they write, that reading by them gives the same, and what they refuse."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from log_arms import arm_of

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.logged import Logged
from gd_analyze.motions.read import read_log
from gd_analyze.motions.reading import Reading

TWO = arm_of("hip", "knee")
Read = Callable[..., Logged]

LOGS: dict[str, tuple[str, dict[str, Any]]] = {
    "names and units": (
        "time_ms,knee_deg,hip,tau2,tau1\n0,90,1,2,3\n8,45,2,3,4\n",
        {"map": ["q:hip=hip", "q:2=knee_deg"]},
    ),
    "samples": ("Time,Position1,Position2\n5,1,2\n6,2,3\n", {"rate": 1000.0}),
    "rows": ("Position1,Position2\n1,2\n2,3\n", {"rate": 125.0}),
    "no header": ("0,9,1,2\n0.1,9,3,4\n", {"columns": "time,-,q0,q1", "measured": False}),
    "twice": ("time,q_0,q_1,q_1\n0,1,2,3\n0.1,1,2,4\n", {"map": ["q:knee=#4"]}),
    "echo": ("15,8,,knee,hip,1,2\n15,9,,knee,hip,3,4\n", {}),
    "target": (
        "t,actual_q_0,actual_q_1,target_q_0,target_q_1\n0,1,2,3,4\n0.1,1,2,3,5\n",
        {"family": "target"},
    ),
    "strange names": ('time,"q ""1"" \\ [deg]",q_2 é\n0,1,2\n0.1,2,3\n', {"map": ["q:1=#2", "q:2=#3"]}),
}


@pytest.mark.parametrize("case", LOGS)
def test_reading_by_a_mapping_gives_the_same(case: str, log, tmp_path: Path) -> None:
    content, asked = LOGS[case]
    path, file = log(content), tmp_path / "ours.toml"
    first = read_log(path, TWO, Reading.of(**asked, save_mapping=file))
    again = read_log(path, TWO, Reading(mapping=file))
    for what in ("time", "q", "qd", "qdd", "torque"):
        np.testing.assert_array_equal(getattr(first, what), getattr(again, what))
    assert first.measured == again.measured
    used = [(use.column, use.role, use.joint, use.unit) for use in first.columns if use.role != "unused"]
    assert used == [
        (use.column, use.role, use.joint, use.unit) for use in again.columns if use.role != "unused"
    ]


def test_what_is_written(log, tmp_path: Path) -> None:
    file = tmp_path / "ours.toml"
    read_log(log("Time,Position1,Position2\n5,1,2\n6,2,3\n"), TWO, Reading.of(rate=1000.0, save_mapping=file))
    assert tomllib.loads(file.read_text()) == {
        "format": "gd-analyze log mapping 1",
        "measured": True,
        "rate": 1000.0,
        "columns": [
            {"column": "Time", "role": "time", "unit": "sample"},
            {"column": "Position1", "role": "q", "joint": "hip", "unit": "rad"},
            {"column": "Position2", "role": "q", "joint": "knee", "unit": "rad"},
        ],
    }


GOOD = """\
format = "gd-analyze log mapping 1"
measured = true

[[columns]]
column = "time"
role = "time"
unit = "s"

[[columns]]
column = "a"
role = "q"
joint = "hip"
unit = "deg"

[[columns]]
column = "b"
role = "q"
joint = "knee"
unit = "rad"
"""
CONTENT = "time,a,b\n0,180,2\n1,90,2\n"

CASES: dict[str, tuple[str, list[str]]] = {
    "no TOML": (GOOD.replace("= true", "= = true"), ["line 2, column"]),
    "another format": (GOOD.replace("mapping 1", "mapping 9"), ["line 1"]),
    "unknown key": (GOOD.replace("measured", "measurd"), ["a key measured"]),
    "unknown joint": (GOOD.replace("hip", "hipp"), ["line 12", "found: hipp"]),
    "unit of time": (GOOD.replace('"s"', '"h"'), ["line 7", "found: h"]),
    "unknown column": (GOOD.replace('"a"', '"A"'), ["ours.toml, line 10", "found: time, a, b"]),
    "a joint twice": (GOOD.replace("knee", "hip"), ["one column for q of every joint"]),
    "no time": (
        GOOD.replace('role = "time"\nunit = "s"', 'role = "q"\njoint = "hip"\nunit = "rad"'),
        ["2 columns for q of hip"],
    ),
    "a rate of 0": (GOOD.replace("measured", "rate = 0.0\nmeasured"), ["line 2"]),
}


def test_the_good_one(log) -> None:
    logged = read_log(log(CONTENT), TWO, Reading(mapping=log(GOOD, "ours.toml")))
    np.testing.assert_array_equal(logged.q, [[np.pi, 2], [np.pi / 2, 2]])


@pytest.mark.parametrize("case", CASES)
def test_message(case: str, log) -> None:
    content, says = CASES[case]
    assert content != GOOD
    file = log(content, "ours.toml")
    with pytest.raises(TrajectoryError) as caught:
        read_log(log(CONTENT), TWO, Reading(mapping=file))
    assert "ours.toml" in str(caught.value)
    for text in says:
        assert text in str(caught.value)


def test_no_other_word_beside_a_mapping(log) -> None:
    with pytest.raises(TrajectoryError, match="says all of a log's columns"):
        read_log(log(CONTENT), TWO, Reading.of(mapping=log(GOOD, "ours.toml"), degrees=True))


def test_a_missing_mapping(log, tmp_path: Path) -> None:
    with pytest.raises(TrajectoryError, match="No such file"):
        read_log(log(CONTENT), TWO, Reading(mapping=tmp_path / "none.toml"))


def test_what_is_read_is_not_written_over(log) -> None:
    path = log("time,q_0,q_1\n0,1,2\n1,2,3\n")
    with pytest.raises(TrajectoryError, match="written over what is read"):
        read_log(path, TWO, Reading(save_mapping=path))
    assert path.read_text().startswith("time,")
