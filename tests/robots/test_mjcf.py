"""MJCF: what Pinocchio's reader knows, what it passes over, and what only MuJoCo can expand."""

from __future__ import annotations

import math
import re
import warnings

import mujoco
import numpy as np
import pinocchio as pin
import pytest

import gd_analyze as gd
from gd_analyze.errors import ArmError, GdAnalyzeWarning, in_options
from gd_analyze.tables import decompose_states
from gd_analyze.types import States
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
    assert (arm.name, arm.convention) == ("bench", "placement")
    assert [(joint.name, joint.source.line) for joint in arm.joints] == [("shoulder", 5), ("elbow", 7)]
    drive = arm.drives[0]
    assert (drive.inertia, drive.viscous, drive.coulomb, drive.gear_ratio) == (0.1, 0.5, (0.2, -0.2), 1.0)
    assert (arm.joints[0].lower, arm.joints[0].upper, arm.joints[1].lower) == (-1.0, 2.0, None)
    assert arm.gravity_vector.tolist() == [0.0, 0.0, -9.81]
    # Pinocchio itself reads the file to some 1e-12: it stores quaternions of frames rounded.
    assert_same_torque(path, arm, random_states(2, 20, 0), askew=1e-12)


def test_what_pinocchio_passes_over(written):
    """Gravity, a range that does not hold, actuators that limit efforts."""
    before = '<option gravity="0 -9.7 0.5"/><compiler angle="radian"/>'
    after = '<actuator><motor joint="elbow" gear="50" ctrlrange="-0.5 0.4"/></actuator>'
    arm = gd.load_arm(written(mjcf(two('axis="1 0 0" range="-1 1" limited="false"'), before, after)))
    assert arm.gravity_vector.tolist() == [0.0, -9.7, 0.5]
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
    with pytest.warns(GdAnalyzeWarning, match=r"no <inertial>, and meshes .* in body arm \(line 4\)"):
        gd.load_arm(written(mjcf(f'<body name="arm">{joint}{box}{mesh}</body>')))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        gd.load_arm(written(mjcf(f'<body name="pedestal">{mesh}{two()}</body>')))  # the base does not move


def test_joints_of_one_body_have_links_of_nothing_between_them_which_nobody_misses(written):
    body = "<body name='{}' pos='0.3 0 0'>{}{}</body>"
    inertial = '<inertial pos="0.1 0 0" mass="2" diaginertia=".005 .006 .007"/>'
    joints = "<joint axis='0 0 1'/>", "<joint axis='0 1 0'/><joint axis='1 0 0'/>", "<joint axis='0 1 0'/>"
    inner = ""
    for name, joint in zip("cba", reversed(joints), strict=True):
        inner = body.format(name, joint + inertial, inner)
    arm = gd.load_arm(written(mjcf(inner)))
    assert arm.mass.tolist() == [2.0, 0.0, 2.0, 2.0]


DEFAULT = "<default><joint range='-1 2'/><general forcerange='-7 5' gear='3'/></default>"
SERVO = '<actuator><position joint="elbow" {}/></actuator>'


@pytest.mark.parametrize(
    ("elbow", "before", "actuator", "limits"),
    [
        ("", DEFAULT, "", (-1.0, 2.0, None)),
        ('limited="false"', DEFAULT, "", (None, None, None)),
        ("", f"<compiler autolimits='false'/>{DEFAULT}", "", (None, None, None)),
        ('limited="true"', f"<compiler autolimits='false'/>{DEFAULT}", "", (-1.0, 2.0, None)),
        ('actuatorfrcrange="-4 3"', "", "", (None, None, 4.0)),
        ('actuatorfrcrange="-4 3" actuatorfrclimited="false"', "", "", (None, None, None)),
        # One default is that of all kinds of actuators.
        ("", DEFAULT, SERVO.format(""), (-1.0, 2.0, 21.0)),
        ("", DEFAULT, SERVO.format('forcelimited="false"'), (-1.0, 2.0, None)),
        ('actuatorfrcrange="-4 3"', DEFAULT, SERVO.format('gear="-2"'), (-1.0, 2.0, 4.0)),
        ("", "", SERVO.format('ctrlrange="-4 3"'), (None, None, None)),
    ],
)
def test_limits_hold_where_the_file_switches_them_on(written, elbow, before, actuator, limits):
    before = '<compiler angle="radian"/>' + before
    arm = gd.load_arm(written(mjcf(two(elbow), before, actuator)))
    joint, drive = arm.joints[1], arm.drives[1]
    assert (joint.lower, joint.upper, drive.torque_limit) == limits


