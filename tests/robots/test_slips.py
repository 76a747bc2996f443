"""Slips in robot files that leave them readable: each is refused, or doubted with its place."""

from __future__ import annotations

import re
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.tables import with_payload
from robot_files import joint, link, mjcf, two_bodies, two_joints, urdf

SIX = [
    link("base"),
    *(
        link(f"link_{k}", 6.0 / k, f"{0.2 / k!r} 0 0", "0 0 0", ixx=0.06 / k, iyy=0.08 / k, izz=0.1 / k)
        for k in range(1, 7)
    ),
    *(
        joint(
            f"j{k}",
            "base" if k == 1 else f"link_{k - 1}",
            f"link_{k}",
            xyz=f"{0.4 / k!r} 0 0.05",
            rpy="0 0 0",
        )
        for k in range(1, 7)
    ),
]
ARM = urdf(*SIX)


@pytest.fixture
def doubts(tmp_path) -> Callable[[str, str], str]:
    """All that a file is doubted for."""

    def read(text: str, suffix: str = ".urdf", **options: str) -> str:
        path = tmp_path / f"robot{suffix}"
        path.write_text(text)
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always", GdAnalyzeWarning)
            gd.load_arm(path, **options)
        return "\n".join(str(item.message) for item in caught)

    return read


def number(tag: str, place: str, value: str, text: str = ARM, count: int = 1) -> str:
    """The file with another value at the first `tag` after a place."""
    head, rest = text.split(place, 1)
    return head + place + re.sub(rf'{tag}="[^"]*"', f'{tag}="{value}"', rest, count=count)


def test_the_arm_without_a_slip_is_not_doubted(doubts):
    assert doubts(ARM) == ""


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        (number("rpy", 'joint name="j3"', "0 0 90"), "line .*an angle of 90 is more than a full turn"),
        (number("xyz", 'joint name="j3"', "10 0 0"), "an offset of 10 m; all others add up to"),
        (
            ARM.replace(SIX[3], link("link_3", 1.0, ixx=1.0, iyy=1.0, izz=1.0, ixy=0.0, ixz=0.0, iyz=0.0)),
            "line .*link link_3 has exporters' defaults, 1 kg and 1 kg m",
        ),
        (
            ARM.replace(SIX[3], '<link name="link_3"/>'),
            "link link_3 has no mass, but links before and after",
        ),
        (number("value", 'link name="link_6"', "8"), "link link_6 has 8 kg, more than a third of all links"),
    ],
)
def test_urdf_is_doubted(doubts, text, fact):
    assert text != ARM
    assert re.search(fact, doubts(text))


@pytest.mark.parametrize(
    ("text", "fact"),
    [
        (number("value", 'link name="link_2"', "1_0"), "value of <mass> is not a finite number"),
        (
            two_joints()
            .replace('lower="-2"', 'lower="-2"', 1)
            .replace("</joint>", '<mimic joint="gone"/></joint>', 1),
            "mimics a joint that does not exist",
        ),
        (
            ARM.replace('<link name="base"', '<link name="bottom"'),
            "parent of joint j1 is a link that the file does",
        ),
        (
            ARM.replace('<child link="link_3"', '<child link="link_33"'),
            "child of joint j3 .*'link_33'\n.*name ",
        ),
    ],
)
def test_urdf_is_refused(doubts, text, fact):
    with pytest.raises(ArmError, match=fact) as caught:
        doubts(text)
    assert "line" in caught.value.details["where"]


MOTOR = "<motorInertia>2e-5</motorInertia><mechanicalReduction>100</mechanicalReduction>"


@pytest.mark.parametrize(
    ("actuator", "fact"),
    [
        (
            f"<actuator name='m'>{MOTOR}</actuator>",
            "motor inertia of 2.00e-05 kg m^2 is not read; .* is 0.2 kg",
        ),
        ("<actuator><drake:rotor_inertia value='3'/></actuator>", "motor inertia of 3 kg m^2 .* is 3 kg"),
        ("<actuator><motorInertia>0</motorInertia></actuator>", "^$"),
        ("<actuator><motorInertia/></actuator>", "^$"),
    ],
)
def test_a_motor_inertia_is_told_with_its_value_at_the_joint(doubts, actuator, fact):
    of = '<transmission name="t"><joint name="{}"/>{}</transmission></robot>'
    assert re.search(fact.replace("^2", r"\^2"), doubts(ARM.replace("</robot>", of.format("j2", actuator))))
    assert doubts(ARM.replace("</robot>", of.format("wheel", actuator))) == ""


def test_a_joint_off_the_arm_may_mimic_what_is_not_there(tmp_path):
    finger = (link("finger"), joint("finger", "lower", "finger", rest='<mimic joint="gone"/>'))
    (tmp_path / "robot.urdf").write_text(two_joints(*finger))
    for picked in ({"tip": "lower"}, {"lock": ["finger=0.1"]}):
        arm = gd.load_arm(tmp_path / "robot.urdf", **picked)
        assert [joint.name for joint in arm.joints] == ["shoulder", "elbow"]
    with pytest.raises(ArmError, match="lock='finger=0'"):
        gd.load_arm(tmp_path / "robot.urdf")


TURNS = 'axis="0 1 0"'


