"""Model files: exact round trip; damaged, foreign and edited files are refused with a way out."""

from __future__ import annotations

import copy
import dataclasses
import json
import pickle
import time
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
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_checks import measured_at, require_terms_computed
from gd_analyze.simplification.model_file import load_model, save_model
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify, simplify_exact
from gd_analyze.simplification.term import TERM
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


@pytest.mark.parametrize(
    ("level", "entry"),
    [
        (ELEMENT, {"part"}),
        (TERM, {"row", "velocities", "factors", "weight"}),
        (ENERGY, {"i", "j", "factors", "coefficient"}),
    ],
    ids=["element", "term", "energy"],
)
def test_the_file_says_what_it_is(two_link, tmp_path, level, entry):
    save_model(exact_model(two_link, level=level), tmp_path / "model.json")
    text = (tmp_path / "model.json").read_text(encoding="utf-8")
    document = json.loads(text)
    assert list(document)[:3] == ["format", "version", "level"]
    assert document["format"] == "gd-analyze simplified model"
    assert document["version"] == 3
    assert document["level"] == level.name
    assert document["errors"][0].keys() == {
        "joint", "unit", "peak_torque", "allowed_error", "largest_error", "rms_error", "uncertainty",
    }  # fmt: skip
    assert document["errors_are"] == "sampled at the states of fitted_on"
    assert all(one.keys() == entry for one in document["terms"])
    assert len(document["outputs"]) == 2
    assert text.endswith("}\n")


NOT_JSON = {
    "empty": "",
    "truncated": '{"format": "gd-analyze simplified model", "version": 3,',
    "prose": "a model of an arm",
    "toml": 'format = "gd-analyze arm 1"\n',
    "byte order mark": '\ufeff{"format": "gd-analyze simplified model"}',
}


@pytest.mark.parametrize("content", NOT_JSON.values(), ids=NOT_JSON.keys())
def test_not_json(file, content):
    error = refused_path(file(content))
    assert "not valid JSON" in error.what
    assert "line 1, column" in error.details["where"]


OTHER = {
    "list": "[]",
    "number": "3",
    "object": '{"a": 1}',
    "other format": '{"format": "gd-analyze results"}',
    "null": "null",
    "nested beyond reason": "[" * 100_000,
    "thousands of digits": f'{{"format": {"9" * 5000}}}',
    "binary": bytes(range(256)),
    "pickle": pickle.dumps({"format": "gd-analyze simplified model"}),
    "latin": '{"name": "Größe"}'.encode("latin-1"),
}


@pytest.mark.parametrize("content", OTHER.values(), ids=OTHER.keys())
def test_foreign(file, content):
    assert refused_path(file(content)).what == "this is not a gd-analyze model"


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


@pytest.mark.parametrize("version", [0, 2, "3", None])
def test_other_version(file, written, version):
    document = json.loads(written)
    document["version"] = version
    error = refused_path(file(json.dumps(document)))
    assert "another version" in error.what


def edit(document: dict[str, Any], keys: tuple[Any, ...], value: Any) -> dict[str, Any]:
    document = copy.deepcopy(document)
    inner: Any = document
    for key in keys[:-1]:
        inner = inner[key]
    if value is KeyError:
        del inner[keys[-1]]
    else:
        inner[keys[-1]] = value
    return document


CHANGED = {
    "list of terms shortened": (("terms", 0), KeyError),
    "a term of another part": (("terms", 0, "part"), "D99 rotation"),
    "a term of another level": (("terms", 0), {"row": 0, "velocities": [], "factors": [], "weight": 1.0}),
    "a term with a key more": (("terms", 0, "colour"), "red"),
    "mass": (("arm", "links", 1, "mass"), 17.5),
    "inertia": (("arm", "links", 1, "inertia_com", 0, 0), 0.1301),
    "gravity": (("arm", "gravity", 2), -9.81),
    "placement": (("arm", "links", 1, "frame", "translation", 0), 0.432),
    "drive inertia": (("arm", "drives", 0, "inertia"), 1.15),
    "negative mass": (("arm", "links", 1, "mass"), -1.0),
    "mass not a number": (("arm", "links", 1, "mass"), float("nan")),
    "mass a word": (("arm", "links", 1, "mass"), "heavy"),
    "drive inertia infinite": (("arm", "drives", 0, "inertia"), float("inf")),
    "link gone": (("arm", "links", 5), KeyError),
    "joint key unknown": (("arm", "joints", 0, "colour"), "red"),
    "joint key gone": (("arm", "joints", 0, "axis"), KeyError),
    "arm of another shape": (("arm",), {"links": 3}),
    "joints no list": (("arm", "joints"), 6),
    "rotation skewed": (("arm", "links", 0, "frame", "rotation", 0, 0), 2.0),
    "errors of one joint gone": (("errors", 5), KeyError),
    "error not a number": (("errors", 0, "largest_error"), "small"),
    "error infinite": (("errors", 0, "largest_error"), float("inf")),
    "key gone": (("budget",), KeyError),
    "key unknown": (("colour",), "red"),
    "another level": (("level",), "term"),
    "no level": (("level",), None),
    "a step of the search a word": (("search", 0, 1), "few"),
    "the search a sentence": (("search",), "integer program 1798"),
    "solved after all": (("solved",), False),
    "operations a word": (("operations", "additions"), "few"),
    "fingerprint": (("arm_fingerprint",), "0" * 64),
    "digest": (("digest",), "0" * 64),
    "smaller error": (("errors", 1, "largest_error"), 1e-9),
    "drives of an arm": (("drives",), False),
}


