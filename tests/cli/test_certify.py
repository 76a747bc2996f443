"""`gd-analyze certify`: the bound it prints, and what it refuses."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from bad_files import ARM, csv

from gd_analyze.certification.certificate import EFFORT
from gd_analyze.cli.certify import certify
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.model_file import _digest, save_model
from gd_analyze.text import rounded_up
from made_models import exact_model, model_of


@pytest.fixture
def model(run, here):
    assert run("simplify", "two_link", "--budget", "5%", "--level", "energy", "-o", "model.json").code == 0
    return here / "model.json"


def test_it_states_the_bound(run, model):
    result = run("certify", model)
    assert (result.code, result.err) == (0, "")
    said = " ".join(result.out.split())
    assert "Two-link planar arm: no state within the arm's limits has a torque error above" in said
    assert "D is positive definite everywhere in the box" in said
    assert max(map(len, result.out.splitlines())) <= 80


def test_json_holds_the_same(run, model):
    document = run("certify", model, "--effort", "1000", "--json").json
    assert (document["arm"], document["effort"]) == ("two_link", 1000)
    assert len(document["box"]["lower"]) == 2
    for joint in document["joints"]:
        assert joint["largest_error"] <= joint["certified"]
        assert joint["worst_found"] <= joint["certified"]
        assert joint["within_allowed"] == (joint["certified"] <= joint["allowed_error"])
        assert [len(joint["worst_state"][name]) for name in ("q", "qd", "qdd")] == [2, 2, 2]
    definite = document["positive_definite"]
    assert definite["proven"]
    assert 0.0 < definite["smallest_eigenvalue_at_least"] <= definite["smallest_eigenvalue_found"]


def test_a_term_level_model_has_no_symmetric_inertia_to_speak_of(run, here):
    assert run("simplify", "two_link", "--budget", "5%", "--level", "term", "-o", "term.json").code == 0
    assert run("certify", "term.json", "--json").json["positive_definite"] is None
    assert "positive definite" not in run("certify", "term.json").out


@pytest.fixture
def dropped(run, here):
    """A model that leaves something out, so that its bound is more than round-off."""
    assert run("simplify", "puma560", "pick-and-place", "--effort", "0.1", "-o", "puma.json").code == 0
    return here / "puma.json"


ALONG = ("--along", "pick-and-place")


def test_along_a_trajectory_the_tube_is_certified_and_the_box_of_its_extremes(run, dropped):
    document, whole = (run("certify", dropped, *words, "--json").json for words in (ALONG, ()))
    assert document["from"] == "1 degree, 2 % of peak rate and 5 % of peak acceleration of pick-and-place"
    assert whole["tube"] is None
    for inner, outer in zip(document["joints"], whole["joints"], strict=True):
        assert 0.0 < inner["largest_error"] <= inner["certified"]
        assert inner["certified"] < inner["certified_between_extremes"] < outer["certified"]
        assert 1.0 <= inner["ratio"] <= 1.1
    for name, sign in (("lower", 1), ("upper", -1)):
        inside, limits = np.array(document["box"][name]), np.array(whole["box"][name])
        assert (sign * inside >= sign * limits).all()
    pieces = document["tube"]["pieces"]
    assert (pieces[0]["begin"], pieces[-1]["end"]) == (0.0, 2.4)
    for joint in range(6):
        largest = max(piece["certified"][joint] for piece in pieces)
        assert largest == document["joints"][joint]["certified"]


def test_it_says_what_is_proven_of_the_motion_on_80_columns(run, dropped):
    for words in ((), ALONG):
        result = run("certify", dropped, *words)
        assert (result.code, result.err) == (0, "")
        assert max(map(len, result.out.splitlines())) <= 80
    said = " ".join(result.out.split())
    assert "of pick-and-place, between its set points too, has a torque error above" in said
    assert (
        "Extremes: certified of every combination of what lies between the motion's, without margins." in said
    )
    assert said.count("too far apart to tell the motion to within the margins in 2 of 30 intervals") == 1


def test_larger_margins_have_larger_bounds(run, dropped):
    usual, large = (
        run("certify", dropped, *ALONG, *margin, "--json").json
        for margin in ((), ("--margin", "5deg,qd=10%"))
    )
    for inner, outer in zip(usual["joints"], large["joints"], strict=True):
        assert inner["certified"] < outer["certified"]
        assert inner["certified_between_extremes"] == outer["certified_between_extremes"]
    assert large["tube"]["margins"]["q"] == pytest.approx([np.radians(5.0)] * 6)
    assert large["tube"]["margins"]["qdd"] == usual["tube"]["margins"]["qdd"]


def test_a_trajectory_sampled_coarsely_is_told(run, model, here):
    rows = ["time,q1,q2,qd1,qd2,qdd1,qdd2"]
    rows += [f"{t},{0.5 * t * t},0,{t},0,{1 if t < 2 else -3},0" for t in (0.0, 1.0, 2.0)]
    (here / "coarse.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    document = run("certify", model, "--along", "coarse.csv", "--json").json
    assert document["tube"]["coarse"] == 2
    said = " ".join(run("certify", model, "--along", "coarse.csv").out.split())
    assert said.count("The set points are too far apart to tell the motion") == 1
    assert "2 of 2 intervals" in said


def test_the_verdict_counts_the_joints_that_are_proven(run, model):
    joints = run("certify", model, "--json").json["joints"]
    proven = sum(joint["within_allowed"] for joint in joints)
    said = " ".join(run("certify", model).out.split())
    every = "Every joint stays within the budget of 5%" in said
    assert every == (proven == 2)
    assert every or f"{proven} of 2 joints are proven to stay within the budget of 5%" in said


def test_the_same_model_gives_the_same_answer(run, model):
    assert run("certify", model, "--json").out == run("certify", model, "--json").out


def test_quiet_prints_nothing(run, model):
    result = run("certify", model, "--effort", "1", "--quiet")
    assert (result.code, result.out, result.err) == (0, "", "")


def test_the_default_effort_is_the_librarys():
    assert {option.name: option.default for option in certify.params}["effort"] == EFFORT


@pytest.mark.parametrize("digits", [2, 3])
def test_a_bound_is_never_shown_smaller_than_it_is(digits):
    for value in (0.0, 1.0, 0.1, 0.12301, 99.95, 1.2e-9, *np.random.default_rng(0).lognormal(0, 5, 200)):
        shown = rounded_up(float(value), digits)
        # The number printed is the decimal one; as a float it is half an eps away.
        assert value * (1 - 1e-15) <= shown <= value * (1 + 10.0 ** (1 - digits))
        assert float(f"{shown:.{digits}g}") == shown


def test_an_element_level_model_is_certified_too(run, here):
    words = ("simplify", "two_link", "two-link-swing", "--level", "element", "-o", "element.json", "--quiet")
    assert run(*words).code == 0
    for joint in run("certify", "element.json", "--along", "two-link-swing", "--json").json["joints"]:
        assert joint["largest_error"] <= joint["certified"] <= joint["allowed_error"]


def test_a_missing_model_is_refused(run):
    result = run("certify", "nowhere.json")
    assert result.code == 2
    assert "nowhere.json" in result.err


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("--effort", "0"), "--effort"),
        (("--along", "pick-and-place"), "pick-and-place"),
        (("--margin", "1deg"), "--along"),
        (("--along", "two-link-swing", "--margin", "much"), "--margin, entry 1"),
        (("--along", "two-link-swing", "--margin", "1deg,2deg"), "twice"),
    ],
)
def test_bad_options_are_refused(run, model, words, named):
    result = run("certify", model, *words)
    assert result.code == 2
    assert named in result.err
    assert "Traceback" not in result.err


def test_it_is_said_of_what_shares_are(run, model):
    document = run("certify", model, "--json").json
    stated = {row["joint"]: row for row in json.loads(model.read_text(encoding="utf-8"))["errors"]}
    for joint in document["joints"]:
        promised = stated[joint["joint_name"]]
        for name, whole in (
            ("certified_share_of_largest_found", joint["largest_torque_found"]),
            ("certified_share_of_peak_made_for", promised["peak_torque"]),
            ("certified_of_allowed", joint["allowed_error"]),
        ):
            assert joint[name] == pytest.approx(joint["certified"] / whole, rel=1e-12)
        assert (joint["certified_of_allowed"] <= 1.0) == joint["within_allowed"]
    worst = max(row["certified_share_of_peak_made_for"] for row in document["joints"])
    said = " ".join(run("certify", model).out.split())
    told = re.search(r"a torque error above ([\d.]+) % of the peak torque over (\d+) states drawn", said)
    # Rounded up to two digits, and no smaller figure is told than a hundredth.
    assert 100 * worst <= float(told[1]) <= max(0.01, 100 * worst * 1.1)


def edited(model, change):
    document = json.loads(model.read_text(encoding="utf-8"))
    change(document)
    document["digest"] = _digest(document)
    model.write_text(json.dumps(document), encoding="utf-8")
    return model


def lie(document):
    """A peak of 1e9 N m, for a trajectory that nobody else has: consistent, and not to be measured again."""
    document["fitted_on"] = {"trajectory": "mine", "trajectory_fingerprint": "0" * 64, "set_points": 9}
    for row in document["errors"]:
        row["peak_torque"], row["allowed_error"] = 1e9, 0.05e9


def test_what_only_the_file_says_is_said_to_be_stated(run, model):
    honest = run("certify", model, "--json").json
    assert honest["allowed_and_largest_error"] == "measured"
    assert "stated" not in run("certify", model).out
    result = run("certify", edited(model, lie))
    said = " ".join(result.out.split())
    assert "sampled and allowed as the file states" in said
    assert "stated by the file, for 9 set points of mine, which are not at hand" in said
    assert "within the stated budget of 5%" in said
    # A share of a peak of 1e9 N m would be none.
    assert re.search(r"has a torque error above [\d.e-]+ N m \(joint \d\)\.", said)
    assert max(map(len, result.out.splitlines())) <= 80
    document = run("certify", model, "--json").json
    assert document["allowed_and_largest_error"] == "stated by the file"
    for here, before in zip(document["joints"], honest["joints"], strict=True):
        for name in ("certified", "certified_share_of_largest_found", "largest_torque_found"):
            assert here[name] == before[name]


def test_the_named_trajectory_measures_what_is_stated(run, here):
    motion = run("plan", "two_link", "--from", "0,0", "--to", "1,1", "--duration", "1", "-o", "mine.csv")
    assert motion.code == 0, motion.err
    assert run("simplify", "two_link", "mine.csv", "--budget", "40%", "-o", "mine.json").code == 0
    assert run("certify", "mine.json", "--json").json["allowed_and_largest_error"] == "stated by the file"
    along = run("certify", "mine.json", "--along", "mine.csv", "--json").json
    assert along["allowed_and_largest_error"] == "measured"

    def understate(document):
        for row in document["errors"]:
            row["peak_torque"], row["allowed_error"] = 1e3 * row["peak_torque"], 1e3 * row["allowed_error"]

    edited(here / "mine.json", understate)
    assert run("certify", "mine.json").code == 0
    refused = run("certify", "mine.json", "--along", "mine.csv")
    assert refused.code == 2
    assert "peak_torque of joint 1" in refused.err


def test_a_singular_model_gets_a_clear_answer(run, here, two_link):
    form = ExactForm(two_link)
    kept = {t: c for t, c in form.energies.items() if 1 not in (t.i, t.j)}
    save_model(model_of(form, ENERGY, kept), here / "singular.json")
    result = run("certify", "singular.json")
    assert result.code == 0, result.err
    said = " ".join(result.out.split())
    assert "D is singular at q = (" in said
    assert "cannot be simulated" in said
    document = run("certify", "singular.json", "--json").json["positive_definite"]
    assert document["singular"]
    assert not document["proven"]
    assert -1.0 < document["smallest_eigenvalue_at_least"] <= 0.0


def test_an_indefinite_model_is_said_to_be_so(run, here, two_link):
    form = ExactForm(two_link)
    kept = {t: c for t, c in form.energies.items() if (t.i, t.j) != (0, 0) or t.monomial}
    save_model(model_of(form, ENERGY, kept), here / "indefinite.json")
    assert "D is not positive definite: it has an eigenvalue of -0.5" in " ".join(
        run("certify", "indefinite.json").out.split()
    )


def test_effort_reaches_the_proof_of_definiteness(run, here, puma):
    save_model(exact_model(puma), here / "puma.json")
    little, more = (
        run("certify", "puma.json", "--effort", effort, "--json").json["positive_definite"]
        for effort in ("2000", "500000")
    )
    assert little["smallest_eigenvalue_at_least"] < more["smallest_eigenvalue_at_least"]
    assert more["smallest_eigenvalue_at_least"] <= more["smallest_eigenvalue_found"]


def test_along_another_motion_what_was_sampled_elsewhere_is_called_promised(run, dropped):
    own, other = (
        run("certify", dropped, "--along", motion).out for motion in ("pick-and-place", "large-slew")
    )
    assert " sampled  certified" in own
    assert "Sampled: over the states the model was made for. " in " ".join(own.split())
    assert " promised  certified" in other
    assert "Promised: over the states the model was made for, not here. " in " ".join(other.split())


def test_no_positive_energy_is_claimed_of_an_arm_whose_inertias_no_body_has(run, here):
    """D_22 = zz + 1/4: definite along the motion, where q2 stays near a right angle, and not at q2 = 0."""
    limits = "a = 1.0\nrange = [-3.0, 3.0]\nrate_limit = 5.0\nacceleration_limit = 9.0"
    (here / "own.toml").write_text(ARM.replace("a = 1.0", limits).replace("zz = 0.1", "zz = -0.2"))
    rows = [f"{0.1 * k},{0.02 * k * k},{1.57 + 0.01 * k}" for k in range(9)]
    (here / "x.csv").write_text(csv(*rows))
    done = run("own.toml", "x.csv", "--level", "energy", "--out", "r", "--format", "html,json")
    assert done.code == 0
    assert "the inertia of link 2 is physically inconsistent" in done.err
    page = (here / "r" / "report.html").read_text(encoding="utf-8")
    assert page.count("the inertia of link 2 is physically inconsistent") == 2
    assert "not claimed here" in page
    for sentence in re.findall(r"[^.>]*positive definite[^.]*\.", page):
        assert "not claimed here" in sentence, sentence
    assert "stays a mechanical system" not in page
    said = " ".join(run("certify", "r/model.json").out.split())
    assert "D is not positive definite: it has an eigenvalue of -" in said
    assert "D is positive definite" not in said
