"""How many readings make an independent one: of series whose answer is known."""

from __future__ import annotations

import numpy as np
import pytest

from gd_analyze.dynamics.friction import correlation_time


def autoregressive(alike: float, count: int, seed: int = 0) -> np.ndarray:
    """x_k = alike x_(k - 1) + noise: correlations alike^k, so (1 + alike) / (1 - alike) readings."""
    noise = np.random.default_rng(seed).normal(size=count)
    out = np.empty(count)
    out[0] = noise[0] / np.sqrt(1 - alike**2)
    for k in range(1, count):
        out[k] = alike * out[k - 1] + noise[k]
    return out


@pytest.mark.parametrize("alike", [0.0, 0.5, 0.9])
def test_of_a_series_that_resembles_itself(alike: float) -> None:
    series = autoregressive(alike, 100_000)
    found = correlation_time(lambda at: series[at], np.ones(100_000, bool), [slice(0, 100_000)])
    # Sokal (1997), Eq. (3.19): the relative error is sqrt(2 (2 W + 1) / N) with a window of W = 5 correlation
    # times, at most 100 readings here: 0.06; three times that.
    assert found == pytest.approx((1 + alike) / (1 - alike), rel=0.2)


def test_what_was_left_out_and_gaps_change_little() -> None:
    series = autoregressive(0.8, 60_000)
    used = np.random.default_rng(1).uniform(size=60_000) < 0.8
    stretches = [slice(0, 20_000), slice(20_000, 20_001), slice(20_001, 60_000)]
    found = correlation_time(lambda at: series[at], used, stretches)
    assert found == pytest.approx(9.0, rel=0.2)


def test_never_less_than_one() -> None:
    alternating = np.resize([1.0, -1.0], 1000)
    everything, whole = np.ones(1000, bool), [slice(0, 1000)]
    assert correlation_time(lambda at: alternating[at], everything, whole) == 1.0
    assert correlation_time(lambda at: 0.0 * alternating[at], everything, whole) == 1.0
    assert correlation_time(lambda at: alternating[at], ~everything, whole) == 1.0
