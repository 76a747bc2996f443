"""Arm files in TOML: what they may state, and what is refused with the line to fix."""

from __future__ import annotations

import warnings

import numpy as np
import pinocchio as pin
import pytest
from arm_files import ARM, PLACED, line_of

from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.description import fingerprint
from strategies import random_states


def test_the_example_is_fine(file):
    arm = load_arm(file(ARM))
    assert [joint.kind for joint in arm.joints] == ["revolute", "prismatic"]
    assert arm.joints[0].upper == pytest.approx(1.5707963267948966, rel=1e-15)
    assert arm.links[0].frame.translation[0] == 0.5
    assert arm.links[1].inertia_com[0, 1] == arm.links[1].inertia_com[1, 0] == 0.001
    assert arm.drive_inertia.tolist() == [0.5, 0.25]
    assert arm.title == "mine"


def test_units_in_keys(file):
    plain = read_arm(file(ARM))
    suffixed = ARM.replace("range = [0.0, 0.5]", "range_mm = [0, 500]").replace(
        "com = [0.0, 0.0, 0.1]", "com_mm = [0.0, 0.0, 100.0]"
    )
    again = read_arm(file(suffixed))
    assert again.joints[1].upper == plain.joints[1].upper == 0.5
    # 100 * 1e-3 and 0.1 differ by a rounding at most.
    assert again.links[0].com[2] == pytest.approx(plain.links[0].com[2], rel=2.3e-16)


def test_inertia_about_the_origin(file):
    """Steiner: about the origin it is larger by m (c.c 1 - c c^T)."""
    about_origin = ARM.replace(
        "inertia = { xx = 0.02, yy = 0.02, zz = 0.01 }",
        'inertia = { xx = 0.04, yy = 0.04, zz = 0.01 }\ninertia_about = "origin"',
    )
    found = read_arm(file(about_origin)).links[0].inertia_com
    expected = read_arm(file(ARM)).links[0].inertia_com
    assert abs(found - expected).max() <= 1e-17  # two roundings of numbers of 0.04


def test_stated_uncertainties(file):
    plain = read_arm(file(ARM))
    assert [link.uncertainty for link in plain.links] == [None, None]
    text = ARM.replace("mass = 2.0", "mass = 2.0\nmass_uncertainty = 0.05").replace(
        "mass = 1.0",
        'mass = 1.0\ncom_uncertainty_mm = [1, 2, 3]\ninertia_about = "origin"\n'
        "inertia_uncertainty = { xx = 1e-3, yy = 2e-3, zz = 3e-3, xz = 4e-3 }",
    )
    arm = read_arm(file(text))
    first, second = (link.uncertainty for link in arm.links)
    assert (first.mass, first.com, first.inertia, first.inertia_about) == (0.05, None, None, "com")
    assert (second.mass, second.inertia_about) == (None, "origin")
    assert second.com.tolist() == [1 * 1e-3, 2 * 1e-3, 3 * 1e-3]
    assert second.inertia.tolist() == [[1e-3, 0, 4e-3], [0, 2e-3, 0], [4e-3, 0, 3e-3]]
    assert fingerprint(arm, drives=True) == fingerprint(plain, drives=True)


def test_a_mass_that_stands_for_none_has_no_density(file):
    """Its radius of gyration, cubed, is beyond a float."""
    read_arm(file(ARM.replace("mass = 2.0", "mass = 7e-283")))


