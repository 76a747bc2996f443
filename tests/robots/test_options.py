"""Options of a robot's file: which chain is the arm, locked joints, and limits beside the file."""

from __future__ import annotations

import math

import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeError, UsageError
from robot_files import TWO_ARMS, chain, fingers, joint, link, two_joints, urdf


@pytest.fixture
def read(tmp_path):
    def arm(text: str, **picked: object) -> gd.types.RobotArm:
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
    assert arm.gravity_vector.tolist() == [0.0, 0.0, -9.81]


def mimicking(mass: float | None = 0.2) -> tuple[str, ...]:
    rest = '<mimic joint="elbow" multiplier="-2" offset="0.1"/>'
    return link("follower", mass), joint("follows", "lower", "follower", rest=rest)


def levered(mass: float | None = 3.0, *more: str) -> str:
    """A palletizer: a lever beside the arm keeps step with the elbow, and a rod with the lever."""
    step, back = '<mimic joint="elbow"/>', '<mimic joint="lever_joint" multiplier="-1"/>'
    lever = (link("lever", mass), joint("lever_joint", "upper", "lever", rest=step))
    rod = (link("rod", mass), joint("rod_joint", "lever", "rod", rest=back))
    return two_joints(*lever, *rod, *more)


def fingers_in_step() -> list[str]:
    """The right finger follows the left one."""
    *others, right = fingers()
    return [*others, right.replace("</joint>", '<mimic joint="left_finger"/></joint>')]


def led_from_aside(*more: str) -> str:
    """The elbow follows a joint beside it, over others where there are more."""
    follows = joint("elbow", "upper", "lower", axis="0 1 0", rest='<mimic joint="aside"/>')
    beside = link("lever"), joint("aside", "upper", "lever")
    return urdf(link("base"), link("upper"), link("lower"), joint("shoulder", "base", "upper"), follows,
                *(more or beside))  # fmt: skip


def circle(count: int) -> str:
    """Joints of a chain, of which each follows the next one, and the last the first."""
    names = [f"l{i}" for i in range(count + 1)]
    rests = [f'<mimic joint="j{(i + 1) % count}"/>' for i in range(count)]
    return urdf(*map(link, names), *(joint(f"j{i}", *names[i : i + 2], rest=rests[i]) for i in range(count)))


RELAYED = (link("lever"), joint("aside", "upper", "lever", rest='<mimic joint="relay"/>'),
           link("rocker"), joint("relay", "upper", "rocker"))  # fmt: skip
FINGERS = two_joints(*fingers())
HAND = [part for side in "xyz" for part in chain("a5", side, 5)]
LONG_FINGERS = urdf(link("base"), *chain("base", "a", 5), *chain("base", "rim", 1), *HAND)
# Some makers call a link and its joint the same.
SAME_NAMES = (link("elbow"), joint("left", "lower", "elbow", "prismatic"))
GAZEBO_LOOP = "<gazebo><joint name='rod'><parent>upper</parent><child>base</child></joint></gazebo>"
LOOP_JOINT = "<loop_joint name='rod'><link1 link='lower'/><link2 link='upper'/></loop_joint>"
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
        (levered(), {}, ["line 8", "lever_joint mimics joint elbow, which moves, and loads it with 6 kg"]),
        (levered(), {"tip": "lower"}, ["lever_joint mimics joint elbow", "--lock elbow=0 both"]),
        (levered(), {"tip": "lower", "lock": ["rod_joint=0"]}, ["lever_joint mimics joint elbow"]),
        (two_joints(*fingers_in_step()), {"tip": "left"}, ["right_finger mimics joint left_finger"]),
        (led_from_aside(), {"tip": "lower"}, ["line 6", "elbow follows joint aside", "--lock aside=0"]),
        (led_from_aside(*RELAYED), {"tip": "lower"}, ["elbow follows joint aside", "--lock aside=0"]),
        (two_joints(*mimicking()).replace('"elbow" mul', '"shoulder" mul'), {"base": "upper"},
         ["follows follows joint shoulder", "--lock shoulder=0 holds both"]),
        (circle(1), {}, ["line 4", "in a circle", "j0 follows j0", "--lock j0=0"]),
        (circle(3), {}, ["line 6", "j0 follows j1 follows j2 follows j0", "--lock j0=0"]),
        (circle(3), {"tip": "l1"}, ["j0 follows j1 follows j2 follows j0"]),
        (two_joints(GAZEBO_LOOP), {}, ["line 7", "links upper and base close a loop", "--lock shoulder=0"]),
        (two_joints(LOOP_JOINT), {}, ["line 7", "links lower and upper close a loop", "--lock elbow=0"]),
        (FLOATING, {}, ["the robot floats: joint root", "--base base fixes that link"]),
        (PLANAR, {}, ["joint slip is planar", "--lock slip=0 holds it"]),
        (PLANAR, {"lock": ["slip=0.1"]}, ["can be held only at 0"]),
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
        assert fact in caught.value.with_options()


