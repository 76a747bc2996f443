"""`gd-analyze certify`: the bound it prints, and what it refuses."""

from __future__ import annotations

import pytest


@pytest.fixture
def model(run, here):
    assert run("simplify", "two_link", "--budget", "5%", "--level", "energy", "-o", "model.json").code == 0
    return here / "model.json"


def test_it_states_the_bound(run, model):
    result = run("certify", model, "--seconds", "0.1")
    assert (result.code, result.err) == (0, "")
    assert "No state within the limits of Two-link planar arm" in " ".join(result.out.split())
    assert max(map(len, result.out.splitlines())) <= 80


def test_json_holds_the_same(run, model):
    document = run("certify", model, "--seconds", "0.1", "--json").json
    assert document["arm"] == "two_link"
    assert len(document["box"]["lower"]) == 2
    for joint in document["joints"]:
        assert joint["sampled"] <= joint["certified"]
        assert joint["worst_found"] <= joint["certified"]


def test_quiet_prints_nothing(run, model):
    result = run("certify", model, "--seconds", "0", "--quiet")
    assert (result.code, result.out, result.err) == (0, "", "")


def test_an_element_level_model_is_refused(run, here):
    assert run("two_link", "two-link-swing", "--format", "json", "--out", "r", "--quiet").code == 0
    result = run("certify", here / "r" / "model.json")
    assert result.code == 2
    assert "has no harmonic terms" in result.err
    assert "gd-analyze simplify" in result.err
    assert "Traceback" not in result.err


def test_a_missing_model_is_refused(run):
    result = run("certify", "nowhere.json")
    assert result.code == 2
    assert "nowhere.json" in result.err
