"""Pipes, files of other kinds, and values of a wrong type in place of an arm, a motion or a model."""

from __future__ import annotations

import os
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeError, UsageError
from gd_analyze.tables import robustness, states_in_box


@pytest.mark.parametrize(
    "verb",
    [
        "rank-terms two_link {}", "two_link {}", "columns two_link {}", "diagnose two_link {}",
        "identify two_link {}", "arms {}", "plan {} --from 0,0 --to 1,1 --duration 1", "equations {}",
        "rank-terms {} two-link-swing",
        "evaluate {} two-link-swing", "certify {}", "export {} --to c",
        "arms two_link --limits {}", "arms two_link --drive-inertia {}", "report {}", "batch {}",
    ],
)  # fmt: skip
@pytest.mark.parametrize(
    "name", ["pipe", "pipe.csv", "pipe.json", "pipe.parquet", "pipe.toml", "pipe.urdf", "pipe.h5"]
)
def test_a_named_pipe_without_a_writer_is_not_waited_for(run, here, listing, monkeypatch, verb, name):
    monkeypatch.setattr("gd_analyze.files.WRITER_WITHIN_SECONDS", 0.02)
    os.mkfifo(here / name)
    before = listing()
    result = run(verb.format(name))
    assert (result.code, result.out) == (2, "")
    assert name in result.err
    assert "next: " in result.err
    assert listing() == before


def test_a_pipe_of_the_shell_is_read(run, here):
    """Its path is the system's, and a writer has it open."""
    rows = "\n".join(f"{0.1 * k},{0.01 * k * k},{0.02 * k * k}" for k in range(9))
    reading, writing = os.pipe()
    os.write(writing, f"time,q1,q2\n{rows}\n".encode())
    os.close(writing)
    try:
        result = run(f"columns two_link /dev/fd/{reading} --json")
    finally:
        os.close(reading)
    assert result.code == 0


@pytest.mark.parametrize("name", ["dh.yaml", "dh.yml", "dh.m", "dh.txt"])
def test_a_table_that_is_no_toml_is_sent_to_one_that_is(run, here, name):
    (here / name).write_text("links: [{theta: q1, d: 0, a: 0, alpha: 90}]")
    result = run(f"arms {name}")
    assert (result.code, result.out) == (2, "")
    assert "`gd-analyze arms puma560 --to toml`" in result.err
    assert run("arms puma560 --to toml").code == 0


@pytest.mark.parametrize(
    ("words", "where"),
    [
        ({"gravity": 9.81}, "gravity"),
        ({"gravity": "9.81"}, "gravity"),
        ({"gravity": [0.0, None, 9.81]}, "gravity"),
        ({"gravity": object()}, "gravity"),
        ({"gravity": True}, "gravity"),
        ({"drive_inertia": 0.1}, "drive_inertia"),
        ({"drive_inertia": np.array([0.1])}, "drive_inertia"),
        ({"lock": 3}, "lock"),
        ({"lock": np.array([1.0, 2.0])}, "lock"),
        ({"limits": 3}, "limits"),
        ({"limits": np.array([np.nan, 1.0])}, "limits"),
        ({"limits": {"knee": 1.0}}, "limits"),
    ],
)
def test_arguments_of_load_arm_say_what_to_give(words, where):
    with pytest.raises(UsageError) as caught:
        gd.load_arm("two_link", **words)
    assert caught.value.details["where"] == where
    assert caught.value.details["next"]


def test_numbers_come_as_any_collection():
    for gravity in ([0, 0, -1.62], (0, 0, -1.62), np.array([0, 0, -1.62]), "0,0,-1.62", iter([0, 0, -1.62])):
        assert gd.load_arm("two_link", gravity=gravity).gravity_vector.tolist() == [0.0, 0.0, -1.62]
    single = np.array([0.5, 0.25], dtype=np.float32)
    assert gd.load_arm("two_link", drive_inertia=single).drive_inertia.tolist() == [0.5, 0.25]


WRONG = (
    3,
    9.81,
    "nonsense",
    object(),
    [1, "a"],
    {"a": 1},
    np.array([np.nan, 1.0]),
    b"x",
    True,
    float("nan"),
    -1,
    [],
)


@pytest.mark.parametrize("value", WRONG, ids=lambda value: str(type(value).__name__))
@pytest.mark.parametrize(
    "call",
    [
        lambda value: gd.load_arm(value),
        lambda value: gd.load_arm("two_link", lock=value),
        lambda value: gd.load_arm("two_link", limits=value),
        lambda value: gd.load_arm("two_link", gravity=value),
        lambda value: gd.load_arm("two_link", drive_inertia=value),
        lambda value: gd.equations("two_link", value),
        lambda value: gd.equations("two_link", min_share=value),
        lambda value: states_in_box("puma560", value),
        lambda value: states_in_box("puma560", 4, seed=value),
        lambda value: robustness("two_link", "two-link-swing", uncertainty=value),
        lambda value: gd.save_arm(value, "x.toml"),
    ],
)
def test_values_of_a_wrong_type_are_answered_by_the_library(here, call, value):
    """Some of the values are right in some of the places; no other exception comes out."""
    with suppress(GdAnalyzeError):
        call(value)


def test_a_folder_and_a_device_are_no_arms(tmp_path):
    for path, fact in ((tmp_path, "a folder"), (Path("/dev/null"), "a pipe or a device")):
        with pytest.raises(ArmError, match=fact):
            gd.load_arm(path)
