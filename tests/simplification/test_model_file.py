"""Model files: exact round trip; damaged, foreign and edited files are refused with a way out."""

from __future__ import annotations

import dataclasses
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from changed_files import Document, Steps, changed, refused
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import ModelError
from gd_analyze.motions.states import States, states_in_box, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.simplification import model_file
from gd_analyze.simplification.effort import COUNTING, ROUGH, THOROUGH
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.simplification.levels import LEVELS, SearchOptions
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_checks import measured_at, require_terms_computed
from gd_analyze.simplification.model_file import load_model, save_model
from gd_analyze.simplification.simplify import simplify_exact
from made_models import assert_same, exact_model, model_of
from strategies import arms, arms_with_states, examples


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "model.json"


@pytest.fixture(scope="module")
def shipped(two_link, swing) -> SimplifiedModel:
    """Made for a shipped trajectory, at which errors can be measured again."""
    return gd.simplify(two_link, swing, "40%", level="term", refit=True)


@pytest.fixture(scope="module")
def own(two_link, swing) -> SimplifiedModel:
    """Made for a trajectory that only its maker has."""
    return gd.simplify(two_link, unknown(swing), "40%")


@pytest.fixture(scope="module")
def energies(two_link) -> SimplifiedModel:
    return exact_model(two_link, level=ENERGY)


def unknown(motion: Trajectory) -> States:
    known = states_of(motion)
    mine = {"trajectory": "my-own", "trajectory_fingerprint": "0" * 64}
    return States(*known.arrays, {**known.described, **mine})


@examples(7)
@given(arms_with_states(max_joints=4), st.sampled_from(list(LEVELS.values())))
def test_round_trip_of_any_arm_is_exact(tmp_path_factory, case, level):
    arm, states = case
    model = exact_model(arm, level=level)
    path = tmp_path_factory.mktemp("model") / "model.json"
    save_model(model, path)
    assert_same(model, load_model(path), states)


def test_a_searched_one_comes_back(shipped, path, swing):
    save_model(shipped, path)
    again = load_model(path)
    assert_same(shipped, again, states_of(swing))
    assert shipped.refitted
    assert again.accuracy.steps == shipped.accuracy.steps != ()
    assert again.accuracy.search == shipped.accuracy.search


def of_puma(motion, budget: str) -> SimplifiedModel:
    exact = gd.ExactDynamics.of("puma560", motion)
    return simplify_exact(exact, budget, SearchOptions(thorough=False, write=False))


@pytest.mark.parametrize(
    ("budget", "is_shipped"),
    [("1% or 10% friction", True), ("0.5% limit or 0.01 N m, 1%, 1%, 1%, uncertainty, friction", False)],
)
def test_budgets_are_read_back(pick_and_place, path, budget, is_shipped):
    model = of_puma(pick_and_place if is_shipped else unknown(pick_and_place), budget)
    save_model(model, path)
    again = load_model(path)
    assert again.accuracy.budget == model.accuracy.budget == budget
    assert again.accuracy.measured == is_shipped
    np.testing.assert_array_equal(again.accuracy.allowed, model.accuracy.allowed)
    np.testing.assert_array_equal(again.accuracy.uncertainty, model.accuracy.uncertainty)
    assert again.arm.drives == model.arm.drives
    assert (again.drives, again.notice) == (True, model.notice)


FOREIGN = {
    "empty": "",
    "truncated": '{"format": "gd-analyze simplified model", "version": 3,',
    "byte order mark": '\ufeff{"format": "gd-analyze simplified model"}',
    "list": "[]",
    "other format": '{"format": "gd-analyze results"}',
    "other version": '{"format": "gd-analyze simplified model", "version": 2}',
    "nested beyond reason": "[" * 100_000,
    "thousands of digits": f'{{"format": {"9" * 5000}}}',
    "binary": bytes(range(256)),
    "a pickle": pickle.dumps(Path),
}


def refused_as_it_is(path: Path) -> ModelError:
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


