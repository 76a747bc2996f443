"""Friction fitted beside the model: what was put in comes out, with errors that are as large as they say."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.signal import butter, sosfiltfilt

from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.friction import correlation_time
from gd_analyze.dynamics.measured_torque import compare_torque
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from recorded_logs import CUTOFF, friction_of, recorded, swinging, with_torques
from strategies import examples

GIVEN = (1.5, 0.7, -0.4)


@given(
    coulomb=st.floats(0.0, 20.0),
    viscous=st.floats(0.0, 20.0),
    offset=st.floats(-20.0, 20.0),
    gaps=st.sampled_from([(), (200,), (120, 121, 380)]),
)
@examples(25)
def test_without_noise_it_is_what_was_put_in(
    puma: RobotArm, coulomb: float, viscous: float, offset: float, gaps: tuple[int, ...]
) -> None:
    log = recorded(puma, friction=(coulomb, viscous, offset), gaps=gaps)
    friction = compare_torque(puma, log).friction
    # Least squares by QR err by eps times the condition of the three columns, at most some 30 here, times
    # the largest of what was measured, at most 300 N m, times the square root of some 500 readings.
    allowed = 300.0 * 30.0 * np.sqrt(500.0) * np.finfo(float).eps
    np.testing.assert_allclose(friction.terms, np.tile([coulomb, viscous, offset], (6, 1)), atol=allowed)
    assert (friction.rms <= allowed).all()
    assert (friction.explained > 1.0 - 1e-9).all()


def smoothed(values: np.ndarray) -> np.ndarray:
    return sosfiltfilt(butter(2, CUTOFF, fs=125.0, output="sos"), values, axis=0)


@pytest.mark.parametrize("alike", [False, True], ids=["white noise", "filtered noise"])
def test_standard_errors_are_as_large_as_the_errors_are(two_link: RobotArm, alike: bool) -> None:
    """Errors over standard errors have the variance 1, whether or not neighbouring readings are alike."""
    motion = swinging(two_link, 2000)
    clean = torque_of(two_link, states_of(motion)) + friction_of(motion, *GIVEN)
    scores = []
    for seed in range(60):
        noise = np.random.default_rng(seed).normal(size=clean.shape)
        log = with_torques(motion, clean + (smoothed(noise) if alike else noise))
        fitted = compare_torque(two_link, log).friction
        scores.append((fitted.terms - GIVEN) / fitted.errors)
    # 60 logs of two joints: the mean square of a term's 120 scores is 1 +- sqrt(2 / 120) = 0.13 where errors
    # are as they should; 4 of these upwards. Downwards a half more is room for what the correlation time is
    # too long: velocities, which change as slowly as the motion, but a sign is as fast as can be.
    of_terms = np.mean(np.square(scores), axis=(0, 1))
    assert (of_terms < 1.0 + 4 * 0.13).all(), of_terms
    assert (of_terms > 0.3).all(), of_terms


def test_friction_that_would_drive_is_held_at_zero(two_link: RobotArm) -> None:
    fitted = compare_torque(two_link, recorded(two_link, friction=(2.0, -0.3, 0.5), noise=0.1)).friction
    assert (fitted.terms[:, 1] == 0.0).all()
    assert np.isnan(fitted.errors[:, 1]).all()
    assert (fitted.terms[:, 0] >= 0.0).all()
    assert np.isfinite(fitted.errors[:, [0, 2]]).all()


def one_way(motion: Trajectory, velocities: np.ndarray) -> Trajectory:
    """The second joint only ever moves forwards."""
    qd, qdd, q = motion.qd.copy(), motion.qdd.copy(), motion.q.copy()
    qd[:, 1], qdd[:, 1] = velocities, np.gradient(velocities, motion.time)
    q[:, 1] = np.cumsum(velocities) * (motion.time[1] - motion.time[0])
    return replace(motion, q=q, qd=qd, qdd=qdd)


def test_one_direction_does_not_tell_coulomb_friction_from_an_offset(two_link: RobotArm) -> None:
    motion = swinging(two_link)
    motion = one_way(motion, 0.6 + 0.3 * np.sin(4.0 * motion.time))
    torque = torque_of(two_link, states_of(motion)) + friction_of(motion, *GIVEN)
    fitted = compare_torque(two_link, with_torques(motion, torque)).friction
    np.testing.assert_allclose(fitted.terms[0], GIVEN, atol=1e-9)
    assert np.isnan(fitted.terms[1, 0])
    # Both at once make a constant torque; round-off is as above.
    np.testing.assert_allclose(fitted.terms[1, 1:], [GIVEN[1], GIVEN[2] + GIVEN[0]], atol=1e-9)


def test_one_speed_tells_nothing_of_viscous_friction(two_link: RobotArm) -> None:
    motion = swinging(two_link)
    motion = one_way(motion, np.full(motion.n_set_points, 0.5))
    torque = torque_of(two_link, states_of(motion)) + friction_of(motion, *GIVEN)
    fitted = compare_torque(two_link, with_torques(motion, torque)).friction
    assert np.isnan(fitted.terms[1, :2]).all()
    np.testing.assert_allclose(fitted.terms[1, 2], GIVEN[0] + 0.5 * GIVEN[1] + GIVEN[2], atol=1e-9)


def test_a_joint_at_rest_has_an_offset_alone(two_link: RobotArm) -> None:
    motion = swinging(two_link)
    motion = one_way(motion, np.zeros(motion.n_set_points))
    torque = torque_of(two_link, states_of(motion)) + np.array([0.0, 2.5])
    comparison = compare_torque(two_link, with_torques(motion, torque))
    assert np.isnan(comparison.friction.terms[1, :2]).all()
    np.testing.assert_allclose(comparison.friction.terms[1, 2], 2.5, atol=1e-9)


def test_readings_near_rest_and_just_after_reversals_do_not_count(two_link: RobotArm) -> None:
    """There friction may be anything, and the filter spreads its jump: whatever is read changes nothing."""
    motion = swinging(two_link)
    torque = torque_of(two_link, states_of(motion)) + friction_of(motion, *GIVEN)
    turns = np.diff(np.sign(motion.qd), axis=0) != 0
    near = np.zeros_like(torque, dtype=bool)
    for row, joint in np.argwhere(turns):
        near[:, joint] |= np.abs(motion.time - motion.time[row]) < 0.4 / CUTOFF
    spoilt = np.where(near, torque + 3.0, torque)
    fitted = compare_torque(two_link, with_torques(motion, spoilt, CUTOFF)).friction
    np.testing.assert_allclose(fitted.terms, np.tile(GIVEN, (2, 1)), atol=1e-9)


def test_noise_of_velocities_widens_what_counts_as_rest(two_link: RobotArm) -> None:
    """Below three standard deviations of its noise a rate's sign is chance."""
    motion = swinging(two_link)
    torque = torque_of(two_link, states_of(motion)) + friction_of(motion, *GIVEN)
    noise = 0.1
    slow = np.abs(motion.qd) < 3 * noise
    log = with_torques(motion, np.where(slow, torque - 2.0, torque))
    # The root of the product of both is the noise of the velocities.
    recording = replace(log.recording, noise_q=np.full(2, noise / 4), noise_qdd=np.full(2, noise * 4))
    fitted = compare_torque(two_link, replace(log, recording=recording)).friction
    np.testing.assert_allclose(fitted.terms, np.tile(GIVEN, (2, 1)), atol=1e-9)


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
