"""MJCF: what Pinocchio's reader knows, what it passes over, and what only MuJoCo can expand."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pinocchio as pin
import pytest

from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots.catalogue import load_arm
from robot_files import assert_same_torque
from strategies import random_states

INERTIAL = '<inertial pos="0.02 0.1 0.03" quat="1 0.2 0.3 0.1" mass="2" diaginertia="0.03 0.04 0.05"/>'


def mjcf(body: str, before: str = '<compiler angle="radian"/>', after: str = "") -> str:
    return f'<mujoco model="bench">\n{before}\n<worldbody>\n{body}\n</worldbody>\n{after}\n</mujoco>'


def two(elbow: str = "", after: str = "") -> str:
    """Two bodies; `elbow` are more attributes of the second one's joint."""
    return (
        f'<body name="base" pos="0 0 1"><body name="upper" pos="0 0 0.2" euler="0.2 0.3 0.4">{INERTIAL}\n'
        f'<joint name="shoulder" axis="0 1 1" range="-1 2" armature=".1" damping=".5" frictionloss=".2"/>\n'
        f'<body name="lower" pos="0.3 0 0" quat="0.9 0.1 0.2 0.3">{INERTIAL}\n'
        f'<joint name="elbow" pos="0.01 0.02 0" {elbow}/>{after}</body></body></body>'
    )


@pytest.fixture
def written(tmp_path):
    def write(text: str):
        path = tmp_path / "robot.xml"
        path.write_text(text)
        return path

    return write


def test_it_has_the_torques_of_pinocchio(written):
    path = written(mjcf(two('axis="1 0 0"')))
    arm = load_arm(path)
    assert (arm.name, arm.convention) == ("bench", "placements from MJCF")
    assert [(joint.name, joint.source.line) for joint in arm.joints] == [("shoulder", 5), ("elbow", 7)]
    drive = arm.drives[0]
    assert (drive.inertia, drive.viscous, drive.coulomb, drive.gear_ratio) == (0.1, 0.5, (0.2, -0.2), 1.0)
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[1].lower) == (-1.0, 2.0, None)
    # Pinocchio itself reads the file to some 1e-12: it stores quaternions of frames rounded.
    ours = pinocchio_dynamics(arm, *random_states(2, 20, 0).arrays)["torque"]
    assert np.isfinite(ours).all()
    assert_same_torque(path, arm, random_states(2, 20, 0), askew=1e-12)


def test_gravity_is_the_files(written):
    arm = load_arm(written(mjcf(two(), '<option gravity="0 -9.7 0.5"/><compiler angle="radian"/>')))
    assert arm.gravity.tolist() == [0.0, -9.7, 0.5]
    assert load_arm(written(mjcf(two()))).gravity.tolist() == [0.0, 0.0, -9.81]


@pytest.mark.parametrize(("kind", "value"), [("hinge", 0.5), ("slide", 0.2)])
def test_a_reference_value_is_that_of_the_pose_as_written(written, kind, value):
    """In MuJoCo the pose of the file is that of q = ref; without ref it is that of q = 0."""
    plain = load_arm(written(mjcf(two(f'axis="1 0 1" type="{kind}" range="-1 1.2"'))))
    moved = load_arm(written(mjcf(two(f'axis="1 0 1" type="{kind}" range="-1 1.2" ref="{value}"'))))
    states = random_states(2, 10, 3)
    q, qd, qdd = states.arrays
    ours = pinocchio_dynamics(moved, q + np.array([0.0, value]), qd, qdd)["torque"]
    # The same arm with its zero elsewhere: some hundred roundings of torques up to 1000 N m.
    np.testing.assert_allclose(ours, pinocchio_dynamics(plain, q, qd, qdd)["torque"], rtol=0, atol=1e-10)
    assert (moved.joints[1].lower, moved.joints[1].upper) == (-1.0, 1.2)


