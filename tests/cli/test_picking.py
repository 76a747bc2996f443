"""--tip, --base, --lock and --limits: wherever a robot is named, and told in what comes of it."""

from __future__ import annotations

import json

import pytest

from robot_files import fingers, two_joints

SWING = "time,q1,q2\n" + "\n".join(f"{0.1 * i},{0.01 * i**2},{-0.02 * i**2}" for i in range(8))
LOCKS = ("--lock", "left_finger=0", "--lock", "right_finger=10mm")


@pytest.fixture(autouse=True)
def robot(here):
    (here / "robot.urdf").write_text(two_joints(*fingers()))
    (here / "swing.csv").write_text(SWING)


def test_what_branches_off_is_named_with_the_flags(run):
    result = run("robot.urdf", "swing.csv")
    assert (result.code, result.out) == (2, "")
    assert "error: the robot branches at link lower" in result.err
    assert "--lock left_finger=0 --lock right_finger=0 holds what branches off" in result.err


@pytest.mark.parametrize("picked", [LOCKS, ("--tip", "lower")])
@pytest.mark.parametrize(
    "verb",
    [
        ("arms", "robot.urdf"),
        ("rank", "robot.urdf", "swing.csv"),
        ("simplify", "robot.urdf", "swing.csv"),
        pytest.param(("trade-off", "robot.urdf", "swing.csv"), marks=pytest.mark.slow),
        ("equations", "robot.urdf"),
        ("plan", "robot.urdf", "--from", "0,0", "--to", "10,20", "--duration", "3"),
    ],
)
def test_every_verb_takes_them(run, verb, picked):
    result = run(*verb, *picked, "--json")
    assert result.code == 0, result.err
    assert result.json


def test_the_main_job_tells_what_is_held(run, here):
    result = run("robot.urdf", "swing.csv", *LOCKS, "-o", "out", "--format", "json,html", "--json")
    assert result.code == 0, result.err
    page = (here / "out" / "report.html").read_text(encoding="utf-8")
    told = "Held, with what they carry: left_finger at 0 m, right_finger at 0.01 m."
    assert told in page
    assert "robot.urdf: URDF, read by Pinocchio" in page
    assert "--lock left_finger=0" in page  # the command


def test_a_box_of_assumed_limits_is_told_everywhere(run, here):
    result = run("simplify", "robot.urdf", *LOCKS, "--states", "50", "-o", "m.json")
    assert result.code == 0
    assumed = "an acceleration of 5 rad/s^2 of every joint"
    assert f"for a box of states, {assumed} is assumed" in " ".join(result.err.split())
    assert f"(assumed, as none are stated: {assumed})" in " ".join(result.out.split())
    assert assumed in json.loads((here / "m.json").read_text())["fitted_on"]["box"]
    certified = run("certify", "m.json", "--effort", "10")
    assert assumed in " ".join(certified.out.split())
    stated = run("simplify", "robot.urdf", *LOCKS, "--states", "50", "--limits", "7,8")
    assert (stated.code, stated.err) == (0, "")
    assert "assumed" not in stated.out


def test_limits_of_a_built_in_arm(run):
    told = run("arms", "two_link", "--limits", "all=90deg", "--json").json
    assert [joint["acceleration_limit"] for joint in told["joints"]] == pytest.approx([1.5707963] * 2)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--tip", "lowre"), "did you mean lower"),
        (("--lock", "left_finger"), "expected: joint=value in rad or m, or with a unit"),
        (("--tip", "lower", "--limits", "none.yaml"), "cannot read the file of limits"),
    ],
)
def test_bad_choices(run, words, said):
    result = run("arms", "robot.urdf", *words)
    assert result.code == 2
    assert said in result.err
