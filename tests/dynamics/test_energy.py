"""Energies from velocities and heights, against D and against 4x4 transforms."""

from __future__ import annotations

import numpy as np
from hypothesis import given

from gd_analyze.dynamics.energy import kinetic_energy, potential_energy
from gd_analyze.dynamics.pinocchio_check import pinocchio_dynamics, round_off_bounds
from strategies import arms_with_states, examples, random_states
from transforms import potential_energy as by_transforms


@examples(30)
@given(arms_with_states())
def test_kinetic_energy_is_half_the_velocities_times_inertia(case):
    arm, states = case
    inertia = pinocchio_dynamics(arm, states.q, states.qd, states.qdd)["inertia"]
    expected = 0.5 * np.einsum("Ni,Nij,Nj->N", states.qd, inertia, states.qd)
    bound = round_off_bounds(arm, states.q, states.qd, states.qdd)["inertia"]
    # Each D_ij within its bound, times the squared sum of velocities.
    tolerance = bound * np.abs(states.qd).sum(axis=1) ** 2
    assert (np.abs(kinetic_energy(arm, states.q, states.qd) - expected) <= tolerance).all()


@examples(30)
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
