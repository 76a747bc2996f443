"""`gd-analyze simplify`: what it prints and writes, and what it refuses."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gd_analyze as gd

SWING = ("simplify", "two_link", "two-link-swing", "--budget", "10%")


def test_along_a_trajectory_on_80_columns(run):
    result = run(*SWING)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    told = " ".join(result.out.split())
    told_json = run(*SWING, "--json").json
    left, full = told_json["operations"], told_json["operations_full"]
    assert left["total"] <= full["total"]
    assert f"{left['total']} instead of {full['total']} operations" in told or (
        left == full and f"operations than the {full['total']} of the exact torque" in told
    )
    assert (f"{full['sines_cosines']} sin and cos -> {left['total']}" in told) == told_json["saves"]
    assert "set points of two-link-swing" in told
    for equation in told_json["equations"]:
        assert equation in told
    assert "; ".join(told_json["legend"]) in told


def test_over_the_box_of_the_arm(run):
    words = ("simplify", "puma560", "--drives", "--level", "energy", "--states", 100, "--seed", 3)
    result = run(*words)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    assert "100 states drawn from the arm's ranges" in " ".join(result.out.split())
    assert "tau2 = tau3 + " in result.out
    assert "p3 = qd2 + qd3; pd3 = qdd2 + qdd3" in result.out
    told = run(*words, "--json").json
    assert told["fitted_on"]["seed"] == 3
    assert told["drives"]
    assert not told["refitted"]
    assert [step["name"] for step in told["search"]][:2] == ["elimination", "integer program"]
    for row in told["joints"]:
        assert row["certified"] is None
        assert 0 <= row["rms_error"] <= row["largest_error"] <= row["allowed_error"]
        # 1 % of a double.
        assert row["allowed_error"] == pytest.approx(0.01 * row["peak_torque"], rel=1e-14)
    operations = told["operations"]
    assert operations["total"] == operations["multiplications"] + operations["additions"]


def test_the_exact_equations_of_two_rods(run):
    result = run("simplify", "two_link", "two-link-swing", "--budget", "0%", "--level", "energy", "--json")
    assert result.json["equations"] == [
        "tau1 = tau2 + 1.67 pd1 + 0.5 C2 pd2 - 0.5 S2 p2² + 19.6 C1",
        "tau2 = 0.5 C2 pd1 + 0.333 pd2 + 0.5 S2 p1² + 4.9 C12",
    ]
    assert result.json["legend"][:2] == ["p2 = qd1 + qd2", "pd2 = qdd1 + qdd2"]
    assert result.json["operations"]["total"] <= 22
    digits = ("--digits", 2, "--quiet", "--json")
    told = run("simplify", "two_link", "two-link-swing", "--budget", "0%", "--level", "energy", *digits).json
    assert told["equations"][1] == "tau2 = 0.5 C2 pd1 + 0.33 pd2 + 0.5 S2 p1² + 4.9 C12"


@pytest.mark.parametrize("level", ["term", "energy"])
def test_a_model_written_is_a_model_evaluated(run, level):
    made = run(*SWING, "--level", level, "-o", "model.json")
    assert made.out.endswith("wrote model.json\n")
    model = gd.load_model("model.json")
    assert model.level.name == level
    assert model.provenance["command"].startswith("gd-analyze simplify two_link")
    found = run("evaluate", "model.json", "two-link-swing", "--json")
    assert (found.code, found.err) == (0, "")
    assert found.json["level"] == level
    assert found.json["largest_losses"] == []
    for row in found.json["joints"]:
        # The same program on the same states, so the same bits.
        assert row["largest_error"] == row["promised_largest_error"]
    assert "errs no more here than on two-link-swing." in run("evaluate", "model.json", "two-link-swing").out


def test_a_model_of_the_box_is_evaluated_along_a_trajectory(run):
    words = (
        "simplify",
        "puma560",
        "--level",
        "energy",
        "--states",
        200,
        "--drives",
        "--quiet",
        "-o",
        "m.json",
    )
    made = run(*words)
    assert (made.code, made.out, made.err) == (0, "", "")
    found = run("evaluate", "m.json", "pick-and-place", "-o", "torque.csv")
    assert (found.code, found.err) == (0, "")
    assert max(map(len, found.out.splitlines())) <= 80
    assert "by a model made for the arm's box with a budget of 1%." in found.out
    assert "What was dropped" not in found.out
    assert found.out.endswith("wrote torque.csv\n")


def test_refit_and_payload(run):
    told = run(*SWING, "--level", "energy", "--refit", "--payload", "1,0,0,0", "--json").json
    assert told["refitted"]
    assert told["arm"] == "two_link+1kg"


REFUSED = {
    "refit of parts": (
        ("simplify", "two_link", "two-link-swing", "--refit", "--level", "element"),
        "expected: level term, recursive or energy",
    ),
    "unknown level": (("simplify", "two_link", "two-link-swing", "--level", "atom"), "--level"),
    "certified and refitted": (
        ("simplify", "two_link", "two-link-swing", "--certified", "--refit"),
        "--certified goes without",
    ),
    "margin of nothing certified": (
        ("simplify", "two_link", "two-link-swing", "--margin", "1deg"),
        "--margin goes with --certified",
    ),
    "margin of no motion": (("simplify", "two_link", "--certified", "--margin", "1deg"), "and a trajectory"),
    "margin": (
        ("simplify", "two_link", "two-link-swing", "--certified", "--margin", "1%"),
        "--margin, entry 1",
    ),
    "fewer than no operations": (("simplify", "two_link", "two-link-swing", "--operations", "-3"), "-3"),
    "budget": (("simplify", "two_link", "two-link-swing", "--budget", "much"), "--budget"),
    "budget of three": (("simplify", "two_link", "two-link-swing", "--budget", "1,2,3"), "1 or 2"),
    "no drives": (("simplify", "two_link", "two-link-swing", "--drives"), "describes no drives"),
    "no states": (("simplify", "puma560", "--states", "0"), "--states"),
    "unknown arm": (("simplify", "nobody"), "nobody"),
}


@pytest.mark.parametrize(("words", "told"), REFUSED.values(), ids=REFUSED.keys())
def test_refused(run, words, told, listing):
    result = run(*words, "-o", "model.json")
    assert (result.code, result.out) == (2, "")
    assert told in result.err
    assert "Traceback" not in result.err
    assert listing() == set()


def test_the_file_is_json_of_every_digit(run, here):
    run(*SWING, "--level", "energy", "--quiet", "-o", "model.json")
    document = json.loads((here / "model.json").read_text(encoding="utf-8"))
    model = gd.load_model("model.json")
    stated = [entry["coefficient"] for entry in document["terms"]]
    np.testing.assert_array_equal(stated, list(model.terms.values()))


def test_as_many_operations_as_asked_for(run):
    asked = run("simplify", "two_link", "two-link-swing", "--operations", 12, "--json").json
    assert asked["operations"]["total"] <= 12
    loose = run("simplify", "two_link", "two-link-swing", "--operations", 1000, "--json").json
    assert max(row["largest_share"] for row in loose["joints"]) <= 1e-5
    for row in (*asked["joints"], *loose["joints"]):
        assert row["largest_error"] <= row["allowed_error"]


def test_the_text_s_own_method(run):
    result = run(*SWING, "--level", "element")
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    told = run(*SWING, "--level", "element", "--json").json
    assert {*told["kept"], *told["dropped"]} >= {"D11 translation", "h2 rotation", "c1"}
    assert "equations" not in told
    for label in told["kept"]:
        assert label in " ".join(result.out.split())


def test_a_refit_takes_no_more_operations(run):
    words = ("simplify", "puma560", "--drives", "--states", 60, "--level", "energy", "--json")
    plain, refitted = run(*words).json, run(*words, "--refit").json
    assert refitted["refitted"]
    assert refitted["operations"]["total"] <= plain["operations"]["total"]
    # A refit goes on from where the search without one ends.
    assert refitted["search"][: len(plain["search"])] == plain["search"]
    assert [step["name"] for step in refitted["search"]][-2:] == ["refit", "shared coefficients"]
    assert refitted["solved"] == plain["solved"]


def test_the_exact_torque_has_one_count(run, here):
    full = run(*SWING, "--json").json["operations_full"]
    by_elements = run("simplify", "two_link", "two-link-swing", "--level", "element", "--json").json
    assert by_elements["operations"] == full
    assert not by_elements["saves"]
    assert not by_elements["cut_short"]
    main_job = run("two_link", "two-link-swing", "--format", "json", "--out", "r", "--json").json
    assert main_job["operations_full"] | {"total": full["total"]} == full
    assert main_job["elements"]["operations_full"] == main_job["operations_full"]
    told = " ".join(run("trade-off", "two_link", "two-link-swing").out.split())
    assert f"The exact torque takes {full['total']};" in told


def test_a_search_that_used_up_its_effort_says_so(run):
    words = ("simplify", "puma560", "--states", 100, "--level", "energy", "--refit", "--effort", 0.001)
    result = run(*words)
    assert result.code == 0
    assert "ended as its effort was used up" in " ".join(result.out.split())
    assert run(*words, "--json").json["cut_short"] is True
    refused = run("simplify", "puma560", "--effort", 0)
    assert refused.code == 2


PUMA = ("simplify", "puma560", "pick-and-place")


def test_the_links_alone(run):
    told = run(*PUMA, "--no-drives", "--budget", "5%", "--json").json
    assert told["drives"] is False
    assert "PUMA 560, links alone: " in " ".join(run(*PUMA, "--no-drives", "--budget", "5%").out.split())