@pytest.mark.parametrize("content", FOREIGN.values(), ids=FOREIGN.keys())
def test_foreign(path, content):
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    error = refused_as_it_is(path)
    assert "JSON" not in error.what or "line 1, column" in error.details["where"]


def test_missing_file_folder_and_a_file_too_large(tmp_path, monkeypatch):
    assert refused_as_it_is(tmp_path / "none.json").what == "cannot read the model file"
    assert refused_as_it_is(tmp_path).what == "cannot read the model file"
    monkeypatch.setattr(model_file, "LARGEST_FILE", 1000)
    assert refused_as_it_is(Path("/dev/zero")).details["found"].startswith("a file of more than")


@pytest.mark.parametrize(
    "edit",
    [lambda d: d["terms"].pop(), lambda d: d["errors"][1].__setitem__("largest_error", 1e-9)],
    ids=["terms", "smaller error"],
)
def test_edited_without_a_new_digest(shipped, path, edit):
    save_model(shipped, path)
    document = json.loads(path.read_text(encoding="utf-8"))
    edit(document)
    path.write_text(json.dumps(document), encoding="utf-8")
    refused_as_it_is(path)


def scale(joint: int, **factors: float) -> Callable[[Document], None]:
    def change(document: Document) -> None:
        for name, factor in factors.items():
            document["errors"][joint][name] *= factor

    return change


def at(place: str, value: Any) -> Callable[[Document], None]:
    """Another value at a place such as "arm links 1 mass"."""

    def change(document: Document) -> None:
        *way, last = (int(key) if key.isdigit() else key for key in place.split())
        inner: Any = document
        for key in way:
            inner = inner[key]
        inner[last] = value

    return change


def constant(place: int, value: Any) -> Callable[[Document], None]:
    """Another word in the first step that multiplies by a constant."""

    def change(document: Document) -> None:
        steps = (step for step in document["steps"] if step[0] == "multiply")
        next(step for step in steps if any(isinstance(x, float) for x in step))[place] = value

    return change


def cosine(*multiples: int, power: int = 1, kind: str = "cos") -> Callable[[Document], None]:
    def change(document: Document) -> None:
        next(term for term in document["terms"] if term["i"] >= 0)["factors"] = [[kind, multiples, power]]

    return change


# Each change fits the types, or nearly, and the digest is set right again.
CONTRADICTIONS = {
    "a term less": lambda d: d["terms"].pop(),
    "a term of another level": at("terms 0", {"part": "D11 rotation"}),
    "another level": at("level", "element"),
    "no level": at("level", None),
    "a key less": lambda d: d.pop("budget"),
    "a key more": at("colour", "red"),
    "a negative mass": at("arm links 1 mass", -1.0),
    "a mass of words": at("arm links 1 mass", "heavy"),
    "a link less": lambda d: d["arm"]["links"].pop(),
    "a joint with a key more": at("arm joints 0 colour", "red"),
    "an arm of another shape": at("arm", {"links": 3}),
    "a skewed rotation": at("arm links 0 frame rotation 0 0", 2.0),
    "drives of an arm without": at("drives", True),
    "a negative error": scale(0, largest_error=-1.0, rms_error=-1.0),
    "a negative peak": at("errors 1 peak_torque", -1.0),
    "a root mean square above the largest": scale(1, rms_error=1e3),
    "a largest error above the allowed": scale(0, largest_error=1e3),
    "allowed what the budget does not": scale(0, allowed_error=1e6),
    "a peak that the budget is no share of": scale(0, peak_torque=1e9),
    "a budget of words": at("budget", "as agreed"),
    "not finite": at("errors 0 rms_error", float("nan")),
    "errors too few": lambda d: d["errors"].pop(),
    "errors of other joints": lambda d: d["errors"].reverse(),
    "fewer operations": at("operations additions", 1),
    "changed gravity": at("arm gravity 1", -1.6),
    "another arm's fingerprint": at("arm_fingerprint", "0" * 64),
    "states of nothing": at("fitted_on", {"moon": "full"}),
    "a term twice": lambda d: d["terms"].append(d["terms"][0]),
    "another row": at("terms 0 row", 2),
    "velocity of another joint": at("terms 0 velocities", [[2, 2]]),
    "velocities out of order": at("terms 0 velocities", [[1, 1], [1, 0]]),
    "a jerk": at("terms 0 velocities", [[3, 0]]),
    "weight infinite": at("terms 0 weight", float("inf")),
    "weight beyond all masses": at("terms 0 weight", 1.7976931348623157e308),
    "factors no list": at("terms 0 factors", "C2"),
    "a constant changed": constant(1, 0.123),
    "a constant beyond all masses": constant(1, 1.5e308),
    "code": constant(0, "__import__"),
    "a later step": constant(2, "s999"),
    "a step before all": constant(2, "s-1"),
    "an empty step": lambda d: d["steps"].append([]),
    "a step twice": lambda d: d["steps"].append(d["steps"][-1]),
    "an unknown input": at("steps 0", ["input", "q7"]),
    "an output less": lambda d: d["outputs"].pop(),
    "outputs exchanged": lambda d: d["outputs"].reverse(),
    "no steps": at("steps", []),
}
OF_ENERGY = {
    "another joint": at("terms 0 i", 6),
    "below the diagonal": at("terms 0 j", -1),
    "another coefficient": at("terms 0 coefficient", 0.123),
    "unknown kind": cosine(0, 1, kind="tan"),
    "too few multiples": cosine(1),
    "of nothing": cosine(0, 0),
    "beyond the degree": cosine(0, 3),
    "an endless sum": cosine(0, 10**12),
    "a high power": cosine(0, 1, power=3),
    "a turning joint's variable": cosine(0, 1, kind="power"),
}


