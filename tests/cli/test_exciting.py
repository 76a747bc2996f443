"""`gd-analyze plan --exciting`."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import gd_analyze as gd

SHORT = "plan two_link --exciting --duration 5"


def test_an_exciting_motion_is_written_with_its_command(run, here):
    told = run(f"{SHORT} --seed 2 -o exciting.csv --json").json
    lines = (here / "exciting.csv").read_text().splitlines()
    assert lines[:2] == [
        f"# gd-analyze {SHORT} --seed 2 -o exciting.csv --json",
        "time,q1,q2,qd1,qd2,qdd1,qdd2",
    ]
    arm = gd.load_arm("two_link")
    made = gd.exciting_motion(arm, 5.0, seed=2).trajectory
    read = gd.read_trajectory(here / "exciting.csv", arm)
    # 100 per second, both ends included; CSV holds every digit.
    assert told["set_points"] == read.n_set_points == 501
    assert (read.q == made.q).all()
    assert (read.qdd == made.qdd).all()
    assert told["trajectory"] == "exciting"
    assert told["knot_times"] == [0.0, 5.0]


@pytest.mark.slow
def test_an_exciting_motion_on_standard_output(run):
    lines = run(f"{SHORT} --points 21").out.splitlines()
    assert lines[0] == f"# gd-analyze {SHORT} --points 21"
    rows = np.array([line.split(",") for line in lines[2:]], dtype=float)
    assert rows.shape == (21, 7)
    assert not rows[[0, -1], 3:].any()


@pytest.mark.slow
def test_a_box(run):
    lines = run(f"{SHORT} --within 0.5,0.2,-1,0.8,0.5,1").out.splitlines()
    q = np.array([line.split(",")[1:3] for line in lines[2:]], dtype=float)
    x = np.cos(q[:, 0]) + np.cos(q.sum(axis=1))
    assert 0.5 <= x.min() < x.max() <= 0.8


@pytest.mark.parametrize(
    ("line", "named"),
    [
        (f"{SHORT} --from 0,0", ["--from", "--exciting"]),
        (f"{SHORT} --from 0,0 --to 1,1", ["--from, --to"]),
        (f"{SHORT} --to 1,1", ["--to"]),
        (f"{SHORT} --via 1,1", ["--via"]),
        (f"{SHORT} --profile 4-3-4", ["--profile"]),
        (f"{SHORT} --allow-violations", ["--allow-violations"]),
        ("plan two_link --duration 5", ["--from", "--to", "--exciting"]),
        ("plan two_link --duration 5 --from 0,0", ["--to"]),
        ("plan two_link --duration 5 --from 0,0 --to 1,1 --seed 1", ["--seed", "--exciting"]),
        ("plan two_link --duration 5 --from 0,0 --to 1,1 --within 0,0,0,1,1,1", ["--within", "--exciting"]),
        (f"{SHORT} --within 1,2,3", ["--within", "'1,2,3'"]),
        (f"{SHORT} --within 0,0,0,1,1,x", ["--within", "x"]),
        (f"{SHORT} --within 0,0,0,nan,1,1", ["--within"]),
        (f"{SHORT} --within 1,1,1,0,0,0", ["--within", "corner"]),
        (f"{SHORT} --within 5,5,5,6,6,6", ["--within", "outside"]),
        (f"{SHORT} --seed -1", ["--seed"]),
        (f"{SHORT} --points 2", ["--points", "at least 11"]),
        ("plan two_link --exciting --duration 1e-6", ["--duration", "too short"]),
        ("plan two_link --exciting", ["--duration"]),
    ],
)
def test_refusals(run, listing, line, named):
    refused = run(f"{line} -o made.csv")
    assert (refused.code, refused.out) == (2, "")
    for word in named:
        assert word in refused.err
    assert "Traceback" not in refused.err
    assert listing() == set()


def test_a_plan_replaces_a_plan_and_no_log(run):
    """A log may have the name of a plan that is advised beside it."""
    assert run(f"{SHORT} -o exciting.csv").code == 0
    assert run(f"{SHORT} -o exciting.csv").code == 0
    Path("log.csv").write_text("time,q1,q2\n0,0,0\n1,1,1\n")
    refused = run(f"{SHORT} -o log.csv")
    assert refused.code == 2
    assert "the plan would replace a file that is not a plan" in refused.err
    assert Path("log.csv").read_text().startswith("time")
