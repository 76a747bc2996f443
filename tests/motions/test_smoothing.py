"""The smoothing spline: its frequency response, its ends, uneven steps, and the noise that it leaves."""

from __future__ import annotations

import numpy as np
import pytest

from gd_analyze.motions.smoothing import noise_of, passed, smoothed


@pytest.mark.parametrize("share", [0.3, 0.7, 1.0, 1.6])
def test_sines_pass_with_the_stated_share_and_without_delay(share):
    cutoff, rate = 4.0, 200.0
    time = np.arange(0.0, 20.0, 1 / rate)
    omega = 2 * np.pi * share * cutoff
    through = smoothed(time, np.sin(omega * time), cutoff)(time)
    middle = slice(len(time) // 4, -len(time) // 4)
    factor = passed(np.array(share * cutoff), cutoff)
    # Knots an eighth of a period of the cut-off apart follow sines this fast within some 1e-3 of them.
    np.testing.assert_allclose(through[middle], factor * np.sin(omega * time[middle]), atol=2e-3)


def test_half_of_the_amplitude_passes_at_the_cutoff():
    assert passed(np.array(3.0), 3.0) == 0.5


@pytest.mark.parametrize("jitter", [0.0, 0.6])
def test_constant_acceleration_passes_unchanged_to_the_ends(jitter, rng):
    time = (np.arange(500) + jitter * rng.uniform(-0.5, 0.5, 500)) / 125
    spline = smoothed(time, 1.0 - 2.0 * time + 3.0 * time**2, 5.0)
    # A parabola has no third derivative to be penalised: rounding of values of 50, differentiated twice by
    # splines with 40 knots per second, 50 eps 40^2, times the condition of the equations, some thousands.
    np.testing.assert_allclose(spline.derivative(2)(time), 6.0, atol=1e-7)


def test_a_straight_line_in_dates_stays_straight():
    time = 1.7e9 + np.arange(1000) / 100
    spline = smoothed(time, 0.5 * (time - time[0]), 3.0)
    # Instants near 2^31 are exact to 2e-7 s, a relative 2e-5 of a step.
    np.testing.assert_allclose(spline.derivative(1)(time), 0.5, atol=1e-4)


def test_reversed_readings_give_the_reversed_curve(rng):
    time, values = np.arange(400) / 100, rng.normal(size=400)
    forth, back = smoothed(time, values, 5.0)(time), smoothed(time, values[::-1], 5.0)(time)
    # Only the grid of knots differs, which begins at the first reading.
    np.testing.assert_allclose(forth, back[::-1], atol=2e-2)


@pytest.mark.parametrize(("rate", "cutoff"), [(1000.0, 10.0), (125.0, 5.0), (30.0, 3.0)])
def test_white_noise_is_left_as_the_closed_forms_say(rate, cutoff, rng):
    time = np.arange(0.0, 20.0, 1 / rate)
    noise = rng.normal(size=(len(time), 60))
    spline, omega = smoothed(time, noise, cutoff), 2 * np.pi * cutoff
    middle = slice(len(time) // 5, -len(time) // 5)
    # Variance: dt times the integral of omega^(2 k) H^2, k derivatives. 60 noises of 12 s have some 12 * 60 *
    # cutoff independent values and tell a standard deviation within 4 / sqrt(2 * 720 * 3) = 6 %.
    for order, variance in ((1, omega**3 / 12), (2, omega**5 / 18)):
        found = spline.derivative(order)(time[middle]).std()
        assert found == pytest.approx(np.sqrt(variance / rate), rel=0.06)
    cutoffs = np.full(60, cutoff)
    np.testing.assert_allclose(noise_of(noise, spline(time), 1 / rate, cutoffs), 1.0, rtol=0.2)
    kept = noise_of(noise, spline(time), 1 / rate, cutoffs, left=True)
    assert kept.mean() == pytest.approx(spline(time).std(), rel=0.1)


def test_ends_are_no_wilder_than_a_few_times_the_middle(rng):
    time = np.arange(2000) / 200
    noise = rng.normal(size=(2000, 400))
    deviations = smoothed(time, noise, 5.0).derivative(2)(time).std(axis=1)
    # An integral over half of the kernel: 2.4 times the middle; 400 noises tell it within 15 %.
    assert deviations.max() < 2.9 * np.median(deviations)
