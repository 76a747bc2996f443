"""The Stanford arm: read as the data file says, possible, and refused when its unit trap springs."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import GdAnalyzeWarning
from gd_analyze.motions.states import States


@pytest.fixture(scope="module")
def stanford() -> gd.RobotArm:
    return gd.load_arm("stanford")


def test_kinds_limits_and_drives(stanford):
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
    told = f"inertia of link {index + 1} is physically inconsistent"
    assert any(told in str(item.message) for item in caught)


def test_the_boom(stanford):
    """What can be said by hand: D33 is the mass that slides, and standing upright it carries its weight."""
    q = np.array([[0.3, 0.0, 0.7, 0.4, -0.5, 0.6]])
    found = decompose_states(stanford, States(q, 0 * q, 0 * q))
    sliding = stanford.mass[2:].sum()
    # A sum of four masses, and of four weights along z: some roundings of each.
    np.testing.assert_allclose(found["inertia"][0, :, 2, 2], [sliding, 0.0], rtol=1e-15)
    np.testing.assert_allclose(found["gravity_loading"][0, 2], 9.8062 * sliding, rtol=1e-14)


def test_the_wrist_is_where_the_table_says(stanford):
    """At q = (0, 90 deg, d3, ...) the boom lies along the base's x axis, past the shoulder's offset."""
    kinematics = solve_kinematics(stanford, np.array([0.0, np.pi / 2, 0.8, 0.0, 0.0, 0.0])[:, None])
    # 0.8 m out, 0.154 m aside, 0.412 m up; cos(pi/2) = 6e-17 is one of a few roundings.
    np.testing.assert_allclose(kinematics.link_origins[5, :, 0], [0.8, 0.154, 0.412], atol=1e-15)