def test_frames_by_placement_are_turned_as_in_urdf(file):
    """About x, then y, then z of the fixed frame: Pinocchio's own, to a few roundings of numbers up to 1."""
    arm, states = read_arm(file(PLACED)), random_states(2, 5, seed=3)
    expected = pin.rpy.rpyToMatrix(0.1, -0.2, 0.3)
    np.testing.assert_allclose(arm.joints[0].placement.rotation, expected, atol=1e-15)
    assert arm.joints[1].placement.rotation.tolist() == [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    assert arm.links[1].frame.rotation.tolist() == [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]
    assert (arm.joints[0].upper, arm.joints[1].kind) == (None, "prismatic")
    rows = PLACED[PLACED.index("rotation") : PLACED.index("\n[[links]]")]
    assert fingerprint(read_arm(file(PLACED.replace(rows, "rpy_deg = [90.0, 0.0, 0.0]\n")))) == fingerprint(
        arm
    )
    theirs = pinocchio_dynamics(arm, *states.arrays)["torque"]
    assert np.abs(torque_of(arm, states) - theirs).max() <= round_off_bounds(arm, *states.arrays)["torque"]


MASS, INERTIA = "mass = 2.0", "inertia = 0.25"
NAME = 'name = "mine"'
# What to change, what the message must say, the line it must name: the first with that text (@1: the second).
CASES: dict[str, tuple[str, str, str, str]] = {
    "unknown key at the top": (NAME, f'{NAME}\ncolour = "red"', "colour", "colour"),
    "unknown key inside": ("zz = 0.01 }", "zz = 0.01, zx = 0.0 }", "links[1].inertia.zx", "zz = 0.01, zx"),
    "missing key": (f"{MASS}\n", "", "links[1].mass", "[[links]]"),
    "missing moment": ("yy = 0.02, ", "", "links[1].inertia.yy", "xx = 0.02"),
    "a word for a number": (MASS, 'mass = "heavy"', "links[1].mass", "mass ="),
    "a truth value for a number": (MASS, "mass = true", "links[1].mass", "mass ="),
    "too few coordinates": ("com = [0.0, 0.0, 0.1]", "com = [0.0, 0.1]", "links[1].com", "com = [0.0, 0.1]"),
    "nan": (MASS, "mass = nan", "links[1].mass", "mass = nan"),
    "infinite after conversion": ("a_mm = 500.0", "a_mm = inf", "joints[1].a", "a_mm = inf"),
    "beyond any arm": ("a_mm = 500.0", "a_mm = 1e300", "joints[1].a", "a_mm = 1e300"),
    "negative mass": (MASS, "mass = -2.0", "mass of link first is negative", "[[links]]"),
    "unknown joint kind": ('kind = "prismatic"', 'kind = "spherical"', "joints[2].kind", "kind ="),
    "empty range": ("range = [0.0", "range = [0.5", "range of joint slide is empty", "[[joints]]@1"),
    "velocity limit of 0": ("limit = 2.0", "limit = 0.0", "velocity_limit of joint turn", "[[joints]]"),
    "given twice": ("a_mm = 500.0", "a_mm = 500.0\na = 0.5", "joints[1]", "[[joints]]"),
    "degrees of a slide": ("range = [0.0", "range_deg = [0.0", "joints[2].range_deg", "range_deg = [0.0"),
    "an angle in millimetres": ("alpha_deg = -90.0", "alpha_mm = 1.0", "joints[1].alpha_mm", "alpha_mm"),
    "negative drive inertia": (INERTIA, "inertia = -0.25", "drives[2].inertia", "inertia = -0.25"),
    "negative uncertainty": (MASS, f"{MASS}\nmass_uncertainty = -0.1", "links[1].mass_u", "mass_uncertainty"),
    "one uncertainty for all": (MASS, f"{MASS}\ncom_uncertainty = [1]", "links[1].com_u", "com_uncertainty"),
    "uncertainty of a drive": (
        INERTIA, f"{INERTIA}\ninertia_uncertainty = -1", "drives[2].inertia_u", "inertia_uncertainty"
    ),
    "another format": ("gd-analyze arm 1", "gd-analyze arm 9", "format", "format ="),
    "another convention": (NAME, f'{NAME}\nconvention = "mine"', "convention", "convention"),
    "a name that is a path": (NAME, 'name = "../mine"', "name", "name ="),
    "a name without end": (NAME, f'name = "{"x" * 201}"', "an arm's name", "name ="),
    "a title that acts": (NAME, f'{NAME}\ntitle = "a\\u202eb"', "an arm's title", "title ="),
    "a source that hides": (NAME, f'{NAME}\nsources = ["\\u200b"]', "one of the sources", "sources ="),
    "one link too few": ("[[drives]]", "[[joints]]\n[[drives]]", "one [[links]] table", "[[links]]@1"),
    "one drive too few": (f"[[drives]]\n{INERTIA}\n", "", "one [[drives]] table", "[[drives]]"),
    "400 digits behind a unit": (
        "range_deg = [-90.0, 90.0]", f"range_deg = [0, 0x1{'0' * 400}]", "joints[1].range[2]", "range_deg"
    ),
    "axial inertia": ("mass = 1.0", "mass = 1.0\naxial_only = true", "axis only", "[[links]]@1"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "says", "line"), CASES.values(), ids=CASES.keys())
def test_refused_with_its_line(file, old, new, says, line):
    assert old in ARM
    text = ARM.replace(old, new, 1)
    path = file(text)
    with pytest.raises(ArmError) as caught:
        read_arm(path)
    assert says in caught.value.what
    needle, _, occurrence = line.partition("@")
    assert caught.value.details["where"] == f"{path}, line {line_of(text, needle, int(occurrence or 0))}"
    assert caught.value.details["expected"]


IDENTITY = "[[1, 0, 0], [0, 1, 0], [0, 0, 1]]"
BY_PLACEMENT = {
    "a rotation that is none": ("0.0, -1.0]", "0.0, -2.0]", "joints[2].rotation", "rotation ="),
    "a mirror": ("0.0, -1.0]", "0.0, 1.0]", "joints[2].rotation", "rotation ="),
    "two rows": ("    [0.0, 1.0, 0.0],\n", "", "joints[2].rotation", "rotation ="),
    "said twice": ("rpy = [0.1", f"rotation = {IDENTITY}\nrpy = [0.1", "joints[1]", "[[joints]]"),
    "an axis too long": ("[0.6, 0.0, 0.8]", "[1, 0, 1]", "joints[1].axis", "axis ="),
    "two coordinates": ("[0.0, 0.0, 0.3]", "[0.0, 0.3]", "joints[1].xyz", "xyz ="),
    "a table's key": ("xyz = [0.0", "alpha = 0.1\nxyz = [0.0", "joints[1].alpha", "alpha"),
    "a misspelt key": ("frame_xyz_mm", "fram_xyz_mm", "links[2].fram_xyz_mm", "fram_xyz"),
    "an unknown lower end above": ("-90.0, inf", "inf, 90.0", "joints[1].range", "range_deg"),
    "a huge end": ("-90.0, inf", "-90.0, 1e300", "joints[1].range", "range_deg"),
}  # fmt: skip


@pytest.mark.parametrize(("old", "new", "says", "line"), BY_PLACEMENT.values(), ids=BY_PLACEMENT.keys())
def test_placements_refused_with_their_line(file, old, new, says, line):
    assert old in PLACED
    text = PLACED.replace(old, new, 1)
    path = file(text)
    with pytest.raises(ArmError) as caught:
        read_arm(path)
    assert says in caught.value.what
    assert caught.value.details["where"] == f"{path}, line {line_of(text, line)}"


def test_a_table_of_one_convention_has_no_keys_of_another(file):
    with pytest.raises(ArmError, match=r"joints\[1\].xyz") as caught:
        read_arm(file(PLACED.replace('"placement"', '"standard"')))
    assert "theta, d, a, alpha" in caught.value.details["expected"]


@pytest.mark.parametrize(
    ("text", "place"),
    [
        ("name = \nformat = 1\n", ", line 1, column 8"),
        ('format = "gd-analyze arm 1"\nname = "mine\n', ", line 2, column 13"),
        ("[[joints]\n", ", line 1, column 9"),
        (f"{ARM}sources = [", f", line {ARM.count(chr(10)) + 1}"),
        (ARM.replace("gravity = [0.0, 0.0, -9.81]", f"gravity = {'[' * 3000}{']' * 3000}"), ""),
        (ARM.replace("gravity = [0.0, 0.0, -9.81]", f"gravity = {'9' * 5000}"), ", line 3"),
        ("", ""),
        (b"name = '\xff'", ""),
        (ARM + "# \n" * 400_000, ""),
    ],
    ids=["value", "quote", "bracket", "cut off", "nested", "digits", "empty", "no text", "too large"],
)
def test_what_is_no_arm_file(file, text, place):
    path = file(text)
    with pytest.raises(ArmError) as caught:
        read_arm(path)
    assert caught.value.details["where"] == f"{path}{place}"
    assert {"found", "expected", "next"} & set(caught.value.details)


def test_missing_file_and_folder(tmp_path):
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(ArmError, match="cannot read the arm file") as caught:
            read_arm(path)
        assert str(path) in caught.value.details["where"]


@pytest.mark.parametrize(
    ("name", "suggestion"),
    [("puma506", "'puma560'"), ("zzz", "lists the built-in"), ("", ""), ("x" * 5000, ""), ("nul\0byte", "")],
)
def test_unknown_arms(name, suggestion):
    with pytest.raises(ArmError, match="there is no arm") as caught:
        load_arm(name)
    assert suggestion in caught.value.details["next"]
    assert "puma560, stanford, two_link" in caught.value.details["expected"]


@pytest.mark.parametrize(
    ("before", "after", "key", "likely"),
    [
        (MASS, "mas = 2.0", "links[1].mas", "mass"),
        (MASS, f"{MASS}\nas_mesured = true", "links[1].as_mesured", "as_measured"),
        ("velocity_limit = 2.0", "velocity_limits = 2.0", "joints[1].velocity_limits", "velocity_limit"),
        ("alpha_deg = -90.0", "alfa_deg = -90.0", "joints[1].alfa_deg", "alpha_deg"),
        (MASS, "mass_mm = 2.0", "links[1].mass_mm", "mass"),
        (INERTIA, "inertias = 0.25", "drives[2].inertias", "inertia"),
        ("xx = 0.02, yy", "ixx = 0.02, yy", "links[1].inertia.ixx", "xx"),
        (NAME, 'nam = "mine"', "nam", "name"),
        ("[[links]]", "[[link]]", "link", "links"),
    ],
)
def test_a_misspelt_key_is_named_with_the_likely_one(file, before, after, key, likely):
    """Where it stands for one that is then missing, too."""
    text = ARM.replace(before, after, -1 if before.startswith("[[") else 1)
    with pytest.raises(ArmError) as caught:
        read_arm(file(text))
    assert caught.value.what.endswith(f": {key}")
    assert f"did you mean {likely}?" in caught.value.details["next"]


@pytest.mark.parametrize(
    ("zz", "measured", "said"),
    [
        (0.042, False, "by 4.8 %"),  # 0.042 > 0.02 + 0.02
        (0.042, True, None),
        (0.06, True, "by 33 %"),
    ],
)
def test_a_measurement_kept_as_published_may_violate_the_triangle_inequality(file, zz, measured, said):
    text = ARM.replace("zz = 0.01 }", f"zz = {zz} }}", 1)
    text = text.replace(MASS, f"{MASS}\nas_measured = true") if measured else text
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read_arm(file(text))
    texts = [str(item.message) for item in caught if item.category is GdAnalyzeWarning]
    assert len(texts) == (said is not None)
    assert said is None or (said in texts[0] and "mine.toml, line 17: " in texts[0])
