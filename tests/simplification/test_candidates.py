"""Candidates, the order in which they go, refits of what is kept, and fits of programs."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from cases import candidate_sets, candidates_with, largest_error
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.errors import UsageError
from gd_analyze.motions.states import states_in_box
from gd_analyze.operations.tape import Tape
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.robots.parts import Drive
from gd_analyze.simplification.candidates import candidates_of
from gd_analyze.simplification.effort import ROUGH, Work
from gd_analyze.simplification.element import ELEMENT
from gd_analyze.simplification.elimination import eliminate
from gd_analyze.simplification.energy import ENERGY
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.fitting import Aim, Columns, fitted, norm, unfitted
from gd_analyze.simplification.program_cache import inputs_of
from gd_analyze.simplification.recursive import RECURSIVE
from gd_analyze.simplification.refit import Refit
from gd_analyze.simplification.term import TERM
from strategies import arms_with_states, examples


@examples(7)
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


@examples(30)
@given(candidate_sets(), st.booleans(), st.booleans())
def test_errors_are_those_of_the_sets_on_the_way(candidates, by_cost, refit):
    elimination = eliminate(candidates, by_cost=by_cost, refit=refit)
    assert sorted(elimination.order) == list(range(len(candidates.effects)))
    errors = elimination.errors().max(axis=1)
    for k in range(len(errors)):
        kept, scale = elimination.kept(k), elimination.scales[k]
        assert kept.sum() == len(candidates.effects) - k
        # Sums of at most 8 numbers of some budgets.
        assert abs(errors[k] - largest_error(candidates, kept, scale)) <= 1e-12
        assert refit or (scale == 1.0).all()


@examples(30)
@given(candidate_sets(), st.floats(0.0, 4.0))
def test_what_a_budget_leaves_is_within_it(candidates, factor):
    kept = eliminate(candidates).within(factor)
    assert largest_error(candidates, kept) <= factor + 1e-12


def test_the_first_to_go_is_the_one_least_missed_for_what_it_costs():
    effects = np.array([3.0, 1.0, 2.0, 0.5]).reshape(4, 1, 1)
    alike = candidates_with(effects, {frozenset([k]): 1 for k in range(4)})
    assert eliminate(alike).order == (3, 1, 2, 0)
    # Dropping 0 saves twenty operations for a squared error of 9, dropping 3 one for 0.25.
    dear = candidates_with(effects, {frozenset([k]): n for k, n in ((0, 50), (1, 1), (2, 1), (3, 1))})
    assert eliminate(dear).order[0] == 0
    assert eliminate(dear, by_cost=False).order[0] == 3


@examples(20)
@given(candidate_sets())
def test_refit_is_the_least_squares_fit(candidates):
    elimination = eliminate(candidates, refit=True)
    flat = candidates.flat
    target = flat.sum(axis=0)
    for k in range(1, len(elimination.order)):
        kept = elimination.kept(k)
        used = np.unique(candidates.parameter[kept])
        columns = np.array([flat[kept & (candidates.parameter == p)].sum(axis=0) for p in used])
        theta, *_ = np.linalg.lstsq(columns.T, target, rcond=None)
        best = np.linalg.norm(theta @ columns - target)
        ours = np.linalg.norm((kept * elimination.scales[k] - 1.0) @ flat)
        # Ours solves the normal equations: their condition number is squared, so half the digits are left.
        assert ours <= best + 1e-6 * np.linalg.norm(target)


def test_numbers_that_do_not_show_in_the_torque_stay_finite():
    """Two candidates of one number cancel but for round-off, and a third has next to no effect."""
    rng = np.random.default_rng(3)
    wave = rng.normal(size=(1, 1, 30))
    effects = np.vstack(
        [wave, -wave * (1.0 + 1e-16 * rng.normal(size=30)), 1e-160 * wave, rng.normal(size=(1, 1, 30))]
    )
    costs = {frozenset([k]): 1 for k in range(4)}
    elimination = eliminate(candidates_with(effects, costs, np.array([0, 0, 1, 2])), refit=True)
    assert sorted(elimination.order) == [0, 1, 2, 3]
    assert np.isfinite(elimination.scales).all()


@examples(30)
@given(candidate_sets(), st.integers(0, 2**32 - 1))
def test_no_other_factors_have_a_smaller_largest_error(candidates, seed):
    rng = np.random.default_rng(seed)
    kept = rng.random(len(candidates.effects)) < 0.6
    refit = Refit(candidates, Work())
    scale = refit.best(kept)
    least = largest_error(candidates, kept, scale)
    assert least <= largest_error(candidates, kept) + 1e-9
    # The solver keeps its rows to 1e-7 of numbers up to some tens here.
    slack = 1e-5 * (1.0 + least)
    for _ in range(20):
        change = rng.normal(size=len(kept)) * rng.choice([1e-3, 0.1, 1.0])
        other = scale + change[candidates.parameter]
        assert largest_error(candidates, kept, other) >= least - slack
    for limit in (0.5 * least, 2.0 * least + 1e-3):
        found = refit.within(kept, limit)
        if limit < least - slack:
            assert found is None
        elif limit > least + slack:
            assert found is not None
            assert largest_error(candidates, kept, found) <= limit


@examples(15)
@given(candidate_sets())
def test_candidates_of_one_parameter_keep_their_ratio(candidates):
    kept = np.ones(len(candidates.effects), dtype=bool)
    kept[0] = False
    scale = Refit(candidates, Work()).best(kept)
    for p in np.unique(candidates.parameter[kept]):
        assert np.ptp(scale[kept & (candidates.parameter == p)]) == 0.0


def test_one_coefficient_takes_over_what_another_did():
    """cos x and 1 near x = 0: the constant alone, refitted, halves the largest error."""
    x = np.linspace(-0.5, 0.5, 41)
    effects = np.array([np.cos(x), np.full(41, 1.0)])[:, None, :]
    candidates = candidates_with(effects, {frozenset([k]): 1 for k in range(2)})
    scale = Refit(candidates, Work()).best(np.array([False, True]))
    # Middle of the range of cos x, which runs from cos 0.5 to 1.
    assert abs(scale[1] - (1.0 + (1.0 + np.cos(0.5)) / 2)) <= 1e-6


@pytest.fixture(scope="module")
def aim_and_tape() -> tuple[Aim, Tape]:
    exact = ExactDynamics.of(load_arm("stanford"), states_in_box(load_arm("stanford"), 200))
    scale = 1.0 / exact.peak_torque
    aim = Aim(inputs_of(exact.states), exact.torque.T * scale[:, None], scale, np.ones(exact.torque.T.shape))
    return aim, Tape(exact.form.recursion.program)


@pytest.mark.parametrize("power", [2.0, 8.0])
def test_numbers_that_are_off_are_found_again(aim_and_tape: tuple[Aim, Tape], power: float) -> None:
    aim, tape = aim_and_tape
    numbers = tape.numbers * (1.0 + 0.05 * np.cos(np.arange(len(tape))))
    start = unfitted(tape, aim, numbers)
    found = fitted(tape, aim, start, power, 8)
    # The torque of 5 % is gone but for steps that are held back: an order of magnitude at least.
    assert found.largest < 0.1 * start.largest


def test_a_fit_is_never_worse(aim_and_tape: tuple[Aim, Tape]) -> None:
    aim, tape = aim_and_tape
    for seed in range(5):
        rng = np.random.default_rng(seed)
        start = unfitted(tape, aim, tape.numbers * rng.uniform(0.5, 1.5, len(tape)))
        assert norm(fitted(tape, aim, start, 12.0, 2).errors, 12.0) <= norm(start.errors, 12.0)


def test_a_high_power_brings_the_largest_error_down() -> None:
    """The line nearest to a parabola on -1 .. 1: squares leave 2/3 at the ends, at best 1/2 is left."""
    x = np.linspace(-1.0, 1.0, 401)
    columns, target = np.stack([np.ones_like(x), x]), x**2

    def largest(power: float) -> float:
        return float(np.abs(Columns(columns).least(target, power)[1]).max())

    assert largest(2.0) == pytest.approx(2 / 3, abs=0.01)
    # Chebyshev: the mean of largest and smallest value. A power of 12 is close to that, not there.
    assert largest(12.0) == pytest.approx(0.5, abs=0.05)
