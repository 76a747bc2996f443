"""Model files: exact round trip; damaged, foreign and edited files are refused with a way out."""

from __future__ import annotations

import copy
import dataclasses
import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import ModelError, OutputError
from gd_analyze.motions.states import states_of
from gd_analyze.simplification import model_file
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_file import load_model, save_model
from gd_analyze.simplification.term import TERM
from made_models import assert_same, by_elements, exact_model
from strategies import arms_with_states, examples


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


def refused(path: Path) -> ModelError:
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


def test_round_trip_is_exact(model, pick_and_place, file, written):
    assert_same(model, load_model(file(written)), states_of(pick_and_place))


def test_what_the_search_did_is_kept(model, file, written):
    again = load_model(file(written)).accuracy
    assert again.steps == model.accuracy.steps != ()
    assert again.solved
    assert again.search == model.accuracy.search
    assert again.search.endswith(", optimum proven")


@examples(15)
@given(arms_with_states(max_joints=4), st.sampled_from(list(LEVELS.values())))
def test_round_trip_of_any_arm_is_exact(tmp_path_factory, case, level):
    arm, states = case
    model = exact_model(arm, level=level)
    path = tmp_path_factory.mktemp("model") / "model.json"
    save_model(model, path)
    assert_same(model, load_model(path), states)


@examples(5)
@given(arms_with_states(max_joints=3, count=12, massive=True))
def test_so_it_is_of_simplified_ones(tmp_path_factory, case):
    arm, states = case
    model = by_elements(arm, states, Budget.parse("10%"))
    path = tmp_path_factory.mktemp("model") / "model.json"
    save_model(model, path)
    assert_same(model, load_model(path), states)


@pytest.mark.parametrize(
    ("level", "entry"),
    [
        (ELEMENT, {"part"}),
        (TERM, {"row", "rates", "factors", "weight"}),
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
    error = refused(file(content))
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
    assert refused(file(content)).what == "this is not a gd-analyze model"


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
    refused(file(payload))
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
    error = refused(file(json.dumps(document)))
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
    "a term of another level": (("terms", 0), {"row": 0, "rates": [], "factors": [], "weight": 1.0}),
    "a term with a key more": (("terms", 0, "colour"), "red"),
    "mass": (("arm", "links", 1, "mass"), 17.5),
    "inertia": (("arm", "links", 1, "inertia_com", 0, 0), 0.1301),
    "gravity": (("arm", "gravity", 2), -9.81),
    "placement": (("arm", "links", 1, "frame", "translation", 0), 0.432),
    "drive inertia": (("arm", "drive_inertia", 0), 1.15),
    "negative mass": (("arm", "links", 1, "mass"), -1.0),
    "mass not a number": (("arm", "links", 1, "mass"), float("nan")),
    "mass a word": (("arm", "links", 1, "mass"), "heavy"),
    "drive inertia infinite": (("arm", "drive_inertia", 0), float("inf")),
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
    refused(file(json.dumps(edited)))


@examples(60)
@given(st.data())
def test_any_truncation_is_refused(written, tmp_path_factory, data):
    raw = written.encode()
    end = data.draw(st.integers(0, len(raw) - 2))  # the last two bytes are the closing brace and a newline
    path = tmp_path_factory.mktemp("model") / "model.json"
    path.write_bytes(raw[:end])
    refused(path)


def test_missing_file_and_folder(tmp_path):
    assert refused(tmp_path / "none.json").what == "cannot read the model file"
    assert refused(tmp_path).what == "cannot read the model file"


def test_unwritable(model, blocked_folder):
    with pytest.raises(OutputError):
        save_model(model, blocked_folder / "model.json")


def test_a_model_file_has_a_largest_size(file, written, monkeypatch):
    monkeypatch.setattr(model_file, "LARGEST_FILE", len(written) - 1)
    assert refused(file(written)).details["found"].startswith("a file of more than")
    assert refused(Path("/dev/zero")).details["found"].startswith("a file of more than")
