"""Terms and programs in model files: exact round trip; impossible and edited ones are refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from gd_analyze.errors import ModelError
from gd_analyze.motions.states import states_of
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.model import SimplifiedModel
from gd_analyze.simplification.model_file import _digest, load_model, save_model
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify, simplify_exact
from made_models import assert_same


@pytest.fixture(scope="module")
def energy_model(puma, pick_and_place) -> SimplifiedModel:
    exact = ExactDynamics.of(puma, pick_and_place, drives=True)
    how = SearchOptions(ENERGY, refit=True, thorough=False)
    return simplify_exact(exact, Budget(), how, provenance={"command": "test"})


@pytest.fixture(scope="module")
def term_model(two_link, swing) -> SimplifiedModel:
    return simplify(two_link, swing, Budget.parse("10%,0.5"))


def written(model: SimplifiedModel, folder: Path) -> Path:
    path = folder / "model.json"
    save_model(model, path)
    return path


def test_round_trip_is_exact(energy_model, term_model, pick_and_place, swing, tmp_path):
    assert_same(energy_model, load_model(written(energy_model, tmp_path)), states_of(pick_and_place))
    assert_same(term_model, load_model(written(term_model, tmp_path)), states_of(swing))


# Each fits the schema's types, or nearly; the digest is set right again, so that the content is judged.
OF_ENERGY = {
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
OF_TORQUE = {
    "another row": ("row", 2),
    "row below 0": ("row", -1),
    "velocity of another joint": ("velocities", [[2, 2]]),
    "velocities out of order": ("velocities", [[1, 1], [1, 0]]),
    "one velocity alone": ("velocities", [[1, 0]]),
    "two accelerations": ("velocities", [[2, 0], [2, 1]]),
    "three velocities": ("velocities", [[1, 0], [1, 0], [1, 0]]),
    "a jerk": ("velocities", [[3, 0]]),
    "weight infinite": ("weight", float("inf")),
    "weight beyond all masses": ("weight", 1.7976931348623157e308),
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


@pytest.mark.parametrize(("key", "value"), OF_ENERGY.values(), ids=OF_ENERGY.keys())
def test_impossible_energy_terms(energy_model, tmp_path, key, value):
    path = written(energy_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    place = next(k for k, entry in enumerate(document["terms"]) if entry["i"] >= 0)
    document["terms"][place][key] = value
    refused(document, path)


@pytest.mark.parametrize(("key", "value"), OF_TORQUE.values(), ids=OF_TORQUE.keys())
def test_impossible_torque_terms(term_model, tmp_path, key, value):
    path = written(term_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["terms"][0][key] = value
    refused(document, path)


def test_a_term_stated_twice(energy_model, term_model, tmp_path):
    for model in (energy_model, term_model):
        path = written(model, tmp_path)
        document = json.loads(path.read_text(encoding="utf-8"))
        document["terms"].append(document["terms"][0])
        assert "stated twice" in refused(document, path).details["found"]


def test_a_changed_coefficient_no_longer_fits_the_program(energy_model, tmp_path):
    path = written(energy_model, tmp_path)
    document = json.loads(path.read_text(encoding="utf-8"))
    document["terms"][0]["coefficient"] *= 1.001
    assert "does not compute the terms" in str(refused(document, path))


def product(document: dict) -> int:
    """A step that multiplies by a constant."""
    return next(
        k
        for k, step in enumerate(document["steps"])
        if step[0] == "multiply" and any(isinstance(x, float) for x in step[1:])
    )


PROGRAM = {
    "a constant changed": lambda d: d["steps"][product(d)].__setitem__(1, 0.123),
    "a constant beyond all masses": lambda d: d["steps"][product(d)].__setitem__(1, 1.5e308),
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
