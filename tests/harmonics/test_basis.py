"""Basis functions: which runs and modes there are, and that derivatives are derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from harmonic_arms import arm_of, arms_with_runs, states_of
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.harmonics import Basis, Series
from strategies import examples


def random_series(basis: Basis, rng: np.random.Generator, count: int = 12) -> Series:
    total = int(np.prod(basis.sizes))
    ids = np.unique(rng.integers(0, total, count))
    return Series(basis, ids, rng.normal(size=len(ids)))


@examples(30)
@given(arms_with_runs(max_joints=5), st.integers(0, 2**32 - 1))
def test_derivatives_against_central_differences(arm, seed):
    rng = np.random.default_rng(seed)
    series = random_series(Basis.of(arm), rng)
    q = states_of(arm, 4, seed).q.T
    step = 1e-4
    for joint in range(arm.n_joints):
        shift = step * np.eye(arm.n_joints)[:, [joint]]
        difference = (series(q + shift) - series(q - shift)) / (2 * step)
        # step^2 / 6 times the third derivative, at most 2^3 of the function (a power has none), and eps /
        # step from the difference: 1.4e-8 and 1e-12 of the sum of magnitudes. Powers near 1 may exceed 1.
        allowed = 3e-8 * 1.01 ** (2 * arm.n_joints) * series.size
        np.testing.assert_allclose(series.derivative(joint)(q), difference, rtol=0, atol=allowed)


@examples(20)
@given(arms_with_runs(max_joints=4), st.integers(0, 2**32 - 1))
def test_second_derivatives_commute(arm, seed):
    series = random_series(Basis.of(arm), np.random.default_rng(seed))
    for a in range(arm.n_joints):
        for b in range(a):
            one, other = series.derivative(a).derivative(b), series.derivative(b).derivative(a)
            np.testing.assert_array_equal(one.ids, other.ids)
            # Factors are small whole numbers; sums of equal functions may be added in another order.
            np.testing.assert_allclose(one.coefficients, other.coefficients, rtol=1e-13, atol=1e-14)


@pytest.mark.parametrize(
    ("turns", "runs", "directions"),
    [
        (["same"] * 3, [(0, 1, 2)], [(1, 1, 1)]),
        (["same", "opposite", "same", "opposite"], [(0, 1, 2, 3)], [(1, -1, -1, 1)]),
        (["askew", "same", "askew"], [(0, 1), (2,)], [(1, 1), (1,)]),
        (["same", "slides", "same", "same"], [(0,), (1,), (2, 3)], [(1,), (1,), (1, 1)]),
        (["slides", "slides"], [(0,), (1,)], [(1,), (1,)]),
    ],
)
def test_runs(turns, runs, directions, rng):
    basis = Basis.of(arm_of(turns, rng))
    assert [run.joints for run in basis.runs] == runs
    assert [run.directions for run in basis.runs] == directions
    assert basis.run_of == tuple(r for r, joints in enumerate(runs) for _ in joints)


def test_modes_of_a_run_grow_as_its_square(rng):
    for m in range(1, 9):
        (run,) = Basis.of(arm_of(["same"] * m, rng)).runs
        assert len(run.modes) == 1 + 2 * (m * m + m)
        arguments = [mode.multiples for mode in run.modes[1::2]]
        # One of a and -a, or the functions would not be independent.
        assert len({max(k, tuple(-x for x in k)) for k in arguments}) == len(arguments)


def test_functions_are_independent(rng):
    basis = Basis.of(arm_of(["same", "opposite", "slides"], rng))
    ids = np.arange(int(np.prod(basis.sizes)))
    values = basis.evaluate(ids, rng.uniform(-2, 2, (3, 4 * len(ids))))
    assert np.linalg.matrix_rank(values) == len(ids)


def test_factors_other_than_one(rng):
    basis = Basis.of(arm_of(["askew", "slides"], rng))
    assert basis.modes(0) == ()
    (run, mode), (sliding, power) = basis.modes(int(np.prod(basis.sizes)) - 1)
    assert (run.joints, mode.kind, mode.multiples) == ((0,), "sin", (2,))
    assert (sliding.joints, power.kind, power.multiples) == ((1,), "power", (2,))
