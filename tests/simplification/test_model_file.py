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
from gd_analyze.simplification import model_file
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.effort import COUNTING, ROUGH, THOROUGH
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.harmonic import ENERGY
from gd_analyze.simplification.levels import LEVELS, SearchOptions
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_checks import measured_at, require_terms_computed
from gd_analyze.simplification.model_file import load_model, save_model
from gd_analyze.simplification.simplify import simplify, simplify_exact
from made_models import assert_same, by_elements, exact_model, model_of
from strategies import arms, arms_with_states, examples


@pytest.fixture(scope="module")
def model(puma, pick_and_place) -> SimplifiedModel:
    return by_elements(puma, pick_and_place, drives=True)


@pytest.fixture(scope="module")
def written(model, tmp_path_factory) -> str:
    path = tmp_path_factory.mktemp("model") / "model.json"
    save_model(model, path)
    return path.read_text(encoding="utf-8")


@pytest.fixture
def file(tmp_path: Path) -> Callable[[str | bytes], Path]:
    def write(content: str | bytes) -> Path:
        path = tmp_path / "model.json"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


def refused_path(path: Path) -> ModelError:
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


def test_what_the_search_did_is_kept(model, file, written):
    again = load_model(file(written)).accuracy
    assert again.steps == model.accuracy.steps != ()
    assert again.solved
    assert again.search == model.accuracy.search
    assert again.search.endswith(", optimum proven")


@examples(7)
@given(arms_with_states(max_joints=4), st.sampled_from(list(LEVELS.values())))
def test_round_trip_of_any_arm_is_exact(tmp_path_factory, case, level):
    arm, states = case
    model = exact_model(arm, level=level)
    path = tmp_path_factory.mktemp("model") / "model.json"
    save_model(model, path)
    assert_same(model, load_model(path), states)


FOREIGN = {
    "empty": ("", "not valid JSON"),
    "truncated": ('{"format": "gd-analyze simplified model", "version": 3,', "not valid JSON"),
    "toml": ('format = "gd-analyze arm 1"\n', "not valid JSON"),
    "byte order mark": ('\ufeff{"format": "gd-analyze simplified model"}', "not valid JSON"),
    "list": ("[]", "not a gd-analyze model"),
    "other format": ('{"format": "gd-analyze results"}', "not a gd-analyze model"),
    "nested beyond reason": ("[" * 100_000, "not a gd-analyze model"),
    "thousands of digits": (f'{{"format": {"9" * 5000}}}', "not a gd-analyze model"),
    "binary": (bytes(range(256)), "not a gd-analyze model"),
    "other version": ('{"format": "gd-analyze simplified model", "version": 2}', "another version"),
}


@pytest.mark.parametrize(("content", "what"), FOREIGN.values(), ids=FOREIGN.keys())
def test_foreign(file, content, what):
    error = refused_path(file(content))
    assert what in error.what
    assert what != "not valid JSON" or "line 1, column" in error.details["where"]


class Trap:
    """Would leave a trace if anything unpickled it."""

    sprung = False

    def __reduce__(self) -> tuple[Any, ...]:
        return (_spring, ())


def _spring() -> None:
    Trap.sprung = True


def test_loading_executes_nothing(file, written):
    payload = pickle.dumps(Trap())
    pickle.loads(payload)
    assert Trap.sprung  # the trap works
    Trap.sprung = False
    refused_path(file(payload))
    path = file(written)
    model = load_model(path)
    arm = dataclasses.replace(model.arm, name="__import__('os').system('false')")
    form = ExactForm(arm, model.drives)
    save_model(dataclasses.replace(model, form=form, provenance={"py/object": "os.system"}), path)
    assert load_model(path).arm.name == arm.name  # names are names
    assert not Trap.sprung


@pytest.mark.parametrize(
    "edit",
    [
        lambda d: d.__setitem__("digest", "0" * 64),
        lambda d: d["terms"].pop(),
        lambda d: d["arm"]["links"][1].__setitem__("mass", 17.5),
        lambda d: d["errors"][1].__setitem__("largest_error", 1e-9),
    ],
    ids=["digest", "terms", "mass", "smaller error"],
)
def test_edited_without_a_new_digest(file, written, edit):
    document = json.loads(written)
    edit(document)
    refused_path(file(json.dumps(document)))


