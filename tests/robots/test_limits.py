"""Limits beside the file: as words, as numbers, and as MoveIt's and Universal Robots' files have them."""

from __future__ import annotations

import math

import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, UsageError
from robot_files import two_joints

MOVEIT = """
joint_limits:
  shoulder:
    has_velocity_limits: true
    max_velocity: 2.5
    has_acceleration_limits: true
    max_acceleration: 7
  elbow:
    has_velocity_limits: true
    max_velocity: 1
    has_acceleration_limits: false
    max_acceleration: 0
  finger:
    max_acceleration: 1
"""


@pytest.fixture
def robot(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(two_joints())
    return path


def accelerations(arm) -> list[float | None]:
    return [joint.acceleration_limit for joint in arm.joints]


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (["shoulder=3", "elbow=180deg"], [3.0, math.pi]),
        (["all=4", "elbow=5"], [4.0, 5.0]),
        (["3, 360deg"], [3.0, 2 * math.pi]),
        ("all=2", [2.0, 2.0]),
        ({"elbow": 6.0}, [None, 6.0]),
        ((), [None, None]),
    ],
)
def test_words_and_numbers(robot, given, expected):
    arm = gd.load_arm(robot, limits=given)
    assert accelerations(arm) == expected
    assert len(arm.assumptions) == 1 + (len(given) if isinstance(given, list) else bool(given))


def test_built_in_and_toml_arms_take_them_too():
    assert accelerations(gd.load_arm("two_link", limits=["9,8"])) == [9.0, 8.0]


def test_the_file_of_moveit(robot, tmp_path):
    path = tmp_path / "joint_limits.yaml"
    path.write_text(MOVEIT)
    arm = gd.load_arm(robot, limits=path)
    assert accelerations(arm) == [7.0, None]
    assert [joint.velocity_limit for joint in arm.joints] == [2.5, 1.0]
    assert [joint.lower for joint in arm.joints] == [-2.0, -2.0]
    assert arm.assumptions[-1] == "Limits of shoulder, elbow from joint_limits.yaml."
    assert accelerations(gd.load_arm(robot, limits=[str(path), "elbow=2"])) == [7.0, 2.0]


def test_degrees_headings_and_toml(robot, tmp_path):
    path = tmp_path / "limits.yml"
    path.write_text(
        "robot_description_planning:\n  joint_limits:\n    elbow: {has_position_limits: true,"
        " min_position: !degrees -90, max_position: !radians 1, max_acceleration: !degrees 180}\n"
    )
    elbow = gd.load_arm(robot, limits=path).joints[1]
    assert (elbow.lower, elbow.upper, elbow.acceleration_limit) == (-math.pi / 2, 1.0, math.pi)
    path = tmp_path / "limits.toml"
    path.write_text("[joint_limits.elbow]\nmax_acceleration = 3\nmax_velocity = 2.0\n")
    elbow = gd.load_arm(robot, limits=path).joints[1]
    assert (elbow.acceleration_limit, elbow.velocity_limit) == (3.0, 2.0)


@pytest.mark.parametrize(
    ("given", "fact"),
    [
        (["elbow"], "2 values with commas"),
        (["1,2,3"], "1,2,3"),
        (["elbow=0"], "elbow=0"),
        (["elbow=fast"], "elbow=fast"),
        (["wrist=1"], "there is no joint 'wrist' to limit"),
        ({"elbow": math.inf}, "elbow=inf"),
        ([3], "found: 3"),
    ],
)
def test_words_that_are_no_limits(robot, given, fact):
    with pytest.raises(UsageError, match=fact):
        gd.load_arm(robot, limits=given)


@pytest.mark.parametrize(
    ("name", "text", "fact"),
    [
        ("l.yaml", "joint_limits: [1, 2", "l.yaml, line 1, column "),
        ("l.toml", "joint_limits = [\n]]", "l.toml, line 2, column "),
        ("l.yaml", "joints: 3", "the file states no limits"),
        ("l.yaml", "joint_limits: {wrist: {max_acceleration: 1}}", "the file limits no joint of"),
        ("l.yaml", "joint_limits: {elbow: {has_acceleration_limits: true}}", "max_acceleration of joint"),
        ("l.yaml", "joint_limits: {elbow: {max_acceleration: -1}}", "found: -1"),
        ("l.yaml", "joint_limits: {elbow: !!python/object/apply:os.system [id]}", "could not determine"),
        ("l.yaml", "[" * 5_000, "nest too deep"),
        ("l.yaml", None, "cannot read the file of limits"),
    ],
)  # fmt: skip
def test_files_that_are_no_limits(robot, tmp_path, name, text, fact):
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(ArmError, match=fact):
        gd.load_arm(robot, limits=path)