@pytest.mark.parametrize(
    ("before", "fact"),
    [
        ('<compiler coordinate="global"/>', "coordinate='global'"),
        ('<compiler angle="gradian"/>', "angle='gradian'"),
    ],
)
def test_mjcf_is_refused(doubts, before, fact):
    with pytest.raises(ArmError, match=fact):
        doubts(mjcf(two_bodies(TURNS), before), ".xml")


def loaded(tmp_path: Path, text: str, **options: str) -> gd.types.RobotArm:
    path = tmp_path / "robot.xml"
    path.write_text(text)
    return gd.load_arm(path, **options)


def test_gravity_that_is_switched_off(tmp_path):
    arm = loaded(tmp_path, mjcf(two_bodies(TURNS), '<option><flag gravity="disable"/></option>'))
    assert not arm.gravity_vector.any()
    assert any("switches gravity off" in text for text in arm.assumptions)


def test_two_worlds_and_two_sections_of_defaults_are_one(tmp_path):
    whole = mjcf(two_bodies(TURNS))
    apart = whole.replace("<worldbody>", '<worldbody><body name="table"/></worldbody><worldbody>')
    inner = '<default><default class="a"><joint damping="3"/></default></default>'
    defaults = f'<default><joint armature="0.2"/></default>{inner}'
    plain, doubled = loaded(tmp_path, whole), loaded(tmp_path, apart)
    assert doubled.mass.tolist() == plain.mass.tolist()
    arm = loaded(tmp_path, mjcf(two_bodies(f'{TURNS} class="a"'), defaults))
    assert (arm.drives[1].inertia, arm.drives[1].viscous) == (0.2, 3.0)


def test_an_actuators_limit_comes_from_its_class(tmp_path):
    defaults = (
        '<default><position forcerange="-9 9"/><default class="weak"><position kp="5"/></default>'
        '<default class="strong"><position forcerange="-70 70"/></default></default>'
    )
    motors = '<position joint="shoulder" class="strong"/><position joint="elbow" class="weak"/>'
    after = f"<actuator>{motors}</actuator>"
    arm = loaded(tmp_path, mjcf(two_bodies(TURNS), defaults, after))
    assert [drive.torque_limit for drive in arm.drives] == [70.0, 9.0]


def test_rounded_quaternions_are_doubted(tmp_path):
    body = two_bodies(TURNS).replace('quat="0.9 0.1 0.2 0.3"', 'quat="0.7071 0.7072 0 0"')
    with pytest.warns(GdAnalyzeWarning, match=r"a rotation of 0.7071 0.7072 0 0 is 0.0001 off a right angle"):
        loaded(tmp_path, mjcf(body))


def test_a_payload_is_stated_in_the_frame_of_the_tip(tmp_path):
    """As if it were a link of its own, fixed to the tip."""
    flange = [
        link("tool", None),
        joint("mount", "lower", "tool", "fixed", xyz="0.05 -0.1 0.1", rpy="0.4 0.1 2.0"),
    ]
    body = link("held", 5.0, "0 0.02 0.1", "0 0 0", ixx=0.02, iyy=0.03, izz=0.04, ixy=0.001, ixz=0.0, iyz=0.0)
    grip = joint("grip", "tool", "held", "fixed", xyz="0 0 0", rpy="0 0 0")
    for name, parts in (("bare", flange), ("full", [*flange, body, grip])):
        (tmp_path / f"{name}.urdf").write_text(two_joints(*parts))
    full = gd.load_arm(tmp_path / "full.urdf")
    bare = gd.load_arm(tmp_path / "bare.urdf", tip="tool")
    ours = with_payload(bare, 5.0, [0.0, 0.02, 0.1], [0.02, 0.03, 0.04, 0.001, 0.0, 0.0])
    assert "(0, 0.02, 0.1) m" in ours.assumptions[-1]
    assert "frame of tool" in ours.assumptions[-1]
    # Round-off of a few products of numbers up to 1.
    np.testing.assert_allclose(ours.links[-1].com, full.links[-1].com, atol=1e-14)
    np.testing.assert_allclose(ours.links[-1].inertia_com, full.links[-1].inertia_com, atol=1e-14)
    untold = gd.load_arm(tmp_path / "bare.urdf")
    assert "in its frame." in with_payload(untold, 5.0, [0.0, 0.02, 0.1]).assumptions[-1]


@pytest.mark.parametrize(
    ("n_joints", "off", "is_doubted"), [(3, 0.1, True), (3, 0.25, False), (6, 0.25, True)]
)
def test_centres_of_mass_on_the_wrong_side_are_doubted_by_less_in_a_longer_chain(
    n_joints, off, is_doubted, doubts
):
    """Links of 1 m with centres 0.3 m behind their joints: with the other sign they are `off` from the line.

    That is 0.32 of what they are off as they stand at 0.1 m, and 0.64 at 0.25 m.
    """
    inertia = {"ixx": 0.4, "iyy": 0.5, "izz": 0.5, "ixy": 0.0, "ixz": 0.0, "iyz": 0.0}
    links = [link(f"link_{k}", 3.0, f"-0.3 {off} 0", "0 0 0", **inertia) for k in range(1, n_joints + 1)]
    parents = ["base", *(f"link_{k}" for k in range(1, n_joints))]
    joints = [
        joint(f"j{k}", parent, f"link_{k}", xyz="1 0 0", rpy="0 0 0")
        for k, parent in enumerate(parents, start=1)
    ]
    told = doubts(urdf(link("base"), *links, *joints))
    assert ("signs of all" in told) == is_doubted
