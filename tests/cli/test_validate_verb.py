"""`gd-analyze validate`: exit codes, what it tells people and machines, and what it refuses."""

from __future__ import annotations

from xml.etree import ElementTree

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.motions.trajectory import trajectory_csv
from gd_analyze.simplification.model_file import save_model
from recorded_logs import RATE, recorded
from several_motions import swung

JOINT = {
    "joint",
    "joint_name",
    "effort_unit",
    "peak_torque",
    "allowed_error",
    "largest_error",
    "rms_error",
    "within_allowed",
    "largest_of_allowed",
    "largest_share_of_peak_here",
    "largest_error_at",
    "fail_over",
    "passed",
}
MOTION = {
    "trajectory",
    "set_points",
    "begin",
    "end",
    "passed",
    "keeps_promise",
    "joints",
    "norms",
    "set_points_outside_box",
    "box_exits",
    "measured_torque",
}
EXIT = {
    "joint",
    "joint_name",
    "quantity",
    "unit",
    "limit",
    "farthest",
    "farthest_at",
    "set_points",
    "first",
    "longest_stretch",
}


@pytest.fixture
def model(two_link, here):
    """Made for the slow motion; beside it lie that one, a fast one and a brisk one in a folder."""
    made = gd.simplify(two_link, swung(6.0, "slow"), "5%")
    save_model(made, here / "model.json")
    (here / "logs").mkdir()
    for path, seconds in (("slow.csv", 6.0), ("fast.csv", 1.0), ("logs/brisk.csv", 2.0)):
        (here / path).write_text(trajectory_csv(swung(seconds, "x")), encoding="utf-8")
    return made


@pytest.fixture
def log(two_link, here):
    """Readings with torques and friction."""
    motion = recorded(two_link, friction=(2.0, 0.7, 0.3))
    rows = np.column_stack([motion.time, motion.q, motion.recording.torque])
    header = "time,q1,q2,tau1,tau2"
    np.savetxt(here / "log.csv", rows, delimiter=",", header=header, comments="")
    assert motion.time[1] == 1 / RATE
    return "log.csv"


def words_of(out: str) -> str:
    return " ".join(out.split())


def test_without_a_verdict_asked_for_the_code_is_0(run, model):
    result = run("validate", "model.json", "slow.csv", "fast.csv")
    assert result.code == 0
    said = words_of(result.out)
    assert "Not judged" in said
    assert "Set points outside the arm's limits" in said


def test_a_model_that_passes_and_one_that_fails(run, model):
    passes = run("validate", "model.json", "slow.csv", "--fail-over", "5%")
    assert passes.code == 0
    assert "Passed: --fail-over 5%" in passes.out
    fails = run("validate", "model.json", "slow.csv", "fast.csv", "--fail-over", "5%")
    assert fails.code == 1
    assert "Failed: --fail-over 5%" in fails.out
    assert "2 of 4" in fails.out
    assert "error:" not in fails.err
    assert run("validate", "model.json", "fast.csv", "--fail-over", "promise").code == 1
    assert run("validate", "model.json", "fast.csv", "--fail-over", "1000 N m").code == 0
    quiet = run("validate", "model.json", "fast.csv", "--fail-over", "5%", "--quiet")
    assert (quiet.code, quiet.out, quiet.err) == (1, "", "")


