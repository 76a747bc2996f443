"""Arm files in TOML: what they may state, what is refused with the line to fix, and arms written as such."""

from __future__ import annotations

import dataclasses
import warnings
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given

import gd_analyze as gd
from arm_files import ARM, PLACED, line_of
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import ArmError, GdAnalyzeWarning, OutputError, UsageError
from gd_analyze.robots.description import describe, fingerprint
from gd_analyze.tables import decompose_states
from gd_analyze.types import RobotArm
from strategies import arms, examples, random_states


@pytest.fixture
def file(tmp_path):
    def write(content: str) -> Path:
        path = tmp_path / "mine.toml"
        path.write_text(content, encoding="utf-8")
        return path

    return write


def test_the_example_is_fine(file):
    arm = gd.load_arm(file(ARM))
    assert [joint.kind for joint in arm.joints] == ["revolute", "prismatic"]
    assert arm.joints[0].upper == pytest.approx(1.5707963267948966, rel=1e-15)
    assert arm.links[0].frame.translation[0] == 0.5
    assert arm.links[1].inertia_com[0, 1] == arm.links[1].inertia_com[1, 0] == 0.001
    assert arm.drive_inertia.tolist() == [0.5, 0.25]
    assert arm.title == "mine"
    suffixed = ARM.replace("range = [0.0, 0.5]", "range_mm = [0, 500]")
    suffixed = suffixed.replace("com = [0.0, 0.0, 0.1]", "com_mm = [0.0, 0.0, 100.0]")
    reloaded = gd.load_arm(file(suffixed))
    assert reloaded.joints[1].upper == arm.joints[1].upper == 0.5
    # 100 * 1e-3 and 0.1 differ by a rounding at most.
    assert reloaded.links[0].com[2] == pytest.approx(arm.links[0].com[2], rel=2.3e-16)
    # The radius of gyration of a mass that stands for none, cubed, is beyond a float.
    assert gd.load_arm(file(ARM.replace("mass = 2.0", "mass = 7e-283"))).mass[0] == 7e-283


def test_inertia_about_the_origin(file):
    """Steiner: about the origin it is larger by m (c.c 1 - c c^T)."""
    about_origin = ARM.replace(
        "inertia = { xx = 0.02, yy = 0.02, zz = 0.01 }",
        'inertia = { xx = 0.04, yy = 0.04, zz = 0.01 }\ninertia_about = "origin"',
    )
    inertia = gd.load_arm(file(about_origin)).links[0].inertia_com
    expected = gd.load_arm(file(ARM)).links[0].inertia_com
    assert abs(inertia - expected).max() <= 1e-17  # two roundings of numbers of 0.04


def test_stated_uncertainties(file):
    text = ARM.replace("mass = 2.0", "mass = 2.0\nmass_uncertainty = 0.05").replace(
        "mass = 1.0",
        'mass = 1.0\ncom_uncertainty_mm = [1, 2, 3]\ninertia_about = "origin"\n'
        "inertia_uncertainty = { xx = 1e-3, yy = 2e-3, zz = 3e-3, xz = 4e-3 }",
    )
    first, second = (link.uncertainty for link in gd.load_arm(file(text)).links)
    assert (first.mass, first.com, first.inertia, first.inertia_about) == (0.05, None, None, "com")
    assert (second.mass, second.com.tolist(), second.inertia_about) == (None, [0.001, 0.002, 0.003], "origin")
    assert second.inertia.tolist() == [[1e-3, 0, 4e-3], [0, 2e-3, 0], [4e-3, 0, 3e-3]]


