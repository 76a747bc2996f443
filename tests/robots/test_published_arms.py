"""The shipped arms against their sources, and published figures against the numbers they were made with."""

from __future__ import annotations

import dataclasses
import re

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.robots.frames import standard_placements
from gd_analyze.tables import decompose_states
from gd_analyze.types import DHRow, Joint, Link, States
from published_arms import arm_of


def test_puma_numbers(puma):
    """Armstrong, Khatib, Burdick 1986 and [FGL87] Fig. 2.11."""
    assert puma.mass.tolist() == [0.0, 17.4, 4.8, 0.82, 0.34, 0.09]
    assert puma.inertia_com[1].diagonal().tolist() == [0.13, 0.524, 0.539]
    assert puma.com[1].tolist() == [-0.3638, 0.006, 0.07745]
    assert puma.com[3].tolist() == [0.0, 0.019, 0.0]
    assert puma.drive_inertia.tolist() == [1.14, 4.71, 0.827, 0.2, 0.179, 0.193]
    uncertain = [drive.inertia_uncertainty for drive in puma.drives]
    assert uncertain == [0.27, 0.54, 0.093, 0.016, 0.014, 0.016]
    assert [drive.torque_limit for drive in puma.drives] == [97.6, 186.4, 89.4, 24.2, 20.1, 21.3]
    lower, upper = [-160, -225, -45, -110, -100, -266], [160, 45, 225, 170, 100, 266]
    np.testing.assert_allclose(np.degrees(puma.limits("lower")), lower, rtol=4e-16)
    np.testing.assert_allclose(np.degrees(puma.limits("upper")), upper, rtol=4e-16)
    assert puma.gravity_vector.tolist() == [0.0, 0.0, -9.8062]
    assert [row.a for row in puma.dh_table] == [0.0, 0.4318, -0.02032, 0.0, 0.0, 0.0]


def test_two_link_numbers(two_link):
    """[FGL87] section 3.2.6: slender rods of length l, m l^2 / 12 across and nothing along them."""
    assert [row.a for row in two_link.dh_table] == [1.0, 1.0]
    assert two_link.mass.tolist() == [2.0, 1.0]
    for rod in two_link.links:
        assert rod.com.tolist() == [-0.5, 0.0, 0.0]
        assert rod.inertia_com.tolist() == np.diag([0.0, rod.mass / 12, rod.mass / 12]).tolist()
    assert two_link.gravity_vector.tolist() == [0.0, -9.8062, 0.0]


def test_scara_numbers():
    """Lloyd, Irani, Ahmadi 2021, Table 1: the file, and the table as the study beside PSDM has it."""
    scara, table = gd.load_arm("scara"), arm_of("SCARA")
    assert scara.is_revolute == table.is_revolute == (True, True, False, True)
    states = gd.tables.states_in_box(scara, 50, seed=3)
    torques = [decompose_states(arm, states)["torque"] for arm in (scara, table)]
    # Some hundred operations on torques of up to 100 N m, of lengths that may be a rounding apart.
    np.testing.assert_allclose(*torques, rtol=0, atol=1e-11)
    assert np.abs(torques[0]).max() < 200.0


@pytest.fixture(scope="module")
def stanford() -> gd.types.RobotArm:
    return gd.load_arm("stanford")


def test_stanford_numbers(stanford):
    assert [joint.unit for joint in stanford.joints] == ["rad", "rad", "m", "rad", "rad", "rad"]
    # Products with 0.0254, 12 to 50 inches: a rounding.
    span = [stanford.joints[2].lower, stanford.joints[2].upper]
    np.testing.assert_allclose(span, [12 * 0.0254, 50 * 0.0254], rtol=3e-16)
    ends = np.degrees([stanford.limits("lower"), stanford.limits("upper")])[:, [0, 1, 3, 4, 5]]
    # Degrees into radians and back: two roundings.
    np.testing.assert_allclose(ends, np.outer([-1, 1], [170, 170, 170, 90, 170]), rtol=5e-16)
    assert stanford.drive_inertia.tolist() == [0.953, 2.193, 0.782, 0.106, 0.097, 0.020]
    assert stanford.mass.tolist() == [9.29, 5.01, 4.25, 1.08, 0.63, 0.51]


def test_copies_in_circulation_hold_the_same_digits(stanford):
    """A second reading of Paul's tables: centres of mass and moments of the copy in P. Corke's toolbox.

    Its link 1 is in metres; of the others the centres of mass are ten times theirs, and the row of link 5 is
    one column too far to the left, x = 0 being lost. So read, every digit is ours.
    """
    copy = np.array(
        [
            [0, 0.0175, -0.1105, 0.276, 0.255, 0.071],
            [0, -1.054, 0, 0.108, 0.018, 0.100],
            [0, 0, -6.447, 2.51, 2.51, 0.006],
            [0, 0.092, -0.054, 0.002, 0.001, 0.001],
            [0, 0.566, 0.003, 0.003, 0.0004, 0],
            [0, 0, 1.554, 0.013, 0.013, 0.0003],
        ]
    )
    copy[4] = np.roll(copy[4], 1)
    com = copy[:, :3] / np.array([1, 10, 10, 10, 10, 10])[:, None]
    # Decimal numbers divided by ten: a rounding.
    np.testing.assert_allclose(stanford.com, com, rtol=2e-16)
    offset = np.einsum("la,la->l", com, com)[:, None] - com**2
    about_origin = np.einsum("lii->li", stanford.inertia_com) + stanford.mass[:, None] * offset
    np.testing.assert_allclose(about_origin, copy[:, 3:], atol=1e-15 * copy.max())