def test_json_holds_everything(run, model, two_link):
    result = run("validate", "model.json", "slow.csv", "fast.csv", "--fail-over", "5%", "--json")
    told = result.json
    assert result.code == 1
    assert (told["arm"], told["budget"], told["fail_over"], told["passed"]) == ("two_link", "5%", "5%", False)
    assert told["box"]["where"] == "the arm's limits"
    assert told["box"]["velocity"] == two_link.limits("velocity_limit").tolist()
    assert [one["passed"] for one in told["motions"]] == [True, False]
    found = gd.validate(model, [swung(6.0, "slow"), swung(1.0, "fast")], fail_over="5%")
    for said, one in zip(told["motions"], found.motions, strict=True):
        assert set(said) == MOTION
        assert said["trajectory"] == one.name
        assert all(set(row) == JOINT for row in said["joints"])
        assert all(set(row) == EXIT for row in said["box_exits"])
        errors = one.evaluation.errors
        # The file holds the same numbers to 17 digits, and so the same bits.
        assert [row["largest_error"] for row in said["joints"]] == errors.largest.tolist()
        assert [row["passed"] for row in said["joints"]] == (~one.fails).tolist()
        assert [row["largest_error_at"] for row in said["joints"]] == one.at.tolist()
        assert said["set_points_outside_box"] == int(one.outside.sum())
        assert [row["first"] for row in said["box_exits"]] == [each.first for each in one.exits]
        assert said["measured_torque"] is None
    assert told["motions"][1]["box_exits"]
    assert (told["warnings"] != [], told["files"]) == (True, [])


def test_a_folder_is_all_motions_in_it(run, model):
    told = run("validate", "model.json", "logs", "slow.csv", "--json").json
    assert [one["trajectory"] for one in told["motions"]] == ["brisk", "slow"]


def test_junit_is_written_where_a_model_fails_too(run, model, here):
    words = (
        "validate",
        "model.json",
        "slow.csv",
        "fast.csv",
        "--fail-over",
        "5%",
        "--junit",
        "out/junit.xml",
    )
    result = run(*words, "--json")
    assert (result.code, result.json["files"]) == (1, ["out/junit.xml"])
    root = ElementTree.parse(here / "out/junit.xml").getroot()
    assert (root.attrib["tests"], root.attrib["failures"]) == ("4", "2")
    assert run(*words).out.endswith("wrote out/junit.xml\n")


def test_measured_torques_beside_exact_and_simplified(run, model, log):
    result = run("validate", "model.json", log, "--measured", "--fit-friction")
    assert result.code == 0
    said = words_of(result.out)
    assert "RMS to" in said
    assert "Friction and offset fitted to the difference from the exact torque" in said
    plain = words_of(run("validate", "model.json", log, "--measured").out)
    assert "Friction and offset" not in plain
    told = run("validate", "model.json", log, "--measured", "--fit-friction", "--json").json
    measured = told["motions"][0]["measured_torque"]
    for row in measured["exact"]:
        # Numerical derivatives of the readings' positions, smoothed: a few per cent of friction.
        assert row["coulomb"] == pytest.approx(2.0, rel=0.05)
        assert row["offset"] == pytest.approx(0.3, abs=0.05)
    assert {row["joint_name"] for row in measured["simplified"]} == {"shoulder", "elbow"}
    without = run("validate", "model.json", log, "--measured", "--json").json
    assert "coulomb" not in without["motions"][0]["measured_torque"]["exact"][0]
    assert "rms_difference" in without["motions"][0]["measured_torque"]["simplified"][0]


def test_a_file_of_a_hostile_name(run, model, here):
    name = "<b>\x1b[2J\n&'\".csv"
    (here / name).write_text((here / "fast.csv").read_text())
    result = run("validate", "model.json", name, "--fail-over", "5%", "--junit", "j.xml")
    assert result.code == 1
    assert "\x1b" not in result.out + result.err
    assert all(line.isprintable() for line in result.out.splitlines())
    root = ElementTree.parse(here / "j.xml").getroot()
    assert root[0].attrib["name"] == "<b>\\x1b[2J\\n&'\""


