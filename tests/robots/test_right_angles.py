"""Right angles of few digits are made right, said so, and change torque by no more than they were off."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.harmonics.absolute_velocities import AbsoluteVelocities
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.right_angles import RIGHT, RightAngles, straight
from gd_analyze.simplification.exact_form import ExactForm
from robot_files import assert_same_torque, joint, link, urdf
from strategies import examples, random_rotation, random_states


def arm_file(tmp_path, right: str, other: str):
    """Base turn, then three parallel joints with frames turned to and fro by right angles."""
    path = tmp_path / "robot.urdf"
    names = ["base", "a", "b", "c", "d"]
    turns = ["0 0 0", f"{right} 0 0", f"{right} 0 {other}", f"-{right} {right} 0"]
    axes = ["0 0 1", "0 0 1", "0 1 0", "0 0 1"]
    path.write_text(
        urdf(
            *(link(name, rpy="0 0 0", xyz="0.1 0 0", ixy=0.0, ixz=0.0, iyz=0.0) for name in names),
            *(
                joint(f"j{i}", names[i], names[i + 1], rpy=turns[i], axis=axes[i], xyz="0 0.2 0.3")
                for i in range(4)
            ),
        )
    )
    return path


@pytest.mark.parametrize("right", ["1.5708", "1.570796", "1.570796325", "1.57079632679"])
def test_they_are_made_right(tmp_path, right):
    path = arm_file(tmp_path, right, "3.14159265359")
    arm = load_arm(path)
    exact = load_arm(arm_file(tmp_path, repr(math.pi / 2), repr(math.pi)))
    for one, other in zip(arm.joints, exact.joints, strict=True):
        np.testing.assert_array_equal(one.placement.rotation, other.placement.rotation)
        assert set(np.abs(one.placement.rotation).ravel()) == {0.0, 1.0}
    assert len(ExactForm(arm).torques) == len(ExactForm(exact).torques)
    assert AbsoluteVelocities.of(arm).runs == AbsoluteVelocities.of(exact).runs
    off = max(abs(float(right) - math.pi / 2), abs(3.14159265359 - math.pi))
    told = arm.assumptions[1]
    assert told.startswith(
        "Angles within 1e-05 rad of a right angle are taken as right: of 3 links, most of "
    )
    assert told.endswith(f", by {off:.2g} rad.")
    assert len(exact.assumptions) == 1
    arm_file(tmp_path, right, "3.14159265359")
    # A joint's frame is turned by three angles at most.
    assert_same_torque(path, arm, random_states(4, 20, 0), askew=3 * off)


def test_nothing_is_changed_where_angles_are_right(tmp_path):
    path = arm_file(tmp_path, repr(math.pi / 2), repr(-math.pi))
    assert_same_torque(path, load_arm(path), random_states(4, 20, 1))


@pytest.mark.parametrize(("right", "off"), [("1.57", "0.0008"), ("1.571", "0.0002")])
def test_angles_that_may_be_right_are_named_and_taken_as_written(tmp_path, right, off):
    path = arm_file(tmp_path, right, "3.14")
    with pytest.warns(GdAnalyzeWarning) as caught:
        arm = load_arm(path)
    told = [str(warning.message) for warning in caught]
    assert told == list(arm.doubts)
    assert f"line 8, column 34: an angle of {right} is {off} rad off a right angle and taken as" in told[0]
    assert told[0].endswith("if 1.5708 is meant, give it six digits")
    assert any("an angle of 3.14 is 0.002 rad off" in one and "3.14159 is meant" in one for one in told)
    assert_same_torque(path, arm, random_states(4, 20, 2))


@pytest.mark.parametrize("measured", ["1.570123456", "0.0012", "1.5688", "0.785398"])
def test_measured_angles_are_neither_changed_nor_suspected(measured):
    angles = RightAngles()
    assert angles.angle(measured, "link", "line 1") == measured
    assert not angles.suspects
    assert not angles.assumptions({"link"})


def test_only_what_the_arm_has_is_told(tmp_path):
    path = tmp_path / "robot.urdf"
    beside = [link("camera"), joint("camera_joint", "base", "camera", "fixed", rpy="1.57 0 1.5708")]
    path.write_text(urdf(link("base"), link("a"), joint("j", "base", "a"), *beside))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        arm = load_arm(path)
    assert arm.doubts == ()
    assert len(arm.assumptions) == 1


def test_degrees_are_right_at_ninety():
    angles = RightAngles()
    assert angles.angle("90.0001", "link", "line 1", 360.0) == "90.0"
    (told,) = angles.assumptions({"link"})
    assert told.endswith("of 1 link, most of link, by 1.7e-06 rad.")


@examples(100)
@given(st.integers(0, 2**32 - 1), st.integers(0, 2), st.floats(-RIGHT / 3, RIGHT / 3))
def test_a_rotation_made_right_has_exact_zeros_and_is_one(seed, axis, tilt):
    """A turn about one axis, tilted by less than is seen, becomes such a turn again; others stay."""
    rng = np.random.default_rng(seed)
    angle = rng.uniform(0.1, 1.4)
    others = [i for i in range(3) if i != axis]
    turn = np.eye(3)
    turn[np.ix_(others, others)] = [[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]]
    lean = np.eye(3)
    lean[axis, others[0]], lean[others[0], axis] = tilt, -tilt
    found = straight(turn @ lean, RIGHT)
    assert (found[axis, others] == 0.0).all()
    assert (found[others, axis] == 0.0).all()
    # Nine products of entries up to 1.
    np.testing.assert_allclose(found.T @ found, np.eye(3), rtol=0, atol=9 * np.finfo(float).eps)
    np.testing.assert_allclose(found, turn @ lean, rtol=0, atol=2 * abs(tilt) + 1e-15)
    askew = random_rotation(rng)
    if np.abs(askew).min() > RIGHT:
        np.testing.assert_allclose(straight(askew, RIGHT), askew, rtol=0, atol=1e-15)