@pytest.mark.parametrize("change", CONTRADICTIONS.values(), ids=CONTRADICTIONS.keys())
def test_a_contradiction_is_refused(own, path, change):
    refused(own, path, change)


@pytest.mark.parametrize("change", OF_ENERGY.values(), ids=OF_ENERGY.keys())
def test_impossible_energy_terms(energies, path, change):
    refused(energies, path, change)


@pytest.mark.parametrize(
    "change",
    [at("budget", "1% or 20% friction"), at("arm drives 0 coulomb", [1.0, -1.0]), at("arm drives", [])],
    ids=["budget", "friction", "no drives"],
)
def test_what_does_not_come_to_the_allowed_error_is_refused(pick_and_place, path, change):
    refused(of_puma(unknown(pick_and_place), "1% or 10% friction"), path, change)


@pytest.mark.parametrize("joint", [0, 1])
@pytest.mark.parametrize(
    "factors",
    [
        {"largest_error": 0.5, "rms_error": 0.5},
        {"peak_torque": 1e9, "allowed_error": 1e9},
        {"rms_error": 0.9},
    ],
    ids=["understated", "a peak of 1e9", "another root mean square"],
)
def test_errors_are_measured_again_where_the_states_are_at_hand(two_link, shipped, path, factors, joint):
    for model in (shipped, gd.simplify(two_link, states_in_box(two_link, 300, 5), "40%")):
        error = refused(model, path, scale(joint, **factors))
        assert f"joint {joint + 1}" in error.details["where"]
        assert "measured at" in error.details["expected"]


def test_a_consistent_lie_is_a_statement_until_the_states_are_there(own, path, swing):
    stated = load_model(changed(own, path, scale(0, peak_torque=1e9, allowed_error=1e9)))
    assert not stated.accuracy.measured
    with pytest.raises(ModelError, match="cannot be") as caught:
        measured_at(stated, states_of(swing))
    assert "peak_torque of joint 1" in caught.value.details["where"]
    save_model(own, path)
    assert measured_at(load_model(path), states_of(swing)).accuracy.measured


def test_the_uncertainty_is_measured_again(pick_and_place, path):
    def lie(document: Document) -> None:
        for joint in range(6):
            scale(joint, uncertainty=2.0, allowed_error=2.0)(document)

    error = refused(of_puma(pick_and_place, "uncertainty"), path, lie)
    assert "uncertainty of joint 1" in error.details["where"]


