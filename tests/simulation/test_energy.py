"""Energies from velocities and heights, against D and against 4x4 transforms."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given

from gd_analyze.dynamics.energy import kinetic_energy, potential_energy
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from gd_analyze.errors import ArmError, UsageError
from strategies import arms_with_states, examples, random_states
from transforms import potential_energy as by_transforms


@examples(60)
@given(arms_with_states())
def test_kinetic_energy_is_half_the_rates_times_inertia(case):
    arm, states = case
    inertia = pinocchio_dynamics(arm, states.q, states.qd, states.qdd)["inertia"]
    expected = 0.5 * np.einsum("Ni,Nij,Nj->N", states.qd, inertia, states.qd)
    bound = round_off_bounds(arm, states.q, states.qd, states.qdd)["inertia"]
    # Each D_ij within its bound, times the squared sum of rates.
    tolerance = bound * np.abs(states.qd).sum(axis=1) ** 2
    assert (np.abs(kinetic_energy(arm, states.q, states.qd) - expected) <= tolerance).all()


@examples(60)
@given(arms_with_states())
def test_potential_energy_is_that_of_the_transforms(case):
    arm, states = case
    bound = round_off_bounds(arm, states.q, states.qd, states.qdd)["gravity_loading"]
    difference = potential_energy(arm, states.q) - by_transforms(arm, states.q)
    assert np.abs(difference).max() <= 2 * bound


def test_drives_add_their_own(puma):
    states = random_states(6, 9, 2)
    added = kinetic_energy(puma, states.q, states.qd, drives=True) - kinetic_energy(puma, states.q, states.qd)
    # The difference of two energies of a few hundred joules: eps of those.
    np.testing.assert_allclose(added, 0.5 * states.qd**2 @ puma.drive_inertia, rtol=1e-13)


def test_any_leading_shape(puma):
    states = random_states(6, 6, 2)
    flat = kinetic_energy(puma, states.q, states.qd)
    folded = kinetic_energy(puma, states.q.reshape(2, 3, 6), states.qd.reshape(2, 3, 6))
    np.testing.assert_array_equal(folded.reshape(6), flat)
    assert potential_energy(puma, states.q.reshape(3, 2, 6)).shape == (3, 2)
    assert potential_energy(puma, states.q[0]).shape == ()


def test_bad_input(puma, two_link):
    with pytest.raises(UsageError, match="qd does not fit"):
        kinetic_energy(puma, np.zeros((3, 6)), np.zeros(6))
    with pytest.raises(UsageError, match="q is not finite"):
        potential_energy(puma, np.full(6, np.inf))
    with pytest.raises(ArmError, match="describes no drives"):
        kinetic_energy(two_link, np.zeros(2), np.zeros(2), drives=True)
