"""Model files of version 1 are read as what they are; damaged ones are refused as any other."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from gd_analyze.errors import ModelError
from gd_analyze.motions.states import states_of
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.evaluation import evaluate
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.levels import LEVELS
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_file import load_model, save_model
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify_exact
from made_models import assert_same, signed, version_1


@pytest.fixture(scope="module", params=["element", "term", "energy"])
def model(request, two_link, swing) -> SimplifiedModel:
    how = SearchOptions(LEVELS[request.param], refit=request.param == "energy", dearer=True)
    exact = ExactDynamics.of(two_link, swing)
    made = simplify_exact(exact, Budget.parse("20%"), how, provenance={"command": "test"})
    assert made.refitted == how.refit
    return made


@pytest.fixture
def path(tmp_path) -> Path:
    return tmp_path / "model.json"


@pytest.fixture
def old(model, path) -> dict[str, Any]:
    save_model(model, path)
    return version_1(json.loads(path.read_text(encoding="utf-8")))


def put(document: dict[str, Any], path: Path) -> Path:
    path.write_text(json.dumps(document, indent=2), encoding="utf-8")
    return path


def test_it_is_the_same_model(model, old, path, swing):
    again = load_model(put(old, path))
    assert_same(model, again, states_of(swing))
    found = evaluate(again, swing)
    assert found.errors.largest.tolist() == model.accuracy.errors.largest.tolist()


def test_written_again_it_is_version_2(old, path):
    save_model(load_model(put(old, path)), path)
    document = json.loads(path.read_text(encoding="utf-8"))
    assert document["version"] == 2
    assert document["provenance"] == {"command": "test"}
    assert document["search"]


def test_one_that_says_nothing_of_a_search(old, path):
    del old["provenance"]["search"]
    again = load_model(put(signed(old), path))
    assert again.accuracy.steps == ()
    assert not again.accuracy.solved


def refused(document: dict[str, Any], path: Path) -> ModelError:
    with pytest.raises(ModelError) as caught:
        load_model(put(document, path))
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


def test_changed_ones_are_refused(old, path):
    rows = [old["errors"][0] | {"largest_error": 1e-9}, *old["errors"][1:]]
    for changed in (old | {"errors": rows}, old | {"digest": "0" * 64}, old | {"budget": "1%"}):
        assert "changed after it was written" in refused(changed, path).what


def test_damaged_ones_are_refused(old, path):
    name = {"element": "kept", "term": "torques", "energy": "energy"}[old["level"]]
    damaged = {
        "terms gone": {key: value for key, value in old.items() if key != name},
        "terms no list": old | {name: 3},
        "a term of something else": old | {name: [*old[name], {"part": "D99 rotation"}]},
        "a term twice": old | {name: [*old[name], old[name][0]]},
        "a search without a count": old | {"provenance": old["provenance"] | {"search": "luck"}},
        "provenance gone": {key: value for key, value in old.items() if key != "provenance"},
        "arm of another shape": old | {"arm": {"links": 3}},
        "a key more": old | {"colour": "red"},
    }
    for what, document in damaged.items():
        assert "damaged" in refused(signed(document), path).what, what
