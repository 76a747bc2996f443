"""MJCF: what Pinocchio's reader knows, what it passes over, and what only MuJoCo can expand."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pinocchio as pin
import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeWarning
from robot_files import INERTIAL, assert_same_torque, mjcf
from robot_files import two_bodies as two
from strategies import random_states


@pytest.fixture
def written(tmp_path):
    def write(text: str):
        path = tmp_path / "robot.xml"
        path.write_text(text)
        return path

    return write


def test_it_has_the_torques_of_pinocchio(written):
    path = written(mjcf(two('axis="1 0 0"')))
    arm = gd.load_arm(path)
    assert (arm.name, arm.convention) == ("bench", "placements from MJCF")
    assert [(joint.name, joint.source.line) for joint in arm.joints] == [("shoulder", 5), ("elbow", 7)]
    drive = arm.drives[0]
    assert (drive.inertia, drive.viscous, drive.coulomb, drive.gear_ratio) == (0.1, 0.5, (0.2, -0.2), 1.0)
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[1].lower) == (-1.0, 2.0, None)
    assert arm.gravity.tolist() == [0.0, 0.0, -9.81]
    # Pinocchio itself reads the file to some 1e-12: it stores quaternions of frames rounded.
    assert_same_torque(path, arm, random_states(2, 20, 0), askew=1e-12)


def test_what_pinocchio_passes_over(written):
    """Gravity, a range that does not hold, actuators that limit efforts."""
    before = '<option gravity="0 -9.7 0.5"/><compiler angle="radian"/>'
    after = '<actuator><motor joint="elbow" gear="50" ctrlrange="-0.5 0.4"/></actuator>'
    arm = gd.load_arm(written(mjcf(two('axis="1 0 0" range="-1 1" limited="false"'), before, after)))
    assert arm.gravity.tolist() == [0.0, -9.7, 0.5]
    assert arm.joints[1].lower is None
    assert [drive.torque_limit for drive in arm.drives] == [None, 25.0]


def test_shapes_weigh_where_nothing_is_stated_and_meshes_are_doubted(written):
    box, joint = '<geom type="box" size="0.1 0.2 0.3" mass="3"/>', '<joint name="j" axis="0 1 0"/>'
    arm = gd.load_arm(written(mjcf(f'<body name="arm">{joint}{box}</body>')))
    assert arm.mass.tolist() == [3.0]
    # m/3 (b^2 + c^2) of half lengths; a few roundings.
    np.testing.assert_allclose(arm.inertia_com[0].diagonal(), [0.13, 0.1, 0.05], rtol=1e-15)
    assert "primitive shapes" in arm.assumptions[0]
    mesh = '<geom type="mesh" mesh="shell"/>'
    with pytest.warns(GdAnalyzeWarning, match=r"line 4, .*body arm states no <inertial>"):
        gd.load_arm(written(mjcf(f'<body name="arm">{joint}{box}{mesh}</body>')))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gd.load_arm(written(mjcf(f'<body name="pedestal">{mesh}{two()}</body>')))  # the base does not move


def test_quaternions_of_six_digits_are_made_right(written):
    body = two('axis="0 0 1"').replace('quat="0.9 0.1 0.2 0.3"', 'quat="0.707107 0.707105 0 0"')
    arm = gd.load_arm(written(mjcf(body)))
    quarter = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    np.testing.assert_array_equal(arm.joints[1].placement.rotation, quarter)
    # Half the angle is atan(0.707105 / 0.707107).
    off = math.pi / 2 - 2 * math.atan2(0.707105, 0.707107)
    assert f"{off:.2g} rad (lower)" in arm.assumptions[0]


def test_springs_taken_weight_and_changed_masses_are_told(written):
    body = two('axis="1 0 0" stiffness="3"').replace('name="lower"', 'name="lower" gravcomp="1"')
    with pytest.warns(GdAnalyzeWarning) as caught:
        gd.load_arm(written(mjcf(body, '<compiler angle="radian" settotalmass="3"/>')))
    texts = " ".join(str(warning.message) for warning in caught)
    assert len(caught) == 3
    assert all(word in texts for word in ("line 6, ", "(gravcomp)", "spring (stiffness)", "settotalmass"))


LOOP = '<equality><connect body1="upper" body2="finger" anchor="0 0 0"/></equality>'
FINGER = f'<body name="finger">{INERTIAL}<joint name="pinch" axis="0 0 1"/></body>'
MIMIC = '<equality><joint joint1="pinch" joint2="elbow" polycoef="0.1 2 0 0 0"/></equality>'


@pytest.mark.parametrize(
    ("text", "line", "fact"),
    [
        (mjcf(two(), '<include file="a.xml"/>'), 2, "mj_saveLastXML"),
        (mjcf('<body><frame pos="0 0 0"/></body>'), 4, "<frame>"),
        ("<mujoco><option/></mujoco>", 1, "no bodies"),
        (mjcf(two("", FINGER), after=LOOP), 9, "--lock elbow=0 --lock pinch=0 holds them"),
        (mjcf(two("", FINGER), after=MIMIC), 7, "pinch mimics joint elbow"),
        (mjcf(f"<body name='trunk'><freejoint/>{INERTIAL}</body>"), 4, "--base trunk fixes"),
        (mjcf(f"<body name='b'><joint name='hip' type='ball'/>{INERTIAL}</body>"), 4, "hip is spherical"),
        (mjcf(two().replace('mass="2"', 'mass="-2"')), 4, "mass of <inertial>"),
        (mjcf(two().replace('quat="0.9 0.1 0.2 0.3"', 'quat="0 0 0 0"')), 6, "quat of lower is 0"),
        (mjcf(two("axis='0 0 0'")), 7, "elbow has no axis"),
        (mjcf(two() + two()), 7, "'base'"),
        (mjcf(two(), '<default><joint ref="1"/></default>'), 2, "reference value"),
    ],
)
def test_refused(written, capfd, text, line, fact):
    with pytest.raises(ArmError) as caught:
        gd.load_arm(written(text))
    assert fact in str(caught.value)
    assert f"robot.xml, line {line}, " in caught.value.details["where"]
    assert capfd.readouterr() == ("", "")


BESIDE = f'<body name="beside">{INERTIAL}<joint name="lever" axis="0 1 0"/></body>'


@pytest.mark.parametrize("bound", ['joint1="lever" joint2="elbow"', 'joint1="elbow" joint2="lever"'])
def test_an_equality_binds_both_joints_whichever_follows(written, bound):
    path = written(mjcf(two() + BESIDE, after=f"<equality><joint {bound}/></equality>"))
    with pytest.raises(ArmError, match="lever mimics joint elbow, which moves, and loads it with 2 kg"):
        gd.load_arm(path, tip="lower")
    assert gd.load_arm(path, tip="lower", lock=["lever=0"]).n_joints == (2 if '1="l' in bound else 1)
    assert gd.load_arm(path, tip="upper").n_joints == 1


def test_a_model_in_memory(written):
    path = written(mjcf(two('axis="1 0 0"')))
    model = pin.buildModelFromMJCF(str(path))
    model.gravity.linear = np.array([0.0, 9.0, 0.0])
    names = [frame.name for frame in model.frames]
    arm = gd.load_arm(model)
    assert arm.gravity.tolist() == [0.0, 9.0, 0.0]
    assert (arm.joints[0].name, arm.links[0].name, arm.joints[0].lower) == ("shoulder", "upper", -1.0)
    assert_same_torque(path, arm, random_states(2, 20, 1), askew=1e-12)
    assert names == [frame.name for frame in model.frames]
    assert gd.load_arm(model, tip="upper").n_joints == 1
    with pytest.raises(ArmError, match="this is not an arm"):
        gd.load_arm(3)