def test_angles_are_in_degrees_unless_the_file_says_otherwise(written):
    degrees = mjcf(two('axis="1 0 0" range="-90 45" ref="30"'), "").replace("0.2 0.3 0.4", "30 0 60")
    radians = mjcf(
        two('axis="1 0 0" range="-1.5707963267948966 0.7853981633974483" ref="0.5235987755982988"')
    )
    turned = radians.replace("0.2 0.3 0.4", "0.5235987755982988 0 1.0471975511965976")
    one, other = load_arm(written(degrees)), load_arm(written(turned))
    assert (one.joints[1].lower, one.joints[1].upper) == (other.joints[1].lower, other.joints[1].upper)
    torques = [pinocchio_dynamics(arm, *random_states(2, 10, 0).arrays)["torque"] for arm in (one, other)]
    # Conversions round, and torques reach 1000 N m.
    np.testing.assert_allclose(torques[0], torques[1], rtol=0, atol=1e-11)


def test_a_range_that_does_not_hold_is_unknown(written):
    arm = load_arm(written(mjcf(two('range="-1 1" limited="false"'))))
    assert arm.joints[1].lower is None


def test_several_joints_of_a_body_are_a_chain(written):
    """Two joints of one body are as two bodies, the first without mass."""
    joints = '<joint name="lift" type="slide" axis="0 0 1"/><joint name="turn" axis="0 1 0"/>'
    body = f'<body name="wrist" pos="0.1 0.2 0.3" euler="0.1 0.2 0.3">{joints}{INERTIAL}</body>'
    arm = load_arm(written(mjcf(body)))
    assert [
        (joint.name, joint.kind, link.name) for joint, link in zip(arm.joints, arm.links, strict=True)
    ] == [
        ("lift", "prismatic", "wrist:lift"),
        ("turn", "revolute", "wrist"),
    ]
    inner = f'<body name="b"><joint name="turn" axis="0 1 0"/>{INERTIAL}</body>'
    outer = (
        '<body name="a" pos="0.1 0.2 0.3" euler="0.1 0.2 0.3"><joint name="lift" type="slide" axis="0 0 1"/>'
    )
    path = written(mjcf(f"{outer}{inner}</body>"))
    states = random_states(2, 10, 0)
    apart = pinocchio_dynamics(load_arm(path), *states.arrays)["torque"]
    np.testing.assert_array_equal(pinocchio_dynamics(arm, *states.arrays)["torque"], apart)


def test_shapes_weigh_where_nothing_is_stated_and_meshes_are_doubted(written):
    box = '<geom type="box" size="0.1 0.2 0.3" mass="3"/>'
    arm = load_arm(written(mjcf(f'<body name="arm"><joint name="j" axis="0 1 0"/>{box}</body>')))
    assert arm.mass.tolist() == [3.0]
    # m/3 (b^2 + c^2) of half lengths; a few roundings.
    np.testing.assert_allclose(arm.inertia_com[0].diagonal(), [0.13, 0.1, 0.05], rtol=1e-15)
    assert arm.assumptions == ("Mass and inertia from primitive shapes, as none are stated: arm.",)
    mesh = '<geom type="mesh" mesh="shell"/>'
    with pytest.warns(
        GdAnalyzeWarning, match=r"line 4, .*body arm states no <inertial>; the mass of its meshes"
    ):
        load_arm(written(mjcf(f'<body name="arm"><joint name="j" axis="0 1 0"/>{box}{mesh}</body>')))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        load_arm(written(mjcf(f'<body name="pedestal">{mesh}{two()}</body>')))  # the base does not move


