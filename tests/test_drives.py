"""What the drives ask for: each cause by itself, at the joint."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.decomposition import decompose_states
from gd_analyze.dynamics.drivetrain import drive_contributions
from gd_analyze.errors import ArmError, UsageError
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Drive
from strategies import examples, random_states

RATIOS = np.array([-62.6111, 107.815, -53.7063, 76.0364, 71.923, 76.686])
VISCOUS = np.array([1.48e-3, 0.817e-3, 1.38e-3, 71.2e-6, 82.6e-6, 36.7e-6])
FORWARD = np.array([0.395, 0.126, 0.132, 11.2e-3, 9.26e-3, 3.96e-3])
BACKWARD = np.array([-0.435, -0.071, -0.105, -16.9e-3, -14.5e-3, -10.5e-3])


def test_puma_at_the_joint(puma):
    """Corke and Armstrong-Helouvry 1994: the motor's numbers, seen through the gears."""
    one = np.ones(6)
    rising, falling = drive_contributions(puma, one, one), drive_contributions(puma, -one, -one)
    # A square and a product: some roundings.
    np.testing.assert_allclose(rising.viscous, RATIOS**2 * VISCOUS, rtol=1e-15)
    np.testing.assert_allclose(rising.coulomb, np.abs(RATIOS) * FORWARD, rtol=1e-15)
    np.testing.assert_allclose(falling.coulomb, np.abs(RATIOS) * BACKWARD, rtol=1e-15)
    np.testing.assert_array_equal(rising.inertia, [1.14, 4.71, 0.827, 0.2, 0.179, 0.193])
    # Joint 1, by hand: 62.6111^2 * 1.48e-3 = 5.80 N m s, 62.6111 * 0.395 = 24.7 N m.
    assert rising.viscous[0] == pytest.approx(5.80, abs=5e-3)
    assert rising.coulomb[0] == pytest.approx(24.7, abs=5e-2)


def test_at_rest_there_is_no_friction(puma):
    still = drive_contributions(puma, np.zeros(6), np.ones(6))
    assert not still.friction.any()
    np.testing.assert_array_equal(still.total, puma.drive_inertia)


@examples(30)
@given(st.integers(0, 2**32 - 1), st.sampled_from(["puma560", "stanford"]), st.floats(0, 1))
def test_parts_sum_and_friction_opposes_motion(seed, name, rest_rate):
    arm = load_arm(name)
    states = random_states(6, 5, seed)
    found = drive_contributions(arm, states.qd, states.qdd, rest_rate=rest_rate)
    np.testing.assert_array_equal(found.total, found.inertia + (found.viscous + found.coulomb))
    for part in (found.viscous, found.coulomb):
        assert (part * states.qd >= 0).all()


def test_any_leading_shape(puma):
    states = random_states(6, 6, 1)
    flat = drive_contributions(puma, states.qd, states.qdd)
    folded = drive_contributions(puma, states.qd.reshape(2, 3, 6), states.qdd.reshape(2, 3, 6))
    for part in ("inertia", "viscous", "coulomb", "friction", "total"):
        np.testing.assert_array_equal(getattr(folded, part).reshape(6, 6), getattr(flat, part))


def test_a_rest_rate_smooths_the_step_and_nothing_else(puma):
    qd = np.linspace(-1, 1, 2001)[:, None] * np.ones(6)
    sharp = drive_contributions(puma, qd, 0 * qd)
    smooth = drive_contributions(puma, qd, 0 * qd, rest_rate=1e-3)
    np.testing.assert_array_equal(smooth.viscous, sharp.viscous)
    moving = np.abs(qd) > 0.03
    # tanh(30) is 1 within exp(-60), far below a rounding.
    np.testing.assert_allclose(smooth.coulomb[moving], sharp.coulomb[moving], rtol=1e-15)
    assert (np.diff(smooth.coulomb, axis=0) >= 0).all()
    assert (np.abs(smooth.coulomb) <= np.abs(sharp.coulomb) * (1 + 1e-15)).all()


def test_the_decomposition_takes_its_drive_torque_from_here(puma):
    states = random_states(6, 7, 3)
    dataset = decompose_states(puma, states, drives=True)
    expected = drive_contributions(puma, states.qd, states.qdd).inertia
    np.testing.assert_array_equal(dataset["drive_torque"], expected)


def test_an_arm_without_drives(two_link):
    with pytest.raises(ArmError, match="describes no drives") as caught:
        drive_contributions(two_link, np.zeros(2), np.zeros(2))
    assert "[[drives]]" in caught.value.details["expected"]


def test_no_drive_pushes_itself(puma):
    with pytest.raises(ArmError, match="viscous friction of a drive is negative"):
        dataclasses.replace(puma.drives[0], viscous=-1.0)


@pytest.mark.parametrize("drive", [{"coulomb": (-0.1, -0.1)}, {"coulomb": (0.1, 0.1)}])
def test_friction_that_would_drive(puma, drive):
    drives = (dataclasses.replace(puma.drives[0], **drive), *puma.drives[1:])
    odd = dataclasses.replace(puma, drives=drives)
    with pytest.raises(ArmError, match="friction of joint waist would drive it"):
        drive_contributions(odd, np.zeros(6), np.zeros(6))


@pytest.mark.parametrize(
    ("qd", "qdd"), [(np.zeros(5), np.zeros(5)), (np.zeros(6), np.zeros((2, 6))), (np.float64(0), np.zeros(6))]
)
def test_shapes_that_do_not_fit(puma, qd, qdd):
    with pytest.raises(UsageError, match="does not fit arm puma560"):
        drive_contributions(puma, qd, qdd)


@pytest.mark.parametrize("rest_rate", [-1.0, np.nan, np.inf])
def test_impossible_rest_rates(puma, rest_rate):
    with pytest.raises(UsageError, match="rest rate"):
        drive_contributions(puma, np.zeros(6), np.zeros(6), rest_rate=rest_rate)


def test_a_sliding_drive_is_in_newtons_and_kilograms():
    """The same formulas: a ratio in rad/m turns motor N m s into N s/m and motor N m into N."""
    stanford = load_arm("stanford")
    boom = Drive(inertia=0.782, gear_ratio=200.0, viscous=1e-4, coulomb=(0.05, -0.04))
    arm = dataclasses.replace(stanford, drives=(*stanford.drives[:2], boom, *stanford.drives[3:]))
    found = drive_contributions(arm, 0.5 * np.ones(6), 2.0 * np.ones(6))
    # 200^2 * 1e-4 * 0.5 = 2 N, 200 * 0.05 = 10 N, 0.782 * 2 = 1.564 N; a rounding each.
    np.testing.assert_allclose(
        [found.viscous[2], found.coulomb[2], found.inertia[2]], [2.0, 10.0, 1.564], rtol=1e-15
    )
