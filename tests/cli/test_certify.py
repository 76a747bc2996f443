"""`gd-analyze certify`: its bounds as text and JSON, and what it refuses."""

from __future__ import annotations

import json

import numpy as np
import pytest
from bad_files import ARM, csv

from gd_analyze.certification.certificate import EFFORT
from gd_analyze.cli.certify import certify
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.simplification.model_file import _digest, save_model
from gd_analyze.text import rounded_up
from made_models import exact_model, model_of

ALONG = ("--along", "pick-and-place")


@pytest.fixture
def model(run, here):
    assert run("simplify", "two_link", "--budget", "5%", "--level", "energy", "-o", "model.json").code == 0
    return here / "model.json"


@pytest.fixture
def dropped(run, here):
    """A model that leaves something out, so that its bound is more than round-off."""
    assert run("simplify", "puma560", "pick-and-place", "--effort", "0.1", "-o", "puma.json").code == 0
    return here / "puma.json"


def test_over_the_arms_limits(run, model):
    result = run("certify", model)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    document = run("certify", model, "--effort", "1000", "--json").json
    assert (document["arm"], document["effort"]) == ("two_link", 1000)
    assert document["allowed_and_largest_error"] == "measured"
    assert len(document["box"]["lower"]) == 2
    proven = 0
    for joint in document["joints"]:
        assert max(joint["largest_error"], joint["worst_found"]) <= joint["certified"]
        assert joint["within_allowed"] == (joint["certified"] <= joint["allowed_error"])
        assert [len(joint["worst_state"][name]) for name in ("q", "qd", "qdd")] == [2, 2, 2]
        for share, whole in (
            ("certified_share_of_largest_found", joint["largest_torque_found"]),
            ("certified_of_allowed", joint["allowed_error"]),
        ):
            assert joint[share] == pytest.approx(joint["certified"] / whole, rel=1e-12)
        proven += joint["within_allowed"]
    assert f"{proven} of 2" in run("certify", model, "--effort", "1000").out
    definite = document["positive_definite"]
    assert definite["proven"]
    assert 0.0 < definite["smallest_eigenvalue_at_least"] <= definite["smallest_eigenvalue_found"]
    assert run("certify", model, "--effort", "1000", "--json").json == document
    quiet = run("certify", model, "--effort", "1", "--quiet")
    assert (quiet.code, quiet.out, quiet.err) == (0, "", "")
    assert {option.name: option.default for option in certify.params}["effort"] == EFFORT


def test_along_a_trajectory_and_between_its_extremes(run, dropped):
    document, whole, large = (
        run("certify", dropped, *words, "--json").json
        for words in (ALONG, (), (*ALONG, "--margin", "5deg,qd=10%"))
    )
    assert document["from"] == "1°, 2 % of peak velocity and 5 % of peak acceleration of pick-and-place"
    assert whole["tube"] is whole["positive_definite"] is None
    for inner, outer, wide in zip(document["joints"], whole["joints"], large["joints"], strict=True):
        assert 0.0 < inner["largest_error"] <= inner["certified"] < wide["certified"]
        assert inner["certified"] < inner["certified_between_extremes"] < outer["certified"]
        assert inner["certified_between_extremes"] == wide["certified_between_extremes"]
        assert 1.0 <= inner["ratio"] <= 1.1
    for name, sign in (("lower", 1), ("upper", -1)):
        inside, limits = np.array(document["box"][name]), np.array(whole["box"][name])
        assert (sign * inside >= sign * limits).all()
    pieces = document["tube"]["pieces"]
    assert (pieces[0]["begin"], pieces[-1]["end"]) == (0.0, 2.4)
    largest = np.max([piece["certified"] for piece in pieces], axis=0).tolist()
    assert largest == [joint["certified"] for joint in document["joints"]]
    assert large["tube"]["margins"]["q"] == pytest.approx([np.radians(5.0)] * 6)
    result = run("certify", dropped, *ALONG)
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    assert "2 of 30 intervals" in " ".join(result.out.split())


@pytest.mark.parametrize("digits", [2, 3])
def test_a_bound_is_never_shown_smaller_than_it_is(digits):
    for value in (0.0, 1.0, 0.1, 0.12301, 99.95, 1.2e-9, *np.random.default_rng(0).lognormal(0, 5, 200)):
        shown = rounded_up(float(value), digits)
        # The number printed is the decimal one; as a float it is half an eps away.
        assert value * (1 - 1e-15) <= shown <= value * (1 + 10.0 ** (1 - digits))
        assert float(f"{shown:.{digits}g}") == shown