@pytest.mark.parametrize(
    ("text", "picked", "joints"),
    [
        (FINGERS, {"lock": ["left_finger=0", "right_finger=0"]}, ["shoulder", "elbow"]),
        (TWO_ARMS, {"tip": "right3"}, ["right_0", "right_1", "right_2"]),
        (two_joints(*mimicking()), {"lock": ["follows=0"]}, ["shoulder", "elbow"]),
        (two_joints(*mimicking(None)), {}, ["shoulder", "elbow"]),
        (two_joints(*mimicking()), {"lock": ["elbow=0.5"]}, ["shoulder"]),
        (levered(None), {"tip": "lower"}, ["shoulder", "elbow"]),
        (levered(), {"tip": "upper"}, ["shoulder"]),
        (levered(), {"tip": "lower", "lock": ["elbow=0.5"]}, ["shoulder"]),
        (levered(), {"tip": "lower", "lock": ["lever_joint=0"]}, ["shoulder", "elbow"]),
        (two_joints(*fingers_in_step()), {"tip": "lower"}, ["shoulder", "elbow"]),
        (led_from_aside(), {"tip": "lower", "lock": ["aside=0.3"]}, ["shoulder"]),
        (led_from_aside(), {"tip": "lower", "lock": ["elbow=0"]}, ["shoulder"]),
        (led_from_aside(*RELAYED), {"tip": "lower", "lock": ["relay=0.3"]}, ["shoulder"]),
        (led_from_aside(), {"tip": "upper"}, ["shoulder"]),
        (two_joints(GAZEBO_LOOP), {"lock": ["shoulder=0"]}, ["elbow"]),
        (two_joints(LOOP_JOINT), {"tip": "upper"}, ["shoulder"]),
        (FLOATING, {"base": "base"}, ["shoulder", "elbow"]),
        (PLANAR, {"lock": ["slip=0"]}, ["shoulder", "elbow"]),
        (PLANAR, {"tip": "lower"}, ["shoulder", "elbow"]),
        (urdf(link("base"), link("gripper"), joint("gripper", "base", "gripper")), {}, ["gripper"]),
        (two_joints(*SAME_NAMES), {"lock": ["left=0"]}, ["shoulder", "elbow"]),
    ],
)
def test_settled_by_options(read, text, picked, joints):
    arm = read(text, **picked)
    assert [joint.name for joint in arm.joints] == joints
    held = " ".join(arm.assumptions)
    # An arm beside this one hangs on the ground.
    assert ("Held" in held) == (text is not TWO_ARMS and "gripper" not in joints)
    is_locked = picked == {"lock": ["elbow=0.5"]}
    assert ("elbow at 0.5 rad" in held and "follows at -0.9 rad" in held) == is_locked


def test_a_joint_of_a_simulator_that_holds_the_base_closes_no_loop(read):
    assert read(two_joints(GAZEBO_LOOP.replace("upper", "world"))).n_joints == 2


@pytest.mark.parametrize("lock", [["elbow"], ["=1"], ["elbow=90grad"], ["elbow=0", "elbow=1"]])
def test_a_lock_that_is_none(read, lock):
    with pytest.raises(UsageError, match="lock"):
        read(two_joints(), lock=lock)


