from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from gd_analyze.motions.derived_rates import FEWEST_SET_POINTS, complete_rates

EPS = np.finfo(float).eps


@given(
    arrays(float, (6, 2), elements=st.floats(-1.0, 1.0)),
    st.integers(FEWEST_SET_POINTS, 40),
    st.floats(0.01, 10.0),
)
def test_quintic_motions_are_differentiated_exactly(
    coefficients: np.ndarray, n_set_points: int, duration: float
) -> None:
    # The spline with not-a-knot ends contains every quintic, so only round-off is left: coefficients of up
    # to 1, divided by h per derivative; the banded system of a quintic spline has a condition below 1e5.
    x = np.linspace(0.0, 1.0, n_set_points)
    q, qd, qdd = (
        np.stack([np.polyval(np.polyder(c, order) if order else c, x) for c in coefficients.T], axis=1)
        / duration**order
        for order in range(3)
    )
    found_qd, found_qdd, _ = complete_rates(x * duration, q, None, None)
    h = duration / (n_set_points - 1)
    assert np.abs(found_qd - qd).max() <= 1e5 * EPS * 6 / h
    assert np.abs(found_qdd - qdd).max() <= 1e5 * EPS * 6 / h**2


def test_accelerations_converge_with_the_fourth_order() -> None:
    errors = []
    for n in (50, 100, 200):
        time = np.linspace(0.3, 4.3, n + 1)
        q = np.sin(2 * time)[:, None]
        _, qdd, _ = complete_rates(time, q, None, None)
        errors.append(np.abs(qdd + 4 * q).max())
    # 2^4 per halving in the limit; the next term of the series may take a quarter of it.
    assert errors[0] / errors[1] > 12
    assert errors[1] / errors[2] > 12


def test_a_clock_that_counts_from_1970_costs_nothing() -> None:
    # Steps of 1/64 s and a whole number of seconds add without rounding: the results are the same bits.
    time = np.arange(50) / 64
    q = np.sin(3 * time)[:, None]
    plain = complete_rates(time, q, None, None)
    shifted = complete_rates(time + 1.7e9, q, None, None)
    np.testing.assert_array_equal(plain[0], shifted[0])
    np.testing.assert_array_equal(plain[1], shifted[1])


def test_given_rates_are_kept_and_differentiated() -> None:
    time = np.linspace(0.0, 1.0, 21)
    qd = (time**5 - time**2)[:, None]
    noisy_q = np.random.default_rng(0).normal(size=(21, 1))
    kept, qdd, said = complete_rates(time, noisy_q, qd, None)
    np.testing.assert_array_equal(kept, qd)
    # A quintic again: condition 1e5, values of up to 1, divided by h once.
    np.testing.assert_allclose(qdd[:, 0], 5 * time**4 - 2 * time, atol=1e5 * EPS * 20)
    assert said == "qdd derived: C4 (quintic) spline through the given qd"


def test_given_accelerations_are_kept() -> None:
    time = np.linspace(0.0, 1.0, 21)
    q, qdd = (time**3)[:, None], (6 * time)[:, None]
    qd, kept, said = complete_rates(time, q, None, qdd)
    np.testing.assert_array_equal(kept, qdd)
    np.testing.assert_allclose(qd[:, 0], 3 * time**2, atol=1e5 * EPS * 20)
    assert said.startswith("qd derived")


def test_complete_trajectories_are_left_alone() -> None:
    time, values = np.arange(2.0), np.zeros((2, 1))
    qd, qdd, said = complete_rates(time, values, values, values)
    assert qd is values
    assert qdd is values
    assert said == "given"


def test_what_was_derived_is_said() -> None:
    time = np.linspace(0.0, 1.0, 6)
    *_, said = complete_rates(time, np.zeros((6, 1)), None, None)
    assert said == "qd and qdd derived: C4 (quintic) spline through the given q"