def test_an_element_level_model_is_certified_too(run):
    words = ("simplify", "two_link", "two-link-swing", "--level", "element", "-o", "element.json", "--quiet")
    assert run(*words).code == 0
    for joint in run("certify", "element.json", "--along", "two-link-swing", "--json").json["joints"]:
        assert joint["largest_error"] <= joint["certified"] <= joint["allowed_error"]


@pytest.mark.parametrize(
    ("words", "named"),
    [
        (("--effort", "0"), "--effort"),
        (("--along", "pick-and-place"), "pick-and-place"),
        (("--margin", "1deg"), "--along"),
        (("--along", "two-link-swing", "--margin", "much"), "--margin, entry 1"),
    ],
)
def test_bad_options_are_refused(run, model, words, named):
    result = run("certify", model, *words)
    assert result.code == 2
    assert named in result.err
    assert "Traceback" not in result.err


def edited(model, change):
    document = json.loads(model.read_text(encoding="utf-8"))
    change(document)
    document["digest"] = _digest(document)
    model.write_text(json.dumps(document), encoding="utf-8")
    return model


def test_figures_that_only_the_file_states_are_told_apart(run, model):
    """A peak of 1e9 N m, for a trajectory that nobody else has: consistent, and not to be measured again."""

    def lie(document):
        document["fitted_on"] = {"trajectory": "mine", "trajectory_fingerprint": "0" * 64, "set_points": 9}
        for row in document["errors"]:
            row["peak_torque"], row["allowed_error"] = 1e9, 0.05e9

    honest = run("certify", model, "--json").json
    document = run("certify", edited(model, lie), "--json").json
    assert document["allowed_and_largest_error"] == "stated by the file"
    assert "of mine" in " ".join(document["notices"])
    # A share of a peak of 1e9 N m would be none.
    assert " N m " in document["headline"]
    for here, before in zip(document["joints"], honest["joints"], strict=True):
        for name in ("certified", "certified_share_of_largest_found", "largest_torque_found"):
            assert here[name] == before[name]


def test_the_trajectory_given_measures_what_is_stated(run, here):
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


@pytest.mark.parametrize(
    ("kept", "verdict"),
    [
        (lambda t: 1 not in (t.i, t.j), "singular"),
        (lambda t: (t.i, t.j) != (0, 0) or t.monomial, "not positive definite"),
    ],
)
def test_models_without_positive_energy_are_named(run, here, two_link, kept, verdict):
    form = ExactForm(two_link)
    energies = {t: c for t, c in form.energies.items() if kept(t)}
    save_model(model_of(form, ENERGY, energies), here / "model.json")
    result = run("certify", "model.json")
    assert result.code == 0, result.err
    assert verdict in " ".join(result.out.split())
    document = run("certify", "model.json", "--json").json["positive_definite"]
    assert document["singular"] == (verdict == "singular")
    assert not document["proven"]


def test_no_positive_energy_is_claimed_of_an_arm_with_physically_inconsistent_inertias(run, here):
    """D_22 = zz + 1/4: definite along the motion, where q2 stays near a right angle, and not at q2 = 0."""
    limits = "a = 1.0\nrange = [-3.0, 3.0]\nvelocity_limit = 5.0\nacceleration_limit = 9.0"
    (here / "own.toml").write_text(ARM.replace("a = 1.0", limits).replace("zz = 0.1", "zz = -0.2"))
    (here / "x.csv").write_text(csv(*(f"{0.1 * k},{0.02 * k * k},{1.57 + 0.01 * k}" for k in range(9))))
    done = run("own.toml", "x.csv", "--level", "energy", "--out", "r", "--format", "html,json")
    assert done.code == 0, done.err
    assert "inertia of link 2 is physically inconsistent" in done.err
    page = (here / "r" / "report.html").read_text(encoding="utf-8")
    assert "inertia of link 2 is physically inconsistent" in page
    assert "positive definite" not in page
    document = run("certify", "r/model.json", "--json").json["positive_definite"]
    assert not document["proven"]
    assert document["smallest_eigenvalue_found"] < 0.0
    said = " ".join(run("certify", "r/model.json").out.split())
    assert "not positive definite" in said
    assert said.count("positive definite") == said.count("not positive definite")


def test_effort_reaches_the_proof_of_definiteness(run, here, puma):
    save_model(exact_model(puma), here / "puma.json")
    little, more = (
        run("certify", "puma.json", "--effort", effort, "--json").json["positive_definite"]
        for effort in ("2000", "500000")
    )
    assert little["smallest_eigenvalue_at_least"] < more["smallest_eigenvalue_at_least"]
    assert more["smallest_eigenvalue_at_least"] <= more["smallest_eigenvalue_found"]