def test_shapes_of_a_class_weigh_what_its_default_states(written):
    """0 kg in class c, 3 kg in a class within it, and 1 kg at the shape itself."""
    defaults = '<default class="c"><geom mass="0"/><default class="d"><geom mass="3"/></default></default>'
    body = '<inertial pos="0.1 0 0" mass="1" diaginertia=".01 .01 .01"/><body pos="0.2 0 0" {}>{}</body>'
    shape, states = '<geom type="box" size=".05 .05 .05" {}/>', States(*np.array([[[0.3]], [[0]], [[0]]]))
    for of_body, of_shape, mass in (
        ("", 'class="c"', 0.0),
        ('childclass="c"', "", 0.0),
        ('childclass="c"', 'class="d"', 3.0),
        ('childclass="d"', 'mass="1"', 1.0),
    ):
        arm = gd.load_arm(
            written(
                mjcf(
                    f'<body><joint axis="0 1 0"/>{body.format(of_body, shape.format(of_shape))}</body>',
                    f"<default>{defaults}</default>",
                )
            )
        )
        torque = decompose_states(arm, states)["torque"].item()
        # Weights at 0.1 m and 0.2 m; a few roundings.
        assert torque == pytest.approx(-9.81 * (0.1 + 0.2 * mass) * math.cos(0.3), rel=1e-14)


def test_quaternions_of_six_digits_are_made_right(written):
    body = two('axis="0 0 1"').replace('quat="0.9 0.1 0.2 0.3"', 'quat="0.707107 0.707105 0 0"')
    arm = gd.load_arm(written(mjcf(body)))
    quarter = [[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]]
    np.testing.assert_array_equal(arm.joints[1].placement.rotation, quarter)
    # Half the angle is atan(0.707105 / 0.707107).
    off = math.pi / 2 - 2 * math.atan2(0.707105, 0.707107)
    assert f"{off:.2g} rad (lower)" in arm.assumptions[0]


TENDON = '<tendon><fixed name="t" {}><joint joint="elbow" coef="1"/></fixed></tendon>'


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        (mjcf(two('stiffness="3"')), 7, ("elbow", "a spring (stiffness)")),
        (mjcf(two(), '<default><joint springdamper="1 1"/></default>'), 7, ("elbow", "(springdamper)")),
        (mjcf(two().replace('name="lower"', 'name="lower" gravcomp="1"')), 6, ("lower", "(gravcomp)")),
        (mjcf(two(), '<option density="1000"/>'), 2, ("drag", "(density)")),
        (mjcf(two(), '<option viscosity="0.1"/>'), 2, ("drag", "(viscosity)")),
        (mjcf(two(), after=TENDON.format('armature="0.1"')), 9, ("tendon t (", "inertia (armature)")),
        (mjcf(two(), after=TENDON.format('stiffness="7"')), 9, ("tendon t", "spring")),
        (mjcf(two(), after=TENDON.format('frictionloss="7"')), 9, ("tendon t", "friction")),
        (mjcf(two(), after=TENDON.format("") + '<actuator><motor tendon="t" armature=".1"/></actuator>'), 9,
         ("actuator", "inertia (armature)")),
        (mjcf(two(after='<plugin plugin="mujoco.elasticity.cable"/>')), 7, ("lower", "plugin")),
        (mjcf(two(), after='<deformable><flex body="lower"/></deformable>'), 9, ("lower", "flex")),
    ],
)  # fmt: skip
def test_forces_and_inertias_that_are_not_read_are_told_where_they_act_on_the_arm(written, text, line, words):
    with pytest.warns(GdAnalyzeWarning) as caught:
        gd.load_arm(written(text))
    of_file = [str(warning.message) for warning in caught if f"(line {line})" in str(warning.message)]
    assert len([text for text in of_file if all(word in text for word in words)]) == 1
    zero = re.sub(
        r'(stiffness|springdamper|gravcomp|density|viscosity|armature|frictionloss)="[^"]*"', "", text
    )
    if not {"plugin", "flex"} & {*words}:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            gd.load_arm(written(zero))


