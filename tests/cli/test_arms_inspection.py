"""`gd-analyze arms ROBOT`: what is suspicious first, then all there is; and any arm as TOML."""

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


def test_what_is_suspicious_stands_first_with_its_line(run, odd):
    result = run("arms", odd)
    assert (result.code, result.err) == (0, "")
    said = result.out
    assert max(map(len, said.splitlines())) <= 80
    line = ODD[: ODD.index('izz="0.15"')].count("\n") + 1
    flowing = " ".join(said.split())
    assert (
        f"read from odd.urdf gravity 0 0 -9.81 m/s² along x, y, z of the base frame Suspicious - line {line}"
        in flowing
    )
    assert "the inertia of link upper violates the triangle inequality by 5" in flowing
    assert said.index("Suspicious") < said.index("Chain") < said.index("Joint frames") < said.index("Links")
    for name in ("shoulder", "elbow", "upper", "lower"):
        assert name in said
    assert "Sources" in said
    assert "?" in said  # no acceleration limits in URDF


def test_json_has_the_same(run, odd):
    document = run("arms", odd, "--json").json
    [told] = document["suspicious"]
    assert told.startswith("odd.urdf, line ")
    assert document["joints"][1]["axis"] == [0.0, 1.0, 0.0]
    assert run("arms", "puma560", "--json").json["suspicious"] == []


def test_an_arm_that_only_slides_and_has_no_products(run, here):
    sliding = urdf(
        link("base"),
        link("a rather long name of a carriage on rails", 1.23456789, "0.123456 -0.234567 0.345678", "0 0 0"),
        joint(
            "rail",
            "base",
            "a rather long name of a carriage on rails",
            "prismatic",
            rpy="0 0 0",
            axis="0 -1 0",
        ),
    )
    for key in ("ixy", "ixz", "iyz"):
        sliding = sliding.replace(f'{key}="{INERTIA[key]!r}"', f'{key}="0"')
    (here / "rail.urdf").write_text(sliding, encoding="utf-8")
    said = run("arms", "rail.urdf").out
    assert "-y, slides" in said
    assert "all products of inertia are zero" in said
    assert max(map(len, said.splitlines())) <= 80


def test_any_arm_becomes_toml(run, here, odd):
    result = run("arms", odd, "--limits", "all=10", "--to", "toml")
    assert result.code == 0
    assert "the inertia of link" in result.err
    (here / "own.toml").write_text(result.out, encoding="utf-8")
    assert tomllib.loads(result.out)["convention"] == "placement"
    with pytest.warns(gd.GdAnalyzeWarning):
        before = gd.load_arm(odd, limits=["all=10"])
    with pytest.warns(gd.GdAnalyzeWarning):
        after = gd.load_arm("own.toml")
    assert fingerprint(after, drives=True) == fingerprint(before, drives=True)
    assert [x.name for x in (*after.joints, *after.links)] == [
        x.name for x in (*before.joints, *before.links)
    ]
    assert after.joints[0].acceleration_limit == 10.0
    # A file that is TOML already keeps its comments; with something added it is written anew.
    assert run("arms", "own.toml", "--to", "toml").out == result.out
    changed = run("arms", "puma560", "--limits", "all=7", "--to", "toml").out
    assert tomllib.loads(changed)["joints"][3]["acceleration_limit"] == 7.0
    assert tomllib.loads(changed)["convention"] == "standard"


def test_another_form_is_refused(run, odd):
    result = run("arms", odd, "--to", "urdf")
    assert result.code == 2
    assert "'toml'" in result.err
    assert run("arms", odd, "--to", "toml", "--json").code == 2