@examples(30)
@given(st.data())
def test_any_truncation_is_refused(written, tmp_path_factory, data):
    raw = written.encode()
    end = data.draw(st.integers(0, len(raw) - 2))  # the last two bytes are the closing brace and a newline
    path = tmp_path_factory.mktemp("model") / "model.json"
    path.write_bytes(raw[:end])
    refused_path(path)


def test_missing_file_folder_and_a_file_too_large(file, written, tmp_path, monkeypatch):
    assert refused_path(tmp_path / "none.json").what == "cannot read the model file"
    assert refused_path(tmp_path).what == "cannot read the model file"
    monkeypatch.setattr(model_file, "LARGEST_FILE", len(written) - 1)
    assert refused_path(file(written)).details["found"].startswith("a file of more than")
    assert refused_path(Path("/dev/zero")).details["found"].startswith("a file of more than")


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
    "a term less": lambda d: d["terms"].pop(),
    "a term of another level": lambda d: d["terms"].__setitem__(0, {"part": "D11 rotation"}),
    "another level": lambda d: d.__setitem__("level", "element"),
    "no level": lambda d: d.__setitem__("level", None),
    "a key less": lambda d: d.pop("budget"),
    "a key more": lambda d: d.__setitem__("colour", "red"),
    "the search a sentence": lambda d: d.__setitem__("search", "integer program 1798"),
    "a negative mass": lambda d: d["arm"]["links"][1].__setitem__("mass", -1.0),
    "a mass that is no number": lambda d: d["arm"]["links"][1].__setitem__("mass", float("nan")),
    "a mass of words": lambda d: d["arm"]["links"][1].__setitem__("mass", "heavy"),
    "a link less": lambda d: d["arm"]["links"].pop(),
    "a joint with a key more": lambda d: d["arm"]["joints"][0].__setitem__("colour", "red"),
    "a joint with a key less": lambda d: d["arm"]["joints"][0].pop("name"),
    "an arm of another shape": lambda d: d.__setitem__("arm", {"links": 3}),
    "a skewed rotation": lambda d: d["arm"]["links"][0]["frame"]["rotation"][0].__setitem__(0, 2.0),
    "drives of an arm without": lambda d: d.__setitem__("drives", True),
    "a negative error": lambda d: put(d, 0, largest_error=-1e-3, rms_error=-1e-3),
    "a negative peak": lambda d: put(d, 1, peak_torque=-1.0),
    "a root mean square above the largest": lambda d: put(d, 1, largest_error=1e-6, rms_error=1e-5),
    "a largest error above the allowed": lambda d: scale(d, 0, allowed_error=1.0, largest_error=1e3),
    "allowed what the budget does not": lambda d: scale(d, 0, allowed_error=1e6),
    "a peak that the budget is no share of": lambda d: scale(d, 0, peak_torque=1e9),
    "a budget of words": lambda d: d.__setitem__("budget", "as agreed"),
    "not finite": lambda d: put(d, 0, rms_error=float("nan")),
    "errors too few": lambda d: d["errors"].pop(),
    "errors of other joints": lambda d: d["errors"].reverse(),
    "fewer operations": lambda d: d["operations"].__setitem__("additions", 1),
    "a changed mass": lambda d: d["arm"]["links"][0].__setitem__("mass", 3.0),
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


def test_a_trajectory_is_looked_for_by_name_only_among_those_shipped(own, path, tmp_path):
    """No file and no standard input is read because a model names it."""
    motion = tmp_path / "motion.csv"
    motion.write_text("this would be refused\n", encoding="utf-8")
    for name in ("-", "/dev/zero", str(motion)):
        given = changed(own, path, lambda d, name=name: d["fitted_on"].__setitem__("trajectory", name))
        assert not load_model(given).accuracy.measured


BUDGETS = ["1% or 10% friction", "0.5% limit or 0.01 N m, 1%, 1%, 1%, uncertainty, friction"]


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
        lambda d: d["arm"].__setitem__("drives", []),
    ],
    ids=["budget", "allowed", "friction", "no drives"],
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


ELSE = [
    a_high_power,
    nothing_at_known_states,
    a_small_term,
    a_term_lost_in_rounding,
    an_overflow,
]


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


# Terms and steps of a program: each change fits the types, or nearly, and the digest is set right again.


@pytest.fixture(scope="module")
def energy_model(puma, pick_and_place) -> SimplifiedModel:
    how = SearchOptions(ENERGY, refit=True, thorough=False)
    exact = gd.ExactDynamics.of(puma, pick_and_place, drives=True)
    return simplify_exact(exact, Budget(), how, provenance={"command": "test"})


