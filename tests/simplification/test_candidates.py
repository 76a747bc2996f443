"""What may be dropped adds up to the exact torque, and what is free in a refit."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from cases import exact_of
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.robots import Drive
from gd_analyze.simplification import ExactDynamics, states_in_box
from gd_analyze.simplification.candidates import candidates_of
from strategies import arms_with_states, examples


@examples(15)
@given(
    arms_with_states(max_joints=4, count=10, massive=True),
    st.sampled_from(["element", "term", "energy"]),
    st.booleans(),
)
def test_candidates_sum_up_to_the_exact_torque(case, level, drives):
    arm, drawn = case
    arm = dataclasses.replace(arm, drives=tuple(Drive(0.1 * (i + 1)) for i in range(arm.n_joints)))
    exact = exact_of((arm, drawn), drives)
    allowed = np.linspace(0.5, 2.0, arm.n_joints)
    candidates = candidates_of(exact, level, allowed)
    total = candidates.effects.sum(axis=0).T * allowed
    wanted = np.array(exact.torque)
    if level == "element" and drives:
        wanted = wanted - arm.drive_inertia * drawn.qdd  # drives are no part that could go
    # Identification is exact to some hundred eps of the largest element, a torque sums some thousand terms.
    assert np.abs(total - wanted).max() <= 1e-10 * max(1.0, np.abs(exact.torque).max())
    if level != "element":  # a constant part costs nothing beside a drive's constant
        assert set().union(*candidates.costs) == set(range(len(candidates.effects)))


def test_equal_coefficients_are_one_parameter(puma):
    exact = ExactDynamics(puma, states_in_box(puma, 5))
    numbers = candidates_of(exact, "energy", np.ones(6)).parameter
    by_number: dict[int, set[float]] = {}
    for number, term in zip(numbers, exact.energy, strict=True):
        by_number.setdefault(int(number), set()).add(abs(term.coefficient))
    for magnitudes in by_number.values():
        exponents = np.log2(np.array(sorted(magnitudes)) / min(magnitudes))
        # Powers of two apart, but for round-off of the identification (1e-13 relative at most here).
        assert np.abs(exponents - np.round(exponents)).max() <= 1e-9
    assert len(by_number) < len(exact.energy)


def test_a_torque_term_follows_the_energy_it_comes_from(puma):
    """Scaling one energy coefficient scales exactly the torque terms with its parameter."""
    exact = ExactDynamics(puma, states_in_box(puma, 40))
    torque = candidates_of(exact, "term", np.ones(6))
    energy = candidates_of(exact, "energy", np.ones(6))
    assert len(torque.parameter) == len(exact.torques)
    shared = set(torque.parameter.tolist()) & set(energy.parameter.tolist())
    assert len(shared) > 20
    for number in sorted(shared):
        of_terms = torque.effects[torque.parameter == number].sum(axis=0)
        of_energy = energy.effects[energy.parameter == number].sum(axis=0)
        size = np.abs(of_energy).max()
        # A torque term that several energies of different coefficients make is a parameter of its own.
        if not np.isclose(np.abs(of_terms).max(), size, rtol=1e-9):
            continue
        assert np.abs(of_terms - of_energy).max() <= 1e-9 * max(size, 1e-12)


def test_no_such_level(two_link, swing):
    from gd_analyze import simplify
    from gd_analyze.errors import UsageError

    with pytest.raises(UsageError, match="no such level"):
        simplify(two_link, swing, level="atom")
    with pytest.raises(UsageError, match="no coefficients to refit"):
        simplify(two_link, swing, level="element", refit=True)
    with pytest.raises(UsageError, match="so few operations"):
        simplify(two_link, swing, operations=-1)
