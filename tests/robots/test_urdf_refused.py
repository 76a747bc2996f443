"""URDF that is no robot, no XML or no file of ours: refused with the line and the way out."""

from __future__ import annotations

import time

import pytest

from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots.catalogue import load_arm
from robot_files import joint, link, two_joints, urdf


@pytest.fixture
def refused(tmp_path, capfd):
    def error(text: str | bytes, name: str = "robot.urdf") -> ArmError:
        path = tmp_path / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        with pytest.raises(ArmError) as caught:
            load_arm(path)
        assert capfd.readouterr() == ("", "")  # parsers of others print to the terminal
        return caught.value

    return error


BASE = link("base")
SHOULDER = joint("shoulder", "base", "upper")


@pytest.mark.parametrize(
    ("text", "what", "line", "details"),
    [
        (
            "<robot name='r'>\n<link name='a'>\n</robot>",
            "is not valid XML",
            3,
            ("mismatched tag", "mend the"),
        ),
        ("just words", "is not valid XML", 1, ("syntax error",)),
        ("", "is not valid XML", 1, ("no element found",)),
        ("<sdf version='1.9'/>", "the XML is no robot that is read", 1, ("<sdf>", "SDF has tools")),
        ("<robot name='r'/>", "the robot has no links", 1, ("macros expanded",)),
        (urdf(BASE), "the robot has no joint that moves", None, ("fixed joints alone",)),
        (
            urdf('<xacro:arm prefix="left_"/>'),
            "the file is xacro that was not expanded",
            2,
            ("<xacro:arm>", "`xacro robot.urdf.xacro > robot.urdf`"),
        ),
        (
            urdf(BASE, link("upper"), joint("shoulder", "base", "upper", limit='lower="${-pi}" upper="1"')),
            "the file is xacro that was not expanded",
            4,
            ("${-pi}",),
        ),
        (urdf(BASE, link("base")), "there are two links 'base'", 3, ("link in line 2",)),
        (urdf(BASE, SHOULDER), "joint shoulder is at link 'upper', which there is not", 3, ()),
        (urdf(BASE, link("upper")), "the links are not one tree", 1, ("base, upper",)),
        (
            urdf(BASE, link("upper"), SHOULDER, joint("bar", "base", "upper")),
            "link upper closes a loop: it is the child of two joints",
            5,
            ("joints shoulder and bar", "remove one"),
        ),
        (
            urdf(BASE, link("a"), link("b"), joint("ab", "a", "b"), joint("ba", "b", "a")),
            "link b closes a loop: it carries itself",
            5,
            (),
        ),
        (urdf(BASE, link("upper", -2.0), SHOULDER), "the mass of link upper is negative", 3, ("-2 kg",)),
        (
            urdf(BASE, link("upper").replace('"2.0"', '"nan"'), SHOULDER),
            "value of <mass> is not a number",
            3,
            ("'nan'",),
        ),
        (
            urdf(BASE, link("upper", xyz="0.1 0.2"), SHOULDER),
            "xyz of <origin> is not 3 numbers",
            3,
            ("'0.1 0.2'",),
        ),
        (
            urdf(BASE, link("upper").replace('ixz="-0.002"', ""), SHOULDER),
            "ixz of <inertia> is not a number",
            3,
            ("nothing",),
        ),
        (
            urdf(BASE, '<link name="upper"><inertial><mass value="1"/></inertial></link>', SHOULDER),
            "the inertial of link upper lacks its inertia",
            3,
            ("remove the <inertial>",),
        ),
        (
            urdf(BASE, link("upper"), joint("shoulder", "base", "upper", "hinge")),
            "joint shoulder is of an unknown type",
            4,
            ("revolute, continuous", "'hinge'"),
        ),
        (
            urdf(BASE, link("upper"), joint("shoulder", "base", "upper", axis="0 0 0")),
            "joint shoulder has no axis",
            4,
            ("a direction",),
        ),
        (
            urdf(BASE, link("upper"), joint("shoulder", "base", "upper", limit='lower="2" upper="1"')),
            "the range of joint shoulder is empty",
            4,
            ("lower < upper", "2 .. 1"),
        ),
        (
            urdf(BASE, link("upper"), joint("shoulder", "base", "upper", limit='velocity="-1"')),
            "the velocity limit of joint shoulder is negative",
            4,
            ("or 0 where it is unknown",),
        ),
    ],
)
@pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")
def test_refused(refused, text, what, line, details):
    error = refused(text)
    assert what in error.what
    if line is not None:
        assert f"robot.urdf, line {line}, column " in error.details["where"]
    told = " ".join(error.details.values())
    for detail in details:
        assert detail in told


