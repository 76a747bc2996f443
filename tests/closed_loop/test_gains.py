"""The most error per unexpected acceleration, against the integral it stands for."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import trapezoid

from gd_analyze.studies.gains import Gains

# Steps of the sum below; the impulse response has a corner at every zero, and the rule an error of h^2 / 12
# times its slope's jumps: below 1e-6 of the integral.
STEPS = 400_001


def response(gains: Gains) -> tuple[np.ndarray, np.ndarray]:
    """Impulse response of e'' + K_d e' + K_p e, by the roots of its polynomial."""
    first, second = np.roots([1.0, gains.damper, gains.stiffness]).astype(complex)
    slowest = -max(first.real, second.real)
    time = np.linspace(0.0, 40.0 / slowest, STEPS)
    if abs(first - second) < 1e-4 * gains.bandwidth:  # critical: the roots are one
        return time, time * np.exp(-gains.bandwidth * time)
    return time, ((np.exp(first * time) - np.exp(second * time)) / (first - second)).real


@pytest.mark.parametrize("damping", [0.1, 0.5, 0.9, 1.0, 1.5, 4.0])
@pytest.mark.parametrize("bandwidth", [3.0, 20.0])
def test_the_integrals(bandwidth, damping):
    gains = Gains(bandwidth, damping)
    time, g = response(gains)
    assert gains.error_per_acceleration == pytest.approx(trapezoid(np.abs(g), time), rel=1e-5)
    assert gains.rate_per_acceleration == pytest.approx(np.abs(np.diff(g)).sum(), rel=1e-5)


def test_a_stationary_error_is_the_least_that_the_bound_can_be():
    """A constant acceleration a leaves e = a / w^2, so the bound is never below that."""
    for damping in np.linspace(0.05, 3.0, 40):
        gains = Gains(10.0, float(damping))
        assert gains.error_per_acceleration * gains.stiffness >= 1.0
    error, rate, acceleration = Gains(20.0, 1.0).margins
    # Critical damping: 1 / w^2, 2 / (e w), and 1 + 2 w times the second + 1.
    assert (error, rate) == pytest.approx((1 / 400, 2 / (np.e * 20)))
    assert acceleration == pytest.approx(2.0 + 4.0 / np.e)
