"""URDF: the torques of Pinocchio on the file as it is, what is unknown or refused, and right angles."""

from __future__ import annotations

import math
import time
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.types import ExactForm
from robot_files import assert_same_torque, fingers, joint, link, two_joints, urdf
from strategies import examples, random_inertia, random_states


@pytest.fixture
def arm_of(tmp_path):
    def read(text: str, **picked: object):
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GdAnalyzeWarning)
            return gd.load_arm(path, **picked), path

    return read


TURNING = two_joints(link("hand"), joint("wrist", "lower", "hand", "continuous"))
ENDLESS = (joint("endless", "base", "upper", "continuous"), joint("elbow", "upper", "lower"))


@pytest.mark.parametrize(
    ("text", "picked", "held"),
    [
        (
            two_joints(*fingers()),
            {"lock": ["left_finger=20mm", "right_finger=-0.01"]},
            {"left_finger": 0.02, "right_finger": -0.01},
        ),
        (TURNING, {"base": "upper", "lock": {"shoulder": 0.7}}, {"shoulder": 0.7}),
        (
            urdf(link("base"), link("upper"), link("lower"), *ENDLESS),
            {"lock": ["endless=90deg"]},
            {"endless": np.pi / 2},
        ),
    ],
)
def test_what_is_held_carries_its_mass_at_the_value(arm_of, text, picked, held):
    arm, path = arm_of(text, **picked)
    assert_same_torque(path, arm, random_states(arm.n_joints, 20, 1), held)
    assert all(name in arm.assumptions[-1] for name in held)


@examples(25)
@given(st.data())
def test_any_chain_of_any_joints(tmp_path_factory, data):
    """Joints of all kinds, skew axes, turned inertial frames, fixed links between, beside and at the end."""
    any_kind = st.sampled_from(["revolute", "continuous", "prismatic", "fixed"])
    kinds = data.draw(st.lists(any_kind, min_size=1, max_size=7))
    seed, beside = data.draw(st.integers(0, 2**32 - 1)), data.draw(st.booleans())
    kinds += ["revolute"] if set(kinds) == {"fixed"} else []
    rng = np.random.default_rng(seed)

    def three() -> str:
        return " ".join(repr(float(x)) for x in rng.normal(size=3))

    elements, before = [link("link0")], "link0"
    for i, kind in enumerate(kinds, start=1):
        moments = random_inertia(rng)[np.triu_indices(3)].tolist()
        keyed = dict(zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), moments, strict=True))
        mass = None if data.draw(st.integers(0, 4)) == 0 else float(rng.uniform(0.1, 9))
        elements.append(link(f"link{i}", mass, three(), three(), **keyed))
        elements.append(joint(f"joint{i}", before, f"link{i}", kind, xyz=three(), rpy=three(), axis=three()))
        if beside:
            elements += [link(f"side{i}"), joint(f"aside{i}", f"link{i}", f"side{i}", "fixed", rpy=three())]
        before = f"link{i}"
    path = tmp_path_factory.mktemp("chain") / "robot.urdf"
    path.write_text(urdf(*elements))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # of numbers no arm has
        arm = gd.load_arm(path)
    moving = [kind for kind in kinds if kind != "fixed"]
    assert [joint.kind for joint in arm.joints] == [k.replace("continuous", "revolute") for k in moving]
    assert_same_torque(path, arm, random_states(len(moving), 4, seed), merged=2 * len(kinds) + 1)


@pytest.fixture
def refused(tmp_path, capfd):
    def error(text: str | bytes) -> ArmError:
        path = tmp_path / "robot.urdf"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        start = time.process_time()
        with pytest.raises(ArmError) as caught:
            gd.load_arm(path)
        # Reading 10 MB of blanks takes 0.1 s; expanding the entities would take gigabytes and minutes.
        assert time.process_time() - start < 5.0
        assert capfd.readouterr() == ("", "")  # parsers of others print to the terminal
        return caught.value

    return error


BASE, UPPER, SHOULDER = link("base"), link("upper"), joint("shoulder", "base", "upper")
MASS_ONLY = '<link name="upper"><inertial><mass value="1"/></inertial></link>'
CIRCLE = (link("a"), link("b"), joint("ab", "a", "b"), joint("ba", "b", "a"))