@pytest.mark.parametrize("index", range(6))
def test_one_centre_of_mass_in_metres_is_enough(tmp_path, index):
    """The copies that mix units: any single link's centre of mass a hundredfold is told."""
    text = gd.builtin_arms()["stanford"].read_text("utf-8")
    start, end = [match.span() for match in re.finditer(r"^com = .*$", text, flags=re.MULTILINE)][index]
    com = [100 * float(word) for word in text[start:end].split("[")[1].rstrip("]").split(",")]
    path = tmp_path / "stanford.toml"
    path.write_text(f"{text[:start]}com = {com}{text[end:]}", encoding="utf-8")
    with pytest.warns(GdAnalyzeWarning) as caught:
        gd.load_arm(path)
    message = f"inertia of link {index + 1} is physically inconsistent"
    assert any(message in str(item.message) for item in caught)


def test_the_boom(stanford):
    """What can be said by hand: D33 is the mass that slides, and standing upright it carries its weight."""
    q = np.array([[0.3, 0.0, 0.7, 0.4, -0.5, 0.6]])
    effects = decompose_states(stanford, States(q, 0 * q, 0 * q))
    sliding = stanford.mass[2:].sum()
    # A sum of four masses, and of four weights along z: some roundings of each.
    np.testing.assert_allclose(effects["inertia"][0, :, 2, 2], [sliding, 0.0], rtol=1e-15)
    np.testing.assert_allclose(effects["gravity_loading"][0, 2], 9.8062 * sliding, rtol=1e-14)


def test_the_wrist_is_where_the_table_says(stanford):
    """At q = (0, 90 deg, d3, ...) the boom lies along the base's x axis, past the shoulder's offset."""
    kinematics = solve_kinematics(stanford, np.array([0.0, np.pi / 2, 0.8, 0.0, 0.0, 0.0])[:, None])
    # 0.8 m out, 0.154 m aside, 0.412 m up; cos(pi/2) = 6e-17 is one of a few roundings.
    np.testing.assert_allclose(kinematics.link_origins[5, :, 0], [0.8, 0.154, 0.412], atol=1e-15)


# P. Corke's Robotics Toolbox: other lengths, twists of the other sign, drive inertia as motor inertia behind
# gears, and link 4's centre of mass beyond the wrist's centre instead of before it.
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
def toolbox() -> gd.types.RobotArm:
    joints, links = [], []
    for i, (d, a, turns, mass, com, moments, _, _) in enumerate(TOOLBOX):
        before, behind = standard_placements("revolute", DHRow(0.0, d, a, turns * np.pi / 2))
        joints.append(Joint(str(i), placement=before))
        options = {"axial_only": i == 0, "as_measured": i == 2}
        links.append(Link(str(i), mass, np.array(com, dtype=float), np.diag(moments), behind, **options))
    return gd.types.RobotArm("toolbox", tuple(joints), tuple(links), np.array([0.0, 0.0, -9.81]))


def dynamics(arm: gd.types.RobotArm) -> dict[str, np.ndarray]:
    effects = decompose_states(arm, States(POSE[None], RATES[None], np.zeros((1, 6))))
    return {
        "inertia": effects["inertia"][0].sum(axis=0) + np.diag(DRIVE_INERTIA),
        "coriolis_centrifugal": effects["coriolis_centrifugal"][0].sum(axis=0),
        "gravity_loading": effects["gravity_loading"][0],
    }


def test_published_figures_hold_for_the_toolboxs_own_numbers(toolbox):
    effects = dynamics(toolbox)
    np.testing.assert_allclose(effects["gravity_loading"], GRAVITY_LOADING, atol=HALF_DIGIT)
    np.testing.assert_allclose(effects["inertia"], INERTIA, atol=HALF_DIGIT)
    # A row of the published matrix times the velocities: each of its entries is half a digit off at most.
    np.testing.assert_allclose(
        effects["coriolis_centrifugal"], CORIOLIS @ RATES, atol=HALF_DIGIT * np.abs(RATES).sum()
    )


def test_they_do_not_with_the_sign_of_1986(toolbox):
    """Link 4's centre of mass on the other side of the wrist's centre."""
    links = list(toolbox.links)
    links[3] = dataclasses.replace(links[3], com=-links[3].com)
    effects = dynamics(dataclasses.replace(toolbox, links=tuple(links)))
    assert np.abs(effects["gravity_loading"] - GRAVITY_LOADING)[1:3].min() > 100 * HALF_DIGIT
    assert np.abs(np.diag(effects["inertia"]) - np.diag(INERTIA))[:3].min() > 100 * HALF_DIGIT


def test_where_the_centre_of_mass_of_link_4_lies(toolbox, puma):
    """Towards the elbow in the shipped arm, beyond the wrist's centre in the toolbox's."""
    for arm, side in ((puma, -1), (toolbox, 1)):
        kinematics = solve_kinematics(arm, np.zeros((6, 1)))
        elbow, wrist = kinematics.link_origins[2, :, 0], kinematics.link_origins[3, :, 0]
        outwards = (wrist - elbow) / np.linalg.norm(wrist - elbow)
        beyond = outwards @ (kinematics.com_positions[3, :, 0] - wrist)
        # Differences of lengths below 1 m: some roundings.
        assert beyond == pytest.approx(side * 0.019, abs=1e-15)
