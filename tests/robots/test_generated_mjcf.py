"""Random MJCF against MuJoCo itself: masses, torque of gravity and of motion, mass matrix."""

from __future__ import annotations

import mujoco
import numpy as np
import pytest
from hypothesis import given

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.tables import decompose_states
from gd_analyze.types import RobotArm, States
from generated_mjcf import FEATURES, mjcf_arm, mjcf_arms
from strategies import examples

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
    """Same whole mass of what moves, and same torques; MuJoCo's own arithmetic has some 1e-13 of the largest."""
    rng, n = np.random.default_rng(0), arm.n_joints
    still = np.zeros((4, n))
    q = rng.uniform(-2, 2, (4, n))
    for states in (States(q, still, still), States(q, rng.uniform(-2, 2, (4, n)), rng.uniform(-5, 5, (4, n)))):
        theirs = torques_of_mujoco(model, [joint.name for joint in arm.joints], states)
        ours = decompose_states(arm, states)["torque"]
        np.testing.assert_allclose(ours, theirs, rtol=0, atol=1e-11 * max(1.0, float(np.abs(theirs).max())))


@examples(200)
@given(text=mjcf_arms())
def test_any_features(tmp_path_factory, text):
    arm, model = loaded(text, tmp_path_factory.mktemp("mjcf"))
    assert_torques_of_mujoco(arm, model)


@pytest.mark.parametrize("feature", FEATURES)
def test_each_feature_with_all_others_of_it(tmp_path, feature):
    """Hypothesis may draw few features together; here each one is left out of all."""
    for seed in range(3):
        text = mjcf_arm({*FEATURES} - {feature}, np.random.default_rng(seed))
        assert_torques_of_mujoco(*loaded(text, tmp_path))
