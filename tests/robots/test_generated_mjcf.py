"""Random MJCF against MuJoCo itself: masses, torque of gravity and of motion, mass matrix."""

from __future__ import annotations

import re

import mujoco
import numpy as np
import pytest
from hypothesis import given

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.tables import decompose_states
from gd_analyze.types import RobotArm, States
from generated_mjcf import FEATURES, mjcf_arm, mjcf_arms
from strategies import examples, random_states

pytestmark = pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")


@pytest.fixture(autouse=True, scope="module")
def quiet_mujoco():
    """Without its warnings, which it also writes into a file: of obsolete settings, and of a singular D."""
    mujoco.set_mju_user_warning(lambda text: None)
    yield
    mujoco.set_mju_user_warning(None)


def loaded(text: str, folder) -> tuple[RobotArm, mujoco.MjModel]:
    path = folder / "arm.xml"
    path.write_text(text)
    return gd.load_arm(path), mujoco.MjModel.from_xml_path(str(path))


def torques_of_mujoco(model: mujoco.MjModel, names: list[str], states: States) -> FloatArray:
    """D qdd + h + c of MuJoCo, the joints in the given order; rotors of actuators are in its D."""
    data, at = mujoco.MjData(model), [int(model.joint(name).dofadr[0]) for name in names]
    torques = []
    for q, qd, qdd in zip(*states.arrays, strict=True):
        acceleration, inertial = np.zeros(model.nv), np.zeros(model.nv)
        for k, name in enumerate(names):
            data.qpos[model.joint(name).qposadr[0]] = q[k]
        data.qvel[at], acceleration[at] = qd, qdd
        mujoco.mj_forward(model, data)
        mujoco.mj_mulM(model, data, inertial, acceleration)
        torques.append((inertial + data.qfrc_bias)[at])
    return np.array(torques)


def assert_torques_of_mujoco(arm: RobotArm, model: mujoco.MjModel) -> None:
    """Masses, and torques at rest and in motion; MuJoCo's own arithmetic has some 1e-13 of the largest."""
    moved = [float(model.body_subtreemass[model.joint(joint.name).bodyid[0]]) for joint in arm.joints]
    np.testing.assert_allclose(arm.mass[::-1].cumsum()[::-1], moved, rtol=1e-12)
    rng, n = np.random.default_rng(0), arm.n_joints
    still = np.zeros((4, n))
    q = rng.uniform(-2, 2, (4, n))
    for states in (
        States(q, still, still),
        States(q, rng.uniform(-2, 2, (4, n)), rng.uniform(-5, 5, (4, n))),
    ):
        theirs = torques_of_mujoco(model, [joint.name for joint in arm.joints], states)
        ours = decompose_states(arm, states)["torque"]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11 * max(1.0, float(np.abs(theirs).max())))


@examples(200)
@given(text=mjcf_arms())
def test_any_features(tmp_path_factory, text):
    arm, model = loaded(text, tmp_path_factory.mktemp("mjcf"))
    assert_torques_of_mujoco(arm, model)


@pytest.mark.parametrize("feature", FEATURES)
def test_all_features_but_one(tmp_path, feature):
    for seed in range(3):
        text = mjcf_arm({*FEATURES} - {feature}, np.random.default_rng(seed))
        assert_torques_of_mujoco(*loaded(text, tmp_path))


