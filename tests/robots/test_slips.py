"""A person's commonest slips in an arm file are named, and no arm that could exist is suspected."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import ArmError, GdAnalyzeWarning, Location
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import builtin_arms, load_arm
from gd_analyze.robots.parts import DHRow, Joint, Link, Placement
from gd_analyze.robots.payload import with_payload
from gd_analyze.robots.plausibility import implausible
from gd_analyze.text import LARGEST
from strategies import examples, random_rotation

PUMA = builtin_arms()["puma560"].read_text(encoding="utf-8")

# What to change in the PUMA's file, by an expression; how many places are told; what is said.
SLIPS: dict[str, tuple[list[tuple[str, str]], str]] = {
    "angles in degrees": ([("alpha_deg", "alpha")], "alpha is -90 rad, more than a full turn"),
    "angles in radians": (
        [("alpha_deg = -90.0", "alpha_deg = -1.5708")],
        "is pi/2; if in radians",
    ),
    "lengths in mm": (
        [("a_mm", "a"), ("d_mm", "d")],
        "is 431.8 m long; if in mm, write a_mm",
    ),
    "range in degrees": ([("range_deg", "range")], "the range goes to 160 rad, which is 25.5 turns; if"),
    "gravity in cm": ([("-9.8062", "-980.62")], "gravity is 980.62 m/s^2"),
    "gravity in mm": ([("-9.8062", "9806.2")], "gravity is 9806.2 m/s^2"),
    "gravity without its point": ([("-9.8062", "-98.062")], "gravity is 98.062 m/s^2"),
    "rates in degrees": (
        [("velocity_limit = ", "velocity_limit = 8")],
        "degrees per second, write",
    ),
}


@pytest.mark.parametrize("slip", SLIPS)
def test_a_slip_is_named_with_its_line(slip: str, tmp_path: Path) -> None:
    changes, said = SLIPS[slip]
    content = PUMA
    for before, after in changes:
        assert before in content
        content = content.replace(before, after)
    path = tmp_path / "own.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.warns(GdAnalyzeWarning) as caught:
        arm = load_arm(path)
    texts = [str(item.message) for item in caught]
    assert any(said in text for text in texts), texts
    assert all("own.toml, line " in text or text.startswith("arm puma560: gravity") for text in texts)
    assert len(texts) == len(set(texts))
    assert set(implausible(arm)) <= set(texts)


def scaled(arm: RobotArm, mass: float = 1.0, inertia: float = 1.0, length: float = 1.0) -> RobotArm:
    """The arm with numbers in other units, as if they were SI."""

    def longer(placement: Placement) -> Placement:
        return Placement(placement.rotation, length * placement.translation)

    links = (
        replace(link, mass=mass * link.mass, inertia_com=inertia * link.inertia_com, frame=longer(link.frame))
        for link in arm.links
    )
    joints = (replace(joint, placement=longer(joint.placement)) for joint in arm.joints)
    return replace(arm, joints=tuple(joints), links=tuple(links), dh_table=())


MASS_SLIPS = {
    "mass in g": (1e3, 1.0, "no material is dense enough for so small an inertia; is it in grams?"),
    "inertia in kg cm^2": (1.0, 1e4, "is it in kg cm^2, kg mm^2 or g mm^2?"),
    "inertia in kg mm^2": (1.0, 1e6, "is it in kg cm^2, kg mm^2 or g mm^2?"),
    "inertia in g mm^2": (1.0, 1e9, "is it in kg cm^2, kg mm^2 or g mm^2?"),
    "both": (1e3, 1e9, "is it in kg cm^2, kg mm^2 or g mm^2?"),
}


def test_masses_and_inertias_of_the_shipped_arms() -> None:
    for name in builtin_arms():
        arm = load_arm(name)
        assert implausible(arm) == ()
        for mass, inertia, said in MASS_SLIPS.values():
            assert any(said in slip for slip in implausible(scaled(arm, mass, inertia)))


@st.composite
def plausible_arms(draw: st.DrawFn, lightest: float = 27.0) -> RobotArm:
    """Arms that could exist: from 0.3 m on a desk to 45 m of a crane, of links of every build.

    A link is a cylinder somewhere along its length, of `lightest` kg/m^3 (aluminium in a hundredth of it: a
    truss, a carbon tube) to solid aluminium's 2700.
    """
    n = draw(st.integers(1, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    longest = 10 ** draw(st.floats(np.log10(0.1), np.log10(15.0)))
    lengths = longest * rng.uniform(0.05, 1.0, n)
    lengths[rng.integers(n)] = longest
    joints, links = [], []
    for i, length in enumerate(lengths):
        radius = length * rng.uniform(0.04, 0.5)
        mass = np.pi * radius**2 * length * 10 ** rng.uniform(np.log10(lightest), np.log10(2700.0))
        along, across = mass * radius**2 / 2, mass * (3 * radius**2 + length**2) / 12
        turn = random_rotation(rng)
        inertia = turn @ np.diag([along, across, across]) @ turn.T
        ends = rng.choice([np.pi / 2, np.pi, 2 * np.pi, np.radians(450), 2 * np.pi * 20, 1e9])
        joints.append(
            Joint(str(i), "revolute", lower=-ends, upper=ends, velocity_limit=rng.uniform(0.01, 40))
        )
        behind = Placement(random_rotation(rng), length * random_rotation(rng)[0])
        com = -rng.uniform(0, 1) * behind.rotation.T @ behind.translation
        links.append(Link(str(i), mass, com, (inertia + inertia.T) / 2, behind))
    links.sort(key=lambda link: -link.mass)
    gravity = rng.choice([0.0, 1.62, 9.81, 24.8]) * random_rotation(rng)[0]
    return RobotArm("plausible", tuple(joints), tuple(links), gravity)


@given(arm=plausible_arms())
@examples(150)
def test_plausible_arms_are_not_suspected(arm: RobotArm) -> None:
    assert implausible(arm) == ()
    bare = replace(arm, links=tuple(replace(link, inertia_com=np.zeros((3, 3))) for link in arm.links))
    heaviest = max(link.mass for link in arm.links)
    assert implausible(bare) == () or heaviest > 300  # an arm of point masses is drawn on paper


@given(arm=plausible_arms(lightest=270.0))
@examples(100)
def test_masses_and_lengths_of_any_arm_in_other_units(arm: RobotArm) -> None:
    for mass, inertia, said in MASS_SLIPS.values():
        if max(np.abs(link.inertia_com).max() for link in arm.links) * inertia > LARGEST:
            with pytest.raises(ArmError, match="too large for any arm"):  # a crane's, in g mm^2
                scaled(arm, mass, inertia)
        else:
            assert any(said in slip for slip in implausible(scaled(arm, mass, inertia)))
    assert any("if in mm" in slip for slip in implausible(scaled(arm, length=1e3)))


@pytest.mark.parametrize("end", [45.0, 90.0, 110.0, 160.0, 170.0, 266.0, 355.0, 360.0, 112.5])
def test_ranges_in_degrees(end: float) -> None:
    told = implausible(one_joint(Joint("1", lower=-end, upper=end)))
    assert len(told) == 1
    assert told[0].startswith(f"joint 1: the range goes to {end:g} rad")


@pytest.mark.parametrize("turns", [0.5, 1.0, 1.25, 2.0, 3.0, 96.0])
def test_ranges_of_turns(turns: float) -> None:
    end = 2 * np.pi * turns
    assert implausible(one_joint(Joint("1", lower=-end, upper=end))) == ()
    assert implausible(one_joint(Joint("1", lower=-round(end, 4), upper=round(end, 4)))) == ()


def one_joint(joint: Joint, **others: object) -> RobotArm:
    link = Link("1", 2.0, np.zeros(3), 0.05 * np.eye(3), Placement(np.eye(3), np.array([0.5, 0, 0])))
    return RobotArm("one", (joint,), (link,), **others)


def test_slides_in_millimetres() -> None:
    assert implausible(one_joint(Joint("1", lower=-np.inf, upper=np.inf))) == ()
    assert implausible(one_joint(Joint("1", "prismatic", lower=0.0, upper=30.0))) == ()
    told = implausible(one_joint(Joint("1", "prismatic", lower=0.0, upper=800.0)))
    assert told == ("joint 1: the range goes to 800 m; if in mm, write range_mm",)


def test_point_masses_in_grams(two_link: RobotArm) -> None:
    points = replace(two_link, links=tuple(replace(k, inertia_com=np.zeros((3, 3))) for k in two_link.links))
    assert implausible(points) == ()
    told = implausible(scaled(points, mass=1e4))
    assert "a mass of 20000 kg is more than an arm that reaches 2 m has; is it in grams?" in told[0]


def test_one_link_without_inertia_is_told(puma: RobotArm) -> None:
    links = list(puma.links)
    for rest in (0.0, 1e-18):  # as it is stated, and as round-off leaves it when a frame is moved
        links[3] = replace(puma.links[3], inertia_com=rest * np.eye(3))
        [told] = implausible(replace(puma, links=tuple(links)))
        assert told.endswith(
            "link 4 has a mass of 0.82 kg and no inertia, like a point mass; other links have one"
        )
        assert "puma560.toml, line " in told


@pytest.mark.parametrize(("index", "mass", "than"), [(5, 46.0, "more than half of"), (3, 23.0, "more than")])
def test_a_link_heavier_than_what_holds_it_is_told(puma: RobotArm, index, mass, than) -> None:
    heavy = replace(puma.links[index], mass=mass, inertia_com=0.01 * mass * np.eye(3))
    links = [*puma.links]
    links[index] = heavy
    before = sum(link.mass for link in puma.links[:index])
    told = [
        slip for slip in implausible(replace(puma, links=tuple(links))) if "towards the end effector" in slip
    ]
    assert len(told) == 1
    assert f"link {heavy.name} has a mass of {mass:g} kg, {than} all links before it together" in told[0]
    assert f"({before:.1f} kg)" in told[0]
    # What the hand carries is nobody's slip.
    assert implausible(with_payload(puma, 15.0, [0.0, 0.0, 0.1], [0.1, 0.1, 0.1])) == ()


def test_a_centre_of_mass_outside_of_its_link_is_told(puma: RobotArm) -> None:
    links = [*puma.links]
    links[3] = replace(puma.links[3], com=np.array([0.8, 0.0, 0.0]))
    [told] = implausible(replace(puma, links=tuple(links)))
    assert "the centre of mass of link 4 is 0.8" in told
    assert "from both of its joints, of an arm that reaches 0.966 m" in told
    assert told.endswith("is it given in another frame?")


@pytest.mark.parametrize(("file", "told"), [("arm.urdf", False), ("arm.toml", True)])
def test_a_limit_that_stands_for_none(file: str, told: bool) -> None:
    """In a format of one unit 1000 means no limit; elsewhere it may be in another unit."""
    source = Location(file, 7)
    turning = Joint("1", velocity_limit=1000.0, source=source)
    sliding = Joint("1", "prismatic", lower=-1000.0, upper=1000.0, source=source)
    for joint in (turning, sliding):
        assert bool(implausible(one_joint(joint))) == told
    [said] = implausible(one_joint(replace(turning, velocity_limit=180.0)))
    assert said.endswith("write velocity_limit_deg" if told else "give rad/s")


def test_a_table_of_turns_is_fine() -> None:
    row = DHRow(theta=2 * np.pi, d=-15.0, a=15.0, alpha=-np.pi)
    assert implausible(one_joint(Joint("1"), dh_table=(row,))) == ()


def test_a_payload_in_grams(puma: RobotArm) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for mass in (0.1, 1.0, 5.0, 10.0):
            assert implausible(with_payload(puma, mass, [0.0, 0.0, 0.1])) == ()
    with pytest.warns(GdAnalyzeWarning, match="a payload of 2500 kg is more than an arm"):
        with_payload(puma, 2500.0, [0.0, 0.0, 0.1])


@pytest.mark.parametrize("huge", ["1e300", "1e308", "-1e16"])
@pytest.mark.parametrize("key", ["mass", "a_mm", "xx", "gear_ratio", "inertia", "range_deg"])
def test_a_number_that_would_overflow_is_refused(key: str, huge: str, tmp_path: Path) -> None:
    content, count = re.subn(rf"\b{key} = (\[)?-?[0-9.]+", rf"{key} = \g<1>{huge}", PUMA, count=1)
    content = content.replace("range_deg = 1", "range_deg = [1")
    assert count == 1
    path = tmp_path / "own.toml"
    path.write_text(content, encoding="utf-8")
    with pytest.raises(ArmError, match="does not fit the schema") as caught:
        load_arm(path)
    assert "own.toml, line " in str(caught.value)


def test_numbers_from_python_are_held_to_the_same_limit() -> None:
    parts: tuple[Callable[[], object], ...] = (
        lambda: Link("1", 1e300, np.zeros(3), np.eye(3)),
        lambda: Link("1", 1.0, np.full(3, 1e300), np.eye(3)),
        lambda: Joint("1", velocity_limit=1e300),
        lambda: one_joint(Joint("1"), gravity=np.array([0, 0, 1e308])),
    )
    for part in parts:
        with pytest.raises(ArmError, match="too large for any arm"):
            part()


def test_an_arm_file_has_a_largest_size(tmp_path: Path) -> None:
    path = tmp_path / "own.toml"
    path.write_text(PUMA + "# \n" * 400_000, encoding="utf-8")
    with pytest.raises(ArmError, match="the arm file is too large") as caught:
        load_arm(path)
    assert "expected: up to 1 MB" in str(caught.value)


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("com = [-0.5, 0.0, 0.0]", "com = [-500.0, 0.0, 0.0]"),
        ("mass = 1.0", "mass = 1000000.0"),
        ("zz = 0.083", "zz = 0.085"),
    ],
)
@pytest.mark.parametrize("payload", [None, 0.01])
def test_a_slip_is_told_once_and_with_one_number(tmp_path, before, after, payload):
    """By reading, by what is made of the arm, and by the main job: the same sentences."""
    import gd_analyze as gd

    text = builtin_arms()["two_link"].read_text(encoding="utf-8")
    assert before in text
    path = tmp_path / "own.toml"
    path.write_text(text.replace(before, after), encoding="utf-8")
    with pytest.warns(GdAnalyzeWarning) as told:
        arm = load_arm(path)
    stated = [str(warning.message) for warning in told]
    assert len(set(stated)) == len(stated)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        arm = arm if payload is None else with_payload(arm, payload, [0.01, 0.0, 0.0])
        findings = gd.find(arm, "two-link-swing")
    assert list(findings.warnings) == stated
