"""URDF and MJCF against MuJoCo's readers: Pinocchio, which reads here, is no independent check of that."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from xml.etree import ElementTree

import mujoco
import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.tables import decompose_states
from gd_analyze.types import States
from robot_files import joint, link, mjcf, two_bodies, two_joints

pytestmark = pytest.mark.filterwarnings("ignore::gd_analyze.errors.GdAnalyzeWarning")

FRAX = importlib.util.find_spec("frax")
# Right angles are made right, and MuJoCo keeps quaternions rounded: of numbers up to 10.
TOLERANCE = 1e-4
EXACT = 1e-12

REFERENCE = 'axis="1 0 1" range="-1 1.2" ref="0.5"'
TOOL = link("tool", 0.3, rpy="1 2 3"), joint("tool_joint", "lower", "tool", "fixed", rpy="0.3 0.2 0.1")
FILES = {
    "askew.urdf": two_joints(),
    "merged.urdf": two_joints(*TOOL),
    "prismatic.urdf": two_joints(link("tip", 0.4), joint("lift", "lower", "tip", "prismatic", axis="1 2 3")),
    "bodies.xml": mjcf(two_bodies('axis="1 0 0"')),
    "tilted.xml": mjcf(two_bodies().replace('pos="0 0 1"', 'pos="0 0 1" euler="1 2 3"')),
    "reference.xml": mjcf(two_bodies(REFERENCE)),
    "degrees.xml": mjcf(two_bodies('axis="0 1 0" range="-90 45" ref="30"'), ""),
    "slide.xml": mjcf(two_bodies('type="slide" axis="0 1 1"')),
    "full.xml": mjcf(two_bodies().replace('diaginertia="0.03 0.04 0.05"', 'fullinertia="3 4 5 .1 .2 .3"')
                     .replace('quat="1 0.2 0.3 0.1" mass', "mass")),
    "shapes.xml": mjcf('<body name="arm"><joint name="j" axis="0 1 0"/><geom type="box" size=".1 .2 .3" '
                       'mass="3" pos=".1 0 .2" euler=".1 .2 .3"/></body>'),
    "joints.xml": mjcf('<body name="w" pos=".1 .2 .3" euler=".1 .2 .3"><joint name="lift" type="slide"/>'
                       '<joint name="turn" axis="0 1 0"/><inertial pos="0.02 0.1 0.03" mass="2" '
                       'diaginertia="0.03 0.04 0.05"/></body>'),
}  # fmt: skip


def without_meshes(path: Path, folder: Path) -> Path:
    """The file without meshes, which MuJoCo would open, and without inertias of no mass, which it drops."""
    tree = ElementTree.parse(path)
    for element in tree.getroot().iter("link"):
        for part in list(element):
            mass = part.find("mass")
            if part.tag != "inertial" or (mass is not None and float(mass.attrib["value"]) == 0.0):
                element.remove(part)
    tree.write(folder / path.name)
    return folder / path.name


def assert_same_bodies(arm: gd.types.RobotArm, model: mujoco.MjModel, tolerance: float) -> None:
    """Masses, and in the base frame centres of mass and inertias, at three poses; the mass matrix, too."""
    rng, data = np.random.default_rng(0), mujoco.MjData(model)
    moving = [model.joint(each.name) for each in arm.joints]
    bodies = [int(each.bodyid[0]) for each in moving]
    # Of several joints of a body the last one moves it.
    last = [i for i, body in enumerate(bodies) if body not in bodies[i + 1 :]]
    bodies = [bodies[i] for i in last]
    np.testing.assert_allclose(arm.mass[last], model.body_mass[bodies], rtol=EXACT)
    for _ in range(3):
        q = rng.uniform(-1.0, 1.0, arm.n_joints)
        for each, value in zip(moving, q, strict=True):
            data.qpos[each.qposadr[0]] = value
        mujoco.mj_forward(model, data)
        kinematics = solve_kinematics(arm, q[:, None])
        turns = kinematics.link_rotations[last, ..., 0]
        ours = turns @ arm.inertia_com[last] @ turns.transpose(0, 2, 1)
        axes = data.ximat[bodies].reshape(-1, 3, 3)
        theirs = axes @ (model.body_inertia[bodies][:, :, None] * axes.transpose(0, 2, 1))
        centres = kinematics.com_positions[last, ..., 0]
        np.testing.assert_allclose(centres, data.xipos[bodies], atol=tolerance)
        np.testing.assert_allclose(ours, theirs, atol=tolerance)
        full = np.zeros((model.nv, model.nv))
        for column, unit in zip(full, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        at = [int(each.dofadr[0]) for each in moving]
        still = np.zeros((1, arm.n_joints))
        inertia = decompose_states(arm, States(q[None], still, still), drives=False)["inertia"][0].sum(axis=0)
        armature = np.diag([drive.inertia for drive in arm.drives] or still[0])
        np.testing.assert_allclose(inertia + armature, full[np.ix_(at, at)], atol=tolerance)


@pytest.mark.parametrize("name", FILES)
def test_files_of_every_kind(name, tmp_path):
    path = tmp_path / name
    path.write_text(FILES[name])
    assert_same_bodies(gd.load_arm(path), mujoco.MjModel.from_xml_path(str(path)), 1e-9)


@pytest.mark.parametrize("name", ["franka_panda/panda.urdf", "iiwa/iiwa14.urdf"])
def test_public_robots(name, tmp_path):
    if FRAX is None or FRAX.origin is None:
        pytest.skip("frax, which has the robots' files, is not installed")
    (robot_file,) = Path(FRAX.origin).parent.rglob(name)
    path = without_meshes(robot_file, tmp_path)
    assert_same_bodies(gd.load_arm(path), mujoco.MjModel.from_xml_path(str(path)), TOLERANCE)
