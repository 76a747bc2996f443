"""Several trajectories, or a folder of them, on the command line."""

from __future__ import annotations

import json

import pytest

from gd_analyze.motions.csv_writing import write_trajectory
from several_motions import swung


@pytest.fixture
def folder(here):
    place = here / "moves"
    place.mkdir()
    for name, duration in (("slow", 20.0), ("quick", 4.0)):
        write_trajectory(swung(duration, name), place / f"{name}.csv")
    return place


def within_80(result) -> str:
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    return " ".join(result.out.split())


def test_the_main_job_along_all_of_them(run, here, folder):
    result = run(
        "two_link", folder / "slow.csv", folder / "quick.csv", "two-link-swing", "--format", "h5,json,csv"
    )
    shown = within_80(result)
    assert "along 3 motions (slow, quick, two-link-swing), 113 set points" in shown
    assert "Largest error along each motion, of what the budget allows there, and its joint" in shown
    assert "The budget is measured along each of the 3 motions by itself" in shown
    assert "elements change between the motions" in shown
    place = here / "reports" / "two_link-slow+quick+two-link-swing"
    model = json.loads((place / "model.json").read_text())
    assert [motion["name"] for motion in model["motions"]] == ["slow", "quick", "two-link-swing"]
    again = run("report", place / "analysis.h5", "--out", "again", "--format", "json,csv")
    assert again.out.splitlines()[:-2] == result.out.splitlines()[:-3]


def test_as_json(run, folder):
    told = run("two_link", "moves", "--format", "csv", "--json").json
    assert told["trajectory"] == "moves"
    each, verdicts = told["motions"]["each"], told["motions"]["verdicts"]
    assert [row["motion"] for row in each] == ["quick", "slow"]
    assert [row["set_points"] for row in each] == [41, 41]
    for row in each:
        assert row["used"][row["joint"] - 1] == row["worst"] <= 1.0
        assert len(row["allowed_error"]) == 2
    assert [row["element"] for row in verdicts] == [row["element"] for row in told["dominance"]]
    assert all(len(row["verdicts"]) == 2 for row in verdicts)
    assert run("two_link", "two-link-swing", "--format", "csv", "--json").json["motions"] is None


@pytest.mark.parametrize("verb", ["simplify", "rank", "trade-off"])
def test_other_verbs(run, folder, verb):
    quick = ["--quick"] if verb == "trade-off" else []
    assert "82 set points of 2 motions (quick, slow)" in within_80(run(verb, "two_link", "moves", *quick))


def test_a_model_knows_its_motions(run, here, folder):
    assert run("simplify", "two_link", "moves", "--budget", "20%", "-o", "model.json").code == 0
    shown = within_80(run("evaluate", "model.json", "moves/quick.csv"))
    assert "by a model made for quick, one of 2 motions (quick, slow), with a budget of 20%" in shown
    assert "is meant, not that here" not in shown
    told = run("evaluate", "model.json", "moves/slow.csv", "--json").json
    assert told["fitted_on"]["motions"] == "quick, slow"
    assert all(row["within_allowed"] for row in told["joints"])
    elsewhere = within_80(run("evaluate", "model.json", "two-link-swing"))
    assert "by a model made for moves with a budget of 20%" in elsewhere
    assert "the peak torque over 82 set points of 2 motions (quick, slow) is meant" in elsewhere
    certified = run("certify", "model.json", "--along", "moves/slow.csv", "--json")
    assert certified.code == 0


def test_another_set_of_motions_does_not_replace_the_first(run, folder):
    assert run("two_link", "moves", "--out", "x", "--format", "csv").code == 0
    assert run("two_link", "moves", "--out", "x", "--format", "csv").code == 0
    result = run("two_link", "moves/slow.csv", "moves/quick.csv", "--out", "x", "--format", "csv")
    assert result.code == 2
    assert "the folder x holds files of another run" in result.err


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("b.csv", "time,q1\n0,1\n", "b.csv, line 1"),
        ("b.csv", "", "the trajectory file is empty"),
        ("b.txt", "what these are\n", "the log holds a header only"),
    ],
)
def test_what_is_no_trajectory_is_named(run, folder, name, content, said):
    (folder / name).write_text(content)
    result = run("two_link", "moves")
    assert (result.code, result.out) == (2, "")
    assert f"moves/{name}" in result.err
    assert said in result.err
    assert "next:" in result.err


def test_a_motion_of_another_arm_is_named(run, folder):
    result = run("two_link", "moves/slow.csv", "pick-and-place")
    assert (result.code, result.out) == (2, "")
    assert "pick-and-place" in result.err
    assert "do not fit arm two_link" in result.err


def test_a_folder_without_trajectories(run, here):
    (here / "empty").mkdir()
    result = run("two_link", "empty")
    assert (result.code, result.out) == (2, "")
    assert "the folder holds no trajectories" in result.err
    assert "found: nothing" in result.err


def test_no_motion_of_a_folder_is_replaced(run, folder):
    before = (folder / "slow.csv").read_bytes()
    result = run("simplify", "two_link", "moves", "-o", "moves/slow.csv")
    assert result.code == 2
    assert "the output would replace an input" in result.err
    assert (folder / "slow.csv").read_bytes() == before


def test_without_any(run):
    result = run("two_link")
    assert result.code == 2
    assert "missing argument 'TRAJECTORY...'" in result.err