LOOP = '<equality><connect body1="upper" body2="finger" anchor="0 0 0"/></equality>'
FINGER = f'<body name="finger">{INERTIAL}<joint name="pinch" axis="0 0 1"/></body>'
MIMIC = '<equality><joint joint1="pinch" joint2="elbow" polycoef="0.1 2 0 0 0"/></equality>'


@pytest.mark.parametrize(
    ("text", "line", "fact"),
    [
        (mjcf(two(), '<include file="a.xml"/>'), 2, "mj_saveLastXML"),
        (mjcf('<body><frame pos="0 0 0"/></body>'), 4, "<frame>"),
        ("<mujoco><option/></mujoco>", 1, "no bodies"),
        (mjcf(two("", FINGER), after=LOOP), 9, "`lock=['elbow=0', 'pinch=0']` holds them"),
        (mjcf(two("", FINGER), after=MIMIC), 7, "pinch mimics joint elbow"),
        (mjcf(f"<body name='trunk'><freejoint/>{INERTIAL}</body>"), 4, "`base='trunk'` fixes"),
        (mjcf(f"<body name='b'><joint name='hip' type='ball'/>{INERTIAL}</body>"), 4, "hip is spherical"),
        (mjcf(two().replace('mass="2"', 'mass="-2"')), 4, "mass of <inertial>"),
        (mjcf(two().replace('quat="0.9 0.1 0.2 0.3"', 'quat="0 0 0 0"')), 6, "quat of lower is 0"),
        (mjcf(two("axis='0 0 0'")), 7, "elbow has no axis"),
        (mjcf(two() + two()), 7, "'base'"),
        (mjcf(two().replace('"upper"', '"world"')), 4, "'world'"),
        (mjcf(two(), '<default class="arm"/>'), 2, "class main"),
        (mjcf(two('class="x"')), 7, "class 'x'"),
        (mjcf(two(), '<default><geom size="0.1 wide"/></default>')
         .replace("</body>", "<geom mass='1'/></body>", 1).replace(INERTIAL, ""), 2, "size of <geom>"),
        (mjcf(two(), '<compiler wind="1"/>'), 2, "wind of <compiler>"),
        (mjcf(two('inertia="1"')), 7, "inertia of <joint>"),
        (mjcf(two(after="<thruster/>")), 7, "<thruster> within <body>"),
        (mjcf(two(), after="<equality><distance/></equality>"), 9, "<distance>"),
        (mjcf(two(), after='<equality><joint joint1="elbou"/></equality>'), 9, "did you mean elbow"),
        (mjcf(two().replace("euler=", 'quat="1 0 0 0" euler=')), 4, "quat and euler"),
        (mjcf(two().replace("diaginertia=", 'fullinertia="1 1 1 0 0 0" diaginertia=')), 4, "twice"),
        (mjcf(two('type="knee"')), 7, "'knee'"),
        (mjcf('<body><joint/><geom type="cone" size="1"/></body>'), 4, "'cone'"),
        (mjcf('<body><joint/><geom size="-1"/></body>'), 4, "not above 0"),
        (mjcf('<body><joint/><geom type="ellipsoid" size="1 1 2" shellinertia="true"/></body>'), 4, "shell"),
        (mjcf('<body><joint/><geom type="box" size="1" fromto="0 0 0 0 0 1" pos="1 0 0"/></body>'), 4, "pos"),
    ],
)  # fmt: skip
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


