"""Each plausibility check finds its slip and names it, and no arm that could exist is suspected."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from arm_files import link
from chains import generic_chain
from gd_analyze.errors import ArmError, GdAnalyzeWarning, Location
from gd_analyze.robots.parts import of_point_mass
from gd_analyze.robots.plausibility import CHECKS, implausible
from gd_analyze.tables import with_payload
from gd_analyze.text import LARGEST
from gd_analyze.types import DHRow, Drive, Joint, Link, Placement, RobotArm
from strategies import examples, random_rotation

SHELF = Placement(np.eye(3), np.array([0.5, 0, 0]))


def one_joint(joint: Joint, of: Link | None = None, **others: object) -> RobotArm:
    return RobotArm("one", (joint,), (of or Link("1", 2.0, np.zeros(3), 0.05 * np.eye(3), SHELF),), **others)


def moving(**changes: object) -> RobotArm:
    return one_joint(Joint("1", **changes))


def changed(index: int, **changes: object) -> RobotArm:
    """The PUMA with another link."""
    arm = gd.load_arm("puma560")
    links = list(arm.links)
    links[index] = replace(links[index], **changes)
    return replace(arm, links=tuple(links))


def lighter(factor: float) -> RobotArm:
    """The PUMA in another unit of mass."""
    arm = gd.load_arm("puma560")
    scaled = (replace(x, mass=factor * x.mass, inertia_com=factor * x.inertia_com) for x in arm.links)
    return replace(arm, links=tuple(scaled))


def row(**angles: float) -> RobotArm:
    zeros = {"theta": 0.0, "d": 0.0, "a": 0.0, "alpha": 0.0}
    return one_joint(Joint("1"), dh_table=(DHRow(**(zeros | angles)),))


def of_inertia(*moments: float, **more: object) -> RobotArm:
    return one_joint(Joint("1"), link(inertia_com=0.1 * np.diag(moments), **more))


URDF = Location("a.urdf", 7)

LENGTHS = (0.1, 0.5, 0.4, 0.1, 0.1, 0.05)
MASSES = (6.0, 8.0, 4.0, 2.0, 1.5, 0.4)


def rods(**changes: object) -> RobotArm:
    """Six rods end to end, alternately along z and x of the frame at their near end."""
    joints, links, before = [], [], np.zeros(3)
    for k, (length, mass) in enumerate(zip(LENGTHS, MASSES, strict=True)):
        along = np.eye(3)[0 if k % 2 else 2]
        joints.append(Joint(str(k + 1), "revolute", Placement(np.eye(3), before), velocity_limit=3.0))
        inertia = mass * length**2 * (0.09 * np.eye(3) - 0.08 * np.outer(along, along))
        links.append(Link(str(k + 1), mass, 0.5 * length * along, inertia))
        before = length * along
    return replace(RobotArm("rods", tuple(joints), tuple(links)), **changes)


def every(change: Callable[[Link], dict[str, object]], *only: int) -> RobotArm:
    """The rods with all or some links changed."""
    links = (
        replace(link, **change(link)) if not only or k in only else link
        for k, link in enumerate(rods().links, start=1)
    )
    return rods(links=tuple(links))


def first_joints(count: int, arm: RobotArm) -> RobotArm:
    """The arm that ends earlier."""
    return replace(arm, joints=arm.joints[:count], links=arm.links[:count])


def inertials(*order: int) -> RobotArm:
    """The rods with the inertials of other links."""
    links = rods().links
    moved = [
        replace(link, mass=of.mass, com=of.com, inertia_com=of.inertia_com)
        for link, of in zip(links, (links[k - 1] for k in order), strict=True)
    ]
    return rods(links=tuple(moved))


def in_frame(of: int) -> RobotArm:
    """The rods with centres of mass in the frame of the base (0), or of the next link (1)."""
    places = np.cumsum([joint.placement.translation for joint in rods().joints], axis=0)
    links = rods().links
    coms = [link.com + places[k] for k, link in enumerate(links)]
    if of == 1:
        ends = [*places[1:], places[-1]]
        coms = [link.com + places[k] - ends[k] for k, link in enumerate(links)]
    return rods(links=tuple(replace(link, com=com) for link, com in zip(links, coms, strict=True)))


def about_the_frame(link: Link) -> dict[str, object]:
    return {"inertia_com": link.inertia_com + of_point_mass(link.mass, link.com)}


def with_torque_limits(*limits: float) -> RobotArm:
    return rods(drives=tuple(Drive(torque_limit=limit) for limit in limits))


# By the check: arms that have the slip, and what the message says.
SLIPS: dict[str, list[tuple[RobotArm, str]]] = {
    "gravity_too_strong": [(one_joint(Joint("1"), gravity_vector=np.array([0, 0, -98.1])), "98.1 m/s^2")],
    "angle_beyond_a_turn": [(row(alpha=-90.0), "alpha is -90 rad"), (row(theta=6.3), "write theta_deg")],
    "angle_of_pi_degrees": [(row(alpha=0.0274156), "is pi/2"), (row(theta=0.0548313), "is pi;")],
    "length_in_millimetres": [
        (row(a=431.8), "write a_mm"),
        (moving(placement=Placement(np.eye(3), np.array([0, 300.0, 0]))), "300 m long"),
    ],
    "offset_far_beyond_the_others": [
        (changed(2, frame=Placement(np.eye(3), np.array([0.0, 10.0, 0.0]))), "an offset of 10 m"),
    ],
    "more_joints_than_have_terms": [(generic_chain(9), "arm chain9: 9 joints, but")],
    "massless_among_bodies": [
        (changed(3, mass=0.0, com=np.zeros(3), inertia_com=np.zeros((3, 3))), "link 4 has no mass"),
    ],
    "prismatic_range_in_millimetres": [(moving(kind="prismatic", lower=0.0, upper=800.0), "goes to 800 m")],
    "revolute_range_in_degrees": [
        (moving(lower=-end, upper=end), f"joint 1: the range goes to {end:g} rad")
        for end in (45.0, 112.5, 355.0, 360.0)
    ],
    "velocity_in_degrees": [(moving(velocity_limit=180.0, source=URDF), "a.urdf, line 7: the velocity")],
    "inertia_wider_than_the_arm": [(changed(1, inertia_com=5000.0 * np.eye(3)), "is it in kg cm^2")],
    "mass_too_large_for_reach": [
        (one_joint(Joint("1"), Link("1", 20000.0, np.zeros(3), np.zeros((3, 3)), SHELF)), "20000 kg"),
    ],
    "masses_too_small_for_reach": [(lighter(1e-3), "in tonnes?")],
    "mass_too_dense": [(changed(4, mass=340.0), "no material is dense enough")],
    "centre_of_mass_beyond_reach": [
        (one_joint(Joint("1"), link(com=np.array([1.2, 0, 0]))), "centre of mass of link l is 1.2 m"),
    ],
    "inertia_physically_inconsistent": [
        (of_inertia(0.5, 0.498, 1.0), "violates the triangle inequality by 0.2 %"),
        (of_inertia(0.5, 0.3999, 1.0, as_measured=True), "by 10 %"),
        (of_inertia(1.0, 1.0, -0.002), "negative, by 0.2 %"),
        (of_inertia(1.0, 1.0, -1.0, as_measured=True), "negative, by 100 %"),
    ],
    "point_mass_among_bodies": [
        (changed(3, inertia_com=rest * np.eye(3)), "puma560.toml, line ") for rest in (0.0, 1e-18)
    ],
    "centre_of_mass_outside_link": [(changed(3, com=np.array([0.8, 0.0, 0.0])), "link 4 is 0.8")],
    "heavier_than_links_before": [
        (changed(5, mass=46.0, inertia_com=0.46 * np.eye(3)), "more than a third of all links"),
        (changed(3, mass=23.0, inertia_com=0.23 * np.eye(3)), "more than all links before it"),
    ],
    "velocity_in_turns_per_minute": [
        (
            rods(joints=tuple(replace(joint, velocity_limit=30.0) for joint in rods().joints)),
            "36 m/s at the end",
        ),
    ],
    "torque_limit_in_newton_millimetres": [
        (with_torque_limits(300.0, 300e3, 100.0, 30.0, 10.0, 5.0), "joint 2: the torque limit is 300000 N m"),
    ],
    "centres_fit_another_reading": [
        (every(lambda link: {"com": -link.com}), "arm rods: the centres of mass are 0.1"),
        (every(lambda link: {"com": -link.com}, 2), "link 2 is 0.25 m off the line"),
        (in_frame(0), "if they are in the base's frame"),
        (in_frame(1), "or in the next link's frame"),
        (first_joints(4, every(lambda link: {"com": -link.com})), "arm rods: the centres of mass are 0.1"),
    ],
    "inertials_of_other_links": [
        (inertials(1, 1, 2, 3, 4, 5), "belongs to the link before its own"),
        (inertials(2, 3, 4, 5, 6, 6), "belongs to the link after its own"),
    ],
    "inertias_about_the_joints": [(every(about_the_frame), "of all 2 links")],
    "inertias_too_small": [(every(lambda link: {"inertia_com": 1e-2 * link.inertia_com}), "(steel: 7900)")],
    "lighter_than_its_neighbours": [(inertials(1, 2, 3, 6, 5, 4), "link 4 has 0.4 kg")],
}  # fmt: skip


@pytest.mark.parametrize("check", CHECKS, ids=lambda check: check.__name__)
def test_a_slip_is_found_by_its_check(check):
    for arm, fact in SLIPS[check.__name__]:
        (sentence,) = (f"{place}: {message}" for place, message in check(arm))
        assert fact in sentence
        assert sentence in implausible(arm)


FINE = [
    *(moving(lower=-np.pi * k, upper=round(np.pi * k, 4)) for k in (1, 2, 2.5, 4, 6, 192)),
    moving(kind="prismatic", lower=0.0, upper=30.0),
    moving(lower=-np.inf, upper=np.inf),
    row(theta=2 * np.pi, d=-15.0, a=15.0, alpha=-np.pi),
    of_inertia(0.5, 0.4995, 1.0),  # rounding
    of_inertia(0.5, 0.4001, 1.0, as_measured=True),
    of_inertia(0.0, 0.35, 0.0, axial_only=True),
    of_inertia(0.0, 1 / 12, 1 / 12),  # a rod without thickness
    one_joint(Joint("1"), link(com=np.array([0.9, 0, 0]))),
    one_joint(Joint("1"), link(com=np.array([1.2, 0, 0]), mass=0.0)),
    rods(),
    with_torque_limits(300.0, 400.0, 100.0, 30.0, 10.0, 5.0),
    every(about_the_frame, 2),  # which is seen in all links alone
    *map(gd.load_arm, gd.builtin_arms()),
]


@pytest.mark.parametrize("arm", FINE, ids=lambda arm: arm.name)
def test_what_is_fine(arm):
    assert implausible(arm) == ()


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


@st.composite
def plausible_arms(draw: st.DrawFn, lightest: float = 27.0) -> RobotArm:
    """Arms that could exist: from 0.3 m on a desk to 45 m of a crane, of links of every build.

    A link is a cylinder about the middle of its length, of `lightest` kg/m^3 (aluminium in a hundredth of it:
    a truss, a carbon tube) to solid aluminium's 2700.
    """
    n = draw(st.integers(1, 8))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    longest = 10 ** draw(st.floats(np.log10(0.1), np.log10(15.0)))
    lengths = longest * rng.uniform(0.05, 1.0, n)
    lengths[rng.integers(n)] = longest
    fastest = min(40.0, 25.0 / lengths.sum())  # 25 m/s at the end of the stretched arm
    joints, links = [], []
    for i, length in enumerate(lengths):
        radius = length * rng.uniform(0.04, 0.5)
        mass = np.pi * radius**2 * length * 10 ** rng.uniform(np.log10(lightest), np.log10(2700.0))
        along, across = mass * radius**2 / 2, mass * (3 * radius**2 + length**2) / 12
        turn = random_rotation(rng)
        inertia = turn @ np.diag([along, across, across]) @ turn.T
        ends = rng.choice([np.pi / 2, np.pi, 2 * np.pi, np.radians(450), 2 * np.pi * 20, 1e9])
        joints.append(Joint(str(i), lower=-ends, upper=ends, velocity_limit=rng.uniform(0.01, fastest)))
        behind = Placement(random_rotation(rng), length * random_rotation(rng)[0])
        com = -rng.uniform(0.3, 0.7) * behind.rotation.T @ behind.translation
        links.append(Link(str(i), mass, com, (inertia + inertia.T) / 2, behind))
    links.sort(key=lambda link: -link.mass)
    gravity = rng.choice([0.0, 1.62, 9.81, 24.8]) * random_rotation(rng)[0]
    return RobotArm("plausible", tuple(joints), tuple(links), gravity)


@given(arm=plausible_arms())
@examples(60)
def test_plausible_arms_are_not_suspected(arm: RobotArm) -> None:
    assert implausible(arm) == ()
    bare = replace(arm, links=tuple(replace(link, inertia_com=np.zeros((3, 3))) for link in arm.links))
    heaviest = max(link.mass for link in arm.links)
    assert implausible(bare) == () or heaviest > 300  # an arm of point masses is drawn on paper


DENSE, WIDE = "no material is dense enough", "is it in kg cm^2, kg mm^2 or g mm^2"
# Mass in g, inertia in kg cm^2 and in g mm^2, both.
IN_OTHER_UNITS = ((1e3, 1.0, DENSE), (1.0, 1e4, WIDE), (1.0, 1e9, WIDE), (1e3, 1e9, WIDE))


def assert_suspected_in_other_units(arm: RobotArm) -> None:
    for mass, inertia, fact in IN_OTHER_UNITS:
        if max(np.abs(link.inertia_com).max() for link in arm.links) * inertia > LARGEST:
            with pytest.raises(ArmError, match="too large for any arm"):  # a crane's, in g mm^2
                scaled(arm, mass, inertia)
        else:
            assert any(fact in slip for slip in implausible(scaled(arm, mass, inertia)))


@given(arm=plausible_arms(lightest=270.0))
@examples(40)
def test_masses_and_lengths_of_any_arm_in_other_units(arm: RobotArm) -> None:
    assert_suspected_in_other_units(arm)
    assert any("if in mm" in slip for slip in implausible(scaled(arm, length=1e3)))


def test_the_shipped_arms_in_other_units():
    for name in gd.builtin_arms():
        assert_suspected_in_other_units(gd.load_arm(name))


def test_a_payload_does_not_accuse_its_link(puma):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for mass, moments in ((0.1, None), (10.0, None), (15.0, [0.1, 0.1, 0.1])):
            assert implausible(with_payload(puma, mass, [0.0, 0.0, 0.1], moments)) == ()


@pytest.mark.parametrize("payload", [None, 0.01])
def test_a_slip_is_reported_once_by_the_main_job(tmp_path, payload):
    """By reading the arm, and by the main job, that of what is made of it: the same sentences."""
    text = gd.builtin_arms()["two_link"].read_text(encoding="utf-8")
    path = tmp_path / "own.toml"
    path.write_text(text.replace("zz = 0.083", "zz = 0.085"), encoding="utf-8")
    with pytest.warns(GdAnalyzeWarning) as caught:
        arm = gd.load_arm(path)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        arm = arm if payload is None else with_payload(arm, payload, [0.01, 0.0, 0.0])
    with pytest.warns(GdAnalyzeWarning) as heard:
        findings = gd.analyze(arm, "two-link-swing")
    for told in (caught, heard):
        assert list(findings.warnings) == [str(warning.message) for warning in told]
    assert len(findings.warnings) == 1