def test_a_trajectory_is_looked_for_by_name_only_among_those_shipped(own, path, tmp_path):
    """No file and no standard input is read because a model names it."""
    motion = tmp_path / "motion.csv"
    motion.write_text("this would be refused\n", encoding="utf-8")
    for name in ("-", "/dev/zero", str(motion)):
        assert not load_model(changed(own, path, at("fitted_on trajectory", name))).accuracy.measured


def test_names_are_names(energies, path):
    arm = dataclasses.replace(energies.arm, name="__import__('os').system('false')")
    form = ExactForm(arm, energies.drives)
    save_model(dataclasses.replace(energies, form=form, provenance={"py/object": "os.system"}), path)
    assert load_model(path).arm.name == arm.name


@pytest.fixture(scope="module", params=LEVELS)
def of_level(request, two_link) -> SimplifiedModel:
    return exact_model(two_link, level=LEVELS[request.param])


def a_high_power(document: Document) -> None:
    step = Steps(document)
    x = step("input", "q1")
    for _ in range(12):
        x = step("multiply", x, x)
    step.add_to_output(x)


def nothing_at_known_states(document: Document) -> None:
    """What the first output is off by is zero at the states of a seed, and large elsewhere."""
    step = Steps(document)
    product: str | float = 1.0
    for known in np.random.default_rng(0).uniform(-1.0, 1.0, (3, 5, 2))[0, :, 1]:
        product = step("multiply", product, step("subtract", step("input", "q2"), float(known)))
    step.add_to_output(product)


def a_small_term(document: Document) -> None:
    step = Steps(document)
    step.add_to_output(step("multiply", 1e-5, step("sin", step("input", "q1"))))


def a_term_lost_in_rounding(document: Document) -> None:
    """1e20 cos q1 - (1e20 cos q1 - 1e-3): what is left is rounded away."""
    step = Steps(document)
    large = step("multiply", 1e20, step("cos", step("input", "q1")))
    step.add_to_output(step("subtract", large, step("subtract", large, 1e-3)))


def an_overflow(document: Document) -> None:
    step = Steps(document)
    x = step("cos", step("input", "q1"))
    for _ in range(4):
        x = step("multiply", 1e99, x)
    step.add_to_output(x)


ELSE = [a_high_power, nothing_at_known_states, a_small_term, a_term_lost_in_rounding, an_overflow]


@pytest.mark.parametrize("change", ELSE)
def test_what_computes_anything_else_is_refused(of_level, tmp_path, change):
    error = refused(of_level, tmp_path / "model.json", change)
    assert error.what in (
        "the program does not compute the terms",
        "the program computes no torque of an arm: it uses an angle outside of sines and cosines",
        "the program computes no torque of an arm: its numbers overflow",
    )


def test_what_is_zero_everywhere_may_be_added(of_level, tmp_path: Path) -> None:
    """c (sin^2 + cos^2 - 1) is nothing, however it is written."""

    def change(document: Document) -> None:
        step = Steps(document)
        squares = [
            step("multiply", x, x) for x in (step(kind, step("input", "q1")) for kind in ("sin", "cos"))
        ]
        nothing = step("subtract", step("add", *squares), 1.0)
        step.add_to_output(step("multiply", 1e-6, nothing))

    again = load_model(changed(of_level, tmp_path / "model.json", change))
    assert again.operations.total > of_level.operations.total


@examples(12)
@given(
    arms(max_joints=4),
    st.sampled_from([LEVELS["term"], LEVELS["energy"]]),
    st.sampled_from([ROUGH, COUNTING, THOROUGH]),
    st.integers(0, 2**32 - 1),
)
def test_what_the_tool_writes_fits_however_it_is_written(arm, level, effort, seed):
    random = np.random.default_rng(seed)
    form = ExactForm(arm)
    kept = {term: number for term, number in level.terms(form).items() if random.random() < 0.8}
    require_terms_computed(model_of(form, level, kept, effort))
