"""Numbers of an arm by name: the same arm from its own, that of an edited file from others, and refusals."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeWarning, UsageError
from gd_analyze.robots.arm_numbers import ArmNumber, with_numbers
from gd_analyze.robots.description import describe, fingerprint, table_convention
from gd_analyze.robots.uncertainty import with_uncertainty


def own_numbers(arm: gd.types.RobotArm) -> dict[str, float]:
    """Numbers of an arm by name, but for turns of placements."""
    out = {f"gravity.{axis}": x for axis, x in zip("xyz", arm.gravity_vector.tolist(), strict=True)}
    placed = table_convention(arm) == "placement"
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        vectors = {f"link{i}.com": link.com}
        if placed:
            vectors[f"joint{i}.xyz"] = joint.placement.translation
            vectors[f"link{i}.frame_xyz"] = link.frame.translation
        else:
            row = arm.dh_table[i - 1]
            out |= {f"joint{i}.{key}": getattr(row, key) for key in ("theta", "d", "a", "alpha")}
        out[f"link{i}.mass"] = link.mass
        out |= {f"{name}.{axis}": x for name, v in vectors.items() for axis, x in zip("xyz", v, strict=True)}
        for row, first in enumerate("xyz"):
            for column in range(row, 3):
                out[f"link{i}.inertia.{first}{'xyz'[column]}"] = float(link.inertia_com[row, column])
    return out | {f"drive{i}.inertia": drive.inertia for i, drive in enumerate(arm.drives, start=1)}


@pytest.mark.parametrize("name", list(gd.builtin_arms()))
@pytest.mark.parametrize("placed", [False, True])
def test_its_own_numbers_make_the_same_arm(name, placed):
    arm = gd.load_arm(name)
    if placed:
        arm = dataclasses.replace(arm, dh_table=())
    numbers = own_numbers(arm)
    assert all(ArmNumber.named(number) is not None for number in numbers)
    assert fingerprint(with_numbers(arm, numbers)) == fingerprint(arm)


@pytest.mark.parametrize(
    ("number", "given", "line", "edited"),
    [
        ("link2.mass", "20500 g", "mass = 17.4", "mass = 20.5"),
        ("joint2.a", 0.5, "a = 0.4318", "a = 0.5"),
        ("joint2.a_mm", 500, "a = 0.4318", "a = 0.5"),
        ("joint2.a_mm", "0.5 m", "a = 0.4318", "a = 0.5"),
        ("link2.com.x", "-200 mm", "com = [-0.3638,", "com = [-0.2,"),
        ("link2.inertia.yy", 0.6, "yy = 0.524", "yy = 0.6"),
        ("drive1.inertia", "1.5", "inertia = 1.14", "inertia = 1.5"),
        ("drive1.torque_limit", 99, "torque_limit = 97.6", "torque_limit = 99.0"),
        ("drive1.coulomb.negative", -0.4, "coulomb = [0.395, -0.435]", "coulomb = [0.395, -0.4]"),
        ("joint1.range.upper", 3.0, "range_deg = [-160.0, 160.0]", "range = [-2.792526803190927, 3.0]"),
        ("link2.mass_uncertainty", 0.1, "mass = 17.4", "mass = 17.4\nmass_uncertainty = 0.1"),
    ],
)  # fmt: skip
def test_a_number_is_that_of_the_edited_file(puma, tmp_path, number, given, line, edited):
    gd.save_arm(puma, tmp_path / "puma.toml")
    text = (tmp_path / "puma.toml").read_text(encoding="utf-8")
    assert text.count(line) == 1
    (tmp_path / "edited.toml").write_text(text.replace(line, edited), encoding="utf-8")
    arm = gd.load_arm(tmp_path / "edited.toml")
    changed = dataclasses.replace(with_numbers(puma, {number: given}), assumptions=arm.assumptions)
    assert describe(changed) == describe(arm)


def test_a_length_is_an_offset_of_the_placed_arm(puma, pick_and_place):
    """In placements a2 is the offset of link 2's frame; other places turn as their angles say."""
    placed = dataclasses.replace(puma, dh_table=())
    ours = with_numbers(placed, {"link2.frame_xyz.x": 0.5})
    theirs = with_numbers(puma, {"joint2.a": "50 cm"})
    torques = [gd.decompose(arm, pick_and_place).torque.values for arm in (ours, theirs)]
    np.testing.assert_allclose(*torques, rtol=1e-12, atol=1e-12)
    turned = with_numbers(placed, {"joint1.rpy_deg.z": 90})
    rotation = turned.joints[0].placement.rotation
    np.testing.assert_allclose(rotation, [[0, -1, 0], [1, 0, 0], [0, 0, 1]], atol=1e-15)


def test_all_else_is_kept_and_it_is_said(puma):
    uncertain = with_uncertainty(puma, "mass=5%")
    changed = with_numbers(uncertain, {"link3.mass": 2})
    assert changed.links[2].uncertainty.mass == uncertain.links[2].uncertainty.mass
    assert [link.source for link in changed.links] == [link.source for link in puma.links]
    assert (changed.name, changed.tip) == (puma.name, puma.tip)
    assert "link3.mass = 2" in changed.assumptions[-1]
    with pytest.warns(GdAnalyzeWarning, match="dense"):
        with_numbers(puma, {"link3.mass": 4000})


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"link9.mass": 1}, "links 1 to 6"),
        ({"link3.mas": 1}, "link3.mas"),
        ({"link3.com": 1}, "link3.com"),
        ({"link3.mass.x": 1}, "link3.mass.x"),
        ({"link0.mass": 1}, "link0.mass"),
        ({"joint2.a_deg": 1}, "joint2.a_deg"),
        ({"joint2.xyz.x": 1}, "Denavit-Hartenberg"),
        ({"joint2.a": 0.4, "joint2.a_mm": 400}, "joint2.a_mm"),
        ({"link3.mass": "5 apples"}, "5 apples"),
        ({"link3.mass": "5 mm"}, "kg, g"),
        ({"link3.mass": ""}, "kg"),
        ({"link3.mass": True}, "True"),
        ({"link3.com_uncertainty.x": 1}, "com_uncertainty"),
        ({"link3.mass": float("nan")}, "nan"),
    ],
)  # fmt: skip
def test_what_is_no_number_of_the_arm_is_told(puma, given, says):
    with pytest.raises(UsageError) as caught:
        with_numbers(puma, given)
    assert says in str(caught.value)
    assert caught.value.details["where"] in given


@pytest.mark.parametrize(
    "given",
    [
        {"link3.mass": -1},
        {"link3.mass": "1e400"},
        {"drive1.inertia": -1},
        {"link1.inertia.zz": -0.1},
        {"link4.inertia.zz": 0.1},
        {"link4.inertia.xy": 0.5},
        {"joint2.a": 1e13},
    ],
)  # fmt: skip
def test_an_arm_that_cannot_be_is_refused_with_the_number(puma, given):
    ((name, value),) = given.items()
    with pytest.raises(ArmError, match="no valid arm") as caught:
        with_numbers(puma, given)
    assert caught.value.details["where"] == name
    assert f"{name} = " in str(caught.value)
    assert str(value).removesuffix("1e400") in str(caught.value) or "1e+13" in str(caught.value)


def test_an_arm_without_drives_has_no_inertia_of_drives(two_link):
    with pytest.raises(UsageError, match="drive_inertia"):
        with_numbers(two_link, {"drive1.inertia": 1})
