"""Both Denavit-Hartenberg conventions, revolute and prismatic, against the four products they stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.pinocchio_check import round_off_bounds
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import exact_cos_sin, modified_placements, standard_placements
from gd_analyze.robots.parts import DHRow, Joint, Link
from strategies import examples, random_inertia, random_states
from transforms import link_frames

EPS = float(np.finfo(float).eps)
angles = st.one_of(st.floats(-3.2, 3.2), st.sampled_from([0.0, math.pi / 2, -math.pi / 2, math.pi]))
lengths = st.floats(-1.0, 1.0)
rows = st.builds(DHRow, angles, lengths, lengths, angles)
kinds = st.sampled_from(["revolute", "prismatic"])


def screw(axis: int, angle: float, along: float) -> np.ndarray:
    """Turn about and slide along x (0) or z (2)."""
    matrix = np.eye(4)
    j, k = (axis + 1) % 3, (axis + 2) % 3
    c, s = math.cos(angle), math.sin(angle)
    matrix[j, j] = matrix[k, k] = c
    matrix[k, j], matrix[j, k] = s, -s
    matrix[axis, 3] = along
    return matrix


def arm_of(table, placements, inertial, name="dh"):
    joints, links = [], []
    for i, (kind, row) in enumerate(table):
        before, behind = placements(kind, row)
        joints.append(Joint(str(i), kind, before))
        links.append(Link(str(i), *inertial[i], behind))
    return RobotArm(name, tuple(joints), tuple(links))


NO_MASS = (0.0, np.zeros(3), np.zeros((3, 3)))


@examples(60)
@given(kinds, rows, st.floats(-3, 3))
def test_standard_link_transform(kind, row, q):
    """[FGL87] Eq. (3.2-5), the joint variable added to theta or d."""
    arm = arm_of([(kind, row)], standard_placements, [NO_MASS])
    theta, d = (row.theta + q, row.d) if kind == "revolute" else (row.theta, row.d + q)
    expected = screw(2, theta, d) @ screw(0, row.alpha, row.a)
    found = link_frames(arm, np.array([[q]]))[0, 0]
    # cos(theta + q) against the product of two rotations: an angle up to 6.2 rounds by 4 eps.
    np.testing.assert_allclose(found, expected, atol=20 * EPS)


@examples(60)
@given(kinds, rows, st.floats(-3, 3))
def test_modified_link_transform(kind, row, q):
    """Craig's order: alpha and a come first."""
    arm = arm_of([(kind, row)], modified_placements, [NO_MASS])
    theta, d = (row.theta + q, row.d) if kind == "revolute" else (row.theta, row.d + q)
    expected = screw(0, row.alpha, row.a) @ screw(2, theta, d)
    np.testing.assert_allclose(link_frames(arm, np.array([[q]]))[0, 0], expected, atol=20 * EPS)


@examples(20)
@given(st.lists(st.tuples(kinds, rows), min_size=1, max_size=5), st.integers(0, 2**32 - 1))
def test_one_arm_described_in_both_conventions_moves_alike(table, seed):
    """Standard frame i is modified frame i behind Rot_x(alpha_i) Trans_x(a_i): same matter, other frames."""
    rng = np.random.default_rng(seed)
    inertial = [(1.0 + i, rng.uniform(-0.05, 0.05, 3), random_inertia(rng)) for i in range(len(table))]
    standard = arm_of(table, standard_placements, inertial)
    shifted = [DHRow(row.theta, row.d, 0.0, 0.0) for _, row in table]
    for i in range(1, len(table)):
        before = table[i - 1][1]
        shifted[i] = DHRow(shifted[i].theta, shifted[i].d, before.a, before.alpha)
    moved = []
    for (_, row), (mass, com, inertia) in zip(table, inertial, strict=True):
        tip = screw(0, row.alpha, row.a)
        turn = tip[:3, :3]
        matter = turn @ inertia @ turn.T
        moved.append((mass, tip[:3, 3] + turn @ com, 0.5 * (matter + matter.T)))
    with_kinds = [(kind, row) for (kind, _), row in zip(table, shifted, strict=True)]
    modified = arm_of(with_kinds, modified_placements, moved)
    states = random_states(len(table), 5, seed)
    ours = decompose_states(standard, states)
    theirs = decompose_states(modified, states)
    bounds = round_off_bounds(standard, states.q, states.qd, states.qdd)
    for name in ("inertia", "coriolis_centrifugal", "gravity_loading", "torque"):
        # Moving the matter between frames rounds once more what each program rounds anyway.
        assert np.abs(ours[name] - theirs[name]).max() <= 2 * bounds[name], name


@pytest.mark.parametrize("turns", range(-9, 10))
def test_right_angles_are_exact(turns):
    assert exact_cos_sin(math.radians(90.0 * turns)) == [(1, 0), (0, 1), (-1, 0), (0, -1)][turns % 4]


@examples(100)
@given(st.floats(-100, 100))
def test_any_angle_is_within_a_rounding(angle):
    cosine, sine = exact_cos_sin(angle)
    # Snapping moves the angle by at most 4 eps of itself, and cos and sin by no more than that.
    slack = 4 * EPS * max(abs(angle), math.pi / 2)
    assert abs(cosine - math.cos(angle)) <= slack
    assert abs(sine - math.sin(angle)) <= slack


def test_an_angle_near_a_right_angle_is_not_snapped():
    near = math.pi / 2 + 1e-12
    assert exact_cos_sin(near) == (math.cos(near), math.sin(near))
