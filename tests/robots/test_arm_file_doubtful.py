"""What an arm file may state, though it looks odd: warned about, read in its units, or silent."""

from __future__ import annotations

import warnings

import pytest
from arm_files import ARM

from gd_analyze.errors import ArmError, GdAnalyzeWarning
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.description import fingerprint

SLIGHTLY_OFF = ARM.replace("zz = 0.01 }", "zz = 0.042 }")  # 0.042 > 0.02 + 0.02 by 5 %


def test_a_triangle_inequality_broken_by_a_measurements_error_warns(file):
    with pytest.warns(GdAnalyzeWarning, match=r"line 17: .*first violates the triangle inequality by 4\.8 %"):
        read_arm(file(SLIGHTLY_OFF))


def test_a_measurement_kept_as_published_is_silent(file):
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read_arm(file(SLIGHTLY_OFF.replace("mass = 2.0", "mass = 2.0\nas_measured = true")))


@pytest.mark.parametrize("measured", ["", "\nas_measured = true"])
def test_no_measurement_excuses_what_is_far_off(file, measured):
    """0.06 > 0.02 + 0.02 by a third of it."""
    text = ARM.replace("zz = 0.01 }", "zz = 0.06 }").replace("mass = 2.0", f"mass = 2.0{measured}")
    said = (
        r"line 17: the inertia of link first violates the triangle inequality by 33 % of its .*principal "
        r"moment \(0\.02, 0\.02, 0\.06 kg m\^2\): physically inconsistent; check units .* \(com or origin\)"
    )
    with pytest.warns(GdAnalyzeWarning, match=said) as told:
        arm = read_arm(file(text))
    assert len(told) == 1
    assert arm.links[0].inertia_com[2, 2] == 0.06


@pytest.mark.parametrize("measured", ["", "\nas_measured = true"])
def test_a_negative_principal_moment_is_one_warning(file, measured):
    """Of [[0.01, 0.02], [0.02, 0.01]] the moments are 0.01 - 0.02 and 0.01 + 0.02."""
    text = ARM.replace("xy = 0.001", "xy = 0.02").replace("mass = 1.0", f"mass = 1.0{measured}")
    said = (
        r"line \d+: the inertia of link second is physically inconsistent: its smallest .* negative, by "
        r"33 % of the largest \(-0\.01, 0\.01, 0\.03 kg m\^2\); check the signs of the products"
    )
    with pytest.warns(GdAnalyzeWarning, match=said) as told:
        read_arm(file(text))
    assert len(told) == 1


def test_inertia_known_about_the_axis_only(file):
    text = ARM.replace("xx = 0.02, yy = 0.02, zz = 0.01", "xx = 0.0, yy = 0.35, zz = 0.0")
    with pytest.warns(GdAnalyzeWarning, match="triangle inequality by 100 %"):
        read_arm(file(text))
    read_arm(file(text.replace("mass = 2.0", "mass = 2.0\naxial_only = true")))
    with pytest.raises(ArmError, match="about the joint axis only"):
        read_arm(file(ARM.replace("mass = 1.0", "mass = 1.0\naxial_only = true")))


def test_a_centre_of_mass_in_millimetres_is_suspicious(file):
    with pytest.warns(GdAnalyzeWarning, match="are its units metres"):
        read_arm(file(ARM.replace("com = [0.0, 0.0, 0.1]", "com = [0.0, 0.0, 100.0]")))


def test_units_in_keys(file):
    plain = read_arm(file(ARM))
    suffixed = ARM.replace("range = [0.0, 0.5]", "range_mm = [0, 500]").replace(
        "com = [0.0, 0.0, 0.1]", "com_mm = [0.0, 0.0, 100.0]"
    )
    again = read_arm(file(suffixed))
    assert again.joints[1].upper == plain.joints[1].upper == 0.5
    # 100 * 1e-3 and 0.1 differ by a rounding at most.
    assert again.links[0].com[2] == pytest.approx(plain.links[0].com[2], rel=2.3e-16)


def test_inertia_about_the_origin(file):
    """Steiner: about the origin it is larger by m (c.c 1 - c c^T)."""
    about_origin = ARM.replace(
        "inertia = { xx = 0.02, yy = 0.02, zz = 0.01 }",
        'inertia = { xx = 0.04, yy = 0.04, zz = 0.01 }\ninertia_about = "origin"',
    )
    found = read_arm(file(about_origin)).links[0].inertia_com
    expected = read_arm(file(ARM)).links[0].inertia_com
    assert abs(found - expected).max() <= 1e-17  # two roundings of numbers of 0.04


def test_stated_uncertainties(file):
    plain = read_arm(file(ARM))
    assert [link.uncertainty for link in plain.links] == [None, None]
    text = ARM.replace("mass = 2.0", "mass = 2.0\nmass_uncertainty = 0.05").replace(
        "mass = 1.0",
        'mass = 1.0\ncom_uncertainty_mm = [1, 2, 3]\ninertia_about = "origin"\n'
        "inertia_uncertainty = { xx = 1e-3, yy = 2e-3, zz = 3e-3, xz = 4e-3 }",
    )
    arm = read_arm(file(text))
    first, second = (link.uncertainty for link in arm.links)
    assert (first.mass, first.com, first.inertia, first.inertia_about) == (0.05, None, None, "com")
    assert (second.mass, second.inertia_about) == (None, "origin")
    assert second.com.tolist() == [1 * 1e-3, 2 * 1e-3, 3 * 1e-3]
    assert second.inertia.tolist() == [[1e-3, 0, 4e-3], [0, 2e-3, 0], [4e-3, 0, 3e-3]]
    assert fingerprint(arm, drives=True) == fingerprint(plain, drives=True)
