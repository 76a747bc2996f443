"""`gd-analyze simplify`: what it prints and writes, budgets proven and odd, and what it refuses."""

from __future__ import annotations

import json

import numpy as np
import pytest

import gd_analyze as gd
from changed_recursions import summands_dropped

TWO = ("simplify", "two_link", "two-link-swing")
SWING = (*TWO, "--budget", "10%")
PUMA = ("simplify", "puma560", "pick-and-place")


def within_80(result) -> str:
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    return " ".join(result.out.split())


def test_along_a_trajectory_text_and_json_agree(run):
    shown, found = within_80(run(*SWING)), run(*SWING, "--json").json
    left, full = found["operations"], found["operations_full"]
    assert left["total"] == left["multiplications"] + left["additions"] <= full["total"]
    assert found["saves"] == (left["total"] < full["total"])
    assert "set points of two-link-swing" in shown
    for text in (*found["equations"], *found["legend"]):
        assert text in shown


def test_over_the_box_of_the_arm(run):
    words = ("simplify", "puma560", "--drives", "--level", "energy", "--states", 100, "--seed", 3)
    shown, found = within_80(run(*words)), run(*words, "--json").json
    assert "100 states drawn from the arm's ranges" in shown
    assert "tau2 = tau3 + " in shown
    assert found["fitted_on"]["seed"] == 3
    assert found["drives"]
    assert not found["refitted"]
    assert [step["name"] for step in found["search"]][:2] == ["elimination", "integer program"]
    for row in found["joints"]:
        assert row["certified"] is None
        assert 0 <= row["rms_error"] <= row["largest_error"] <= row["allowed_error"]
        assert row["allowed_error"] == pytest.approx(0.01 * row["peak_torque"], rel=1e-14)
    refitted = run(*words, "--refit", "--json").json
    assert refitted["refitted"]
    assert refitted["operations"]["total"] <= found["operations"]["total"]
    # A refit goes on from where the search without one ends.
    assert refitted["search"][: len(found["search"])] == found["search"]


def test_the_exact_equations_of_two_rods(run):
    words = (*TWO, "--budget", "0%", "--level", "energy", "--json")
    found = run(*words).json
    assert found["equations"] == [
        "tau1 = tau2 + 1.67 pd1 + 0.5 C2 pd2 - 0.5 S2 p2² + 19.6 C1",
        "tau2 = 0.5 C2 pd1 + 0.333 pd2 + 0.5 S2 p1² + 4.9 C12",
    ]
    assert found["legend"][:2] == ["p2 = qd1 + qd2", "pd2 = qdd1 + qdd2"]
    assert found["operations"]["total"] <= 22
    assert "0.33 pd2" in run(*words, "--digits", 2, "--quiet").json["equations"][1]


@pytest.mark.parametrize("level", ["term", "energy"])
def test_a_model_written_is_a_model_evaluated(run, here, level):
    made = run(*SWING, "--level", level, "-o", "model.json")
    assert made.out.endswith("wrote model.json\n")
    model = gd.load_model("model.json")
    assert model.level.name == level
    assert model.provenance["command"].startswith("gd-analyze simplify two_link")
    entries = json.loads((here / "model.json").read_text(encoding="utf-8"))["terms"]
    numbers = [entry["coefficient" if level == "energy" else "weight"] for entry in entries]
    np.testing.assert_array_equal(numbers, list(model.terms.values()))
    found = run("evaluate", "model.json", "two-link-swing", "--json")
    assert (found.code, found.err) == (0, "")
    assert found.json["level"] == level
    assert found.json["largest_losses"] == []
    for row in found.json["joints"]:
        # The same program on the same states, so the same bits.
        assert row["largest_error"] == row["promised_largest_error"]


def test_refit_and_payload(run):
    found = run(*SWING, "--level", "energy", "--refit", "--payload", "1,0,0,0", "--json").json
    assert found["refitted"]
    assert found["arm"] == "two_link+1kg"


REFUSED = {
    "refit of parts": ((*TWO, "--refit", "--level", "element"), "level term, recursive or energy"),
    "unknown level": ((*TWO, "--level", "atom"), "--level"),
    "certified and refitted": ((*TWO, "--certified", "--refit"), "--certified goes without"),
    "margin of nothing certified": ((*TWO, "--margin", "1deg"), "--margin goes with --certified"),
    "margin": ((*TWO, "--certified", "--margin", "1%"), "--margin, entry 1"),
    "fewer than no operations": ((*TWO, "--operations", "-3"), "-3"),
    "no effort": ((*TWO, "--effort", "0"), "--effort"),
    "budget": ((*TWO, "--budget", "much"), "--budget"),
    "budget of three": ((*TWO, "--budget", "1,2,3"), "1 or 2"),
    "no drives": ((*TWO, "--drives"), "describes no drives"),
    "no states": (("simplify", "puma560", "--states", "0"), "--states"),
    "unknown arm": (("simplify", "nobody"), "nobody"),
}


@pytest.mark.parametrize(("words", "fact"), REFUSED.values(), ids=REFUSED.keys())
def test_refused(run, words, fact, listing):
    result = run(*words, "-o", "model.json")
    assert (result.code, result.out) == (2, "")
    assert fact in result.err
    assert "Traceback" not in result.err
    assert listing() == set()


def test_as_many_operations_as_asked_for(run):
    asked = run(*TWO, "--operations", 12, "--json").json
    assert asked["operations"]["total"] <= 12
    loose = run(*TWO, "--operations", 1000, "--json").json
    assert max(row["largest_share"] for row in loose["joints"]) <= 1e-5
    for row in (*asked["joints"], *loose["joints"]):
        assert row["largest_error"] <= row["allowed_error"]


