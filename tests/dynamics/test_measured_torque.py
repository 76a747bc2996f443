"""Measured torque beside the exact one: numbers of known differences, and friction put in."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

import gd_analyze as gd
from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.friction import correlation_time
from gd_analyze.types import RobotArm
from recordings import CUTOFF, friction_of, recorded, swinging, with_torques
from strategies import examples

GIVEN = (1.5, 0.7, -0.4)

# Round-off of sums of 500 terms, of torques up to some 1000 N m with offsets of 100, relative to the spread
# of the smallest, some 10: below eps * 500 * 1000 / 10.
CLOSE = 1e-9


def exact_of(arm: RobotArm, motion: Trajectory) -> FloatArray:
    return gd.types.ArmDynamics(arm).torque(motion.q, motion.qd, motion.qdd)


@given(gain=st.floats(0.1, 10.0), offset=st.floats(-100.0, 100.0), sign=st.sampled_from([-1.0, 1.0]))
@examples(30)
def test_a_gain_and_an_offset(two_link, gain, offset, sign):
    motion = swinging(two_link)
    exact = exact_of(two_link, motion)
    left = (sign * gain - 1.0) * exact + offset
    found = gd.compare_torque(two_link, with_torques(motion, exact + left))
    for name, wanted in {
        "bias": left.mean(axis=0),
        "rms": np.sqrt((left**2).mean(axis=0)),
        "explained": 1.0 - (1.0 - sign / gain) ** 2,
        "peak_measured": np.abs(exact + left).max(axis=0),
    }.items():
        np.testing.assert_allclose(getattr(found, name), wanted, rtol=CLOSE, atol=CLOSE)


def test_a_joint_without_readings_is_left_out(puma):
    log = recorded(puma)  # torques of the links and of the drives
    torque = log.recording.torque.copy()
    torque[:, 1], torque[:, 4] = 0.0, np.nan
    found, whole = gd.compare_torque(puma, with_torques(log, torque)), gd.compare_torque(puma, log)
    for name in ("bias", "rms", "explained", "peak_measured"):
        values = getattr(found, name)
        assert np.isnan(values[[1, 4]]).all(), name
        same = [0, 2, 3, 5]
        np.testing.assert_allclose(values[same], getattr(whole, name)[same], atol=CLOSE)
    np.testing.assert_allclose(whole.rms, 0.0, atol=CLOSE)
    assert (gd.compare_torque(puma, log, drives=False).rms > 1e-3).all()


def test_set_points_without_a_reading_or_near_the_filters_ends_do_not_count(two_link):
    """At both ends of a recording and of its gaps, for half a period of the cut-off."""
    motion, cutoff = swinging(two_link, gaps=(200,)), 5.0
    torque = exact_of(two_link, motion)
    torque[100:150, 0] = np.nan
    found = gd.compare_torque(two_link, with_torques(motion, torque))
    assert found.compared == 500
    np.testing.assert_allclose(found.rms, 0.0, atol=CLOSE)
    for end in (0, 199, 200, 499):
        torque[np.abs(motion.time - motion.time[end]) < 0.49 / cutoff] += 1000.0
    found = gd.compare_torque(two_link, with_torques(motion, torque, cutoff))
    np.testing.assert_allclose(found.rms, 0.0, atol=CLOSE)
    # 0.1 s at 125 Hz, 13 readings at each of the four ends.
    assert found.compared == 500 - 4 * 13


def test_motions_without_torques_are_refused(puma, pick_and_place):
    log = recorded(puma)
    silent = replace(log, recording=replace(log.recording, torque=None))
    for motion, found in ((pick_and_place, "a plan"), (silent, "a recording without torques")):
        with pytest.raises(gd.GdAnalyzeError) as caught:
            gd.compare_torque(puma, motion)
        assert caught.value.details["found"] == found


# Friction: what was put in comes out, with errors that are as large as they say.


@pytest.mark.parametrize("gaps", [(), (200,), (120, 121, 380)])
@given(coulomb=st.floats(0.0, 20.0), viscous=st.floats(0.0, 20.0), offset=st.floats(-20.0, 20.0))
@examples(12)
def test_without_noise_friction_is_what_was_put_in(puma, coulomb, viscous, offset, gaps):
    log = recorded(puma, friction=(coulomb, viscous, offset), gaps=gaps)
    friction = gd.compare_torque(puma, log).friction
    # Least squares by QR err by eps times the condition of the three columns, at most some 30 here, times
    # the largest of what was measured, at most 300 N m, times the square root of some 500 readings.
    allowed = 300.0 * 30.0 * np.sqrt(500.0) * np.finfo(float).eps
    np.testing.assert_allclose(friction.terms, np.tile([coulomb, viscous, offset], (6, 1)), atol=allowed)
    assert (friction.rms <= allowed).all()
    assert (friction.explained > 1.0 - 1e-9).all()


@pytest.mark.parametrize("alike", [False, True], ids=["white noise", "filtered noise"])
def test_standard_errors_are_as_large_as_the_errors_are(two_link, alike):
    """Errors over standard errors have the variance 1, whether or not neighbouring readings are alike."""
    motion, low_pass = swinging(two_link, 2000), butter(2, CUTOFF, fs=125.0, output="sos")
    clean = exact_of(two_link, motion) + friction_of(motion, *GIVEN)
    scores = []
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(size=clean.shape)
        noise = sosfiltfilt(low_pass, noise, axis=0) if alike else noise
        fitted = gd.compare_torque(two_link, with_torques(motion, clean + noise)).friction
        scores.append((fitted.terms - GIVEN) / fitted.errors)
    # The mean square of a term's 120 scores is 1 +- sqrt(2 / 120) = 0.13 where errors are as they should; 4
    # of these upwards. Downwards there is room for a correlation time that is too long, as of a sign's.
    of_terms = np.mean(np.square(scores), axis=(0, 1))
    assert (of_terms < 1.0 + 4 * 0.13).all(), of_terms
    assert (of_terms > 0.3).all(), of_terms


def test_friction_that_would_drive_is_held_at_zero(two_link):
    fitted = gd.compare_torque(two_link, recorded(two_link, friction=(2.0, -0.3, 0.5), noise=0.1)).friction
    assert (fitted.terms[:, 1] == 0.0).all()
    assert (np.isfinite(fitted.errors) == [True, False, True]).all()


@pytest.mark.parametrize(
    ("steady", "swing", "wanted"),
    [
        # One direction does not tell Coulomb friction from an offset, one speed nothing of viscous friction.
        (0.6, 0.3, [np.nan, GIVEN[1], GIVEN[0] + GIVEN[2]]),
        (0.5, 0.0, [np.nan, np.nan, GIVEN[0] + 0.5 * GIVEN[1] + GIVEN[2]]),
        (0.0, 0.0, [np.nan, np.nan, GIVEN[2]]),
    ],
    ids=["one way", "one speed", "at rest"],
)
def test_motions_that_do_not_tell_all_terms(two_link, steady, swing, wanted):
    motion = swinging(two_link)
    qd = motion.qd.copy()
    qd[:, 1] = steady + swing * np.sin(4.0 * motion.time)
    motion = replace(motion, qd=qd)
    torque = exact_of(two_link, motion) + friction_of(motion, *GIVEN)
    fitted = gd.compare_torque(two_link, with_torques(motion, torque)).friction
    np.testing.assert_allclose(fitted.terms, [GIVEN, wanted], atol=CLOSE)


def test_readings_near_rest_and_just_after_reversals_do_not_count(two_link):
    """There friction may be anything, and the filter spreads its jump: whatever is read changes nothing."""
    motion = swinging(two_link)
    torque = exact_of(two_link, motion) + friction_of(motion, *GIVEN)
    near = np.zeros_like(torque, dtype=bool)
    for row, joint in np.argwhere(np.diff(np.sign(motion.qd), axis=0) != 0):
        near[:, joint] |= np.abs(motion.time - motion.time[row]) < 0.4 / CUTOFF
    spoilt = with_torques(motion, np.where(near, torque + 3.0, torque), CUTOFF)
    # Below three standard deviations of its noise a velocity's sign is chance; the root of the product of the
    # other two is the noise of the velocities.
    noise = 0.1
    noisy = with_torques(motion, np.where(np.abs(motion.qd) < 3 * noise, torque - 2.0, torque))
    told = replace(noisy.recording, noise_q=np.full(2, noise / 4), noise_qdd=np.full(2, noise * 4))
    for log in (spoilt, replace(noisy, recording=told)):
        fitted = gd.compare_torque(two_link, log).friction
        np.testing.assert_allclose(fitted.terms, np.tile(GIVEN, (2, 1)), atol=CLOSE)


@pytest.mark.parametrize("gaps", [False, True])
@pytest.mark.parametrize("alike", [0.0, 0.5, 0.9])
def test_readings_per_independent_one(alike, gaps):
    """x_k = alike x_(k - 1) + noise: correlations alike^k, so (1 + alike) / (1 - alike) readings."""
    count, rng = 100_000, np.random.default_rng(0)
    series = rng.normal(size=count)
    series[0] /= np.sqrt(1 - alike**2)
    for k in range(1, count):
        series[k] += alike * series[k - 1]
    used = rng.uniform(size=count) < (0.8 if gaps else 1.0)
    stretches = [slice(0, 20_000), slice(20_000, 20_001), slice(20_001, count)] if gaps else [slice(0, count)]
    # Sokal (1997), Eq. (3.19): the relative error is sqrt(2 (2 W + 1) / N) with a window of W = 5 correlation
    # times, at most 100 readings here: 0.06; three times that.
    found = correlation_time(lambda at: series[at], used, stretches)
    assert found == pytest.approx((1 + alike) / (1 - alike), rel=0.2)


def test_never_less_than_one_reading_per_independent_one():
    series = np.resize([1.0, -1.0], 1000)
    assert correlation_time(lambda at: series[at], np.ones(1000, bool), [slice(0, 1000)]) == 1.0
