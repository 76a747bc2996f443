"""Results files edited and sealed again: what no report could be made of is refused, with its name."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from gd_analyze.errors import StoreError
from gd_analyze.results.seal import SEAL_LENGTH, seal
from gd_analyze.results.store import load_findings, load_results, save_results
from gd_analyze.schema import ATTRIBUTES, COORDINATES, GROUPS
from gd_analyze.studies.find import find
from recorded_logs import MEASURED
from several_motions import swung

Edit = Callable[[h5py.File], None]


@pytest.fixture(scope="module")
def content(everything_found, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("edited") / "analysis.h5"
    save_results(everything_found, path)
    return path.read_bytes()[:-SEAL_LENGTH]


@pytest.fixture(scope="module")
def content_of_motions(two_link, tmp_path_factory) -> bytes:
    path = tmp_path_factory.mktemp("edited") / "analysis.h5"
    save_results(find(two_link, [swung(20.0, "slow"), swung(2.2, "fast")]), path)
    return path.read_bytes()[:-SEAL_LENGTH]


def edited(content: bytes, path: Path, edit: Edit) -> Path:
    path.write_bytes(content)
    with h5py.File(path, "r+") as file:
        edit(file)
    seal(path)
    return path


def found(content: bytes, path: Path, edit: Edit, load: Callable[[Path], Any] = load_results) -> str:
    """What is said to be wrong."""
    with pytest.raises(StoreError, match="the results file is damaged") as caught:
        load(edited(content, path, edit))
    assert str(path) in caught.value.details["where"]
    assert caught.value.details["next"]
    return caught.value.details["found"]


def made_again(name: str, values: Any) -> Edit:
    """Put other values in the place of a variable, described and stored in the same way."""

    def edit(file: h5py.File) -> None:
        dims = file[name].attrs["dims"]
        attributes = {key: value for key, value in file[name].attrs.items() if key in ("units", "units_in")}
        del file[name]
        made = file.create_dataset(name, data=values, chunks=np.shape(values), fletcher32=True)
        for key, value in {"dims": dims, **attributes}.items():
            made.attrs.create(key, np.bytes_(value))

    return edit


def entry(name: str, value: Any, place: Any = 0) -> Edit:
    """Write one value of a variable."""
    return lambda file: file[name].__setitem__(place, value)


def attribute(name: str, key: str, value: Any) -> Edit:
    return lambda file: file[name].attrs.create(key, value)


def text(*words: str) -> Any:
    return np.array([word.encode() for word in words], dtype="S20")


def without(name: str) -> Edit:
    return lambda file: file.__delitem__(name)


def without_attribute(group: str, name: str) -> Edit:
    return lambda file: file[group].attrs.__delitem__(name)


EDITS: dict[str, tuple[Edit, str]] = {
    "text as numbers": (
        made_again("dominance/verdict", np.zeros(7)),
        "verdict of dominance is of another",
    ),
    "numbers as text": (
        made_again("dominance/peak", text(*"1234567")),
        "peak of dominance is of another kind",
    ),
    "numbers of half a precision": (
        made_again("trajectory/time", np.arange(61, dtype="f2")),
        "time is not stored as variables are",
    ),
    "a verdict of its own": (entry("dominance/verdict", b"good"), "verdict of dominance cannot be 'good'"),
    "a joint too many": (entry("dominance/torque_joint", 3), "torque_joint of dominance cannot be '3'"),
    "joint 0": (entry("terms/alone_joint", 0), "alone_joint of terms cannot be '0'"),
    "a level of its own": (entry("trade_off/level", b"terms"), "level of trade_off cannot be 'terms'"),
    "effects exchanged": (
        made_again("decomposition/effect", text("rotation", "translation")),
        "effect of decomposition is not in order",
    ),
    "a joint twice": (entry("decomposition/joint", 2), "joint of decomposition is not in order"),
    "a quantity of its own": (entry("cross_check/quantity", b"energy"), "quantity of cross_check cannot be"),
    "a kind twice": (entry("trade_off/kind", b"term", 2), "kind of trade_off names one of its rows twice"),
    "an element twice": (
        lambda file: entry("dominance/element", file["dominance/element"][1])(file),
        "element of dominance names one of its rows twice",
    ),
    "an element of another arm": (entry("dominance/element", b"D33"), "element of dominance is not what"),
    "a part of another arm": (entry("parts/part", b"D33"), "part of parts is not what belongs"),
    "budgets of another model": (
        entry("budgets/operations", 1, 10),
        "operations of budgets at a factor of 1 is not what belongs to the rest",
    ),
    "budgets of another ranking": (entry("budgets/rank", 99, 0), "rank of budgets is not what belongs"),
    "budgets of parts, where terms are kept": (
        lambda file: file.move("budgets/kept", "budgets/kept_parts"),
        "kept_parts of budgets has other dimensions",
    ),
    "another unit": (attribute("decomposition/torque", "units", np.bytes_("N")), "is in other units"),
    "another shape of an attribute": (
        attribute("dominance", "threshold", np.zeros(2)),
        "threshold of dominance has another shape",
    ),
    "an attribute of another kind": (
        attribute("simplified_model", "drives", 0.0),
        "drives of simplified_model is of another kind",
    ),
    "an attribute that is no number": (
        attribute("dominance", "threshold", np.nan),
        "threshold of dominance is no finite number",
    ),
    "a coordinate more": (
        lambda file: file.copy("dominance/unit", "dominance/colour"),
        "dominance has no coordinate colour",
    ),
    "a negative error": (entry("simplified_model/rms_error", -1.0), "rms_error of simplified_model is not"),
    "nothing allowed": (entry("simplified_model/allowed_error", 0.0), "allowed_error of simplified_model is"),
    "a number without a square": (
        entry("decomposition/torque", -1e200, (0, 0)),
        "torque of decomposition holds what is no finite number, or too large",
    ),
    "a certificate of one joint": (entry("beyond/certified", np.nan), "certified of beyond is known where"),
    "a tube of one joint": (
        entry("tube/tube_certified", np.nan),
        "tube_certified of tube is known where",
    ),
    "a piece that is worse than the tube": (
        entry("tube/tube_along", 9.9, (0, 0)),
        "tube_certified of tube is not the largest of tube_along",
    ),
    "a torque of no readings": (
        lambda file: file["measured_torque/measured"].write_direct(np.full((2 * MEASURED, 2), np.nan)),
        "measured_torque has no reading of joint 1, of which it says: follows",
    ),
    "friction in part": (
        without("measured_torque/offset"),
        "friction of measured_torque is not what belongs",
    ),
    "errors of no states": (attribute("beyond", "states_drawn", 0), "within_limits of beyond is known where"),
    "a loss that is not known": (
        lambda file: file["parts/torque_peak"].write_direct(np.full(12, np.nan)),
        "torque_peak of parts is not known of a part that is left out",
    ),
    "other set points": (
        entry("decomposition/time", -1.0),
        "time of decomposition is not that of the trajectory",
    ),
    "another joint's name": (
        entry("beyond/joint_name", b"wrist"),
        "joint_name of beyond is not what belongs",
    ),
    "a joint that slides": (
        made_again("decomposition/joint_kind", text("prismatic", "revolute")),
        "joint_kind of decomposition is not what",
    ),
}


@pytest.mark.parametrize(("edit", "says"), EDITS.values(), ids=EDITS.keys())
def test_what_no_report_can_be_made_of_is_refused(content, tmp_path, edit, says):
    assert says in found(content, tmp_path / "analysis.h5", edit)


LABELS = [(group, name) for group, names in COORDINATES.items() for name in names]


@pytest.mark.parametrize(("group", "name"), LABELS)
def test_every_coordinate_must_be_there(content, content_of_motions, tmp_path, group, name):
    content = content_of_motions if group == "motions" else content
    with h5py.File(edited(content, tmp_path / "analysis.h5", lambda file: None)) as file:
        if name not in file[group]:
            assert name in ("link", "term", "term_effect", "part")
            return
    assert found(content, tmp_path / "analysis.h5", without(f"{group}/{name}"))


@pytest.mark.parametrize(
    ("group", "name"), [(group, name) for group in ATTRIBUTES for name in ATTRIBUTES[group]]
)
def test_every_attribute_must_be_there(content, tmp_path, group, name):
    says = found(content, tmp_path / "analysis.h5", without_attribute(group, name))
    assert says == f"{group} lacks the attribute {name}"


def test_every_coordinate_and_attribute_is_declared(measured_findings):
    for group, table in measured_findings.tables.items():
        own = set(table.coords)
        assert own <= set(COORDINATES[group])
        more = set(table.attrs) - set(ATTRIBUTES.get(group, {}))
        assert more <= set(measured_findings.provenance)
        assert group in GROUPS


def document(change: Callable[[dict[str, Any]], Any]) -> Edit:
    """Change what is stored as JSON."""

    def edit(file: h5py.File) -> None:
        tree = json.loads(file["documents/json"][()].tobytes())
        change(tree)
        made_again("documents/json", np.frombuffer(json.dumps(tree).encode(), dtype=np.uint8))(file)

    return edit


def _of_another_arm(tree: dict[str, Any]) -> None:
    tree["arm"]["links"][0]["mass"] *= 2


DOCUMENTS: dict[str, tuple[Callable[[dict[str, Any]], Any], str]] = {
    "a model of another arm": (_of_another_arm, "a model is of another arm than the tables"),
    "another weight": (
        lambda tree: tree["ranked_terms"][0].__setitem__("weight", 7.0),
        "the weights of the ranked terms is not what belongs to the rest",
    ),
    "a term less": (lambda tree: tree["ranked_terms"].pop(), "the weights of the ranked terms is not"),
    "no model by elements": (lambda tree: tree.pop("element_model"), "level of the model by elements is not"),
    "models exchanged": (
        lambda tree: tree.update(model=tree["element_model"], element_model=tree["model"]),
        "level of the model is not what belongs",
    ),
}


@pytest.mark.parametrize(("change", "says"), DOCUMENTS.values(), ids=DOCUMENTS.keys())
def test_parts_that_do_not_belong_together_are_refused(content, tmp_path, change, says):
    assert says in found(content, tmp_path / "analysis.h5", document(change), load_findings)
