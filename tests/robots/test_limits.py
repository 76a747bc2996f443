"""Limits beside the file: as words, as numbers, and as MoveIt's and Universal Robots' files have them."""

from __future__ import annotations

import math

import pytest

from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.catalogue import load_arm
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
    assert accelerations(load_arm(robot, limits=given)) == expected


def test_what_is_given_is_told(robot):
    assert load_arm(robot, limits=["all=4"]).assumptions[-1] == "Acceleration limits as given: all=4."
    told = load_arm(robot, limits={"elbow": 6.0}).assumptions[-1]
    assert told == "Acceleration limits as given, per s^2: elbow 6."


def test_built_in_and_toml_arms_take_them_too():
    assert accelerations(load_arm("two_link", limits=["9,8"])) == [9.0, 8.0]


def test_the_file_of_moveit(robot, tmp_path):
    path = tmp_path / "joint_limits.yaml"
    path.write_text(MOVEIT)
    arm = load_arm(robot, limits=path)
    assert accelerations(arm) == [7.0, None]
    assert [joint.velocity_limit for joint in arm.joints] == [2.5, 1.0]
    assert [joint.lower for joint in arm.joints] == [-2.0, -2.0]
    assert arm.assumptions[-1] == "Limits of shoulder, elbow from joint_limits.yaml."
    assert accelerations(load_arm(robot, limits=[str(path), "elbow=2"])) == [7.0, 2.0]


def test_degrees_headings_and_ranges(robot, tmp_path):
    path = tmp_path / "limits.yml"
    path.write_text(
        "robot_description_planning:\n  joint_limits:\n    elbow: {has_position_limits: true,"
        " min_position: !degrees -90, max_position: !radians 1, max_acceleration: !degrees 180}\n"
    )
    elbow = load_arm(robot, limits=path).joints[1]
    assert (elbow.lower, elbow.upper, elbow.acceleration_limit) == (-math.pi / 2, 1.0, math.pi)


def test_toml_of_the_same_names(robot, tmp_path):
    path = tmp_path / "limits.toml"
    path.write_text("[joint_limits.elbow]\nmax_acceleration = 3\nmax_velocity = 2.0\n")
    elbow = load_arm(robot, limits=path).joints[1]
    assert (elbow.acceleration_limit, elbow.velocity_limit) == (3.0, 2.0)


@pytest.mark.parametrize(
    ("given", "what", "text"),
    [
        (["elbow"], "this is no acceleration limit", "joint=value, all=value, 2 values with commas"),
        (["1,2,3"], "this is no acceleration limit", "1,2,3"),
        (["elbow=0"], "this is no acceleration limit", "elbow=0"),
        (["elbow=fast"], "this is no acceleration limit", "elbow=fast"),
        (["wrist=1"], "there is no joint 'wrist' to limit", "shoulder, elbow"),
        ({"elbow": math.inf}, "this is no acceleration limit", "elbow=inf"),
        ([3], "this is no acceleration limit", "3"),
    ],
)
def test_words_that_are_no_limits(robot, given, what, text):
    with pytest.raises(UsageError) as caught:
        load_arm(robot, limits=given)
    assert caught.value.what == what
    assert text in str(caught.value)


@pytest.mark.parametrize(
    ("name", "text", "what", "detail"),
    [
        ("l.yaml", "joint_limits: [1, 2", "the file of limits is not valid YAML", "l.yaml, line 1, column "),
        ("l.toml", "joint_limits = [\n]]", "the file of limits is not valid TOML", "l.toml, line 2, column "),
        ("l.yaml", "joints: 3", "the file states no limits", "has_acceleration_limits: true"),
        ("l.yaml", "joint_limits: {wrist: {max_acceleration: 1}}", "the file limits no joint of", "wrist"),
        (
            "l.yaml",
            "joint_limits: {elbow: {has_acceleration_limits: true}}",
            "max_acceleration of joint elbow is no limit",
            "set has_acceleration_limits to false",
        ),
        (
            "l.yaml",
            "joint_limits: {elbow: {max_acceleration: -1}}",
            "max_acceleration of joint elbow is no limit",
            "-1",
        ),
        (
            "l.yaml",
            "joint_limits: {elbow: {max_acceleration: !!python/object/apply:os.system [id]}}",
            "the file of limits is not valid YAML",
            "could not determine a constructor",
        ),
        ("l.yaml", "[" * 5_000, "the file of limits ", ""),
    ],
)
def test_files_that_are_no_limits(robot, tmp_path, name, text, what, detail):
    path = tmp_path / name
    path.write_text(text)
    with pytest.raises(ArmError) as caught:
        load_arm(robot, limits=path)
    assert caught.value.what.startswith(what)
    assert detail in str(caught.value)


def test_a_file_that_is_not_there(robot):
    with pytest.raises(ArmError, match="cannot read the file of limits"):
        load_arm(robot, limits="missing.yaml")
