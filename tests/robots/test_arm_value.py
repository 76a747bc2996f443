"""The arm as a value: valid once it exists, immutable, placed by its table, and identified by its numbers."""

from __future__ import annotations

import dataclasses
import json
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from arm_files import link
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import ArmError
from gd_analyze.robots.arm_file import arm_in
from gd_analyze.robots.description import describe, fingerprint
from gd_analyze.robots.frames import exact_cos_sin, modified_placements, standard_placements
from gd_analyze.robots.parts import LinkUncertainty
from gd_analyze.types import DHRow, Drive, Joint, Placement, RobotArm
from strategies import arms, examples
from transforms import link_frames


def one_joint(**changes) -> gd.types.RobotArm:
    return gd.types.RobotArm(**{"name": "a", "joints": (Joint("1"),), "links": (link(),)} | changes)


def test_limits_that_are_unknown_are_infinite():
    limits = [
        *one_joint().limits("lower"),
        *one_joint().limits("upper"),
        *one_joint().limits("velocity_limit"),
    ]
    assert limits == [-np.inf, np.inf, np.inf]
    assert Joint("1", lower=-math.inf, upper=1.0, velocity_limit=math.inf).velocity_limit is None
    with pytest.raises(ArmError, match="not finite"):
        Joint("1", lower=math.inf)


@pytest.mark.parametrize(
    ("build", "says"),
    [
        (lambda: Joint("1", "spherical"), "unknown kind"),
        (lambda: Joint("1", axis=np.array([0, 0, 1 + 1e-5])), "not a unit vector"),
        (lambda: Joint("1", lower=1.0, upper=1.0), "range of joint 1 is empty"),
        (lambda: Joint("1", acceleration_limit=-1.0), "acceleration_limit of joint 1 is not positive"),
        (lambda: Joint("1", axis=np.array([np.nan, 0, 1])), "not finite"),
        (lambda: Placement(np.diag([1.0, 1.0, -1.0])), "is not a rotation"),
        (lambda: link(mass=-1.0), "is negative"),
        (lambda: link(com=np.zeros(2)), "wrong shape"),
        (lambda: link(inertia_com=np.triu(np.ones((3, 3)))), "not symmetric"),
        (lambda: Drive(viscous={}), "viscous of a drive is not made of numbers"),
        (lambda: DHRow(0.0, "1", 0.0, 0.0), "d of a Denavit-Hartenberg row is not made of numbers"),
        (lambda: LinkUncertainty(com=np.array([0.0, -0.1, 0.0])), "com of a link's uncertainty is negative"),
        (lambda: LinkUncertainty(inertia=np.triu(np.ones((3, 3)))), "uncertainty is not symmetric"),
        (lambda: one_joint(joints=(), links=()), "has no joints"),
        (lambda: one_joint(links=()), "as many links as joints"),
        (lambda: one_joint(drives=(Drive(),) * 2), "as many drives as joints"),
        (lambda: one_joint(convention="other"), "unknown convention"),
        (lambda: one_joint(sources=("\u200b",)), "not printable"),
    ],
)
def test_impossible_parts(build, says):
    with pytest.raises(ArmError, match=says):
        build()


def test_values_cannot_be_changed(puma):
    with pytest.raises(dataclasses.FrozenInstanceError):
        puma.name = "other"
    for array in (
        puma.gravity_vector,
        puma.mass,
        puma.com,
        puma.inertia_com,
        puma.drive_inertia,
        puma.links[0].com,
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0
    com = np.zeros(3)
    body = link(com=com)
    com[0] = 0.05
    assert body.com[0] == 0.0


@examples(20)
@given(arms())
def test_reach_bounds_every_pose(arm):
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (arm.n_joints, 20))
    q[[not revolute for revolute in arm.is_revolute]] = 0.0
    kinematics = solve_kinematics(arm, q)
    distance = np.linalg.norm(kinematics.link_origins - kinematics.joint_origins[0], axis=1).max()
    assert distance <= arm.reach * (1 + 1e-13)  # some 20 roundings per joint


@examples(20)
@given(arms())
def test_description_round_trip(arm):
    again = arm_in(json.loads(json.dumps(describe(arm), allow_nan=False)))
    assert fingerprint(again) == fingerprint(arm)
    assert describe(again) == describe(arm)