def test_a_refitted_model_comes_back(energy_model, path, pick_and_place):
    save_model(energy_model, path)
    assert_same(energy_model, load_model(path), states_of(pick_and_place))


def cosine(*multiples: int, power: int = 1, kind: str = "cos") -> tuple[str, Any]:
    return "factors", [[kind, list(multiples), power]]


OF_ENERGY = {
    "another joint": ("i", 6),
    "below the diagonal": ("j", -1),
    "half a potential": ("i", -1),
    "a word": ("coefficient", "much"),
    "not finite": ("coefficient", float("nan")),
    "unknown kind": cosine(0, 1, 0, 0, 0, 0, kind="tan"),
    "too few multiples": cosine(0, 1),
    "of nothing": cosine(0, 0, 0, 0, 0, 0),
    "beyond the degree": cosine(0, 3, 0, 0, 0, 0),
    "an endless sum": cosine(0, 10**12, 0, 0, 0, 0),
    "a high power": cosine(0, 1, 0, 0, 0, 0, power=3),
    "a turning joint's variable": cosine(0, 1, 0, 0, 0, 0, kind="power"),
    "a key more": ("colour", "red"),
}
OF_TORQUE = {
    "another row": ("row", 2),
    "velocity of another joint": ("velocities", [[2, 2]]),
    "velocities out of order": ("velocities", [[1, 1], [1, 0]]),
    "one velocity alone": ("velocities", [[1, 0]]),
    "two accelerations": ("velocities", [[2, 0], [2, 1]]),
    "a jerk": ("velocities", [[3, 0]]),
    "weight infinite": ("weight", float("inf")),
    "weight beyond all masses": ("weight", 1.7976931348623157e308),
    "factors no list": ("factors", "C2"),
}


@pytest.mark.parametrize(("key", "value"), OF_ENERGY.values(), ids=OF_ENERGY.keys())
def test_impossible_energy_terms(energy_model, path, key, value):
    refused(energy_model, path, lambda d: next(t for t in d["terms"] if t["i"] >= 0).update({key: value}))


@pytest.mark.parametrize(("key", "value"), OF_TORQUE.values(), ids=OF_TORQUE.keys())
def test_impossible_torque_terms(shipped, path, key, value):
    refused(shipped, path, lambda d: d["terms"][0].update({key: value}))


def test_a_term_stated_twice_or_with_another_coefficient(energy_model, shipped, path):
    for model in (energy_model, shipped):
        error = refused(model, path, lambda d: d["terms"].append(d["terms"][0]))
        assert "stated twice" in error.details["found"]
    coefficient = energy_model.terms[next(iter(energy_model.terms))]
    error = refused(energy_model, path, lambda d: d["terms"][0].update(coefficient=1.001 * coefficient))
    assert "does not compute the terms" in str(error)


def product(document: Document) -> tuple[int, list[Any]]:
    """A step that multiplies by a constant, and its place."""
    return next(
        (k, step)
        for k, step in enumerate(document["steps"])
        if step[0] == "multiply" and any(isinstance(x, float) for x in step[1:])
    )


PROGRAM = {
    "a constant changed": lambda d: product(d)[1].__setitem__(1, 0.123),
    "a constant beyond all masses": lambda d: product(d)[1].__setitem__(1, 1.5e308),
    "code": lambda d: product(d)[1].__setitem__(0, "__import__"),
    "a later step": lambda d: product(d)[1].__setitem__(2, f"s{len(d['steps'])}"),
    "itself": lambda d: product(d)[1].__setitem__(2, f"s{product(d)[0]}"),
    "a step before all": lambda d: product(d)[1].__setitem__(2, "s-1"),
    "an argument more": lambda d: product(d)[1].append("s0"),
    "an argument less": lambda d: product(d)[1].pop(),
    "an empty step": lambda d: d["steps"].append([]),
    "a step twice": lambda d: d["steps"].append(d["steps"][-1]),
    "an unknown input": lambda d: d["steps"].__setitem__(0, ["input", "q7"]),
    "an output less": lambda d: d["outputs"].pop(),
    "outputs exchanged": lambda d: d["outputs"].reverse(),
    "an output of nothing": lambda d: d["outputs"].__setitem__(0, "s9999999"),
    "no steps": lambda d: d.__setitem__("steps", []),
}


@pytest.mark.parametrize("change", PROGRAM.values(), ids=PROGRAM.keys())
def test_a_damaged_program_is_refused(shipped, path, change):
    refused(shipped, path, change)
