"""`gd-analyze simplify`: budgets proven and odd, nothing gained, and what is said of a recursion."""

from __future__ import annotations

import re

import pytest

from changed_recursions import summands_dropped

SWING = ("simplify", "two_link", "two-link-swing", "--budget", "10%")


PUMA = ("simplify", "puma560", "pick-and-place")


def test_a_certified_budget(run):
    words = ("simplify", "two_link", "--certified", "--states", 100, "--budget", "5%")
    result = run(*words, "-o", "proven.json")
    assert (result.code, result.err) == (0, "")
    assert "Certified: no state within the arm's limits" in " ".join(result.out.split())
    assert max(map(len, result.out.splitlines())) <= 80
    told = run(*words, "--json").json
    for row in told["joints"]:
        assert row["largest_error"] <= row["certified"] <= row["allowed_error"]
    shown = run("certify", "proven.json", "--json").json
    assert [row["certified"] for row in shown["joints"]] == [row["certified"] for row in told["joints"]]


@pytest.mark.parametrize("level", ["term", "energy", "element"])
def test_a_certified_budget_along_a_trajectory_holds_in_the_whole_tube(run, level):
    words = ("simplify", "two_link", "two-link-swing", "--certified", "--budget", "5%", "--level", level)
    result = run(*words, "-o", "proven.json")
    assert (result.code, result.err) == (0, "")
    said = " ".join(result.out.split())
    assert "of two-link-swing, between its set points too, has an error above" in said
    told = run(*words, "--json").json
    assert told["certified_within"].endswith("of two-link-swing")
    shown = run("certify", "proven.json", "--along", "two-link-swing", "--json").json
    for row, joint in zip(told["joints"], shown["joints"], strict=True):
        assert row["largest_error"] <= row["certified"] <= row["allowed_error"]
        assert row["certified"] == joint["certified"]


def test_nothing_gained_is_said(run):
    result = run("simplify", "two_link", "two-link-swing", "--budget", "0.01%", "--level", "term")
    assert result.code == 0
    told = " ".join(result.out.split())
    full = run("simplify", "two_link", "two-link-swing", "--json").json["operations_full"]["total"]
    assert told.startswith(
        "Two-link planar arm: Nothing is saved within the budget of 0.01%: no model found takes fewer "
        f"operations than the {full} of the exact torque, which is given."
    )
    assert "->" not in told
    assert run("simplify", "two_link", "two-link-swing", "--budget", "0.01%", "--json").json["saves"] is False
    assert max(map(len, result.out.splitlines())) <= 80


def test_a_budget_that_is_the_larger_of_several(run, here):
    words = (*PUMA, "--budget", "1% or 10% friction")
    told = run(*words, "-o", "model.json", "--json").json
    assert (told["budget"], told["notice"], told["drives"]) == ("1% or 10% friction", "", True)
    assert 0 < told["terms"] <= 14
    for row in told["joints"]:
        assert row["largest_of_allowed"] == pytest.approx(row["largest_error"] / row["allowed_error"])
        assert row["allowed_error"] > 0.01 * row["peak_torque"]
    shown = run(*words)
    said = " ".join(shown.out.split())
    assert max(map(len, shown.out.splitlines())) <= 80
    assert "PUMA 560, drives included: " in said
    assert re.search(r"largest error \d+ % of the allowed error \(joint \d\)", said)
    assert "and its share of the allowed error" in said
    assert "friction at" not in said


def test_a_budget_below_friction_is_noticed_once(run):
    result = run(*PUMA)
    assert result.err == ""
    said = " ".join(result.out.split())
    assert said.count('--budget "1% or 10% friction" takes that into account.') == 1
    assert run(*PUMA, "--json").json["notice"] in said


def test_torques_are_answered_in_torques(run):
    said = " ".join(run(*PUMA, "--budget", "1").out.split())
    assert re.search(r"largest error 0\.\d+ N m \(joint \d\)", said)


def test_nothing_gained_on_the_whole_curve_is_said(run):
    words = ("trade-off", "two_link", "--states", 50, "--quick", "--budget", "1e-6%")
    said = " ".join(run(*words).out.split())
    told = run(*words, "--json").json
    full = told["operations_full"]["total"]
    assert told["saves"] is False
    assert (
        f"Nothing is saved within any of these budgets: no model found takes fewer operations than "
        f"the {full} of the exact torque, which is given." in said
    )
    assert run("trade-off", "puma560", "pick-and-place", "--quick", "--json").json["saves"] is True


def test_the_curve_is_in_the_terms_of_the_budget(run):
    words = ("trade-off", "puma560", "pick-and-place", "--quick", "--budget", "0.5 N m", "--json")
    told = run(*words).json
    assert told["shares_of"] == "allowed error"
    for point in told["points"]:
        multiple = float(point["budget"].removesuffix(" N m")) / 0.5
        # Quick points are counted on a tenth of the smallest budget of terms swept before.
        assert point["largest_share"] <= multiple * (1 + 1e-9)


@pytest.fixture
def quickly(monkeypatch):
    """Without a search: this is about what is told of a model."""
    monkeypatch.setattr("gd_analyze.simplification.pruning.prune", summands_dropped)


@pytest.mark.usefixtures("quickly")
def test_a_recursion_tells_what_it_keeps_and_leaves_out(run):
    words = ("simplify", "puma560", "pick-and-place", "--level", "recursive")
    result = run(*words)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    told, told_json = " ".join(result.out.split()), run(*words, "--json").json
    for equation in told_json["equations"]:
        assert " ".join(equation.split()) in told
    assert "Link 6, forces and torque" in told
    assert "omega, omegad: angular velocity and acceleration of a link" in told

    assert len(told_json["parameters"]) == 6 * 11
    states = {(row["link"], row["parameter"]): row["state"] for row in told_json["parameters"]}
    assert states[1, "M"] == states[6, "MZ"] == "never acts"
    assert {"dropped", "kept", "partly kept"} <= set(states.values())
    kept = [len(row["kept"]) for row in told_json["parameters"] if row["link"] == 3 and row["products"]]
    of = [row["products"] for row in told_json["parameters"] if row["link"] == 3 and row["products"]]
    row = next(line.split() for line in result.out.splitlines() if line.split()[:1] == ["3"] and "/" in line)
    assert [cell.rstrip("*") for cell in row[1:]] == [f"{k}/{n}" for k, n in zip(kept, of, strict=True)]

    left_out = told_json["left_out"]
    shares = [max(row["share"]) for row in left_out]
    assert shares == sorted(shares, reverse=True)
    assert all(1 <= row["link"] <= 6 and len(row["torque"]) == 6 for row in left_out)
    assert f"And {len(left_out) - 12} more" in told
    assert left_out[0]["in"] in told


@pytest.mark.usefixtures("quickly")
def test_nothing_left_out_of_a_recursion_is_said_to_be_nothing(run):
    result = run("simplify", "two_link", "two-link-swing", "--level", "recursive", "--budget", "0%")
    assert (result.code, result.err) == (0, "")
    assert "Nothing is left out." in result.out
    assert "tau1 = n1z" in result.out