@pytest.mark.parametrize(("keys", "value"), CHANGED.values(), ids=CHANGED.keys())
def test_edited(file, written, keys, value):
    edited = edit(json.loads(written), keys, value)
    assert edited != json.loads(written)
    refused_path(file(json.dumps(edited)))


@examples(30)
@given(st.data())
def test_any_truncation_is_refused(written, tmp_path_factory, data):
    raw = written.encode()
    end = data.draw(st.integers(0, len(raw) - 2))  # the last two bytes are the closing brace and a newline
    path = tmp_path_factory.mktemp("model") / "model.json"
    path.write_bytes(raw[:end])
    refused_path(path)


def test_missing_file_and_folder(tmp_path):
    assert refused_path(tmp_path / "none.json").what == "cannot read the model file"
    assert refused_path(tmp_path).what == "cannot read the model file"


def test_a_model_file_has_a_largest_size(file, written, monkeypatch):
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


@pytest.fixture(scope="module", params=LEVELS)
def model_of_program_check(request, two_link) -> SimplifiedModel:
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


def nothing_at_known_angles(document: Document) -> None:
    """The same of sines, so that no angle stands alone."""
    step = Steps(document)
    product: str | float = 1e-3
    for known in np.random.default_rng(0).uniform(-1.0, 1.0, (3, 5, 2))[0, :, 1]:
        sine = step("sin", step("input", "q2"))
        product = step("multiply", product, step("subtract", sine, float(np.sin(known))))
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


def numbers_beyond_a_torque(document: Document) -> None:
    """They do not overflow yet: what is made of them does."""
    step = Steps(document)
    x = step("multiply", 1e99, step("multiply", 1e99, step("cos", step("input", "q1"))))
    step.add_to_output(step("multiply", 1e99, x))


ELSE = [
    a_high_power,
    nothing_at_known_states,
    nothing_at_known_angles,
    a_small_term,
    a_term_lost_in_rounding,
    an_overflow,
    numbers_beyond_a_torque,
]


@pytest.mark.parametrize("change", ELSE)
def test_what_computes_anything_else_is_refused(model_of_program_check, tmp_path, change):
    error = refused(model_of_program_check, tmp_path / "model.json", change)
    assert error.what in (
        "the program does not compute the terms",
        "the program computes no torque of an arm: it uses an angle outside of sines and cosines",
        "the program computes no torque of an arm: its numbers overflow",
    )


def test_what_is_zero_everywhere_may_be_added(model_of_program_check, tmp_path: Path) -> None:
    """c (sin^2 + cos^2 - 1) is nothing, however it is written."""

    def change(document: Document) -> None:
        step = Steps(document)
        squares = [
            step("multiply", x, x) for x in (step(kind, step("input", "q1")) for kind in ("sin", "cos"))
        ]
        nothing = step("subtract", step("add", *squares), 1.0)
        step.add_to_output(step("multiply", 1e-6, nothing))

    again = load_model(changed(model_of_program_check, tmp_path / "model.json", change))
    assert again.operations.total > model_of_program_check.operations.total


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


def test_a_program_of_a_sample_is_written_out_quickly(puma):
    """A hundredth of a second here, for the exact PUMA's 600 operations two; loading must not be felt."""
    model_of_program_check = exact_model(puma)
    started = time.process_time()
    require_terms_computed(model_of_program_check)
    assert time.process_time() - started < 1.0
