"""docs/arms.md against the reader: every key, every default, and the example."""

from __future__ import annotations

import json
import warnings

import numpy as np
import pytest
from markdown_pages import ROOT, blocks, code, tables

from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.errors import ArmError
from gd_analyze.motions.states import States
from gd_analyze.robots import arm_file
from gd_analyze.robots.catalogue import load_arm

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


@pytest.fixture
def example(tmp_path):
    path = tmp_path / "lift_and_turn.toml"
    path.write_text(TEXTS[0], encoding="utf-8")
    return path


@pytest.mark.parametrize("section", list(SECTIONS))
def test_every_key_is_explained_and_none_is_invented(section):
    rows = tables(PAGE, section)
    keys = SECTIONS[section]
    assert [code(row["key"]) for row in rows] == list(keys)
    for row in rows:
        default = keys[code(row["key"])].default
        assert (row["default"] == "required") == (default is arm_file.REQUIRED), row["key"]
        stated = row["default"].strip("`")
        if stated[0] in '["0123456789' or stated in ("true", "false"):
            found = list(default) if isinstance(default, tuple) else default
            assert json.loads(stated) == found, row["key"]


@pytest.mark.parametrize("section", list(SECTIONS))
def test_the_stated_suffixes_are_read(section):
    table = SECTIONS[section]
    for row in tables(PAGE, section):
        key = code(row["key"])
        suffix = table[key].suffix
        taken = set() if suffix is None else {suffix} if suffix else {"_deg", "_mm"}
        assert {suffix for suffix in ("_deg", "_mm") if f"`{suffix}`" in row["unit"]} == taken, key


def test_the_example_uses_almost_every_key(example):
    text = example.read_text(encoding="utf-8")
    text += TEXTS[1]
    left_out = {"theta", "d", "as_measured", "axial_only", "doubts", "inertia_uncertainty_about"}
    left_out |= {"rotation", "frame_rpy", "frame_rotation"}
    for section in SECTIONS:
        for row in tables(PAGE, section):
            assert code(row["key"]) in text or code(row["key"]) in left_out


def test_the_example_by_placements_is_a_possible_arm(tmp_path):
    path = tmp_path / "askew.toml"
    path.write_text(TEXTS[1], encoding="utf-8")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        arm = load_arm(path)
    assert arm.joints[0].axis.tolist() == [0.6, 0.0, 0.8]
    assert arm.joints[1].placement.translation.tolist() == [0.4, 0.0, 0.0]
    assert arm.joints[1].placement.rotation.tolist() == [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    assert arm.links[1].frame.translation.tolist() == [0.35, 0.0, 0.0]
    assert (arm.dh_table, arm.convention) == ((), "placements")


def test_the_example_is_a_possible_arm(example):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        arm = load_arm(example)
    assert [joint.kind for joint in arm.joints] == ["prismatic", "revolute"]
    assert arm.joints[1].upper == pytest.approx(np.deg2rad(150), rel=1e-15)
    assert arm.joints[1].velocity_limit == pytest.approx(np.pi, rel=1e-15)
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
        ("mass = 6.0", "mass = -6.0", "negative"),
        ("inertia = 1.5", "inertia = -1.5", "drives[1].inertia"),
        ("range = [0.0, 0.8]", "range = [0.8, 0.0]", "empty"),
        ("velocity_limit = 0.5", "velocity_limit = 0.0", "not positive"),
        ("mass = 2.0", "mass = 2.0\naxial_only = true", "about the joint axis only"),
        ("mass = 2.0", "mass = nan", "links[2].mass"),
        ("mass = 2.0", "weight = 2.0", "links[2]"),
        ("range_deg = [-150.0, 150.0]", "range_mm = [-150.0, 150.0]", "joints[2]"),
        ("[[drives]]\ninertia = 1.5\ntorque_limit = 300.0\n", "", "[[drives]]"),
    ],
)
def test_the_stated_failures_fail(example, sound, broken, says):
    text = example.read_text(encoding="utf-8")
    assert sound in text
    example.write_text(text.replace(sound, broken, 1), encoding="utf-8")
    with pytest.raises(ArmError) as caught:
        load_arm(example)
    assert says in str(caught.value)


def test_the_stated_warnings_warn(example):
    # The other two moments add up to xx + zz = 0.12 kg m^2, so yy = 0.125 is too large by 4 % of itself.
    text = example.read_text(encoding="utf-8")
    example.write_text(text.replace("yy = 0.09", "yy = 0.125"), encoding="utf-8")
    with pytest.warns(UserWarning, match="as_measured = true"):
        load_arm(example)
    for impossible, said in (("yy = 0.2", "triangle inequality by"), ("yy = -0.01", "moment is negative")):
        example.write_text(text.replace("yy = 0.09", impossible), encoding="utf-8")
        with pytest.warns(UserWarning, match=said):
            load_arm(example)
    measured = text.replace("yy = 0.09", "yy = 0.125").replace("mass = 6.0", "mass = 6.0\nas_measured = true")
    example.write_text(measured, encoding="utf-8")
    load_arm(example)
    example.write_text(text.replace("com = [-0.1, 0.0, 0.05]", "com = [-100.0, 0.0, 50.0]"), encoding="utf-8")
    with pytest.warns(UserWarning, match="are its units metres"):
        load_arm(example)
