"""`gd-analyze columns`, and options on logs through the real entry point."""

from __future__ import annotations

import json

import numpy as np
import pytest

LOG = "timestamp,actual_q_0,actual_q_1,target_q_0,target_q_1,temp_0\n" + "".join(
    f"{0.01 * k:.2f},{0.2 * np.sin(0.02 * k):.9f},{0.3 * np.cos(0.02 * k):.9f},0,{k},21\n" for k in range(200)
)


@pytest.fixture
def log(here):
    (here / "log.csv").write_text(LOG)
    return "log.csv"


def test_table(run, log):
    result = run("columns", "two_link", log)
    assert (result.code, result.err) == (0, "")
    lines = result.out.splitlines()
    assert max(map(len, lines)) <= 80
    rows = [line.split() for line in lines]
    assert ["actual_q_1", "q", "elbow", "rad", "by", "number,", "from", "0"] in rows
    assert ["temp_0", "unused", "no", "quantity", "of", "the", "joints'", "motion"] in rows


def test_json(run, log):
    told = run("columns", "two_link", log, "--json").json
    assert (told["measured"], told["rows"], told["seconds"]) == (True, 200, 1.99)
    assert told["columns"][1] == {
        "column": "actual_q_0",
        "role": "q",
        "joint": "shoulder",
        "unit": "rad",
        "why": "by number, from 0",
    }


def test_a_trajectory_has_columns_too(run, motion):
    result = run("columns", "two_link", "two-link-swing")
    assert result.code == 0
    assert ["Kind", "plan"] in [line.split() for line in result.out.splitlines()]


def test_options_reach_the_reader(run, here, log):
    assert (
        run("columns", "two_link", log, "--planned", "--family", "target", "--json").json["measured"] is False
    )
    words = ["--map", "q:1=#3", "--map", "q:elbow=actual_q_0", "--time-unit", "ms", "--degrees"]
    told = run("columns", "two_link", log, *words, "--save-mapping", "ours.toml", "--json").json
    used = [[use["column"], use["joint"], use["unit"]] for use in told["columns"][:3]]
    assert used == [
        ["timestamp", "", "ms"],
        ["actual_q_0", "elbow", "deg"],
        ["actual_q_1", "shoulder", "deg"],
    ]
    again = run("columns", "two_link", log, "--mapping", "ours.toml", "--json").json
    assert [use["unit"] for use in again["columns"][:3]] == ["ms", "deg", "deg"]
    result = run("columns", "two_link", log, "--rate", "0")
    assert (result.code, result.out) == (2, "")
    assert "'--rate'" in result.err


def test_every_verb_takes_a_log(run, here, log):
    assert run("two_link", log, "--out", "r", "--format", "json", "--cutoff", "5").code == 0
    document = run("rank", "two_link", log, "--time-unit", "ms", "--planned", "--json").json
    assert document["states"]["trajectory"] == "log"
    result = run("evaluate", "r/model.json", log, "--map", "time=none", "--rate", "100", "--json")
    assert result.code == 0, result.err


def test_ambiguity_is_an_error_of_the_user(run, here, log):
    (here / "log.csv").write_text(LOG.replace("target_q", "q").replace("actual_q", "position"))
    result = run("two_link", log)
    assert (result.code, result.out) == (2, "")
    for text in (
        "several columns may be the positions",
        "log.csv, line 1",
        "--family position or --family q",
    ):
        assert text in result.err


def test_a_log_from_standard_input(process, here):
    told = json.loads(process("columns", "two_link", "-", "--json", stdin=LOG).out)
    assert (told["log"], told["rows"]) == ("stdin", 200)
    result = process("rank", "two_link", "-", "--json", stdin=LOG)
    assert result.code == 0, result.err
    assert json.loads(result.out)["states"]["trajectory"] == "stdin"