@pytest.mark.parametrize("lock", ["elbow=10mm", "elbow=90", "elbow=4ms"])
def test_a_lock_of_another_kind_or_of_degrees_without_a_unit(read, lock):
    with pytest.raises(GdAnalyzeError) as caught:
        read(two_joints(), lock=[lock])
    assert "lock" in caught.value.details["where"]
    assert "elbow at 1.5708 rad" in " ".join(read(two_joints(), lock=["elbow=90deg"]).assumptions)


@pytest.mark.parametrize("limit", ["1=10mm", "all=600", "1=4ms", "1=20g"])
def test_a_limit_of_another_kind_or_of_degrees_without_a_unit(limit):
    with pytest.raises(UsageError) as caught:
        gd.load_arm("two_link", limits=[limit])
    assert caught.value.details["where"] == "limits"
    assert accelerations(gd.load_arm("two_link", limits=["all=600deg"])) == pytest.approx([10.47197551] * 2)


def test_an_arm_of_toml_takes_limits_and_has_no_chain_to_choose():
    assert accelerations(gd.load_arm("two_link", limits=["9,8"])) == [9.0, 8.0]
    with pytest.raises(ArmError, match="nothing to choose"):
        gd.load_arm("two_link", tip="2")


MOVEIT = """
joint_limits:
  shoulder: {has_velocity_limits: true, max_velocity: 2.5, has_acceleration_limits: true, max_acceleration: 7}
  elbow: {has_velocity_limits: true, max_velocity: 1, has_acceleration_limits: false, max_acceleration: 0}
  finger: {max_acceleration: 1}
"""


