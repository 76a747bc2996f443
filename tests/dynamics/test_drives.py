"""Inertia and friction of the drives at the joint; they count unless the links alone are asked for."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.dynamics.drivetrain import coulomb_friction, least_friction, viscous_coefficients
from gd_analyze.dynamics.kinematics import kinetic_energy
from gd_analyze.dynamics.methods import METHODS
from gd_analyze.errors import ArmError, TorqueLimitWarning
from gd_analyze.tables import joint_accelerations
from gd_analyze.types import Drive, Drivetrain
from strategies import random_states

RATIOS = np.array([-62.6111, 107.815, -53.7063, 76.0364, 71.923, 76.686])
VISCOUS = np.array([1.48e-3, 0.817e-3, 1.38e-3, 71.2e-6, 82.6e-6, 36.7e-6])
FORWARD = np.array([0.395, 0.126, 0.132, 11.2e-3, 9.26e-3, 3.96e-3])
BACKWARD = np.array([-0.435, -0.071, -0.105, -16.9e-3, -14.5e-3, -10.5e-3])


def test_puma_at_the_joint(puma):
    """Corke and Armstrong-Helouvry 1994: the motor's numbers, seen through the gears."""
    one = np.ones(6)
    # A square and a product: some roundings.
    np.testing.assert_allclose(viscous_coefficients(puma), RATIOS**2 * VISCOUS, rtol=1e-15)
    np.testing.assert_allclose(coulomb_friction(puma, one), np.abs(RATIOS) * FORWARD, rtol=1e-15)
    np.testing.assert_allclose(coulomb_friction(puma, -one), np.abs(RATIOS) * BACKWARD, rtol=1e-15)
    expected = np.abs(RATIOS) * np.minimum(FORWARD, -BACKWARD)
    np.testing.assert_allclose(least_friction(puma), expected, rtol=1e-15)
    assert not coulomb_friction(puma, 0 * one).any()
    # Joint 1, by hand: 62.6111^2 * 1.48e-3 = 5.80 N m s.
    assert viscous_coefficients(puma)[0] == pytest.approx(5.80, abs=5e-3)


def test_a_rest_velocity_smooths_the_step_of_friction(puma):
    qd = np.linspace(-1, 1, 2001)[:, None] * np.ones(6)
    sharp, smooth = coulomb_friction(puma, qd), coulomb_friction(puma, qd, rest_velocity=1e-3)
    moving = np.abs(qd) > 0.03
    # tanh(30) is 1 within exp(-60), far below a rounding.
    np.testing.assert_allclose(smooth[moving], sharp[moving], rtol=1e-15)
    assert (np.diff(smooth, axis=0) >= 0).all()


def test_what_the_drives_ask_for_is_taken_off_before_the_links_accelerate(puma):
    states, damping = random_states(6, 50, 5), np.arange(6.0)
    drivetrain = Drivetrain(inertia=True, friction=True, damping=damping)
    resistance = (viscous_coefficients(puma) + damping) * states.qd
    resistance += coulomb_friction(puma, states.qd, rest_velocity=drivetrain.rest_velocity)
    torque = METHODS["newton_euler_link"].torque(puma, *states.last).T
    torque += puma.drive_inertia * states.qdd + resistance
    found = joint_accelerations(puma, states.q, states.qd, torque, drivetrain=drivetrain)
    # Round-off of torques of some 1000 N m over inertias from 0.2 kg m^2 on.
    np.testing.assert_allclose(found, states.qdd, rtol=0, atol=1e-9)
    added = kinetic_energy(puma, states.q, states.qd, drives=True) - kinetic_energy(puma, states.q, states.qd)
    # The difference of two energies of a few hundred joules: eps of those.
    np.testing.assert_allclose(added, 0.5 * states.qd**2 @ puma.drive_inertia, rtol=1e-13)


def test_a_prismatic_drive_is_in_newtons_and_kilograms():
    """The same formulas: a ratio in rad/m turns motor N m s into N s/m and motor N m into N."""
    stanford = gd.load_arm("stanford")
    boom = Drive(inertia=0.782, gear_ratio=200.0, viscous=1e-4, coulomb=(0.05, -0.04))
    arm = dataclasses.replace(stanford, drives=(*stanford.drives[:2], boom, *stanford.drives[3:]))
    # 200^2 * 1e-4 = 4 N s/m, 200 * 0.05 = 10 N; a rounding each.
    found = [viscous_coefficients(arm)[2], coulomb_friction(arm, np.ones(6))[2], arm.drive_inertia[2]]
    np.testing.assert_allclose(found, [4.0, 10.0, 0.782], rtol=1e-15)


def test_impossible_drives_and_none(puma, two_link, swing):
    for coulomb in ((-0.1, -0.1), (0.1, 0.1)):
        drives = (dataclasses.replace(puma.drives[0], coulomb=coulomb), *puma.drives[1:])
        with pytest.raises(ArmError, match=r"friction .*waist"):
            viscous_coefficients(dataclasses.replace(puma, drives=drives))
    for use in (viscous_coefficients, lambda arm: gd.decompose(arm, swing, drives=True)):
        with pytest.raises(ArmError, match="describes no drives"):
            use(two_link)
    idle = dataclasses.replace(two_link, drives=(Drive(torque_limit=10.0), Drive(torque_limit=5.0)))
    with pytest.warns(TorqueLimitWarning, match="joint 1"):
        assert not gd.simplify(idle, swing, "10%").drives  # they state no inertia


def test_decompositions_and_models_include_them(puma, pick_and_place, pick_and_place_dataset):
    driven = gd.decompose(puma, pick_and_place)
    np.testing.assert_array_equal(driven.drive_torque, puma.drive_inertia * pick_and_place.qdd)
    peak = np.abs(driven.torque.values).max(axis=0)
    added = driven.torque - driven.drive_torque - pick_and_place_dataset.torque
    # One addition and its undoing: a rounding of the sum, one of the difference.
    assert float(np.abs(added).max()) <= 5e-16 * peak.max()
    # D, h and c remain the links' own.
    for name in ("inertia", "coriolis_centrifugal", "gravity_loading"):
        np.testing.assert_array_equal(driven[name], pick_and_place_dataset[name])
    # A decomposition knows whether it has drives; what is asked for counts more.
    own = np.abs(pick_and_place_dataset.torque.values).max(axis=0)
    for given, drives, expected in (
        (pick_and_place, None, peak),
        (driven, None, peak),
        (pick_and_place_dataset, None, own),
        (pick_and_place_dataset, True, peak),
        (pick_and_place, False, own),
    ):
        exact = gd.types.ExactDynamics.of(puma, given, drives=drives)
        np.testing.assert_allclose(exact.peak_torque, expected, rtol=1e-14)
