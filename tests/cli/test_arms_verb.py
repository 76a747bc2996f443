"""`gd-analyze arms`: the list, one arm in full with suspicious numbers first, and any arm as TOML."""

from __future__ import annotations

import tomllib

import pytest

import gd_analyze as gd
from gd_analyze.robots.description import fingerprint
from robot_files import INERTIA, joint, link, two_joints, urdf

# The moments are 0.03, 0.04 and 0.05 but for products; 0.15 is more than the others by half of itself.
ODD = two_joints().replace(link("upper"), link("upper", izz=0.15))


@pytest.fixture
def odd(here):
    (here / "odd.urdf").write_text(ODD, encoding="utf-8")
    return "odd.urdf"


def test_the_list_of_built_in_arms(run):
    result = run("arms")
    assert (result.code, result.err) == (0, "")
    assert all(name in result.out for name in [*gd.builtin_arms(), "pick-and-place"])
    assert [row["name"] for row in run("arms", "--json").json["arms"]] == list(gd.builtin_arms())


@pytest.mark.parametrize("name", list(gd.builtin_arms()))
def test_one_arm_in_full_within_80_columns(run, name):
    result, document = run("arms", name), run("arms", name, "--json").json
    assert (result.code, result.err) == (0, "")
    assert max(map(len, result.out.splitlines())) <= 80
    arm = gd.load_arm(name)
    flowing = " ".join(result.out.split())
    for text in (*(part.name for part in (*arm.joints, *arm.links)), *arm.sources, *arm.assumptions):
        assert text in flowing
    assert document["suspicious"] == []
    assert [link["mass"] for link in document["links"]] == arm.mass.tolist()
    assert [drive["inertia"] for drive in document["drives"]] == [drive.inertia for drive in arm.drives]


def test_products_of_inertia_and_long_numbers_are_never_cut(run, here):
    (here / "own.toml").write_text(
        'format = "gd-analyze arm 1"\nname = "own"\n[[joints]]\nname = "a joint with quite a long name"\n'
        "[[links]]\nmass = 1.23456\ncom = [0.123456, -0.234567, 0.345678]\n"
        "inertia = { xx = 0.912345, yy = 0.923456, zz = 0.934567, "
        "xy = -0.0123456, xz = 0.0234567, yz = 0.0345678 }\n"
    )
    out = run("arms", "own.toml").out
    for number in ("1.23456", "-0.234567", "0.934567", "-0.0123456", "0.0345678"):
        assert number in out


def test_suspicious_numbers_stand_first_with_their_line(run, odd):
    result = run("arms", odd)
    assert (result.code, result.err) == (0, "")
    said = result.out
    line = ODD[: ODD.index('izz="0.15"')].count("\n") + 1
    flowing = " ".join(said.split())
    assert f"Suspicious - line {line}" in flowing
    assert "the inertia of link upper violates the triangle inequality by 5" in flowing
    assert said.index("Suspicious") < said.index("Chain") < said.index("Joint frames") < said.index("Links")
    assert "?" in said  # no acceleration limits in URDF
    document = run("arms", odd, "--json").json
    [text] = document["suspicious"]
    assert text.startswith("odd.urdf, line ")
    assert document["joints"][1]["axis"] == [0.0, 1.0, 0.0]


def test_a_prismatic_arm_without_products_of_inertia(run, here):
    name = "a rather long name of a carriage on rails"
    sliding = urdf(
        link("base"),
        link(name, 1.23456789, "0.123456 -0.234567 0.345678", "0 0 0"),
        joint("rail", "base", name, "prismatic", rpy="0 0 0", axis="0 -1 0"),
    )
    for key in ("ixy", "ixz", "iyz"):
        sliding = sliding.replace(f'{key}="{INERTIA[key]!r}"', f'{key}="0"')
    (here / "rail.urdf").write_text(sliding, encoding="utf-8")
    said = run("arms", "rail.urdf").out
    assert "-y  prismatic" in said
    assert "All products of inertia are zero" in said
    assert max(map(len, said.splitlines())) <= 80


def test_any_arm_becomes_toml(run, here, odd):
    result = run("arms", odd, "--limits", "all=10", "--to", "toml")
    assert result.code == 0
    assert "the inertia of link" in result.err
    (here / "own.toml").write_text(result.out, encoding="utf-8")
    assert tomllib.loads(result.out)["convention"] == "placement"
    with pytest.warns(gd.GdAnalyzeWarning):
        before, after = gd.load_arm(odd, limits=["all=10"]), gd.load_arm("own.toml")
    assert fingerprint(after, drives=True) == fingerprint(before, drives=True)
    names = [[part.name for part in (*arm.joints, *arm.links)] for arm in (before, after)]
    assert names[0] == names[1]
    assert after.joints[0].acceleration_limit == 10.0
    # A file that is TOML already keeps its comments; with something added it is written anew.
    assert run("arms", "own.toml", "--to", "toml").out == result.out
    changed = tomllib.loads(run("arms", "puma560", "--limits", "all=7", "--to", "toml").out)
    assert changed["joints"][3]["acceleration_limit"] == 7.0
    assert changed["convention"] == "standard"


def test_another_form_is_refused(run, odd):
    result = run("arms", odd, "--to", "urdf")
    assert result.code == 2
    assert "'toml'" in result.err
    assert run("arms", odd, "--to", "toml", "--json").code == 2


UNCERTAIN = """\
format = "gd-analyze arm 1"
name = "own"
joints = [{ a = 0.5 }, { a = 0.5 }, { a = 0.5 }]

[[links]]
name = "plain"
mass = 1.0
com = [0.0, 0.0, 0.0]
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }
mass_uncertainty = 0.0123

[[links]]
name = "silent"
mass = 1.0
com = [0.0, 0.0, 0.0]
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }

[[links]]
name = "swung"
mass = 1.0
com = [0.0, 0.0, 0.0]
inertia = { xx = 0.1, yy = 0.1, zz = 0.1 }
com_uncertainty_mm = [1.5, 2.5, 3.5]
inertia_uncertainty = { xx = 0.011, yy = 0.012, zz = 0.013, xz = 0.0042 }
inertia_uncertainty_about = "origin"
"""


def rows(out: str, title: str) -> list[list[str]]:
    """Rows of the table below a title, cell by cell."""
    lines = out[out.index(title) :].split("\n\n")[0].splitlines()
    rule = next(i for i, line in enumerate(lines) if line.startswith("─"))
    return [line.split() for line in lines[rule + 1 :]]


def test_stated_uncertainties(run, here):
    (here / "own.toml").write_text(UNCERTAIN, encoding="utf-8")
    result = run("arms", "own.toml")
    assert (result.code, result.err) == (0, "")
    assert rows(result.out, "Standard uncertainties of mass") == [
        ["plain", "0.0123", "?", "?", "?", "?", "?", "?"],
        ["swung", "?", "0.0015", "0.0025", "0.0035", "0.011", "0.012", "0.013"],
    ]
    products, origin = rows(result.out, "Standard uncertainties of products")
    assert products == ["swung", "0", "0.0042", "0"]
    assert origin[-1] == "swung."
    for name in set(gd.builtin_arms()) - {"puma560"}:
        assert "uncertainties" not in run("arms", name).out
