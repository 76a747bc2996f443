"""docs/arms.md against the reader: every key, every default, and the example."""

from __future__ import annotations

import json
import warnings

import numpy as np
import pytest
from markdown_pages import ROOT, blocks, code, tables

from gd_analyze import load_arm
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots import arm_file
from gd_analyze.tables import decompose_states
from gd_analyze.types import States

PAGE = ROOT / "docs" / "arms.md"
SECTIONS = {
    "The file": arm_file.FILE,
    "`[[joints]]`": arm_file.JOINT,
    "`[[joints]]` of a Denavit-Hartenberg table": arm_file.DH_JOINT,
    "`[[joints]]` by placements": arm_file.PLACED_JOINT,
    "`[[links]]`": arm_file.LINK,
    "`[[links]]` by placements": arm_file.PLACED_LINK,
    "`[[drives]]`": arm_file.DRIVE,
}
TEXTS = [block.text for block in blocks(PAGE) if block.language == "toml"]


def arm_of(text, folder):
    """The arm of a text that gives no warning."""
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        return load_arm(path)


@pytest.mark.parametrize("section", list(SECTIONS))
def test_every_key_is_explained_and_none_is_invented(section):
    rows, keys = tables(PAGE, section), SECTIONS[section]
    assert [code(row["key"]) for row in rows] == list(keys)
    for row in rows:
        key = keys[code(row["key"])]
        assert (row["default"] == "required") == (key.default is arm_file.REQUIRED), row["key"]
        stated = row["default"].strip("`")
        if stated[0] in '["0123456789' or stated in ("true", "false"):
            found = list(key.default) if isinstance(key.default, tuple) else key.default
            assert json.loads(stated) == found, row["key"]
        taken = {key.suffix("revolute"), key.suffix("prismatic")} - {""}
        assert {suffix for suffix in ("_deg", "_mm") if f"`{suffix}`" in row["unit"]} == taken, row["key"]
        if key.unit:
            assert row["unit"].partition(",")[0] == key.unit, row["key"]


def test_the_examples_are_possible_arms(tmp_path):
    askew, arm = arm_of(TEXTS[1], tmp_path), arm_of(TEXTS[0], tmp_path)
    assert askew.joints[0].axis.tolist() == [0.6, 0.0, 0.8]
    assert askew.joints[1].placement.rotation.tolist() == [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    assert askew.links[1].frame.translation.tolist() == [0.35, 0.0, 0.0]
    assert [joint.kind for joint in arm.joints] == ["prismatic", "revolute"]
    assert arm.joints[1].upper == pytest.approx(np.deg2rad(150), rel=1e-15)
    # 0.107 about the frame's origin, less m c^2 = 2 * 0.2^2; a few roundings of 0.107.
    assert arm.inertia_com[1, 2, 2] == pytest.approx(0.027, rel=1e-14)
    assert arm.inertia_com[0, 0, 2] == -0.01
    assert arm.drive_inertia.tolist() == [1.5, 0.2]
    state = np.zeros((1, 2))
    found = decompose_states(arm, States(state, state, state), drives=True)
    # The lift carries both masses; a product and a sum of two numbers.
    assert found["torque"][0, 0] == pytest.approx(8.0 * 9.8062, rel=1e-15)


@pytest.mark.parametrize(
    ("sound", "broken", "says"),
    [
        ("inertia = 1.5", "inertia = -1.5", "drives[1].inertia"),
        ("mass = 2.0", "mass = 2.0\naxial_only = true", "about the joint axis only"),
        # The other two moments add up to xx + zz = 0.12 kg m^2: too large by 4 % of itself.
        ("yy = 0.09", "yy = 0.125", "as_measured = true"),
        ("yy = 0.09", "yy = -0.01", "moment is negative"),
        ("com = [-0.1, 0.0, 0.05]", "com = [-100.0, 0.0, 50.0]", "are its units metres"),
    ],
)
def test_the_stated_failures_fail_and_warnings_warn(tmp_path, sound, broken, says):
    assert sound in TEXTS[0]
    with pytest.raises((ArmError, GdAnalyzeWarning)) as caught:
        arm_of(TEXTS[0].replace(sound, broken, 1), tmp_path)
    assert says in str(caught.value)


def test_what_was_measured_so_gives_no_warning(tmp_path):
    measured = TEXTS[0].replace("yy = 0.09", "yy = 0.125")
    arm_of(measured.replace("mass = 6.0", "mass = 6.0\nas_measured = true"), tmp_path)
