"""Every way an arm file can be wrong: refused with the line to mend, or warned about."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots import fingerprint, load_arm, read_arm

ARM = """\
format = "gd-analyze arm 1"
name = "mine"
gravity = [0.0, 0.0, -9.81]

[[joints]]
name = "turn"
alpha_deg = -90.0
a_mm = 500.0
range_deg = [-90.0, 90.0]
rate_limit = 2.0

[[joints]]
name = "slide"
kind = "prismatic"
range = [0.0, 0.5]

[[links]]
name = "first"
mass = 2.0
com = [0.0, 0.0, 0.1]
inertia = { xx = 0.02, yy = 0.02, zz = 0.01 }

[[links]]
name = "second"
mass = 1.0
com = [0.0, 0.0, 0.0]
inertia = { xx = 0.01, yy = 0.01, zz = 0.01, xy = 0.001 }

[[drives]]
inertia = 0.5

[[drives]]
inertia = 0.25
"""


def line_of(text: str, needle: str, occurrence: int = 0) -> int:
    return [i for i, line in enumerate(text.splitlines(), start=1) if needle in line][occurrence]


@pytest.fixture
def file(tmp_path: Path) -> Callable[[str | bytes], Path]:
    def write(content: str | bytes) -> Path:
        path = tmp_path / "mine.toml"
        path.write_bytes(content.encode() if isinstance(content, str) else content)
        return path

    return write


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
    "rate limit of zero": ("rate_limit = 2.0", "rate_limit = 0.0", "rate limit of joint turn", "[[joints]]"),
    "given twice": ("a_mm = 500.0", "a_mm = 500.0\na = 0.5", "joints[1]", "[[joints]]"),
    "degrees of a slide": ("range = [0.0", "range_deg = [0.0", "joints[2].range_deg", "range_deg = [0.0"),
    "a length in degrees": ("a_mm = 500.0", "a_deg = 5.0", "joints[1].a_deg", "a_deg = 5"),
    "an angle in millimetres": ("alpha_deg = -90.0", "alpha_mm = 1.0", "joints[1].alpha_mm", "alpha_mm"),
    "a mass in millimetres": ("mass = 2.0", "mass_mm = 2.0", "links[1].mass", "mass_mm"),
    "not a semidefinite inertia": (
        "xy = 0.001",
        "xy = 0.02",
        "link second is not positive semidefinite",
        "[[links]]@1",
    ),
    "triangle inequality": (
        "zz = 0.01 }",
        "zz = 0.06 }",
        "link first breaks the triangle inequality",
        "[[links]]",
    ),
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


@pytest.mark.parametrize(
    ("text", "line", "column"),
    [
        ("name = \nformat = 1\n", 1, 8),
        ('format = "gd-analyze arm 1"\nname = "mine\n', 2, 13),
        ("a = 1\na = 2\n", 2, 6),
        ("[[joints]\n", 1, 9),
        (ARM + "[[links]]\nmass = 1,5\n", ARM.count("\n") + 2, 9),
    ],
)
def test_malformed_toml(file, text, line, column):
    path = file(text)
    with pytest.raises(ArmError, match="not valid TOML") as caught:
        read_arm(path)
    assert caught.value.details["where"] == f"{path}, line {line}, column {column}"
    assert "at line" not in caught.value.details["found"]
    assert caught.value.details["next"]


@pytest.mark.parametrize(
    ("value", "what", "place"),
    [
        ("[" * 3000 + "]" * 3000, "nests tables or lists beyond any arm", ""),
        ("9" * 5000, "a number of thousands of digits", ", line 3"),
    ],
    ids=["nested", "digits"],
)
def test_what_no_parser_should_have_to_make(file, value, what, place):
    path = file(ARM.replace("gravity = [0.0, 0.0, -9.81]", f"gravity = {value}"))
    with pytest.raises(ArmError, match=what) as caught:
        read_arm(path)
    assert caught.value.details["where"] == f"{path}{place}"


def test_a_mass_that_stands_for_none_has_no_density(file):
    """Its radius of gyration, cubed, is beyond a float."""
    read_arm(file(ARM.replace("mass = 2.0", "mass = 7e-283")))


def test_cut_off_toml_names_the_last_line(file):
    path = file(ARM + "sources = [")
    with pytest.raises(ArmError, match="not valid TOML") as caught:
        read_arm(path)
    assert f"line {ARM.count(chr(10)) + 1}" in caught.value.details["where"]


def test_empty_file(file):
    with pytest.raises(ArmError, match="does not fit the schema") as caught:
        read_arm(file(""))
    assert caught.value.details["found"] == "nothing"


def test_not_text(file):
    with pytest.raises(ArmError, match="is not text") as caught:
        read_arm(file(b"name = '\xff'"))
    assert caught.value.details["found"] == "byte 0xff at offset 8"


def test_missing_file_and_folder(tmp_path):
    for path in (tmp_path / "none.toml", tmp_path):
        with pytest.raises(ArmError, match="cannot read the arm file") as caught:
            read_arm(path)
        assert str(path) in caught.value.details["where"]


@pytest.mark.parametrize(
    ("name", "suggestion"),
    [
        ("puma506", "did you mean 'puma560'?"),
        ("twolink", "did you mean 'two_link'?"),
        ("zzz", "lists the built-in"),
    ],
)
def test_unknown_arm(name, suggestion):
    with pytest.raises(ArmError, match="there is no arm") as caught:
        load_arm(name)
    assert suggestion in caught.value.details["next"]
    assert "puma560, stanford, two_link" in caught.value.details["expected"]


@pytest.mark.parametrize("name", ["", "x" * 5000, "nul\0byte", "mine.toml"])
def test_impossible_names(name):
    with pytest.raises(ArmError, match="there is no arm"):
        load_arm(name)


@pytest.mark.parametrize(
    ("before", "after", "key", "likely"),
    [
        ("mass = 2.0", "mas = 2.0", "links[1].mas", "mass"),
        ("com = [0.0, 0.0, 0.1]", "comm = [0.0, 0.0, 0.1]", "links[1].comm", "com"),
        ("mass = 2.0", "mass = 2.0\nas_mesured = true", "links[1].as_mesured", "as_measured"),
        ("rate_limit = 2.0", "rate_limits = 2.0", "joints[1].rate_limits", "rate_limit"),
        ("alpha_deg = -90.0", "alfa_deg = -90.0", "joints[1].alfa_deg", "alpha_deg"),
        ("mass = 2.0", "mass_mm = 2.0", "links[1].mass_mm", "mass"),
        ("inertia = 0.25", "inertias = 0.25", "drives[2].inertias", "inertia"),
        ("xx = 0.02, yy", "ixx = 0.02, yy", "links[1].inertia.ixx", "xx"),
        ('name = "mine"', 'nam = "mine"', "nam", "name"),
    ],
)
def test_a_misspelt_key_is_named_with_the_likely_one(file, before, after, key, likely):
    """Where it stands for one that is then missing, too."""
    text = ARM.replace(before, after, 1)
    with pytest.raises(ArmError) as caught:
        read_arm(file(text))
    error = caught.value
    assert error.what == f"the arm file does not fit the schema: {key}"
    line = line_of(text, after.splitlines()[-1].split(",")[0])
    assert error.details["where"].endswith(f"mine.toml, line {line}")
    assert error.details["next"].startswith(f"did you mean {likely}?")
    assert likely.removesuffix("_deg") in error.details["expected"].removeprefix(
        "a key of the schema: "
    ).split(", ")


def test_misspelt_tables(file):
    with pytest.raises(ArmError, match="schema: link\n") as caught:
        read_arm(file(ARM.replace("[[links]]", "[[link]]")))
    assert "did you mean links?" in caught.value.details["next"]


SLIGHTLY_OFF = ARM.replace("zz = 0.01 }", "zz = 0.042 }")  # 0.042 > 0.02 + 0.02 by 5 %


def test_a_triangle_inequality_broken_by_a_measurements_error_warns(file):
    with pytest.warns(GdAnalyzeWarning, match=r"line 17: .*first breaks the triangle inequality by 4\.8%"):
        read_arm(file(SLIGHTLY_OFF))


def test_a_measurement_kept_as_published_is_silent(file):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_arm(file(SLIGHTLY_OFF.replace("mass = 2.0", "mass = 2.0\nas_measured = true")))


def test_as_measured_does_not_excuse_the_impossible(file):
    text = ARM.replace("zz = 0.01 }", "zz = 0.06 }").replace("mass = 2.0", "mass = 2.0\nas_measured = true")
    with pytest.raises(ArmError, match="triangle inequality"):
        read_arm(file(text))


def test_inertia_known_about_the_axis_only(file):
    text = ARM.replace("xx = 0.02, yy = 0.02, zz = 0.01", "xx = 0.0, yy = 0.35, zz = 0.0")
    with pytest.raises(ArmError, match="triangle inequality"):
        read_arm(file(text))
    read_arm(file(text.replace("mass = 2.0", "mass = 2.0\naxial_only = true")))
    with pytest.raises(ArmError, match="about the joint axis only"):
        read_arm(file(ARM.replace("mass = 1.0", "mass = 1.0\naxial_only = true")))


def test_a_centre_of_mass_in_millimetres_is_suspicious(file):
    with pytest.warns(GdAnalyzeWarning, match="are its units metres"):
        read_arm(file(ARM.replace("com = [0.0, 0.0, 0.1]", "com = [0.0, 0.0, 100.0]")))


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


def test_urdf_is_named_for_what_it_is(tmp_path):
    path = tmp_path / "arm.urdf"
    path.write_text('<?xml version="1.0"?>\n<robot name="arm"/>\n', encoding="utf-8")
    with pytest.raises(ArmError, match="which is not read") as caught:
        read_arm(path)
    assert "docs/arms.md" in str(caught.value)
