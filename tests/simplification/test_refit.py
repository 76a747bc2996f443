"""Refitted coefficients: the least largest error, and whether a limit can be held at all."""

from __future__ import annotations

import numpy as np
from cases import candidate_sets, candidates_with, largest_error
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.simplification.effort import Work
from gd_analyze.simplification.refit import Refit
from strategies import examples


@examples(60)
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


@examples(30)
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
