"""Model files with budgets that are the larger of several, and of arms with drives."""

from __future__ import annotations

import json

import numpy as np
import pytest
from changed_files import changed, refused

import gd_analyze as gd
from gd_analyze.motions.states import States, states_of
from gd_analyze.simplification.model_checks import measured_at
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact

BUDGETS = [
    "1% or 10% friction",
    "1% or uncertainty",
    "0.5% limit or 0.01 N m, 1%, 1%, 1%, uncertainty, friction",
]


@pytest.fixture(scope="module")
def made(puma, pick_and_place):
    def make(budget: str, name: str | None = None) -> gd.SimplifiedModel:
        states = states_of(pick_and_place)
        if name is not None:
            own = {"trajectory": name, "trajectory_fingerprint": "0" * 64}
            states = States(*states.arrays, {**states.described, **own})
        exact = gd.ExactDynamics.of(puma, states)
        return simplify_exact(exact, budget, SearchOptions(thorough=False, write=False))

    return make


@pytest.mark.parametrize("budget", BUDGETS)
@pytest.mark.parametrize("name", [None, "my-own"])
def test_they_are_read_back(made, tmp_path, budget, name):
    model = made(budget, name)
    gd.save_model(model, tmp_path / "model.json")
    again = gd.load_model(tmp_path / "model.json")
    assert again.accuracy.budget == model.accuracy.budget == budget
    assert again.accuracy.measured == (name is None)
    assert again.drives
    np.testing.assert_array_equal(again.accuracy.allowed, model.accuracy.allowed)
    np.testing.assert_array_equal(again.accuracy.uncertainty, model.accuracy.uncertainty)
    assert again.arm.drives == model.arm.drives
    assert again.notice == model.notice


@pytest.mark.parametrize(
    "change",
    [
        lambda d: d.__setitem__("budget", "1% or 20% friction"),
        lambda d: d["errors"][0].__setitem__("allowed_error", 100.0),
        lambda d: d["arm"]["drives"][0].__setitem__("coulomb", [1.0, -1.0]),
        lambda d: d["arm"]["drives"][0].__setitem__("gear_ratio", 1.0),
        lambda d: d["arm"]["drives"][0].__setitem__("inertia", 0.5),
        lambda d: d["arm"].__setitem__("drives", []),
    ],
    ids=["budget", "allowed", "friction", "ratio", "inertia", "no drives"],
)
def test_what_does_not_come_to_the_allowed_error_is_refused(made, tmp_path, change):
    refused(made("1% or 10% friction", "my-own"), tmp_path / "model.json", change)


def test_the_uncertainty_is_measured_again(made, tmp_path, pick_and_place):
    def lie(document):
        for row in document["errors"]:
            row["uncertainty"] *= 2.0
            row["allowed_error"] *= 2.0

    path = tmp_path / "model.json"
    refused(made("uncertainty"), path, lie)
    stated = gd.load_model(changed(made("uncertainty", "my-own"), path, lie))
    assert not stated.accuracy.measured
    with pytest.raises(gd.GdAnalyzeError, match="cannot be") as caught:
        measured_at(stated, states_of(pick_and_place))
    assert "uncertainty of joint 1" in caught.value.details["where"]


def test_files_of_before_are_read(made, tmp_path):
    """They state no uncertainty, and of the drives their inertia alone."""
    path = tmp_path / "model.json"

    def as_before(document):
        del document["arm"]["drives"]
        for row in document["errors"]:
            del row["uncertainty"]

    for name in (None, "my-own"):
        again = gd.load_model(changed(made("1%", name), path, as_before))
        assert again.accuracy.measured == (name is None)
        assert (again.accuracy.uncertainty is None) == (name is not None)
        assert [drive.inertia for drive in again.arm.drives] == [d.inertia for d in made("1%").arm.drives]


def test_the_file_says_whether_drives_are_included(puma, pick_and_place, tmp_path):
    for drives in (True, False):
        gd.save_model(gd.simplify(puma, pick_and_place, "10%", drives=drives), tmp_path / "model.json")
        assert json.loads((tmp_path / "model.json").read_text("utf-8"))["drives"] is drives
