"""Figures published with common toolbox data of the PUMA 560 hold for those data, not for the shipped arm.

P. Corke's Robotics Toolbox: other lengths, twists of the other sign, drive inertia as motor inertia behind
gears, and link 4's centre of mass beyond the wrist's centre instead of before it.
"""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.motions.states import States
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import standard_placements
from gd_analyze.robots.parts import DHRow, Joint, Link

# d, a, alpha in right angles; mass, centre of mass, moments; motor inertia, gear ratio.
TOOLBOX = (
    (0.0, 0.0, 1, 0.0, (0, 0, 0), (0, 0.35, 0), 200e-6, -62.6111),
    (0.0, 0.4318, 0, 17.4, (-0.3638, 0.006, 0.2275), (0.13, 0.524, 0.539), 200e-6, 107.815),
    (0.15005, 0.0203, -1, 4.8, (-0.0203, -0.0141, 0.070), (0.066, 0.086, 0.0125), 200e-6, -53.7063),
    (0.4318, 0.0, 1, 0.82, (0, 0.019, 0), (1.8e-3, 1.3e-3, 1.8e-3), 33e-6, 76.0364),
    (0.0, 0.0, -1, 0.34, (0, 0, 0), (0.3e-3, 0.4e-3, 0.3e-3), 33e-6, 71.923),
    (0.0, 0.0, 0, 0.09, (0, 0, 0.032), (0.15e-3, 0.15e-3, 0.04e-3), 33e-6, 76.686),
)
DRIVE_INERTIA = np.array([motor * ratio**2 for *_, motor, ratio in TOOLBOX])

# At the toolbox's pose qn = (0, 45, 180, 0, 45, 0) degrees, to four decimals; h for the velocities below.
POSE = np.radians([0.0, 45.0, 180.0, 0.0, 45.0, 0.0])
RATES = np.array([1.0, 2.0, 3.0, 1.0, 2.0, 3.0])
GRAVITY_LOADING = [0.0, 31.6399, 6.0351, 0.0, 0.0283, 0.0]
INERTIA = [
    [3.6594, -0.4044, 0.1006, -0.0025, 0.0, 0.0],
    [-0.4044, 4.4137, 0.3509, 0.0, 0.0024, 0.0],
    [0.1006, 0.3509, 0.9378, 0.0, 0.0015, 0.0],
    [-0.0025, 0.0, 0.0, 0.1925, 0.0, 0.0],
    [0.0, 0.0024, 0.0015, 0.0, 0.1713, 0.0],
    [0.0, 0.0, 0.0, 0.0, 0.0, 0.1941],
]
CORIOLIS = [
    [-0.1735, -2.0494, -0.1178, -0.0002, -0.0045, 0.0001],
    [0.6274, 1.1572, 1.9287, -0.0015, -0.0003, 0.0],
    [-0.3608, -0.7734, -0.0018, -0.0009, -0.0064, 0.0],
    [0.0011, 0.0005, -0.0001, 0.0002, 0.0002, -0.0001],
    [-0.0002, 0.0028, 0.0046, -0.0002, 0.0, 0.0],
    [0.0001, 0.0, 0.0, 0.0, 0.0, 0.0],
]
HALF_DIGIT = 0.5e-4


@pytest.fixture(scope="module")
def toolbox() -> RobotArm:
    joints, links = [], []
    for i, (d, a, turns, mass, com, moments, _, _) in enumerate(TOOLBOX):
        before, behind = standard_placements("revolute", DHRow(0.0, d, a, turns * np.pi / 2))
        joints.append(Joint(str(i), placement=before))
        known = {"axial_only": i == 0, "as_measured": i == 2}
        links.append(Link(str(i), mass, np.array(com, dtype=float), np.diag(moments), behind, **known))
    return RobotArm("toolbox", tuple(joints), tuple(links), np.array([0.0, 0.0, -9.81]))


def dynamics(arm: RobotArm) -> dict[str, np.ndarray]:
    found = decompose_states(arm, States(POSE[None], RATES[None], np.zeros((1, 6))))
    return {
        "inertia": found["inertia"][0].sum(axis=0) + np.diag(DRIVE_INERTIA),
        "coriolis_centrifugal": found["coriolis_centrifugal"][0].sum(axis=0),
        "gravity_loading": found["gravity_loading"][0],
    }


def test_published_figures_hold_for_the_toolboxs_own_numbers(toolbox):
    found = dynamics(toolbox)
    np.testing.assert_allclose(found["gravity_loading"], GRAVITY_LOADING, atol=HALF_DIGIT)
    np.testing.assert_allclose(found["inertia"], INERTIA, atol=HALF_DIGIT)
    # A row of the published matrix times the velocities: each of its entries is half a digit off at most.
    np.testing.assert_allclose(
        found["coriolis_centrifugal"], CORIOLIS @ RATES, atol=HALF_DIGIT * np.abs(RATES).sum()
    )


def test_they_do_not_with_the_sign_of_1986(toolbox):
    """Link 4's centre of mass on the other side of the wrist's centre."""
    links = list(toolbox.links)
    links[3] = dataclasses.replace(links[3], com=-links[3].com)
    found = dynamics(dataclasses.replace(toolbox, links=tuple(links)))
    assert np.abs(found["gravity_loading"] - GRAVITY_LOADING)[1:3].min() > 100 * HALF_DIGIT
    assert np.abs(np.diag(found["inertia"]) - np.diag(INERTIA))[:3].min() > 100 * HALF_DIGIT


def test_where_the_centre_of_mass_of_link_4_lies(toolbox, puma):
    """Towards the elbow in the shipped arm, beyond the wrist's centre in the toolbox's."""
    for arm, side in ((puma, -1), (toolbox, 1)):
        kinematics = solve_kinematics(arm, np.zeros((6, 1)))
        elbow, wrist = kinematics.link_origins[2, :, 0], kinematics.link_origins[3, :, 0]
        outwards = (wrist - elbow) / np.linalg.norm(wrist - elbow)
        beyond = outwards @ (kinematics.com_positions[3, :, 0] - wrist)
        # Differences of lengths below 1 m: some roundings.
        assert beyond == pytest.approx(side * 0.019, abs=1e-15)
