"""Which chain of a tree is the arm: found, picked, or refused with the options that settle it."""

from __future__ import annotations

import pytest

from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from robot_files import fingers, joint, link, two_joints, urdf


@pytest.fixture
def read(tmp_path):
    def arm(text: str, **picked: object) -> RobotArm:
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        return load_arm(path, **picked)

    return arm


def refused(read, text: str, **picked: object) -> ArmError:
    with pytest.raises(ArmError) as caught:
        read(text, **picked)
    return caught.value


def test_one_chain_is_found_by_itself(read):
    arm = read(two_joints())
    assert (arm.name, arm.title, arm.dh_table) == ("bench_arm", "bench arm", ())
    assert arm.convention == "placements from URDF"
    assert arm.sources[0].startswith("robot.urdf: URDF, read by Pinocchio ")
    assert [(joint.name, link.name) for joint, link in zip(arm.joints, arm.links, strict=True)] == [
        ("shoulder", "upper"),
        ("elbow", "lower"),
    ]
    assert (arm.joints[0].source.line, arm.links[1].source.line) == (5, 4)
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[0].velocity_limit) == (-2.0, 1.5, 3.0)
    assert [drive.torque_limit for drive in arm.drives] == [40.0, 40.0]
    assert arm.gravity.tolist() == [0.0, 0.0, -9.81]


def test_fingers_are_named_with_the_locks_that_settle_it(read):
    error = refused(read, two_joints(*fingers()))
    assert error.what == "the robot branches at link lower"
    assert error.details["where"].endswith("robot.urdf, line 4, column 1")
    assert error.details["found"] == "2 branches: left_finger, right_finger"
    assert error.details["next"] == (
        "--lock left_finger=0 --lock right_finger=0 holds what branches off, with its mass; "
        "--tip lower does the same"
    )
    assert read(two_joints(*fingers()), lock=["left_finger=0", "right_finger=0"]).n_joints == 2


def test_of_two_arms_the_tips_are_named(read):
    arms = [urdf_arm(side) for side in ("left", "right")]
    error = refused(read, urdf(link("torso"), *arms[0], *arms[1]))
    assert error.what == "the robot branches at its base"
    assert error.details["next"] == "name the arm's last link, --tip left3 or --tip right3"
    arm = read(urdf(link("torso"), *arms[0], *arms[1]), tip="right3")
    assert [joint.name for joint in arm.joints] == ["right_joint1", "right_joint2", "right_joint3"]
    assert "Held" not in " ".join(arm.assumptions)  # the other arm hangs on the ground


def urdf_arm(side: str) -> list[str]:
    names = ["torso", *(f"{side}{i}" for i in (1, 2, 3))]
    links = [link(name) for name in names[1:]]
    return [*links, *(joint(f"{side}_joint{i}", names[i - 1], names[i]) for i in (1, 2, 3))]


@pytest.mark.parametrize(
    ("picked", "what", "detail", "text"),
    [
        ({"tip": "lwoer"}, "there is no link 'lwoer'", "next", "did you mean lower"),
        ({"base": "ground"}, "there is no link 'ground'", "found", "base, upper, lower"),
        ({"lock": ["elbw=0"]}, "there is no moving joint 'elbw'", "next", "did you mean elbow"),
        ({"tip": "upper", "base": "lower"}, "link upper is not beyond link lower", "next", "name a base on"),
        ({"tip": "base"}, "the robot has no joint that moves", "found", "2 joints, all of them held"),
    ],
)
def test_a_choice_that_is_none(read, picked, what, detail, text):
    error = refused(read, two_joints(), **picked)
    assert error.what == what
    assert text in error.details[detail]


@pytest.mark.parametrize("lock", ["elbow", "elbow=", "elbow=quarter", "=1", "elbow=90grad"])
def test_a_lock_that_is_none(read, lock):
    with pytest.raises(UsageError, match="this locks no joint") as caught:
        read(two_joints(), lock=[lock])
    assert "elbow=90deg" in caught.value.details["expected"]


def test_a_joint_locked_twice(read):
    with pytest.raises(UsageError, match="joint elbow is locked twice"):
        read(two_joints(), lock=["elbow=0", "elbow=1"])


def test_a_chain_of_toml_has_nothing_to_choose():
    with pytest.raises(ArmError, match="has no other links or joints to choose from"):
        load_arm("two_link", tip="2")


def mimicking(master: str, mass: float | None = 0.2) -> tuple[str, ...]:
    rest = f'<mimic joint="{master}" multiplier="-2" offset="0.1"/>'
    return link("follower", mass), joint("follows", "lower", "follower", rest=rest)


def test_a_mimic_joint_that_moves_mass_is_refused(read):
    error = refused(read, two_joints(*mimicking("elbow")))
    assert error.what == "joint follows mimics joint elbow and moves mass"
    assert error.details["found"] == "-2 times elbow plus 0.1"
    assert error.details["next"] == "--lock follows=0 holds it, --lock elbow=0 both of them"
    assert read(two_joints(*mimicking("elbow")), lock=["follows=0"]).n_joints == 2


def test_a_mimic_joint_without_mass_or_of_a_held_joint_is_held(read):
    assert read(two_joints(*mimicking("elbow", None))).n_joints == 2
    held = read(two_joints(*mimicking("elbow")), lock=["elbow=0.5"])
    assert [joint.name for joint in held.joints] == ["shoulder"]
    assert "elbow at 0.5 rad, follows at -0.9 rad" in held.assumptions[-1]


def test_a_floating_base_is_refused(read):
    text = two_joints(link("world"), joint("root", "world", "base", "floating"))
    error = refused(read, text)
    assert error.what == "the robot floats: joint root lets link base move freely"
    assert error.details["next"] == "--base base takes that link as fixed; or use a file with a fixed base"
    assert read(text, base="base").n_joints == 2


def test_a_planar_joint_is_refused_unless_it_is_held(read):
    text = two_joints(link("pad"), joint("slip", "lower", "pad", "planar"))
    error = refused(read, text)
    assert error.what.startswith("joint slip is planar")
    assert "--lock slip=0 holds it" in error.details["next"]
    assert read(text, lock=["slip=0"]).mass[-1] == 3.0
    assert read(text, tip="lower").n_joints == 2
    assert refused(read, text, lock=["slip=0.1"]).what.startswith("joint slip is planar and can be held at 0")


def test_two_links_of_one_name_and_a_joint_may_share_it(read):
    """Some makers call a link and its joint the same."""
    arm = read(urdf(link("base"), link("gripper"), joint("gripper", "base", "gripper")), lock=[])
    assert arm.joints[0].name == arm.links[0].name == "gripper"
    fixed = two_joints(link("elbow"), joint("left", "lower", "elbow", "prismatic"))
    assert read(fixed, lock=["left=0"]).mass[-1] == 3.0


def test_an_arm_with_long_fingers_may_end_at_its_wrist(read):
    body = [link("base"), *(link(f"a{k}") for k in range(1, 6))]
    body += [joint(f"arm{k}", "base" if k == 1 else f"a{k - 1}", f"a{k}") for k in range(1, 6)]
    wheel = [link("rim"), joint("wheel", "base", "rim")]
    hand: list[str] = []
    for side in "xyz":
        names = ["a5", *(f"{side}{k}" for k in range(1, 6))]
        hand += [link(name) for name in names[1:]]
        hand += [joint(f"{side}_{k}", *names[k : k + 2]) for k in range(5)]
    error = refused(read, urdf(*body, *wheel, *hand))
    assert error.details["next"] == ("name the arm's last link, --tip a5 or --tip x5 or --tip y5 or --tip z5")