LAUGHS = '<!DOCTYPE r [<!ENTITY a "ha">' + "".join(
    f'<!ENTITY {b} "{f"&{a};" * 10}">' for a, b in zip("abcdefghi", "bcdefghij", strict=True)
)


def limited(limit: str) -> str:
    return urdf(BASE, UPPER, joint("shoulder", "base", "upper", limit=limit))


@pytest.mark.parametrize(
    ("text", "line", "fact"),
    [
        ("<robot name='r'>\n<link name='a'>\n</robot>", 3, "another element within <link> of line 2"),
        ("<robot name='r'>\n<link name='a'/>\n", 3, "the robot's file is cut off"),
        ("<robot name='r'>\n<link na", 2, "its end within <robot> of line 1"),
        ("", 1, "its end before any element"),
        ("<sdf version='1.9'/>", 1, "sdf2mjcf"),
        ("<robot name='r'/>", None, "No link elements"),
        (urdf(BASE), None, "only fixed joints"),
        (urdf('<xacro:arm prefix="left_"/>'), 2, "`xacro robot.urdf.xacro > robot.urdf`"),
        (limited('lower="${-pi}" upper="1"'), 4, "${-pi}"),
        (urdf(BASE, BASE), 3, "line 2"),
        (urdf(BASE, SHOULDER), 3, "the child of joint shoulder is a link that the file does not declare"),
        (urdf(BASE, UPPER), None, "Two root links found: [base] and [upper]"),
        (urdf(BASE, UPPER, SHOULDER, joint("bar", "base", "upper")), 5, "joints shoulder and bar"),
        (urdf(BASE, *CIRCLE), 5, "closes a loop"),
        (urdf(BASE, link("upper", -2.0), SHOULDER), 3, "found: '-2.0'"),
        (urdf(BASE, UPPER.replace('"2.0"', '"nan"'), SHOULDER), 3, "'nan'"),
        (urdf(BASE, link("upper", xyz="0.1 0.2"), SHOULDER), 3, "'0.1 0.2'"),
        (urdf(BASE, UPPER.replace('ixz="-0.002"', ""), SHOULDER), 3, "ixz of <inertia>"),
        (urdf(BASE, MASS_ONLY, SHOULDER), 3, "lacks its"),
        (urdf(BASE, UPPER, joint("shoulder", "base", "upper", "hinge")), 4, "[hinge]"),
        (urdf(BASE, UPPER, joint("shoulder", "base", "upper", axis="0 0 0")), 4, "shoulder has no axis"),
        (limited('lower="2" upper="1"'), 4, "2 .. 1"),
        (urdf(BASE, link("up\u202eper"), joint("shoulder", "base", "up\u202eper")), 3, "\\u202e"),
        (f"{LAUGHS}]><robot name='&j;'/>", 1, "declares a document type"),
        ("<!DOCTYPE r SYSTEM 'file:///etc/passwd'><robot/>", 1, "declares a document type"),
        ("<robot>" * 100_000, 1, "nests elements too deep"),
        (b"<robot>" + b" " * 10_000_001, None, "too large"),
        (b"<?xml version='1.0' encoding='no-such'?><robot/>", None, "not "),
        ("<robot>" + "<link/>" * 2001 + "</robot>", 1, "too many links"),
    ],
)  # fmt: skip
@pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")
def test_refused_with_the_place_and_the_fact(refused, text, line, fact):
    error = refused(text)
    assert fact in str(error)
    assert "robot.urdf" in error.details["where"]
    if line is not None:
        assert f"robot.urdf, line {line}, column " in error.details["where"]