def test_frames_by_placement_are_turned_as_in_urdf(file):
    """About x, then y, then z of the fixed frame: Pinocchio's own, to a few roundings of numbers up to 1."""
    arm, states = gd.load_arm(file(PLACED)), random_states(2, 5, seed=3)
    expected = pin.rpy.rpyToMatrix(0.1, -0.2, 0.3)
    np.testing.assert_allclose(arm.joints[0].placement.rotation, expected, atol=1e-15)
    assert arm.joints[1].placement.rotation.tolist() == [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    assert arm.links[1].frame.rotation.tolist() == [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]
    assert (arm.joints[0].upper, arm.joints[1].kind) == (None, "prismatic")
    rows = PLACED[PLACED.index("rotation") : PLACED.index("\n[[links]]")]
    by_angles = gd.load_arm(file(PLACED.replace(rows, "rpy_deg = [90.0, 0.0, 0.0]\n")))
    assert fingerprint(by_angles) == fingerprint(arm)
    theirs = pinocchio_dynamics(arm, *states.arrays)["torque"]
    assert (
        np.abs(decompose_states(arm, states)["torque"] - theirs).max()
        <= round_off_bounds(arm, *states.arrays)["torque"]
    )


MASS, INERTIA = "mass = 2.0", "inertia = 0.25"
NAME = 'name = "mine"'
IDENTITY = "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
# What to change, what the message must say, the line it must name: the first with that text (@1: the second).
CASES: list[tuple[str, str, str, str]] = [
    ("yy = 0.02, ", "", "links[1].inertia.yy", "xx = 0.02"),
    (MASS, "mass = true", "links[1].mass", "mass ="),
    ("com = [0.0, 0.0, 0.1]", "com = [0.0, 0.1]", "links[1].com", "com = [0.0, 0.1]"),
    ("a_mm = 500.0", "a_mm = inf", "joints[1].a", "a_mm = inf"),
    ("a_mm = 500.0", "a_mm = 500.0\na = 0.5", "joints[1].a", "a = 0.5"),
    ('kind = "prismatic"', 'kind = "spherical"', "joints[2].kind", "kind ="),
    ("range = [0.0", "range = [0.5", "range of joint slide is empty", "[[joints]]@1"),
    ("range = [0.0", "range_deg = [0.0", "joints[2].range_deg", "range_deg = [0.0"),
    ("limit = 2.0", "limit = 0.0", "velocity_limit of joint turn", "[[joints]]"),
    (MASS, f"{MASS}\nmass_uncertainty = -0.1", "links[1].mass_u", "mass_uncertainty"),
    ("gd-analyze arm 1", "gd-analyze arm 9", "format", "format ="),
    (NAME, 'name = "../mine"', "name", "name ="),
    (NAME, f'{NAME}\nsources = ["\\u200b"]', "sources", "sources ="),
    (f"[[drives]]\n{INERTIA}\n", "", "one [[drives]] table", "[[drives]]"),
    ("mass = 1.0", "mass = 1.0\naxial_only = true", "axis only", "[[links]]@1"),
    # Misspelt keys, named with the likely one, also where that is missing then.
    (MASS, "mas = 2.0", "did you mean mass?", "mas ="),
    (MASS, "mass_mm = 2.0", "did you mean mass?", "mass_mm"),
    ("xx = 0.02, yy", "ixx = 0.02, yy", "did you mean xx?", "ixx"),
    ("[[links]]", "[[link]]", "did you mean links?", "[[link]]"),
]  # fmt: skip
BY_PLACEMENT = [
    ("0.0, -1.0]", "0.0, 1.0]", "joints[2].rotation", "rotation ="),  # a mirror
    ("rpy = [0.1", f"rotation = {IDENTITY}\nrpy = [0.1", "joints[1].rpy", "rpy ="),
    ("[0.6, 0.0, 0.8]", "[1, 0, 1]", "joints[1].axis", "axis ="),
    ("xyz = [0.0", "alpha = 0.1\nxyz = [0.0", "joints[1].alpha", "alpha"),
    ("-90.0, inf", "inf, 90.0", "joints[1].range", "range_deg"),
    ('"placement"', '"standard"', "joints[1].xyz", "xyz"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("base", "old", "new", "says", "line"),
    [(ARM, *case) for case in CASES] + [(PLACED, *case) for case in BY_PLACEMENT],
)
def test_refused_with_its_line(file, base, old, new, says, line):
    assert old in base
    text = base.replace(old, new, 1)
    path = file(text)
    with pytest.raises(ArmError) as caught:
        gd.load_arm(path)
    assert says in str(caught.value)
    needle, _, occurrence = line.partition("@")
    assert caught.value.details["where"] == f"{path}, line {line_of(text, needle, int(occurrence or 0))}"


def test_files_that_end_early_or_never(file):
    path = file(f"{ARM}sources = [")
    with pytest.raises(ArmError, match=f"mine.toml, line {ARM.count(chr(10)) + 1}"):
        gd.load_arm(path)
    with pytest.raises(ArmError, match="too large"):
        gd.load_arm(file(ARM + "# \n" * 400_000))


@pytest.mark.parametrize("name", ["puma506", "", "x" * 5000, "nul\0byte"])
def test_unknown_arms(name):
    with pytest.raises(ArmError) as caught:
        gd.load_arm(name)
    assert all(arm in caught.value.details["expected"] for arm in gd.builtin_arms())
    assert ("'puma560'" in caught.value.details["next"]) == (name == "puma506")


def read_back(arm: RobotArm, folder: Path) -> RobotArm:
    path = folder / "written.toml"
    gd.save_arm(arm, path)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        return gd.load_arm(path)


def same_but_for(arm: RobotArm, reloaded: RobotArm, *names: str) -> None:
    before, after = describe(arm), describe(reloaded)
    for name in names:
        del before[name], after[name]
    assert after == before


@examples(30)
@given(arms(max_joints=6))
def test_any_arm_reads_back_to_the_last_bit(tmp_path_factory, arm):
    reloaded = read_back(arm, tmp_path_factory.mktemp("arm"))
    assert fingerprint(reloaded, drives=True) == fingerprint(arm, drives=True)
    same_but_for(arm, reloaded)


@pytest.mark.parametrize("name", gd.builtin_arms())
def test_built_in_arms_keep_their_table(name, tmp_path):
    arm = gd.load_arm(name)
    reloaded = read_back(arm, tmp_path)
    assert reloaded.dh_table == arm.dh_table
    same_but_for(arm, reloaded)


def test_right_angles_texts_and_names_come_back(file, tmp_path):
    arm = dataclasses.replace(
        gd.load_arm(file(PLACED)),
        name="my arm / 2",
        title="my arm / 2",
        sources=('A "quoted" \\ source\nof two lines', "é"),
        doubts=("its base is moved",),
    )
    reloaded = read_back(arm, tmp_path)
    assert reloaded.name == "my_arm___2"
    same_but_for(arm, reloaded, "name")
    text = (tmp_path / "written.toml").read_text(encoding="utf-8")
    assert "\nrpy_deg = [90.0, 0.0, 0.0]" in text
    assert "range_deg = [-90.0, inf]" in text
    with pytest.warns(GdAnalyzeWarning, match="its base is moved"):
        gd.load_arm(tmp_path / "written.toml")


@pytest.mark.parametrize("name", ["arm.urdf", "arm"])
def test_an_arm_is_not_written_under_a_name_that_reads_as_another_format(two_link, name, tmp_path):
    with pytest.raises(OutputError) as caught:
        gd.save_arm(two_link, tmp_path / name)
    assert ".toml" in caught.value.details["expected"]
    assert not list(tmp_path.iterdir())


def test_what_is_no_arm_is_not_written(tmp_path):
    with pytest.raises(UsageError):
        gd.save_arm("two_link", tmp_path / "arm.toml")