def test_the_text_s_own_method(run):
    shown, found = (
        within_80(run(*SWING, "--level", "element")),
        run(*SWING, "--level", "element", "--json").json,
    )
    assert {*found["kept"], *found["dropped"]} >= {"D11 translation", "h2 rotation", "c1"}
    assert "equations" not in found
    for label in found["kept"]:
        assert label in shown


def test_the_exact_torque_has_one_count(run, here):
    full = run(*SWING, "--json").json["operations_full"]
    by_elements = run(*TWO, "--level", "element", "--json").json
    assert by_elements["operations"] == full
    assert not by_elements["saves"]
    main_job = run("two_link", "two-link-swing", "--format", "json", "--out", "r", "--json").json
    assert main_job["operations_full"] == full
    assert run("trade-off", "two_link", "two-link-swing", "--quick", "--json").json["operations_full"] == full


def test_a_search_that_used_up_its_effort_says_so(run):
    words = ("simplify", "puma560", "--states", 100, "--level", "energy", "--refit", "--effort", 0.001)
    assert "Effort used up" in within_80(run(*words))
    assert run(*words, "--json").json["cut_short"] is True


def test_the_links_alone(run):
    words = (*PUMA, "--no-drives", "--budget", "5%")
    assert run(*words, "--json").json["drives"] is False
    assert "links alone" in run(*words).out


def test_a_certified_budget(run):
    words = ("simplify", "two_link", "--certified", "--states", 100, "--budget", "5%")
    assert "the arm's limits" in within_80(run(*words, "-o", "proven.json"))
    found = run(*words, "--json").json
    for row in found["joints"]:
        assert row["largest_error"] <= row["certified"] <= row["allowed_error"]
    shown = run("certify", "proven.json", "--json").json
    assert [row["certified"] for row in shown["joints"]] == [row["certified"] for row in found["joints"]]


@pytest.mark.parametrize("level", ["term", "energy", "element"])
def test_a_certified_budget_along_a_trajectory_holds_in_the_whole_tube(run, level):
    words = ("simplify", "two_link", "two-link-swing", "--certified", "--budget", "5%", "--level", level)
    assert run(*words, "-o", "proven.json").code == 0
    found = run(*words, "--json").json
    assert found["certified_within"].endswith("of two-link-swing")
    shown = run("certify", "proven.json", "--along", "two-link-swing", "--json").json
    for row, joint in zip(found["joints"], shown["joints"], strict=True):
        assert row["largest_error"] <= row["certified"] <= row["allowed_error"]
        assert row["certified"] == joint["certified"]


def test_a_budget_that_is_the_larger_of_several(run):
    words = (*PUMA, "--budget", "1% or 10% friction")
    shown, found = within_80(run(*words)), run(*words, "--json").json
    assert (found["budget"], found["notices"], found["drives"]) == ("1% or 10% friction", [], True)
    assert 0 < found["terms"] <= 14
    for row in found["joints"]:
        assert row["largest_of_allowed"] == pytest.approx(row["largest_error"] / row["allowed_error"])
        assert row["allowed_error"] > 0.01 * row["peak_torque"]
    assert "of allowed error (joint" in shown or "of the allowed error (joint" in shown


def test_a_budget_below_friction_is_noticed_once_and_torques_are_answered_in_torques(run):
    shown = within_80(run(*PUMA))
    (notice,) = run(*PUMA, "--json").json["notices"]
    assert shown.count(notice) == 1
    assert '--budget "1% or 10% friction"' in notice
    assert "N m (joint" in within_80(run(*PUMA, "--budget", "1"))


@pytest.fixture
def quickly(monkeypatch):
    """Without a search: this is about what is shown of a model."""
    monkeypatch.setattr("gd_analyze.simplification.pruning.prune", summands_dropped)


@pytest.mark.usefixtures("quickly")
def test_a_recursion_shows_what_it_keeps_and_leaves_out(run):
    words = (*PUMA, "--level", "recursive")
    result = run(*words)
    shown, found = within_80(result), run(*words, "--json").json
    for equation in found["equations"]:
        assert " ".join(equation.split()) in shown
    assert len(found["parameters"]) == 6 * 11
    states = {(row["link"], row["parameter"]): row["state"] for row in found["parameters"]}
    assert states[1, "M"] == states[6, "MZ"] == "never acts"
    assert {"dropped", "kept", "partly kept"} <= set(states.values())
    left_out = found["left_out"]
    shares = [max(row["share"]) for row in left_out]
    assert shares == sorted(shares, reverse=True)
    assert all(1 <= row["link"] <= 6 and len(row["torque"]) == 6 for row in left_out)
    assert left_out[0]["in"] in shown


@pytest.mark.usefixtures("quickly")
def test_a_recursion_that_leaves_nothing_out(run):
    result = run(*TWO, "--level", "recursive", "--budget", "0%")
    assert (result.code, result.err) == (0, "")
    assert "tau1 = n1z" in result.out


def test_the_curve_is_in_the_terms_of_the_budget(run):
    words = ("trade-off", "puma560", "pick-and-place", "--quick", "--budget", "0.5 N m", "--json")
    found = run(*words).json
    assert found["shares_of"] == "allowed error"
    assert found["saves"]
    for point in found["points"]:
        multiple = float(point["budget"].removesuffix(" N m")) / 0.5
        # Quick points are counted on a tenth of the smallest budget of terms swept before.
        assert point["largest_share"] <= multiple * (1 + 1e-9)
    nothing = run("trade-off", "two_link", "--states", 50, "--quick", "--budget", "1e-6%", "--json").json
    assert nothing["saves"] is False
