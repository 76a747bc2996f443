"""Which chain of a tree is the arm: found, picked, or refused with the options that settle it."""

from __future__ import annotations

import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, UsageError
from robot_files import fingers, joint, link, two_joints, urdf


@pytest.fixture
def read(tmp_path):
    def arm(text: str, **picked: object) -> gd.RobotArm:
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        return gd.load_arm(path, **picked)

    return arm


def test_one_chain_is_found_by_itself(read):
    arm = read(two_joints())
    assert (arm.name, arm.title, arm.dh_table) == ("bench_arm", "bench arm", ())
    assert [joint.name for joint in arm.joints] == ["shoulder", "elbow"]
    assert [link.name for link in arm.links] == ["upper", "lower"]
    assert (arm.joints[0].source.line, arm.links[1].source.line) == (5, 4)
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[0].velocity_limit) == (-2.0, 1.5, 3.0)
    assert [drive.torque_limit for drive in arm.drives] == [40.0, 40.0]
    assert arm.gravity.tolist() == [0.0, 0.0, -9.81]


def chain(start: str, side: str, length: int) -> list[str]:
    names = [start, *(f"{side}{i}" for i in range(1, length + 1))]
    joints = [joint(f"{side}_{i}", *names[i : i + 2]) for i in range(length)]
    return [*map(link, names[1:]), *joints]


def mimicking(mass: float | None = 0.2) -> tuple[str, ...]:
    rest = '<mimic joint="elbow" multiplier="-2" offset="0.1"/>'
    return link("follower", mass), joint("follows", "lower", "follower", rest=rest)


FINGERS = two_joints(*fingers())
TWO_ARMS = urdf(link("torso"), *chain("torso", "left", 3), *chain("torso", "right", 3))
HAND = [part for side in "xyz" for part in chain("a5", side, 5)]
LONG_FINGERS = urdf(link("base"), *chain("base", "a", 5), *chain("base", "rim", 1), *HAND)
FLOATING = two_joints(link("world"), joint("root", "world", "base", "floating"))
PLANAR = two_joints(link("pad"), joint("slip", "lower", "pad", "planar"))


@pytest.mark.parametrize(
    ("text", "picked", "facts"),
    [
        (
            FINGERS,
            {},
            ["branches at link lower", "line 4", "left_finger, right_finger",
             "--lock left_finger=0 --lock right_finger=0 holds", "--tip lower does the same"],
        ),
        (TWO_ARMS, {}, ["branches at its base", "--tip left3 or --tip right3"]),
        (LONG_FINGERS, {}, ["--tip a5 or --tip x5 or --tip y5 or --tip z5"]),
        (two_joints(*mimicking()), {}, ["follows mimics", "-2 times elbow plus 0.1", "--lock follows=0"]),
        (FLOATING, {}, ["the robot floats: joint root", "--base base takes that link"]),
        (PLANAR, {}, ["joint slip is planar", "--lock slip=0 holds it"]),
        (PLANAR, {"lock": ["slip=0.1"]}, ["can be held at 0 only"]),
        (two_joints(), {"tip": "lwoer"}, ["there is no link 'lwoer'", "did you mean lower"]),
        (two_joints(), {"base": "ground"}, ["there is no link 'ground'", "base, upper, lower"]),
        (two_joints(), {"lock": ["elbw=0"]}, ["there is no moving joint 'elbw'", "did you mean elbow"]),
        (two_joints(), {"tip": "upper", "base": "lower"}, ["link upper is not beyond link lower"]),
        (two_joints(), {"tip": "base"}, ["no joint that moves", "2 joints, all of them held"]),
    ],
)  # fmt: skip
def test_refused_with_the_way_out(read, text, picked, facts):
    with pytest.raises(ArmError) as caught:
        read(text, **picked)
    for fact in facts:
        assert fact in str(caught.value)


@pytest.mark.parametrize(
    ("text", "picked", "joints"),
    [
        (FINGERS, {"lock": ["left_finger=0", "right_finger=0"]}, ["shoulder", "elbow"]),
        (TWO_ARMS, {"tip": "right3"}, ["right_0", "right_1", "right_2"]),
        (two_joints(*mimicking()), {"lock": ["follows=0"]}, ["shoulder", "elbow"]),
        (two_joints(*mimicking(None)), {}, ["shoulder", "elbow"]),
        (two_joints(*mimicking()), {"lock": ["elbow=0.5"]}, ["shoulder"]),
        (FLOATING, {"base": "base"}, ["shoulder", "elbow"]),
        (PLANAR, {"lock": ["slip=0"]}, ["shoulder", "elbow"]),
        (PLANAR, {"tip": "lower"}, ["shoulder", "elbow"]),
        # Some makers call a link and its joint the same.
        (urdf(link("base"), link("gripper"), joint("gripper", "base", "gripper")), {}, ["gripper"]),
        (
            two_joints(link("elbow"), joint("left", "lower", "elbow", "prismatic")),
            {"lock": ["left=0"]},
            ["shoulder", "elbow"],
        ),
    ],
)
def test_settled_by_options(read, text, picked, joints):
    arm = read(text, **picked)
    assert [joint.name for joint in arm.joints] == joints
    held = " ".join(arm.assumptions)
    assert ("Held" in held) == (
        text is not TWO_ARMS and "gripper" not in joints
    )  # that arm hangs on the ground
    assert ("elbow at 0.5 rad, follows at -0.9 rad" in held) == (picked == {"lock": ["elbow=0.5"]})


@pytest.mark.parametrize(
    "lock", [["elbow"], ["elbow="], ["elbow=quarter"], ["=1"], ["elbow=90grad"], ["elbow=0", "elbow=1"]]
)
def test_a_lock_that_is_none(read, lock):
    with pytest.raises(UsageError, match="--lock"):
        read(two_joints(), lock=lock)


def test_a_chain_of_toml_has_nothing_to_choose():
    with pytest.raises(ArmError, match="has no other links or joints to choose from"):
        gd.load_arm("two_link", tip="2")