LAUGHS = '<!DOCTYPE r [<!ENTITY a "ha">' + "".join(
    f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefghi", "bcdefghij", strict=True)
)


@pytest.mark.parametrize(
    ("text", "what"),
    [
        (f"{LAUGHS}]><robot name='&j;'/>", "declares a document type"),
        ("<!DOCTYPE r SYSTEM 'file:///etc/passwd'><robot/>", "declares a document type"),
        ("<robot>" * 100_000, "nests elements beyond any robot"),
        (b"<robot>" + b" " * 10_000_001, "too large"),
        (b"<robot name='\xff\xfe\x00'/>", "not valid XML"),
        (b"<?xml version='1.0' encoding='no-such'?><robot/>", "not "),
    ],
)
def test_hostile_xml_is_refused_at_once(refused, text, what):
    start = time.process_time()
    assert what in refused(text).what
    # Reading 10 MB of blanks takes 0.1 s; expanding the entities would take gigabytes and minutes.
    assert time.process_time() - start < 5.0


def test_a_name_that_does_not_show(refused):
    error = refused(urdf(BASE, link("up\u202eper"), joint("shoulder", "base", "up\u202eper")))
    assert error.what == "a link has no name that shows"
    assert "\\u202e" in error.details["found"]


def test_ranges_that_are_not_stated_are_unknown_and_told(tmp_path):
    path = tmp_path / "robot.urdf"
    bare, zero = 'effort="3" velocity="0"', 'lower="0" upper="0" effort="0"'
    path.write_text(
        urdf(
            *(link(name) for name in ("base", "a", "b", "c")),
            joint("one", "base", "a", limit=bare),
            joint("two", "a", "b", limit=zero),
            joint("three", "b", "c", "continuous", limit='lower="-1" upper="1" velocity="2"'),
        )
    )
    with pytest.warns(GdAnalyzeWarning) as caught:
        arm = load_arm(path)
    told = [str(warning.message) for warning in caught]
    assert told == list(arm.doubts)
    assert "robot.urdf, line 6, column " in told[0]
    assert told[0].endswith("joint one is revolute and states no range, which is taken as unknown")
    assert told[1].endswith("joint two is revolute and states a range of 0 .. 0, which is taken as unknown")
    assert [(joint.lower, joint.upper, joint.velocity_limit) for joint in arm.joints] == [
        (None, None, None),
        (None, None, None),
        (None, None, 2.0),
    ]
    assert [drive.torque_limit for drive in arm.drives] == [3.0, None, None]


def test_limits_that_stand_for_none(tmp_path):
    path = tmp_path / "robot.urdf"
    far, near = 'lower="-1e9" upper="1e9" velocity="1000"', 'lower="-1" upper="1" velocity="9"'
    joints = [joint("one", "base", "a", limit=far), joint("two", "a", "b", limit=near)]
    path.write_text(urdf(*(link(name) for name in ("base", "a", "b")), *joints))
    one, two = load_arm(path).joints
    assert (one.lower, one.upper, one.velocity_limit) == (None, None, None)
    assert (two.lower, two.upper, two.velocity_limit) == (-1.0, 1.0, 9.0)
    assert load_arm(path).assumptions[-1] == "Limits of 100, 1000 and so on stand for none: joint one."


def test_a_robot_without_any_mass_is_told(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(two_joints().replace('mass value="2.0"', 'mass value="0"').replace('"1.0"', '"0"'))
    with pytest.warns(GdAnalyzeWarning, match="no link has any mass; is the file stripped, or xacro"):
        load_arm(path)


def test_joints_that_state_the_same_of_their_ranges_are_told_together(tmp_path):
    path = tmp_path / "robot.urdf"
    names = ("base", "a", "b", "c")
    bare = 'effort="3" velocity="1"'
    joints = [joint(f"q{k}", names[k], names[k + 1], limit=bare) for k in range(3)]
    path.write_text(urdf(*(link(name) for name in names), *joints))
    with pytest.warns(GdAnalyzeWarning) as caught:
        load_arm(path)
    assert len(caught) == 1
    assert str(caught[0].message).endswith(
        "robot.urdf, line 6, column 1: joints q0, q1 and q2 are revolute and state no range, "
        "which is taken as unknown"
    )
