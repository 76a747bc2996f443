"""Mapping files: what they write, that reading by them gives the same, and what they refuse."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from log_arms import arm_of

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.read import read_log
from gd_analyze.motions.reading import Reading

TWO = arm_of("hip", "knee")

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
def test_reading_by_a_mapping_gives_the_same(case, log, tmp_path):
    content, asked = LOGS[case]
    path, file = log(content), tmp_path / "ours.toml"
    first = read_log(path, TWO, Reading.of(**asked, save_mapping=file))
    again = read_log(path, TWO, Reading(mapping=file))
    for what in ("time", "q", "qd", "qdd", "torque"):
        np.testing.assert_array_equal(getattr(first, what), getattr(again, what))
    assert first.measured == again.measured
    first_uses, again_uses = (
        [replace(use, why="") for use in log.columns if use.role != "unused"] for log in (first, again)
    )
    assert first_uses == again_uses


COLUMN = '[[columns]]\ncolumn = "%s"\nrole = "%s"\njoint = "%s"\nunit = "%s"\n'
TIME = '[[columns]]\ncolumn = "time"\nrole = "time"\nunit = "s"\n'
GOOD = f"""format = "gd-analyze log mapping 1"
measured = true
{TIME}{COLUMN % ("a", "q", "hip", "deg")}{COLUMN % ("b", "q", "knee", "rad")}"""
CONTENT = "time,a,b\n0,180,2\n1,90,2\n"

CASES: dict[str, tuple[str, str]] = {
    "no TOML": (GOOD.replace("= true", "= = true"), "line 2, column"),
    "another format": (GOOD.replace("mapping 1", "mapping 9"), "line 1"),
    "unknown key": (GOOD.replace("measured", "measurd"), "a field measured"),
    "unknown joint": (GOOD.replace("hip", "hipp"), "line 10"),
    "unit of time": (GOOD.replace('"s"', '"h"'), "line 6"),
    "unknown column": (GOOD.replace('"a"', '"A"'), "ours.toml, line 8"),
    "a joint twice": (GOOD.replace("knee", "hip"), "one column for q of every joint"),
    "no time": (GOOD.replace(TIME, ""), "0 columns of time"),
    "a rate of 0": (GOOD.replace("measured", "rate = 0.0\nmeasured"), "line 2"),
}


@pytest.mark.parametrize("case", CASES)
def test_refusals(case, log):
    content, says = CASES[case]
    assert content != GOOD
    with pytest.raises(TrajectoryError) as caught:
        read_log(log(CONTENT), TWO, Reading(mapping=log(content, "ours.toml")))
    assert "ours.toml" in str(caught.value)
    assert says in str(caught.value)


def test_the_good_one_and_what_it_is_not_used_for(log, tmp_path):
    path, mapping = log(CONTENT), log(GOOD, "ours.toml")
    np.testing.assert_array_equal(
        read_log(path, TWO, Reading(mapping=mapping)).q, [[np.pi, 2], [np.pi / 2, 2]]
    )
    for asked, says in (
        (Reading(mapping=mapping, degrees=True), "all columns of a log"),
        (Reading(mapping=tmp_path / "none.toml"), "No such file"),
        (Reading(save_mapping=path), "would overwrite an input"),
    ):
        with pytest.raises(TrajectoryError, match=says):
            read_log(path, TWO, asked)
    assert path.read_text() == CONTENT