def test_an_equality_is_of_deviations_from_the_reference_and_the_follower_of_a_locked_joint_is_held(written):
    """Held at its polynomial of the leader's value; MuJoCo's residual is 0 there."""
    equality = '<equality><joint joint1="pinch" joint2="elbow" polycoef="0.1 2 0.5"/></equality>'
    finger = FINGER.replace("axis", 'ref="0.4" axis')
    path = written(mjcf(two('ref="0.3"', finger), after=equality))
    arm = gd.load_arm(path, lock=["elbow=0.8"])
    value = 0.4 + 0.1 + 2 * 0.5 + 0.5 * 0.5**2
    assert f"pinch at {value:g} rad" in " ".join(arm.assumptions)
    model = mujoco.MjModel.from_xml_path(str(path))
    data = mujoco.MjData(model)
    data.qpos[:] = 0.0, 0.8, value
    mujoco.mj_forward(model, data)
    np.testing.assert_allclose(
        data.efc_pos[data.efc_type == mujoco.mjtConstraint.mjCNSTR_EQUALITY], 0, atol=1e-15
    )


TIES = (
    "<tendon><fixed name='t'><joint joint='elbow' coef='1'/><joint joint='pinch' coef='-1'/></fixed></tendon>"
)
SITES = "<tendon><spatial name='t'><site site='far'/><site site='near'/></spatial></tendon>"


@pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")
@pytest.mark.parametrize(
    ("tendons", "equality", "held"),
    [
        (TIES, "<tendon tendon1='t'/>", {"elbow", "pinch"}),
        (SITES, "<tendon tendon1='t'/>", {"elbow"}),
        ("", "<weld body1='finger'/>", {"shoulder", "elbow", "pinch"}),
        ("", "<connect site1='far' site2='near'/>", {"elbow"}),
        ("", "<joint joint1='pinch'/><joint joint1='pinch' joint2='shoulder'/>", {"shoulder"}),
    ],
)
def test_whatever_ties_joints_beside_the_tree_is_refused_unless_they_are_held(
    written, tendons, equality, held
):
    after = f"{tendons}<equality>{equality}</equality>"
    body = two("", f"<site name='far'/>{FINGER}").replace(
        '<joint name="shoulder"', '<site name="near"/><joint name="shoulder"'
    )
    path = written(mjcf(body, after=after))
    with pytest.raises(ArmError) as caught:
        gd.load_arm(path)
    assert "line 9, " in caught.value.details["where"]
    assert set(re.findall(r"--lock (\w+)=0", in_options(caught.value.details["next"]))) == held
    free = {"shoulder", "elbow", "pinch"} - held
    if free:
        gd.load_arm(path, lock=[f"{name}=0" for name in held])
    for off in (
        '<option><flag equality="disable"/></option>',
        '<option><flag constraint="disable"/></option>',
        '<default><equality active="false"/></default>',
    ):
        assert gd.load_arm(written(mjcf(body, off, after))).n_joints == 3


def test_a_model_in_memory(written):
    path = written(mjcf(two('axis="1 0 0"')))
    model = pin.buildModelFromMJCF(str(path))
    model.gravity.linear = np.array([0.0, 9.0, 0.0])
    names = [frame.name for frame in model.frames]
    arm = gd.load_arm(model)
    assert arm.gravity_vector.tolist() == [0.0, 9.0, 0.0]
    assert (arm.joints[0].name, arm.links[0].name, arm.joints[0].lower) == ("shoulder", "upper", -1.0)
    assert_same_torque(path, arm, random_states(2, 20, 1), askew=1e-12)
    assert names == [frame.name for frame in model.frames]
    assert gd.load_arm(model, tip="upper").n_joints == 1
    with pytest.raises(ArmError, match="this is not an arm"):
        gd.load_arm(3)
