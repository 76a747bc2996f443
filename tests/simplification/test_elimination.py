"""The order of elimination, the errors along it, and the least-squares refit."""

from __future__ import annotations

import numpy as np
from cases import candidate_sets, candidates_with, largest_error
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.simplification.elimination import eliminate
from strategies import examples


@examples(60)
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


@examples(60)
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


@examples(40)
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
