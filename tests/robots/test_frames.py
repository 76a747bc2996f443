"""Both Denavit-Hartenberg conventions, revolute and prismatic, against the four products they stand for."""

from __future__ import annotations

import math

import numpy as np
import pytest
from arm_files import link
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import exact_cos_sin, modified_placements, standard_placements
from gd_analyze.robots.parts import DHRow, Joint
from strategies import examples
from transforms import link_frames

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
    near = math.pi / 2 + 1e-12
    assert exact_cos_sin(near) == (math.cos(near), math.sin(near))
