"""Files that are no arm files, and keys that are none: refused with the place and the likely one."""

from __future__ import annotations

import pytest
from arm_files import ARM, line_of

from gd_analyze.errors import ArmError
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.catalogue import load_arm


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
        ("velocity_limit = 2.0", "velocity_limits = 2.0", "joints[1].velocity_limits", "velocity_limit"),
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
