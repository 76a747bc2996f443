"""What a file states of its model: made again where that is cheap, and never contradicting itself."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path
from typing import Any

import pytest
from changed_files import Document, changed, refused

from gd_analyze.errors import ModelError
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_checks import measured_at
from gd_analyze.simplification.model_file import load_model, save_model
from gd_analyze.simplification.simplify import simplify


@pytest.fixture(scope="module")
def shipped(two_link, swing) -> SimplifiedModel:
    """Made for a shipped trajectory, at which errors can be measured again."""
    return simplify(two_link, swing, Budget.parse("40%"))


@pytest.fixture(scope="module")
def own(two_link, swing) -> SimplifiedModel:
    """Made for a trajectory that only its maker has."""
    known = states_of(swing)
    described = dict(known.described) | {"trajectory": "my-own", "trajectory_fingerprint": "0" * 64}
    return simplify(two_link, States(*known.arrays, described), Budget.parse("40%"))


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "model.json"


def scale(document: Document, joint: int, **factors: float) -> None:
    for name, factor in factors.items():
        document["errors"][joint][name] *= factor


def put(document: Document, joint: int, **values: Any) -> None:
    document["errors"][joint].update(values)


SELF_CONTRADICTING = {
    "a negative error": lambda d: put(d, 0, largest_error=-1e-3, rms_error=-1e-3),
    "a negative root mean square": lambda d: put(d, 1, rms_error=-1e-9),
    "a negative peak": lambda d: put(d, 1, peak_torque=-1.0),
    "a root mean square above the largest": lambda d: put(d, 1, largest_error=1e-6, rms_error=1e-5),
    "a largest error above the allowed": lambda d: scale(d, 0, allowed_error=1.0, largest_error=1e3),
    "allowed what the budget does not": lambda d: scale(d, 0, allowed_error=1e6),
    "a peak that the budget is no share of": lambda d: scale(d, 0, peak_torque=1e9),
    "another budget": lambda d: d.__setitem__("budget", "50%"),
    "a budget of words": lambda d: d.__setitem__("budget", "as agreed"),
    "not finite": lambda d: put(d, 0, rms_error=float("nan")),
    "errors too few": lambda d: d["errors"].pop(),
    "errors too many": lambda d: d["errors"].append(d["errors"][0]),
    "no errors": lambda d: d.__setitem__("errors", []),
    "errors of other joints": lambda d: d["errors"].reverse(),
    "fewer operations": lambda d: d["operations"].__setitem__("additions", 1),
    "a changed mass": lambda d: d["arm"]["links"][0].__setitem__("mass", 3.0),
    "a changed centre of mass": lambda d: d["arm"]["links"][1]["com"].__setitem__(0, 0.1),
    "changed gravity": lambda d: d["arm"]["gravity"].__setitem__(1, -1.6),
    "another arm's fingerprint": lambda d: d.__setitem__("arm_fingerprint", "0" * 64),
    "states of nothing": lambda d: d.__setitem__("fitted_on", {"moon": "full"}),
}


@pytest.mark.parametrize("change", SELF_CONTRADICTING.values(), ids=SELF_CONTRADICTING.keys())
def test_a_contradiction_is_refused(own, path, change):
    refused(own, path, change)


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize(
    "change",
    [
        lambda d, k: scale(d, k, largest_error=0.5, rms_error=0.5),
        lambda d, k: scale(d, k, peak_torque=1e9, allowed_error=1e9),
        lambda d, k: scale(d, k, rms_error=0.9),
    ],
    ids=["understated", "a peak of 1e9", "another root mean square"],
)
def test_errors_are_measured_again_where_the_states_are_at_hand(two_link, shipped, path, change, joint):
    drawn = simplify(two_link, states_in_box(two_link, 300, 5), Budget.parse("40%"))
    for model in (shipped, drawn):
        assert (model.accuracy.errors.rms > 0.0).all()
        error = refused(model, path, lambda document: change(document, joint))
        assert f"joint {joint + 1}" in error.details["where"]
        assert "measured at" in error.details["expected"]


def test_whether_they_could_be_is_known(two_link, shipped, own, path):
    drawn = simplify(two_link, states_in_box(two_link, 300, 5), Budget.parse("40%"))
    for model, measured in ((shipped, True), (drawn, True), (own, False)):
        assert model.accuracy.measured
        save_model(model, path)
        assert load_model(path).accuracy.measured == measured


def test_states_of_no_name_can_be_stored(two_link, path):
    states = states_in_box(two_link, 50)
    save_model(simplify(two_link, States(*states.arrays), Budget.parse("40%")), path)
    again = load_model(path)
    assert again.accuracy.fitted_on == {}
    assert not again.accuracy.measured


def test_at_hand_they_are_measured(own, path, swing):
    """A consistent lie is a statement of the file until the states are there."""
    lie = changed(own, path, lambda d: scale(d, 0, peak_torque=1e9, allowed_error=1e9))
    stated = load_model(lie)
    assert not stated.accuracy.measured
    with pytest.raises(ModelError, match="cannot be") as caught:
        measured_at(stated, states_of(swing))
    assert "peak_torque of joint 1" in caught.value.details["where"]
    save_model(own, path)
    assert measured_at(load_model(path), states_of(swing)).accuracy.measured


def test_a_trajectory_is_looked_for_by_name_only_among_those_shipped(own, path, here_file):
    """No file and no standard input is read because a model names it."""
    for name in ("-", "/dev/zero", str(here_file)):
        given = changed(own, path, lambda d, name=name: d["fitted_on"].__setitem__("trajectory", name))
        assert not load_model(given).accuracy.measured


@pytest.fixture
def here_file(tmp_path) -> Path:
    file = tmp_path / "motion.csv"
    file.write_text("this would be refused\n", encoding="utf-8")
    return file


def test_loading_warns_of_nothing(two_link, swing, path):
    """Not even of limits that the trajectory breaks: whoever loads a model did not name the trajectory."""
    slow = dataclasses.replace(
        two_link, joints=tuple(dataclasses.replace(joint, velocity_limit=1e-3) for joint in two_link.joints)
    )
    save_model(simplify(slow, states_of(swing), Budget.parse("40%")), path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert load_model(path).accuracy.measured
