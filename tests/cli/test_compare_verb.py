"""`gd-analyze compare` and numbers at one posture in the terminal: what is printed, and JSON."""

from __future__ import annotations

import pytest

import gd_analyze as gd
from robot_files import fingers, two_joints


@pytest.fixture
def files(here):
    """A robot with fingers, a heavier one without, and that one with other names of links."""
    heavier = two_joints().replace('value="1.0"', 'value="1.5"')
    renamed = heavier.replace('"lower"', '"forearm"')
    for name, text in (("a.urdf", two_joints(*fingers())), ("b.urdf", heavier), ("c.urdf", renamed)):
        (here / name).write_text(text)
    return here


OPTIONS = "--limits all=5 --states 200"


def test_two_files_of_one_robot(run, files):
    assert (told := run(f"compare b.urdf c.urdf {OPTIONS} --json")).code == 0, told.err
    assert told.json["agrees"]
    shown = run(f"compare b.urdf c.urdf {OPTIONS}")
    assert "Torques agree, up to round-off." in shown.words
    light = two_joints()
    (files / "light.urdf").write_text(light)
    told = run(f"compare light.urdf c.urdf {OPTIONS} --json").json
    assert not told["agrees"]
    assert [(row["kind"], row["link"]) for row in told["parts"]] == [("link", 2)]
    assert told["parts"][0]["left_share"] < 1e-9
    largest = max(row["share"] for row in told["joints"])
    assert told["largest_share"] == largest == told["joints"][told["largest_at_joint"] - 1]["share"]
    words = run(f"compare light.urdf c.urdf {OPTIONS}").words
    assert "All of it comes from link 2 lower." in words
    assert "mass 1 and 1.5 kg" in words
    assert "c.urdf" in words


def test_a_link_for_each_file(run, files):
    refused = run(f"compare b.urdf a.urdf {OPTIONS}")
    assert refused.code == 2
    assert "--tip" in refused.err
    told = run(f"compare a.urdf c.urdf {OPTIONS} --tip lower,forearm --json")
    assert told.code == 0, told.err
    assert {row["kind"] for row in told.json["parts"]} == {"link"}
    gd.save_arm(gd.load_arm("b.urdf"), files / "b.toml")
    # A chain alone has no links to choose from: the option is the other file's.
    assert run(f"compare a.urdf b.toml {OPTIONS} --tip lower --json").code == 0
    assert run(f"compare b.toml b.toml {OPTIONS} --tip lower").code == 2


def test_options_are_for_both_and_a_motion_takes_the_place_of_states(run, motion):
    told = run("compare two_link two_link gentle.csv --gravity 0,0,-1.62 --json").json
    assert told["agrees"]
    assert "9 set points" in told["compared_at"]
    assert [row["first_peak"] for row in told["joints"]] == [row["second_peak"] for row in told["joints"]]


def test_numbers_at_one_posture(run):
    words = run("equations two_link --at 0,90").words
    assert "D11 2 1.75 0.25 kg m²" in words
    assert "h112 -0.5 -0.5 0 kg m²" in words
    told = run("equations two_link --at 0,0.5rad --velocity 10,20 --element h --json").json
    assert [row["element"] for row in told["elements"]] == ["h1", "h2"]
    assert told["q"] == [0.0, 0.5]
    exact = gd.types.ArmDynamics("two_link").coriolis_centrifugal(told["q"], told["qd"])
    assert [row["value"] for row in told["elements"]] == pytest.approx(exact.tolist(), rel=1e-12)
    assert "0.333333" in run("equations two_link --at 0,90 --digits 6").words


def test_base_parameters_in_symbols(run, here):
    words = run("equations two_link --parameters --symbolic").words
    assert "MX1 = mx1 + a1 m2" in words
    assert "a1 = 1" in words
    told = run("equations two_link --parameters --symbolic --json").json
    assert told["combinations"][0] == "MX1 = mx1 + a1 m2"
    assert "mx1 = m1 x1 + m1 a1" in told["links"]
    assert told["symbols"]["x1"] == -0.5
    assert run("equations two_link --parameters --symbolic -o base.tex").code == 0
    assert r"a_{1} \, m_{2} = 2" in (here / "base.tex").read_text()
