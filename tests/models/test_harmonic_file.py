"""Files of harmonic models: exact round trip; damaged and edited ones are refused with a way out."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from harmonic_models import exact_model
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import ModelError
from gd_analyze.models import HarmonicModel, evaluate, load_model, save_model
from gd_analyze.models.model_file import _digest
from gd_analyze.simplification import simplify
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.states import states_of
from strategies import arms_with_states, examples


@pytest.fixture(scope="module")
def energy_model(puma, pick_and_place) -> HarmonicModel:
    return simplify(
        puma,
        states_of(pick_and_place),
        level="energy",
        refit=True,
        drives=True,
        provenance={"command": "test"},
    )


@pytest.fixture(scope="module")
def term_model(two_link, swing) -> HarmonicModel:
    return simplify(two_link, states_of(swing), Budget.parse("10%,0.5"))


def written(model: HarmonicModel, folder: Path) -> Path:
    path = folder / "model.json"
    save_model(model, path)
    return path


def assert_same(model: HarmonicModel, again, states) -> None:
    assert isinstance(again, HarmonicModel)
    q, qd, qdd = states.q, states.qd, states.qdd
    np.testing.assert_array_equal(again.torque(q, qd, qdd), model.torque(q, qd, qdd))
    np.testing.assert_array_equal(again.inertia(q), model.inertia(q))
    np.testing.assert_array_equal(again.coriolis_centrifugal(q, qd), model.coriolis_centrifugal(q, qd))
    np.testing.assert_array_equal(again.budget, model.budget)
    for table in ("peak_torque", "largest", "rms"):
        np.testing.assert_array_equal(getattr(again.promise, table), getattr(model.promise, table))
    for name in (
        "level", "energy", "drives", "refitted", "budget_stated", "made_for", "provenance", "operations",
        "operations_full",
    ):  # fmt: skip
        assert getattr(again, name) == getattr(model, name), name
    assert dict(again.torques) == dict(model.torques)


def test_round_trip_is_exact(energy_model, term_model, pick_and_place, swing, tmp_path):
    assert_same(energy_model, load_model(written(energy_model, tmp_path)), pick_and_place)
    assert_same(term_model, load_model(written(term_model, tmp_path)), swing)


@examples(12)
@given(arms_with_states(max_joints=4), st.sampled_from(["term", "energy"]))
def test_round_trip_of_any_arm_is_exact(tmp_path_factory, case, level):
    arm, states = case
    model = exact_model(arm, level=level)
    assert_same(model, load_model(written(model, tmp_path_factory.mktemp("model"))), states)


def test_the_file_says_what_it_is(energy_model, term_model, tmp_path):
    document = json.loads(written(energy_model, tmp_path).read_text(encoding="utf-8"))
    assert (document["format"], document["version"]) == ("gd-analyze simplified model", 1)
    assert (document["level"], document["refitted"], document["drives"]) == ("energy", True, True)
    assert document["errors_are"] == "sampled at the states of made_for"
    assert document["made_for"]["trajectory"] == "pick-and-place"
    assert len(document["energy"]) == len(energy_model.energy)
    assert document["energy"][0].keys() == {"i", "j", "factors", "coefficient"}
    assert "torques" not in document
    document = json.loads(written(term_model, tmp_path).read_text(encoding="utf-8"))
    assert document["level"] == "term"
    assert len(document["torques"]) == len(term_model.torques)
    assert document["torques"][0].keys() == {"row", "rates", "factors", "weight"}


def test_a_loaded_model_keeps_its_promise(energy_model, pick_and_place, tmp_path):
    model = load_model(written(energy_model, tmp_path))
    found = evaluate(model, pick_and_place)
    np.testing.assert_array_equal(found.table.largest, model.promise.largest)
    assert found.within(model.budget).all()


# Each fits the schema's types, or nearly; the digest is set right again, so that the content is judged.
ENERGY = {
    "another joint": ("i", 6),
    "below the diagonal": ("j", -1),
    "half a potential": ("i", -1),
    "a word": ("coefficient", "much"),
    "not finite": ("coefficient", float("nan")),
    "unknown kind": ("factors", [["tan", [0, 1, 0, 0, 0, 0], 1]]),
    "too few multiples": ("factors", [["cos", [0, 1], 1]]),
    "too many multiples": ("factors", [["cos", [0, 1, 0, 0, 0, 0, 0], 1]]),
    "of nothing": ("factors", [["cos", [0, 0, 0, 0, 0, 0], 1]]),
    "beyond the degree": ("factors", [["cos", [0, 3, 0, 0, 0, 0], 1]]),
    "an endless sum": ("factors", [["cos", [0, 10**12, 0, 0, 0, 0], 1]]),
    "a high power": ("factors", [["cos", [0, 1, 0, 0, 0, 0], 3]]),
    "no power": ("factors", [["cos", [0, 1, 0, 0, 0, 0], 0]]),
    "a turning joint's variable": ("factors", [["power", [0, 1, 0, 0, 0, 0], 1]]),
    "a key more": ("colour", "red"),
}
TORQUE = {
    "another row": ("row", 2),
    "row below 0": ("row", -1),
    "rate of another joint": ("rates", [[2, 2]]),
    "rates out of order": ("rates", [[1, 1], [1, 0]]),
    "one rate alone": ("rates", [[1, 0]]),
    "two accelerations": ("rates", [[2, 0], [2, 1]]),
    "three rates": ("rates", [[1, 0], [1, 0], [1, 0]]),
    "a jerk": ("rates", [[3, 0]]),
    "weight infinite": ("weight", float("inf")),
    "factors no list": ("factors", "C2"),
}


def refused(document: dict, path: Path) -> ModelError:
    document["digest"] = _digest(document)
    path.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(ModelError) as caught:
        load_model(path)
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value


@pytest.mark.parametrize(("key", "value"), ENERGY.values(), ids=ENERGY.keys())
def test_impossible_energy_terms(energy_model, tmp_path, key, value):
    path = written(energy_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    place = next(k for k, entry in enumerate(document["energy"]) if entry["i"] >= 0)
    document["energy"][place][key] = value
    refused(document, path)


@pytest.mark.parametrize(("key", "value"), TORQUE.values(), ids=TORQUE.keys())
def test_impossible_torque_terms(term_model, tmp_path, key, value):
    path = written(term_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["torques"][0][key] = value
    refused(document, path)


def test_a_term_stated_twice(energy_model, term_model, tmp_path):
    for model, key in ((energy_model, "energy"), (term_model, "torques")):
        path = written(model, tmp_path)
        document = json.loads(path.read_text(encoding="utf-8"))
        document[key].append(document[key][0])
        assert "stated twice" in refused(document, path).details["found"]


@pytest.mark.parametrize("level", ["element", "harmonic", None, ["term"]])
def test_the_level_of_another_schema(energy_model, tmp_path, level):
    path = written(energy_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["level"] = level
    refused(document, path)


def test_a_changed_coefficient_no_longer_fits_the_program(energy_model, tmp_path):
    path = written(energy_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["energy"][0]["coefficient"] *= 1.001
    assert "does not compute the terms" in str(refused(document, path))


def test_a_changed_promise_no_longer_fits_the_digest(energy_model, tmp_path):
    path = written(energy_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["errors"][0]["largest_error"] *= 0.5
    path.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(ModelError, match="changed after it was written"):
        load_model(path)


def product(document: dict) -> int:
    """A step that multiplies by a constant."""
    return next(
        k
        for k, step in enumerate(document["steps"])
        if step[0] == "multiply" and any(isinstance(x, float) for x in step[1:])
    )


PROGRAM = {
    "a constant changed": lambda d: d["steps"][product(d)].__setitem__(1, 0.123),
    "a constant infinite": lambda d: d["steps"][product(d)].__setitem__(1, 1e400),
    "another operation": lambda d: d["steps"][product(d)].__setitem__(0, "power"),
    "code": lambda d: d["steps"][product(d)].__setitem__(0, "__import__"),
    "a later step": lambda d: d["steps"][product(d)].__setitem__(2, f"s{len(d['steps'])}"),
    "itself": lambda d: d["steps"][product(d)].__setitem__(2, f"s{product(d)}"),
    "a step before all": lambda d: d["steps"][product(d)].__setitem__(2, "s-1"),
    "an argument more": lambda d: d["steps"][product(d)].append("s0"),
    "an argument less": lambda d: d["steps"][product(d)].pop(),
    "an empty step": lambda d: d["steps"].append([]),
    "a step twice": lambda d: d["steps"].append(d["steps"][-1]),
    "an unknown input": lambda d: d["steps"].__setitem__(0, ["input", "q7"]),
    "an output less": lambda d: d["outputs"].pop(),
    "outputs exchanged": lambda d: d["outputs"].reverse(),
    "an output of nothing": lambda d: d["outputs"].__setitem__(0, "s9999999"),
    "no steps": lambda d: d.__setitem__("steps", []),
}


@pytest.mark.parametrize("change", PROGRAM.values(), ids=PROGRAM.keys())
def test_a_damaged_program_is_refused(term_model, tmp_path, change):
    path = written(term_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    change(document)
    refused(document, path)
