"""Every way an arm file can be wrong: refused with the line to mend, or warned about."""

from __future__ import annotations

import pytest
from arm_files import ARM, line_of

from gd_analyze.errors import ArmError
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.catalogue import load_arm


def test_the_example_is_fine(file):
    arm = load_arm(file(ARM))
    assert [joint.kind for joint in arm.joints] == ["revolute", "prismatic"]
    assert arm.joints[0].upper == pytest.approx(1.5707963267948966, rel=1e-15)
    assert arm.links[0].frame.translation[0] == 0.5
    assert arm.links[1].inertia_com[0, 1] == arm.links[1].inertia_com[1, 0] == 0.001
    assert arm.drive_inertia.tolist() == [0.5, 0.25]
    assert arm.title == "mine"


# What to change, what the message must say, the line it must name: the first with that text (@1: the second).
CASES: dict[str, tuple[str, str, str, str]] = {
    "unknown key": ("mass = 2.0", "mass = 2.0\nmas = 1.0", "links[1].mas", "mas = 1.0"),
    "unknown key at the top": ('name = "mine"', 'name = "mine"\ncolour = "red"', "colour", "colour"),
    "unknown key inside inertia": (
        "zz = 0.01 }",
        "zz = 0.01, zx = 0.0 }",
        "links[1].inertia.zx",
        "zz = 0.01, zx",
    ),
    "missing key": ("mass = 2.0\n", "", "links[1].mass", "[[links]]"),
    "missing moment": ("yy = 0.02, ", "", "links[1].inertia.yy", "xx = 0.02"),
    "a word for a number": ("mass = 2.0", 'mass = "heavy"', "links[1].mass", "mass ="),
    "a truth value for a number": ("mass = 2.0", "mass = true", "links[1].mass", "mass ="),
    "too few coordinates": ("com = [0.0, 0.0, 0.1]", "com = [0.0, 0.1]", "links[1].com", "com = [0.0, 0.1]"),
    "nan": ("mass = 2.0", "mass = nan", "links[1].mass", "mass = nan"),
    "infinity": (
        "com = [0.0, 0.0, 0.1]",
        "com = [0.0, 0.0, inf]",
        "links[1].com[3]",
        "com = [0.0, 0.0, inf]",
    ),
    "infinite after conversion": ("a_mm = 500.0", "a_mm = inf", "joints[1].a", "a_mm = inf"),
    "negative mass": ("mass = 2.0", "mass = -2.0", "mass of link first is negative", "[[links]]"),
    "unknown joint kind": ('kind = "prismatic"', 'kind = "spherical"', "joints[2].kind", "kind ="),
    "empty range": (
        "range = [0.0, 0.5]",
        "range = [0.5, 0.5]",
        "range of joint slide is empty",
        "[[joints]]@1",
    ),
    "reversed range": ("[-90.0, 90.0]", "[90.0, -90.0]", "range of joint turn is empty", "[[joints]]"),
    "rate limit of zero": (
        "velocity_limit = 2.0",
        "velocity_limit = 0.0",
        "velocity limit of joint turn",
        "[[joints]]",
    ),
    "given twice": ("a_mm = 500.0", "a_mm = 500.0\na = 0.5", "joints[1]", "[[joints]]"),
    "degrees of a slide": ("range = [0.0", "range_deg = [0.0", "joints[2].range_deg", "range_deg = [0.0"),
    "a length in degrees": ("a_mm = 500.0", "a_deg = 5.0", "joints[1].a_deg", "a_deg = 5"),
    "an angle in millimetres": ("alpha_deg = -90.0", "alpha_mm = 1.0", "joints[1].alpha_mm", "alpha_mm"),
    "a mass in millimetres": ("mass = 2.0", "mass_mm = 2.0", "links[1].mass", "mass_mm"),
    "negative drive inertia": ("inertia = 0.25", "inertia = -0.25", "drives[2].inertia", "inertia = -0.25"),
    "negative mass uncertainty": (
        "mass = 2.0",
        "mass = 2.0\nmass_uncertainty = -0.1",
        "links[1].mass_uncertainty",
        "mass_uncertainty",
    ),
    "mass uncertainty in percent": (
        "mass = 2.0",
        'mass = 2.0\nmass_uncertainty = "1%"',
        "links[1].mass_uncertainty",
        "mass_uncertainty",
    ),
    "one uncertainty for all coordinates": (
        "mass = 1.0",
        "mass = 1.0\ncom_uncertainty = [0.001]",
        "links[2].com_uncertainty",
        "com_uncertainty",
    ),
    "negative uncertainty in millimetres": (
        "mass = 1.0",
        "mass = 1.0\ncom_uncertainty_mm = [1.0, -1.0, 1.0]",
        "links[2].com_uncertainty[2]",
        "com_uncertainty_mm",
    ),
    "negative uncertainty of a product": (
        "mass = 1.0",
        "mass = 1.0\ninertia_uncertainty = { xx = 0.0, yy = 0.0, zz = 0.0, xy = -0.001 }",
        "links[2].inertia_uncertainty.xy",
        "inertia_uncertainty",
    ),
    "missing moment of an uncertainty": (
        "mass = 1.0",
        "mass = 1.0\ninertia_uncertainty = { xx = 0.001 }",
        "links[2].inertia_uncertainty.yy",
        "inertia_uncertainty",
    ),
    "infinite uncertainty": (
        "mass = 1.0",
        "mass = 1.0\nmass_uncertainty = inf",
        "links[2].mass_uncertainty",
        "mass_uncertainty",
    ),
    "negative uncertainty of a drive": (
        "inertia = 0.25",
        "inertia = 0.25\ninertia_uncertainty = -0.1",
        "drives[2].inertia_uncertainty",
        "inertia_uncertainty",
    ),
    "another format": ("gd-analyze arm 1", "gd-analyze arm 9", "format", "format ="),
    "another convention": ('name = "mine"', 'name = "mine"\nconvention = "mine"', "convention", "convention"),
    "a name that is a path": ('name = "mine"', 'name = "../mine"', "name", "name ="),
    "one link too few": (
        "[[drives]]",
        "[[joints]]\n[[drives]]",
        "one [[links]] table per joint",
        "[[links]]@1",
    ),
    "a title that acts": ('name = "mine"', 'name = "mine"\ntitle = "a\\u202eb"', "an arm's title", "title ="),
    "a title without end": (
        'name = "mine"',
        f'name = "mine"\ntitle = "{"x" * 201}"',
        "an arm's title",
        "title =",
    ),
    "a name without end": ('name = "mine"', f'name = "{"x" * 201}"', "an arm's name", "name ="),
    "a source that hides": (
        'name = "mine"',
        'name = "mine"\nsources = ["\\u200b"]',
        "one of the sources",
        "sources =",
    ),
    "an assumption that hides": (
        'name = "mine"',
        'name = "mine"\nassumptions = ["a", "\\u200b"]',
        "one of the assumptions",
        "assumptions =",
    ),
    "400 digits behind a unit": (
        "range_deg = [-90.0, 90.0]",
        f"range_deg = [0, 0x1{'0' * 400}]",
        "joints[1].range[2]",
        "range_deg",
    ),
    "one drive too few": ("[[drives]]\ninertia = 0.25\n", "", "one [[drives]] table per joint", "[[drives]]"),
}


@pytest.mark.parametrize(("old", "new", "says", "line"), CASES.values(), ids=CASES.keys())
def test_impossible(file, old, new, says, line):
    assert ARM.count(old) >= 1
    text = ARM.replace(old, new, 1)
    path = file(text)
    with pytest.raises(ArmError) as caught:
        read_arm(path)
    assert says in caught.value.what
    needle, _, occurrence = line.partition("@")
    assert caught.value.details["where"] == f"{path}, line {line_of(text, needle, int(occurrence or 0))}"
    assert caught.value.details["expected"]