# Attributes that move no torque, as MuJoCo is asked here; those of elements that draw or touch are left out.
IDLE = {
    "compiler": """alignfree='true' assetdir='a' conflict='warning' discardvisual='false' fitaabb='true'
        fusestatic='true' meshdir='b' savecanonical='true' savecompiled='true' saveinertial='true'
        strippath='true' texturedir='c' usethread='false'""",
    "option": """actuatorgroupdisable='3' ccd_iterations='9' ccd_tolerance='1e-3' cone='elliptic' impratio='2'
        integrator='implicit' iterations='9' jacobian='dense' ls_iterations='9' ls_tolerance='1e-3'
        magnetic='0 0 1' noslip_iterations='2' noslip_tolerance='1e-3' o_friction='1 1 1 1 1' o_margin='0.1'
        o_solimp='0.9 0.95 0.001 0.5 2' o_solref='0.02 1' sdf_initpoints='9' sdf_iterations='9'
        sleep_tolerance='1e-3' solver='CG' timestep='0.001' tolerance='1e-3' wind='1 2 3'""",
    "flag": re.sub(
        r"(\w+)",
        r"\1='enable'",
        """autoreset clampctrl contact damper energy eulerdamp filterparent frictionloss fwdinv invdiscrete
        island limit midphase multiccd nativeccd override refsafe sensor spring warmstart actuation constraint
        equality gravity""",
    ),
    "body": "fuse='false' simple='false' sleep='auto' user='1 2'",
    "joint": """actuatorgravcomp='true' group='3' margin='0.1' solimpfriction='0.9 0.95 0.001 0.5 2'
        solimplimit='0.9 0.95 0.001 0.5 2' solreffriction='0.02 1' solreflimit='0.02 1' springref='1'
        springyield='1' user='1' frictionloss='1' damping='1' limited='true' range='-1 1'
        actuatorfrclimited='true' actuatorfrcrange='-9 9'""",
    "geom": """adhesion='1' castshadow='false' conaffinity='0' condim='1' contype='0'
        fluidcoef='0.5 0.2 1 1 1' fluidshape='ellipsoid' friction='1 1 1' gap='1' margin='1'
        priority='1' rgba='1 0 0 1' solimp='0.9 0.95 0.001 0.5 2' solmix='2' solref='0.02 1'
        surfacevel='1 2 3 4 5 6' user='1'""",
    "fixed": """actuatorfrclimited='true' actuatorfrcrange='-1 1' group='2' limited='true' margin='0.1'
        range='-1 1' solimpfriction='0.9 0.95 0.001 0.5 2' solimplimit='0.9 0.95 0.001 0.5 2'
        solreffriction='0.02 1' solreflimit='0.02 1' springlength='1' user='1'""",
    "motor": "ctrlrange='-1 1' forcerange='-1 1' group='1' lengthrange='0 1' user='1'",
}


def with_idle(element: str) -> str:
    """A file of two joints with all the idle attributes of an element."""
    of = {name: IDLE[name] if name == element else "" for name in IDLE}
    return f"""<mujoco><compiler {of["compiler"]}/>
        <size nuser_body='2' nuser_jnt='1' nuser_geom='1' nuser_tendon='1' nuser_actuator='1'/>
        <option {of["option"]}><flag {of["flag"]}/></option>
        <worldbody><body name='a' {of["body"]}><joint name='j' axis='0 1 1' {of["joint"]}/>
        <geom type='box' size='0.1 0.2 0.3' pos='0.2 0.1 0.3' {of["geom"]}/>
        <body name='b' pos='0.3 0 0'><joint name='k' axis='1 0 0'/><geom size='0.1' pos='0 0.2 0.1'/></body>
        </body></worldbody>
        <tendon><fixed name='t' {of["fixed"]}><joint joint='j' coef='1'/></fixed></tendon>
        <actuator><motor joint='j' {of["motor"]}/></actuator><sensor><jointpos joint='j'/></sensor>
        <keyframe><key qpos='1 1'/></keyframe></mujoco>"""


@pytest.mark.parametrize("element", IDLE)
def test_attributes_that_move_no_torque(tmp_path, element):
    arm, model = loaded(with_idle(element), tmp_path)
    assert_torques_of_mujoco(arm, model)
    same, _ = loaded(with_idle(""), tmp_path)
    states = random_states(2, 5, 0)
    np.testing.assert_array_equal(
        *(decompose_states(each, states, drives=False)["torque"] for each in (arm, same))
    )


READ = {
    "compiler": """angle autolimits balanceinertia boundinertia boundmass coordinate eulerseq inertiafromgeom
        inertiagrouprange settotalmass passthrough""",
    "option": "gravity density viscosity",
    "flag": "diagexact ipc sleep speculative",  # not in every build
    "body": "name childclass pos axisangle euler quat xyaxes zaxis gravcomp mocap",
    "joint": "name class type pos axis ref armature stiffness springdamper",
    "geom": """name class type pos axisangle euler quat xyaxes zaxis size mass density fromto shellinertia
        group mesh hfield fitscale material""",
    "fixed": "name class springyield stiffness damping frictionloss armature",
}


def test_every_attribute_of_mujoco_is_read_told_or_tried_here():
    """A new version of MuJoCo may have attributes of which nobody has asked what they do."""
    schema = mujoco.mj_printSchema(False, False)
    for element, read in READ.items():
        # Elements of the same tag stand in defaults and equalities, with fewer attributes.
        listed = re.findall(rf"^ *(?:\(world\))?{element} \([*!?R]\) +(.*\n(?: {{20,}}.*\n)*)", schema, re.M)
        tried = set(re.findall(r"(\w+)=", IDLE[element])) | set(read.split())
        assert set(max(listed, key=len).split()) - tried == set()
