"""Arm files by placements: what they may say, and what is refused with its line."""

from __future__ import annotations

import numpy as np
import pytest
from arm_files import line_of

from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import ArmError
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.description import fingerprint

ARM = """\
format = "gd-analyze arm 1"
name = "askew"
convention = "placement"

[[joints]]
name = "shoulder"
xyz = [0.0, 0.0, 0.3]
rpy = [0.1, -0.2, 0.3]
axis = [0.6, 0.0, 0.8]
range_deg = [-90.0, inf]

[[joints]]
name = "lift"
kind = "prismatic"
xyz_mm = [400.0, 0.0, 0.0]
rotation = [
    [1.0, 0.0, 0.0],
    [0.0, 0.0, -1.0],
    [0.0, 1.0, 0.0],
]

[[links]]
mass = 3.0
com = [0.2, 0.0, 0.0]
inertia = { xx = 0.002, yy = 0.04, zz = 0.04 }

[[links]]
frame_xyz_mm = [350.0, 0.0, 0.0]
frame_rpy_deg = [0.0, 0.0, 180.0]
mass = 1.5
com = [0.15, 0.0, 0.0]
inertia = { xx = 0.001, yy = 0.015, zz = 0.015 }
"""


def test_a_frame_is_turned_as_in_urdf(file):
    """About x, then y, then z of the fixed frame: Pinocchio's own, to a few roundings of numbers up to 1."""
    import pinocchio as pin

    arm = read_arm(file(ARM))
    np.testing.assert_allclose(
        arm.joints[0].placement.rotation, pin.rpy.rpyToMatrix(0.1, -0.2, 0.3), atol=1e-15
    )
    assert arm.joints[1].placement.rotation.tolist() == [[1, 0, 0], [0, 0, -1], [0, 1, 0]]
    assert arm.links[1].frame.rotation.tolist() == [[-1, 0, 0], [0, -1, 0], [0, 0, 1]]
    assert (arm.joints[0].upper, arm.joints[1].kind) == (None, "prismatic")


def test_an_angle_of_ninety_degrees_is_as_exact_as_a_matrix(file):
    rows = ARM[ARM.index("rotation") : ARM.index("\n[[links]]")]
    turned = ARM.replace(rows, "rpy_deg = [90.0, 0.0, 0.0]\n")
    assert fingerprint(read_arm(file(turned))) == fingerprint(read_arm(file(ARM)))


def test_pinocchio_agrees(file):
    from gd_analyze.dynamics.decomposition import torque_of
    from strategies import random_states

    arm, states = read_arm(file(ARM)), random_states(2, 5, seed=3)
    theirs = pinocchio_dynamics(arm, *states.arrays)["torque"]
    bound = round_off_bounds(arm, *states.arrays)["torque"]
    assert np.abs(torque_of(arm, states) - theirs).max() <= bound


CASES = {
    "a rotation that is none": ("0.0, -1.0]", "0.0, -2.0]", "joints[2].rotation", "rotation =", "three rows"),
    "a mirror": ("0.0, -1.0]", "0.0, 1.0]", "joints[2].rotation", "rotation =", "right-handed"),
    "two rows": ("    [0.0, 1.0, 0.0],\n", "", "joints[2].rotation", "rotation =", "at least 3"),
    "said twice": (
        "rpy = [0.1",
        "rotation = [[1, 0, 0], [0, 1, 0], [0, 0, 1]]\nrpy = [0.1",
        "joints[1]",
        "[[joints]]",
        "either rpy or rotation",
    ),
    "an axis too long": ("[0.6, 0.0, 0.8]", "[1, 0, 1]", "joints[1].axis", "axis =", "instead of 1.41421"),
    "no axis": ("[0.6, 0.0, 0.8]", "[0, 0, 0]", "joints[1].axis", "axis =", "instead of 0"),
    "two coordinates": ("[0.0, 0.0, 0.3]", "[0.0, 0.3]", "joints[1].xyz", "xyz =", "at least 3"),
    "words": ("[0.0, 0.0, 0.3]", '"up"', "joints[1].xyz", "xyz =", "a valid list"),
    "a table's key": (
        "xyz = [0.0",
        "alpha = 0.1\nxyz = [0.0",
        "joints[1].alpha",
        "alpha",
        "xyz, rpy, rotation",
    ),
    "a misspelt key": ("frame_xyz_mm", "fram_xyz_mm", "links[2].fram_xyz_mm", "fram_xyz", "frame_xyz"),
    "an unknown lower end above": ("-90.0, inf", "inf, 90.0", "joints[1].range", "range_deg", "inf where"),
    "nan for an end": ("-90.0, inf", "-90.0, nan", "joints[1].range", "range_deg", "inf where unknown"),
    "a huge end": ("-90.0, inf", "-90.0, 1e300", "joints[1].range", "range_deg", "inf where unknown"),
}


@pytest.mark.parametrize(("old", "new", "says", "line", "expected"), CASES.values(), ids=CASES.keys())
def test_refused(file, old, new, says, line, expected):
    assert old in ARM
    text = ARM.replace(old, new, 1)
    path = file(text)
    with pytest.raises(ArmError) as caught:
        read_arm(path)
    assert says in caught.value.what
    assert caught.value.details["where"] == f"{path}, line {line_of(text, line)}"
    assert expected in caught.value.details["expected"]


def test_a_table_of_one_convention_has_no_keys_of_another(file):
    text = ARM.replace('convention = "placement"', 'convention = "standard"')
    with pytest.raises(ArmError, match=r"joints\[1\].xyz") as caught:
        read_arm(file(text))
    assert "theta, d, a, alpha" in caught.value.details["expected"]
    with pytest.raises(ArmError, match="convention") as caught:
        read_arm(file(ARM.replace('"placement"', '"urdf"')))
    assert "'placement'" in caught.value.details["expected"]
