"""Arms from URDF have the torques of Pinocchio on the file as it is: every kind of joint, nothing lost."""

from __future__ import annotations

import importlib.util
import warnings
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from robot_files import assert_same_torque, fingers, joint, link, two_joints, urdf
from strategies import examples, random_inertia, random_states


@pytest.fixture
def arm_of(tmp_path):
    def read(text: str, **picked: object) -> tuple[RobotArm, Path]:
        path = tmp_path / "robot.urdf"
        path.write_text(text)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GdAnalyzeWarning)
            return load_arm(path, **picked), path

    return read


def test_fixed_links_are_merged_and_no_mass_is_lost(arm_of):
    text = two_joints(
        link("flange", 0.5),
        link("tool", 0.3, rpy="1 2 3"),
        link("camera", 0.2),
        joint("flange_joint", "lower", "flange", "fixed"),
        joint("tool_joint", "flange", "tool", "fixed"),
        joint("camera_joint", "upper", "camera", "fixed"),
    )
    arm, path = arm_of(text)
    assert [link.name for link in arm.links] == ["upper", "lower"]
    # Sums of three numbers of one sign: two roundings.
    np.testing.assert_allclose(arm.mass, [2.2, 1.8], rtol=4e-16)
    assert_same_torque(path, arm, random_states(2, 20, 0))


def test_what_is_held_carries_its_mass_at_the_value(arm_of):
    arm, path = arm_of(two_joints(*fingers()), lock=["left_finger=20mm", "right_finger=-0.01"])
    assert arm.n_joints == 2
    np.testing.assert_allclose(arm.mass, [2.0, 1.2], rtol=4e-16)
    held = {"left_finger": 0.02, "right_finger": -0.01}
    assert_same_torque(path, arm, random_states(2, 20, 1), held)
    assert arm.assumptions[-1] == (
        "Held, with what they carry: left_finger at 0.02 m, right_finger at -0.01 m."
    )
    other, _ = arm_of(two_joints(*fingers()), tip="lower")
    np.testing.assert_allclose(other.mass, arm.mass, rtol=4e-16)
    assert "left_finger at 0 m" in other.assumptions[-1]


def test_a_base_further_out_keeps_its_place_in_the_world(arm_of):
    text = two_joints(link("hand"), joint("wrist", "lower", "hand", "continuous"))
    arm, path = arm_of(text, base="upper", lock={"shoulder": 0.7})
    assert [joint.name for joint in arm.joints] == ["elbow", "wrist"]
    assert_same_torque(path, arm, random_states(2, 20, 2), {"shoulder": 0.7})


def test_a_joint_without_ends_is_held_at_an_angle(arm_of):
    text = urdf(
        link("base"),
        link("upper"),
        link("lower"),
        joint("endless", "base", "upper", "continuous"),
        joint("elbow", "upper", "lower"),
    )
    arm, path = arm_of(text, lock=["endless=90deg"])
    assert_same_torque(path, arm, random_states(1, 10, 3), {"endless": np.pi / 2})


@examples(60)
@given(st.data())
def test_any_chain_of_any_joints(tmp_path_factory, data):
    """Joints of all kinds, askew axes, turned inertial frames, fixed links between, beside and at the end."""
    kinds = data.draw(
        st.lists(st.sampled_from(["revolute", "continuous", "prismatic", "fixed"]), min_size=1, max_size=7)
    )
    seed = data.draw(st.integers(0, 2**32 - 1))
    beside = data.draw(st.booleans())
    if set(kinds) == {"fixed"}:
        kinds.append("revolute")
    rng = np.random.default_rng(seed)

    def three() -> str:
        return " ".join(repr(float(x)) for x in rng.normal(size=3))

    elements, before = [link("link0")], "link0"
    for i, kind in enumerate(kinds, start=1):
        tensor = random_inertia(rng)
        moments = dict(
            zip(("ixx", "ixy", "ixz", "iyy", "iyz", "izz"), tensor[np.triu_indices(3)].tolist(), strict=True)
        )
        mass = None if data.draw(st.integers(0, 4)) == 0 else float(rng.uniform(0.1, 9))
        elements.append(link(f"link{i}", mass, three(), three(), **moments))
        elements.append(joint(f"joint{i}", before, f"link{i}", kind, xyz=three(), rpy=three(), axis=three()))
        if beside:
            elements += [link(f"side{i}"), joint(f"aside{i}", f"link{i}", f"side{i}", "fixed", rpy=three())]
        before = f"link{i}"
    path = tmp_path_factory.mktemp("chain") / "robot.urdf"
    path.write_text(urdf(*elements))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)  # of numbers no arm has
        arm = load_arm(path)
    moving = [kind for kind in kinds if kind != "fixed"]
    assert [joint.kind for joint in arm.joints] == [k.replace("continuous", "revolute") for k in moving]
    assert_same_torque(path, arm, random_states(len(moving), 4, seed), merged=2 * len(kinds) + 1)


FRAX = importlib.util.find_spec("frax")


@pytest.mark.parametrize("name", ["franka_panda/panda.urdf", "iiwa/iiwa14.urdf"])
def test_public_robots(name):
    if FRAX is None or FRAX.origin is None:
        pytest.skip("frax, which has the robots' files, is not installed")
    found = sorted(Path(FRAX.origin).parent.rglob(name))
    if not found:
        pytest.skip(f"frax holds no {name}")
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        arm = load_arm(found[0])
    assert arm.n_joints == 7
    # Their angles are right to 12 digits at least.
    assert_same_torque(found[0], arm, random_states(7, 50, 0), askew=1e-11)