def test_uncertainties_are_no_part_of_the_fingerprint():
    """What acts on torque is; how well it is known changes no result that was made for the arm."""
    plain = one_joint(drives=(Drive(1.0),))
    measured = link(name="x", mass=np.float32(1), uncertainty=LinkUncertainty(0.1))
    stated = RobotArm("b", (Joint("2"),), (measured,), drives=(Drive(1.0, 0.1),))
    assert fingerprint(stated, drives=True) == fingerprint(plain, drives=True)
    # Stored models name their arms by it.
    assert fingerprint(plain) == "e2d53fe166ba8618a5c5d9d0ef23435d8285b50c9e8f86a907855992e3ab1eb6"
    assert fingerprint(plain, drives=True) != fingerprint(one_joint(drives=(Drive(2.0),)), drives=True)


def leaves(value, keys=()):
    """Places of all numbers and words in nested JSON values."""
    if isinstance(value, dict | list):
        for key, inner in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(inner, (*keys, key))
    else:
        yield keys, value


ACTING = {"gravity", "kind", "axis", "mass", "com", "inertia"}
ACTING |= {"xyz", "rotation", "frame_xyz", "frame_rotation"}


def test_fingerprint_changes_with_every_number_that_acts_and_with_nothing_else(puma):
    """Through the fingerprint of an edited description, where that still describes a possible arm."""
    # Right angles of a table absorb the smallest changes.
    placed = dataclasses.replace(puma, dh_table=())
    before, counts = fingerprint(puma), {True: 0, False: 0}
    text = json.dumps(describe(placed))
    for keys, value in leaves(json.loads(text)):
        if isinstance(value, bool):
            continue
        edited = inner = json.loads(text)
        for key in keys[:-1]:
            inner = inner[key]
        # The smallest change there is; numbers of rotations and inertias stay within what is possible.
        inner[keys[-1]] = value + "x" if isinstance(value, str) else float(np.nextafter(value, 2.0))
        if keys[-1] == "kind":
            inner[keys[-1]] = "prismatic"
        try:
            after = fingerprint(arm_in(edited))
        except ArmError:
            continue  # e.g. an unknown word
        acts = bool(ACTING & set(keys)) and "drives" not in keys
        assert (after != before) == acts, keys
        counts[acts] += 1
    assert counts[True] > 150
    assert counts[False] > 30


EPS = float(np.finfo(float).eps)
angles = st.one_of(st.floats(-3.2, 3.2), st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi]))
rows = st.builds(DHRow, angles, st.floats(-1.0, 1.0), st.floats(-1.0, 1.0), angles)


def screw(axis: int, angle: float, along: float) -> np.ndarray:
    """Turn about and slide along x (0) or z (2)."""
    matrix = np.eye(4)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    c, s = math.cos(angle), math.sin(angle)
    matrix[j, j] = matrix[k, k] = c
    matrix[k, j], matrix[j, k] = s, -s
    matrix[axis, 3] = along
    return matrix


@pytest.mark.parametrize("placements", [standard_placements, modified_placements])
@examples(60)
@given(st.sampled_from(["revolute", "prismatic"]), rows, st.floats(-3, 3))
def test_link_transform(placements, kind, row, q):
    """[FGL87] Eq. (3.2-5), the joint variable added to theta or d; for Craig alpha and a come first."""
    before, behind = placements(kind, row)
    arm = RobotArm("dh", (Joint("1", kind, before),), (link(frame=behind),))
    theta, d = (row.theta + q, row.d) if kind == "revolute" else (row.theta, row.d + q)
    about_z, about_x = screw(2, theta, d), screw(0, row.alpha, row.a)
    expected = about_z @ about_x if placements is standard_placements else about_x @ about_z
    # cos(theta + q) against the product of two rotations: an angle up to 6.2 rounds by 4 eps.
    np.testing.assert_allclose(link_frames(arm, np.array([[q]]))[0, 0], expected, atol=20 * EPS)


def test_right_angles_are_exact_and_near_ones_are_not_snapped():
    for turns in range(-9, 10):
        assert exact_cos_sin(math.radians(90.0 * turns)) == [(1, 0), (0, 1), (-1, 0), (0, -1)][turns % 4]
    near = math.pi / 2 + 1e-12
    assert exact_cos_sin(near) == (math.cos(near), math.sin(near))