BAD = {
    "no motion": ((), ("missing argument 'TRAJECTORY...'",)),
    "missing motion": (("nowhere.csv",), ("there is no trajectory 'nowhere.csv'", "expected:", "next:")),
    "wrong column": (("bad.csv",), ("where: bad.csv, line 1, column 4", "q3")),
    "wrong number": (("cell.csv",), ("where: cell.csv, line 3, column 2", "found: 'x'")),
    "strange share": (
        ("slow.csv", "--fail-over", "1% frction"),
        ("where: --fail-over, entry 1", "next: did you mean friction?"),
    ),
    "norm": (("slow.csv", "--fail-over", "1% norm"), ("where: --fail-over", "expected: an error allowed")),
    "too many": (
        ("slow.csv", "--fail-over", "1,2,3"),
        ("where: --fail-over", "expected: 1 or 2", "found: 3"),
    ),
    "no friction": (
        ("slow.csv", "--fail-over", "10% friction"),
        ("--fail-over, joint 1, shoulder, of two_link", "next: state it in the arm file"),
    ),
    "over the model": (
        ("slow.csv", "--junit", "model.json"),
        ("the output would replace an input", "next: choose another name with --junit"),
    ),
    "over a motion of a folder": (("logs", "--junit", "logs/brisk.csv"), ("would replace an input",)),
    "into a file": (
        ("slow.csv", "--junit", "slow.csv/j.xml"),
        ("slow.csv is not a folder", "next: choose another place with --junit"),
    ),
    "an option of evaluate": (("slow.csv", "--payload", "1,0,0,0"), ("no such option '--payload'",)),
}


@pytest.mark.parametrize("name", BAD)
def test_refused(run, model, here, listing, name):
    words, says = BAD[name]
    header = "time,q1,q2"
    (here / "bad.csv").write_text(f"{header},q3\n" + "".join(f"{k},0,0,0\n" for k in range(9)))
    (here / "cell.csv").write_text(
        f"{header}\n" + "".join(f"{k},{'x' if k == 1 else 0},0\n" for k in range(9))
    )
    before = listing()
    result = run("validate", "model.json", *words)
    assert (result.code, result.out) == (2, "")
    assert result.err.startswith("error: ")
    for text in says:
        assert text in result.err
    assert listing() == before


def test_a_missing_and_a_damaged_model(run, model, here):
    assert "where: nowhere.json" in run("validate", "nowhere.json", "slow.csv").err
    (here / "model.json").write_text((here / "model.json").read_text().replace('"mass": 2.0', '"mass": 2.5'))
    result = run("validate", "model.json", "slow.csv", "--junit", "j.xml")
    assert (result.code, result.out) == (2, "")
    assert "model.json" in result.err
    assert not (here / "j.xml").exists()


def test_evaluate_and_validate_tell_the_same_errors(run, model):
    one = run("evaluate", "model.json", "fast.csv", "--json").json["joints"]
    other = run("validate", "model.json", "fast.csv", "--json").json["motions"][0]["joints"]
    for mine, theirs in zip(one, other, strict=True):
        shared = mine.keys() & theirs.keys()
        assert "largest_error" in shared
        assert {key: mine[key] for key in shared} == {key: theirs[key] for key in shared}


def test_a_promise_of_the_norm_is_told(run, two_link, here):
    save_model(gd.simplify(two_link, swung(6.0, "slow"), "5% norm at 95%"), here / "model.json")
    (here / "fast.csv").write_text(trajectory_csv(swung(1.0, "x")), encoding="utf-8")
    said = words_of(run("validate", "model.json", "fast.csv").out)
    assert "5% norm at 95% of states (broken)" in said
    result = run("validate", "model.json", "fast.csv", "--fail-over", "promise")
    assert result.code == 2
    assert "this model promises no joint an error of its own" in result.err


def test_the_exact_model_is_said_to_be_that(run, two_link, here):
    (here / "fast.csv").write_text(trajectory_csv(swung(1.0, "x")), encoding="utf-8")
    assert run("simplify", "two_link", "fast.csv", "--budget", "1e-6%", "-o", "model.json").code == 0
    for words in ((), ("--fail-over", "1e-6%")):
        result = run("validate", "model.json", "fast.csv", *words, "--junit", "j.xml")
        assert result.code == 0
        assert "no torque error beyond round-off" in words_of(result.out)
    told = run("validate", "model.json", "fast.csv", "--json").json["motions"][0]["joints"]
    assert [row["largest_error_at"] for row in told] == [None, None]
    assert "no torque error beyond round-off" in (here / "j.xml").read_text()
