"""Motion and noise told apart, and the cut-off that leaves the least error of accelerations."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gd_analyze.motions.noise import Noise, best_cutoff
from gd_analyze.motions.smoothing import smoothed
from gd_analyze.motions.spectrum import Spectrum
from recordings import Motion, instants, rms

SECONDS = 20.0


def noise_in(time, x, rate, order=2):
    return Noise.of(Spectrum.of([time], [x], rate, order), min(30.0, 0.2 * rate), SECONDS)


def error_at(time, x, truth, cutoff):
    """Error of the accelerations, ends included."""
    found = smoothed(time, x, cutoff).derivative(2)(time)
    return float(rms((found - truth)[:, None])[0])


@pytest.mark.parametrize("rate", [125.0, 1000.0])
@pytest.mark.parametrize("deviation", [1e-5, 1e-4, 1e-3])
def test_the_rule_comes_close_to_the_best_cutoff_there_is(rate, deviation):
    time, motion = instants(rate, SECONDS), Motion.of(1, 1)
    truth = motion.at(time, 2)[:, 0]
    x = motion.at(time)[:, 0] + deviation * np.random.default_rng(2).normal(size=len(time))
    cutoff = best_cutoff([noise_in(time, x, rate)], min(30.0, 0.2 * rate))
    best = min(error_at(time, x, truth, tried) for tried in np.geomspace(0.5, min(30.0, 0.2 * rate), 40))
    # The error grows as f_c^2.5 with the noise and f_c^-6 with the motion: a cut-off 1.5 times off the best
    # costs up to 1.5^2.5 = 2.8.
    assert error_at(time, x, truth, cutoff) < 2.8 * best


def test_late_and_early_stamps_are_noise_too():
    """Positions read at other instants than stamped err by their rate: a spectrum that falls, not a floor."""
    rate, motion = 500.0, Motion.of(3, 1)
    time = instants(rate, SECONDS)
    late = np.cumsum(np.random.default_rng(4).normal(size=len(time))) * 2e-5
    x = motion.at(time + late)[:, 0]
    found = noise_in(time, x, rate)
    cutoff = best_cutoff([found], 30.0)
    assert cutoff < 15.0
    actual = smoothed(time, x - motion.at(time)[:, 0], cutoff).derivative(2)(time).std()
    # The law of such noise is fitted, not known.
    assert 0.5 < found.left(cutoff) / actual < 2.0


def test_two_frequencies_with_quiet_between_are_both_motion():
    rate = 500.0
    time = instants(rate, SECONDS)
    x = 0.3 * np.sin(2 * np.pi * 0.5 * time) + 2e-3 * np.sin(2 * np.pi * 8.0 * time)
    x += 1e-5 * np.random.default_rng(5).normal(size=len(time))
    assert best_cutoff([noise_in(time, x, rate)], 30.0) > 12.0


def test_readings_without_noise_have_the_highest_cutoff():
    time, motion = instants(100.0, SECONDS), Motion.of(6, 1)
    found = noise_in(time, motion.at(time)[:, 0], 100.0)
    assert best_cutoff([found], 20.0) > 10.0
    assert found.left(5.0) < 1e-3


def test_a_joint_at_rest_does_not_take_the_motion_from_others():
    rate, rng = 200.0, np.random.default_rng(7)
    time, motion = instants(rate, SECONDS), Motion.of(6, 1)
    moving = noise_in(time, motion.at(time)[:, 0] + 1e-4 * rng.normal(size=len(time)), rate)
    still = noise_in(time, 1e-4 * rng.normal(size=len(time)), rate)
    alone, together = best_cutoff([moving], 30.0), best_cutoff([moving, *[still] * 5], 30.0)
    # The noise of the five counts, as its expected square grows as f_c^5, by up to (1 + 5 * 100)^(1/5) = 3.5
    # where ends decide; the motion up to 1.4 Hz still passes.
    assert 2.0 < together <= alone


def test_a_joint_at_rest_has_a_low_cutoff():
    time = instants(200.0, SECONDS)
    x = 1e-4 * np.random.default_rng(7).normal(size=len(time))
    assert best_cutoff([noise_in(time, x, 200.0)], 30.0) < 1.0


@given(seed=st.integers(0, 10_000), rate=st.sampled_from([60.0, 125.0, 500.0]), fine=st.booleans())
@settings(max_examples=40)
def test_the_noise_left_is_what_is_stated(seed, rate, fine):
    """White noise of known size, motion of two joints drawn anew: the statement holds within a third."""
    rng = np.random.default_rng(seed)
    deviation = 1e-5 if fine else 3e-4
    time, motion = instants(rate, SECONDS), Motion.of(seed, 1)
    noise = deviation * rng.normal(size=len(time))
    found = noise_in(time, motion.at(time)[:, 0] + noise, rate)
    cutoff = 4.0
    omega = 2 * np.pi * cutoff
    exact = deviation * np.sqrt(omega**5 / rate / 18)
    # 20 s have 2 * 20 * 4 values of the pass band, twenty to fifty of which make the law that is fitted: its
    # level is known within some 15 % and its slope within 0.3, of which the sum takes an octave. What motion
    # of up to 1.4 Hz leaks beyond its band counts as noise.
    assert 0.7 < found.left(cutoff) / exact < 1.6


def test_a_spectrum_of_pieces_is_that_of_the_whole():
    rate, rng = 200.0, np.random.default_rng(8)
    time = instants(rate, 60.0)
    x = rng.normal(size=len(time))
    whole = Spectrum.of([time], [x], rate, 2)
    parts = Spectrum.of([time[:6000], time[6000:]], [x[:6000], x[6000:]], rate, 2)
    # White noise of variance 1 has the density 2 / rate (2 pi f)^4; twelve averaged pieces, wide windows.
    high = whole.frequency > 5.0
    expected = 2 / rate * (2 * np.pi * whole.frequency) ** 4
    for spectrum in (whole, parts):
        assert np.median(spectrum.density[high] / expected[high]) == pytest.approx(1.0, rel=0.1)