def test_quaternions_of_six_digits_are_made_right(written):
    body = two('axis="0 0 1"').replace('quat="0.9 0.1 0.2 0.3"', 'quat="0.707107 0.707105 0 0"')
    arm = load_arm(written(mjcf(body)))
    np.testing.assert_array_equal(
        arm.joints[1].placement.rotation, [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    )
    # Half the angle is atan(0.707105 / 0.707107).
    off = math.pi / 2 - 2 * math.atan2(0.707105, 0.707107)
    assert f"of 1 link, most of lower, by {off:.2g} rad" in arm.assumptions[0]


def test_actuators_limit_efforts(written):
    after = '<actuator><motor joint="elbow" gear="50" ctrlrange="-0.5 0.4"/></actuator>'
    arm = load_arm(written(mjcf(two('axis="1 0 0"'), after=after)))
    assert [drive.torque_limit for drive in arm.drives] == [None, 25.0]


def test_springs_and_taken_weight_are_told(written):
    body = two('axis="1 0 0" stiffness="3"').replace('name="lower"', 'name="lower" gravcomp="1"')
    with pytest.warns(GdAnalyzeWarning) as caught:
        load_arm(written(mjcf(body)))
    told = sorted(str(warning.message).partition(": ")[2] for warning in caught)
    assert told == [
        "MuJoCo takes weight off body lower (gravcomp); here not",
        "joint elbow has a spring (stiffness), which is not counted",
    ]


LOOP = '<equality><connect body1="upper" body2="{}" anchor="0 0 0"/></equality>'
FINGER = f'<body name="finger">{INERTIAL}<joint name="pinch" axis="0 0 1"/></body>'
MIMIC = '<equality><joint joint1="pinch" joint2="elbow" polycoef="0.1 2 0 0 0"/></equality>'


@pytest.mark.parametrize(
    ("text", "what", "line", "next_step"),
    [
        (
            mjcf(two(), '<include file="a.xml"/>'),
            "the file uses <include>, which is not read",
            2,
            "saveinertial",
        ),
        (mjcf('<body><frame pos="0 0 0"/></body>'), "the file uses <frame>", 4, "mj_saveLastXML"),
        ("<mujoco><option/></mujoco>", "the file describes no bodies", 1, "not that of a scene"),
        (
            mjcf(two("", FINGER), after=LOOP.format("finger")),
            "links upper and finger close a loop",
            None,
            "--lock elbow=0 --lock pinch=0 holds them; or --tip takes an arm without the loop",
        ),
        (
            mjcf(two("", FINGER), after=MIMIC),
            "joint pinch mimics joint elbow and moves mass",
            7,
            "--lock pinch=0 holds it, --lock elbow=0 both of them",
        ),
        (
            mjcf(f"<body name='trunk'><freejoint/>{INERTIAL}</body>"),
            "the robot floats",
            4,
            "--base trunk takes",
        ),
        (
            mjcf(f"<body name='b'><joint name='hip' type='ball'/>{INERTIAL}</body>"),
            "joint hip is spherical",
            4,
            "--lock hip=0 holds it",
        ),
        (
            mjcf(two().replace('mass="2"', 'mass="-2"')),
            "the mass of body upper is negative",
            4,
            "mend the mass",
        ),
        (mjcf(two().replace('quat="0.9 0.1 0.2 0.3"', 'quat="0 0 0 0"')), "the quat of lower is 0", 6, ""),
        (mjcf(two() + two()), "there are two bodies 'base'", 7, "rename"),
    ],
)
def test_refused(written, capfd, text, what, line, next_step):
    with pytest.raises(ArmError) as caught:
        load_arm(written(text))
    assert what in caught.value.what
    assert next_step in caught.value.details.get("next", "")
    if line is not None:
        assert f"robot.xml, line {line}, " in caught.value.details["where"]
    assert capfd.readouterr() == ("", "")


def test_a_model_in_memory(tmp_path):
    path = tmp_path / "robot.xml"
    path.write_text(mjcf(two('axis="1 0 0"')))
    model = pin.buildModelFromMJCF(str(path))
    model.gravity.linear = np.array([0.0, 9.0, 0.0])
    names = [frame.name for frame in model.frames]
    arm = load_arm(model)
    assert arm.convention == "placements from a Pinocchio model"
    assert arm.gravity.tolist() == [0.0, 9.0, 0.0]
    assert (arm.joints[0].name, arm.links[0].name, arm.joints[0].lower) == ("shoulder", "upper", -1.0)
    assert_same_torque(path, arm, random_states(2, 20, 1), askew=1e-12)
    assert names == [frame.name for frame in model.frames]
    assert load_arm(model, tip="upper").n_joints == 1
    with pytest.raises(ArmError, match="this is no arm"):
        load_arm(3)