def test_limits_that_are_unknown(tmp_path):
    """Not stated, 0, or 1000 and so on, which makers write for none."""
    path = tmp_path / "robot.urdf"
    bare, zero = 'effort="3" velocity="0"', 'lower="0" upper="0" effort="0"'
    far = 'lower="-1e9" upper="1e9" velocity="1000"'
    ends = [("one", "base", "a"), ("two", "a", "b"), ("three", "b", "c"), ("four", "c", "d")]
    path.write_text(
        urdf(
            *(link(name) for name in ("base", "a", "b", "c", "d")),
            *(joint(*between, limit=limit) for between, limit in zip(ends, (bare, zero, far), strict=False)),
            joint(*ends[3], "continuous", limit='lower="-1" upper="1" velocity="2"'),
        )
    )
    with pytest.warns(GdAnalyzeWarning) as caught:
        arm = gd.load_arm(path)
    assert [str(warning.message) for warning in caught] == list(arm.doubts)
    (doubt,) = arm.doubts
    assert "robot.urdf: " in doubt
    assert all(fact in doubt for fact in ("one (line 7)", "two (line 8)"))
    assert [(j.lower, j.upper) for j in arm.joints] == [(None, None)] * 4
    assert [j.velocity_limit for j in arm.joints] == [None, None, None, 2.0]
    assert [drive.torque_limit for drive in arm.drives] == [3.0, None, None, None]
    assert arm.assumptions[-1].endswith("joint three.")


def test_masses_that_are_none_are_doubted(arm_of):
    arm, _ = arm_of(two_joints().replace('mass value="2.0"', 'mass value="0"').replace('"1.0"', '"0"'))
    assert any("no link" in text and "mass" in text for text in arm.doubts)
    assert any("line 3, " in text and "upper has inertia" in text for text in arm.doubts)


def right_angled(right: str, straight: str) -> str:
    """Base turn, then three parallel joints with frames turned to and fro by right angles."""
    names = ["base", "a", "b", "c", "d"]
    turns = ["0 0 0", f"{right} 0 0", f"{right} 0 {straight}", f"-{right} {right} 0"]
    axes = ["0 0 1", "0 0 1", "0 1 0", "0 0 1"]
    links = (link(name, rpy="0 0 0", xyz="0.1 0 0", ixy=0.0, ixz=0.0, iyz=0.0) for name in names)
    joints = (
        joint(f"j{i}", names[i], names[i + 1], rpy=turns[i], axis=axes[i], xyz="0 0.2 0.3") for i in range(4)
    )
    return urdf(*links, *joints)


@pytest.mark.parametrize("right", ["1.5708", "1.570796325", "1.57079632679", repr(math.pi / 2)])
def test_right_angles_of_few_digits_are_made_right(arm_of, right):
    exact, _ = arm_of(right_angled(repr(math.pi / 2), repr(math.pi)))
    arm, path = arm_of(right_angled(right, "3.14159265359"))
    for rounded, written in zip(arm.joints, exact.joints, strict=True):
        np.testing.assert_array_equal(rounded.placement.rotation, written.placement.rotation)
        assert set(np.abs(rounded.placement.rotation).ravel()) == {0.0, 1.0}
    assert len(ExactForm(arm).torques) == len(ExactForm(exact).torques)
    assert AbsoluteVelocities.of(arm).runs == AbsoluteVelocities.of(exact).runs
    off = max(abs(float(right) - math.pi / 2), abs(3.14159265359 - math.pi))
    assert f"{off:.2g} rad" in arm.assumptions[1]
    assert len(exact.assumptions) == 1
    # A joint's frame is turned by three angles at most.
    assert_same_torque(path, arm, random_states(4, 20, 0), askew=3 * off)


@pytest.mark.parametrize(("right", "off"), [("1.57", "0.0008"), ("1.571", "0.0002")])
def test_angles_that_may_be_right_are_doubted_and_taken_as_written(arm_of, right, off):
    arm, path = arm_of(right_angled(right, "3.14"))
    assert all(fact in arm.doubts[0] for fact in ("line 8, column 34", f" {right} ", f" {off} rad"))
    assert any(" 3.14 is 0.002 rad" in doubt for doubt in arm.doubts)
    assert_same_torque(path, arm, random_states(4, 20, 2))


def test_only_changes_of_the_arm_are_reported(arm_of):
    beside = [link("camera"), joint("camera_joint", "base", "camera", "fixed", rpy="1.57 0 1.5708")]
    """Nor measured angles, which are near a right one by chance."""
    measured = [link("b"), joint("k", "a", "b", rpy="1.570123456 0.0012 1.5688")]
    arm, _ = arm_of(urdf(link("base"), link("a"), joint("j", "base", "a"), *measured, *beside))
    assert arm.doubts == ()
    assert len(arm.assumptions) == 1
