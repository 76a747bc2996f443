"""What may be dropped adds up to the exact torque, and what is free in a refit."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import UsageError
from gd_analyze.motions.states import states_in_box
from gd_analyze.robots.parts import Drive
from gd_analyze.simplification.candidates import candidates_of
from gd_analyze.simplification.effort import ROUGH
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.search_options import SearchOptions
from gd_analyze.simplification.simplify import simplify
from gd_analyze.simplification.term import TERM
from strategies import arms_with_states, examples


@examples(15)
@given(
    arms_with_states(max_joints=4, count=10, massive=True),
    st.sampled_from([ELEMENT, TERM, ENERGY]),
    st.booleans(),
)
def test_candidates_sum_up_to_the_exact_torque(case, level, drives):
    arm, drawn = case
    arm = dataclasses.replace(arm, drives=tuple(Drive(0.1 * (i + 1)) for i in range(arm.n_joints)))
    exact = ExactDynamics.of(arm, drawn, drives)
    allowed = np.linspace(0.5, 2.0, arm.n_joints)
    candidates = candidates_of(exact, level, allowed)
    total = candidates.effects.sum(axis=0).T * allowed
    wanted = np.array(exact.torque)
    if level is ELEMENT and drives:
        wanted = wanted - arm.drive_inertia * drawn.qdd  # drives are no part that could go
    # Identification is exact to some hundred eps of the largest element, a torque sums some thousand terms.
    assert np.abs(total - wanted).max() <= 1e-10 * max(1.0, np.abs(exact.torque).max())
    if level is not ELEMENT:  # a constant part costs nothing beside a drive's constant
        assert set().union(*candidates.costs) == set(range(len(candidates.effects)))


def test_equal_coefficients_are_one_parameter(puma):
    exact = ExactDynamics.of(puma, states_in_box(puma, 5))
    numbers = candidates_of(exact, ENERGY, np.ones(6)).parameter
    by_number: dict[int, set[float]] = {}
    for number, coefficient in zip(numbers, exact.form.energies.values(), strict=True):
        by_number.setdefault(int(number), set()).add(abs(coefficient))
    for magnitudes in by_number.values():
        exponents = np.log2(np.array(sorted(magnitudes)) / min(magnitudes))
        # Powers of two apart, but for round-off of the identification (1e-13 relative at most here).
        assert np.abs(exponents - np.round(exponents)).max() <= 1e-9
    assert len(by_number) < len(exact.form.energies)


def test_a_torque_term_follows_the_energy_it_comes_from(puma):
    """Scaling one energy coefficient scales exactly the torque terms with its parameter."""
    exact = ExactDynamics.of(puma, states_in_box(puma, 40))
    torque = candidates_of(exact, TERM, np.ones(6))
    energy = candidates_of(exact, ENERGY, np.ones(6))
    assert len(torque.parameter) == len(exact.form.torques)
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


def test_a_recursion_has_no_candidates(two_link, swing):
    with pytest.raises(UsageError, match="level recursive keeps no terms") as caught:
        candidates_of(ExactDynamics.of(two_link, swing), RECURSIVE, np.ones(2))
    assert caught.value.details["expected"] == "term, energy or element"


def test_no_such_level(two_link, swing):
    with pytest.raises(UsageError, match="no such level"):
        simplify(two_link, swing, level="atom")
    with pytest.raises(UsageError, match="no coefficients to refit"):
        simplify(two_link, swing, level="element", refit=True)
    with pytest.raises(UsageError, match="so few operations"):
        simplify(two_link, swing, operations=-1)
    with pytest.raises(UsageError, match="no such level"):
        SearchOptions("atom")


@pytest.mark.parametrize("level", [ELEMENT, TERM, ENERGY], ids=str)
def test_a_selection_keeps_terms_times_their_factors(two_link, swing, level):
    exact = ExactDynamics.of(two_link, swing)
    candidates = candidates_of(exact, level, np.ones(2))
    count = len(candidates)
    every, one = np.ones(count, dtype=bool), np.ones(count)
    assert candidates.keep(every, one) == candidates.terms == level.terms(exact.form)
    assert (
        candidates.count(every, one, ROUGH) == level.write(exact.form, level.terms(exact.form), ROUGH).count
    )
    some = every.copy()
    some[::2] = False
    kept = candidates.keep(some, 3.0 * one)
    assert list(kept) == list(candidates.terms)[1::2]
    assert all(weight == 3.0 * candidates.terms[term] for term, weight in kept.items())
    assert candidates.count(some, one, ROUGH).total < candidates.count(every, one, ROUGH).total
    assert candidates.count(~every, one, ROUGH).total == 0