@pytest.fixture
def robot(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(two_joints())
    return path


def accelerations(arm) -> list[float | None]:
    return [joint.acceleration_limit for joint in arm.joints]


@pytest.mark.parametrize(
    ("limits", "expected"),
    [
        (["shoulder=3", "elbow=180deg"], [3.0, math.pi]),
        (["all=4", "elbow=5"], [4.0, 5.0]),
        (["3, 360deg"], [3.0, 2 * math.pi]),
        ("all=2", [2.0, 2.0]),
        ({"elbow": 6.0}, [None, 6.0]),
        ("2=1", [None, 1.0]),
        ((), [None, None]),
    ],
)
def test_words_and_numbers(robot, limits, expected):
    arm = gd.load_arm(robot, limits=limits)
    assert accelerations(arm) == expected
    assert len(arm.assumptions) == 1 + (len(limits) if isinstance(limits, list) else bool(limits))


def test_the_file_of_moveit(robot, tmp_path):
    path = tmp_path / "joint_limits.yaml"
    path.write_text(MOVEIT)
    arm = gd.load_arm(robot, limits=path)
    assert accelerations(arm) == [7.0, None]
    assert [joint.velocity_limit for joint in arm.joints] == [2.5, 1.0]
    assert [joint.lower for joint in arm.joints] == [-2.0, -2.0]
    assert "shoulder, elbow" in arm.assumptions[-1]
    assert path.name in arm.assumptions[-1]
    assert accelerations(gd.load_arm(robot, limits=[str(path), "elbow=2"])) == [7.0, 2.0]


def test_degrees_headings_and_toml(robot, tmp_path):
    path, toml_path = tmp_path / "limits.yml", tmp_path / "limits.toml"
    path.write_text(
        "robot_description_planning:\n  joint_limits:\n    elbow: {has_position_limits: true,"
        " min_position: !degrees -90, max_position: !radians 1, max_acceleration: !degrees 180}\n"
    )
    elbow = gd.load_arm(robot, limits=path).joints[1]
    assert (elbow.lower, elbow.upper, elbow.acceleration_limit) == (-math.pi / 2, 1.0, math.pi)
    toml_path.write_text("[joint_limits.elbow]\nmax_acceleration = 3\nmax_velocity = 2.0\n")
    elbow = gd.load_arm(robot, limits=toml_path).joints[1]
    assert (elbow.acceleration_limit, elbow.velocity_limit) == (3.0, 2.0)


@pytest.mark.parametrize(
    ("limits", "fact"),
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
def test_words_that_are_no_limits(robot, limits, fact):
    with pytest.raises(UsageError, match=fact):
        gd.load_arm(robot, limits=limits)


@pytest.mark.parametrize(
    ("name", "text", "fact"),
    [
        ("l.yaml", "joint_limits: [1, 2", "l.yaml, line 1, column "),
        ("l.toml", "joint_limits = [\n]]", "l.toml, line 2, column "),
        ("l.yaml", "joint_limits: {elbow: {min_position: -0.5}}", "max_position of joint elbow"),
        ("l.yaml", "joint_limits: {elbow: {max_acceleration: 1, max_acceleration: 9}}", "a second key"),
        ("l.yaml", "joints: 3", "no table joint_limits"),
        ("l.yaml", "joint_limits: {wrist: {max_acceleration: 1}}", "the file limits no joint of"),
        ("l.yaml", "joint_limits: {elbow: {has_acceleration_limits: true}}", "max_acceleration of joint"),
        ("l.yaml", "joint_limits: {elbow: {max_acceleration: -1}}", "found: -1"),
        ("l.yaml", "joint_limits: {elbow: !!python/object/apply:os.system [id]}", "could not determine"),
        ("l.yaml", "[" * 1_500, "nested too deep"),
        ("l.yaml", None, "cannot read the file of limits"),
    ],
)  # fmt: skip
def test_files_that_are_no_limits(robot, tmp_path, name, text, fact):
    path = tmp_path / name
    if text is not None:
        path.write_text(text)
    with pytest.raises(ArmError, match=fact):
        gd.load_arm(robot, limits=path)


def test_gravity_and_drive_inertia_in_place_of_the_files(read):
    arm = read(two_joints(), gravity="0,0,-1.62", drive_inertia="0.5,0.25")
    assert arm.gravity_vector.tolist() == [0.0, 0.0, -1.62]
    assert arm.drive_inertia.tolist() == [0.5, 0.25]
    assert [drive.torque_limit for drive in arm.drives] == [40.0, 40.0]
    plain = gd.load_arm("two_link", drive_inertia=[0.1, 0.2])
    assert plain.counts_drives()
    assert plain.drive_inertia.tolist() == [0.1, 0.2]


def test_drives_of_a_file_beside_the_robots(read, tmp_path):
    """Inertia, friction and limits; a slip in it has its line."""
    path = tmp_path / "drives.toml"
    drive = "[[drives]]\ninertia = {}\nviscous = 0.3\ncoulomb = [1.0, -1.5]\n"
    path.write_text(drive.format(0.2) + drive.format(0.4) + "torque_limit = 50.0\n")
    arm = read(two_joints(), drive_inertia=str(path))
    assert arm.drive_inertia.tolist() == [0.2, 0.4]
    assert [drive.coulomb for drive in arm.drives] == [(1.0, -1.5)] * 2
    assert [drive.torque_limit for drive in arm.drives] == [None, 50.0]
    path.write_text(drive.format(0.2) + drive.format(-0.4))
    with pytest.raises(ArmError, match=r"drives.toml, line 6"):
        gd.load_arm("two_link", drive_inertia=str(path))
    path.write_text(drive.format(0.2))
    with pytest.raises(ArmError, match="drives"):
        gd.load_arm("two_link", drive_inertia=str(path))
    path.write_text('name = "x"\n')
    with pytest.raises(ArmError, match=r"drives.toml, line 1"):
        gd.load_arm("two_link", drive_inertia=str(path))


@pytest.mark.parametrize(
    ("options", "where"),
    [
        ({"gravity": "0,-9.81"}, "gravity"),
        ({"gravity": "0,0,g"}, "gravity"),
        ({"drive_inertia": "1"}, "drive_inertia"),
        ({"drive_inertia": [1.0, 2.0, 3.0]}, "drive_inertia"),
    ],
)
def test_numbers_that_do_not_fit_are_refused(options, where):
    with pytest.raises(UsageError) as caught:
        gd.load_arm("two_link", **options)
    assert caught.value.details["where"] == where
    with pytest.raises(ArmError, match="inertia"):
        gd.load_arm("two_link", drive_inertia="-1,2")
