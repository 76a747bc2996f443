"""From a log to a motion: errors against a motion known exactly, and what is stated of them."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError, UsageError
from gd_analyze.motions.cutoff import Noise, Source
from gd_analyze.motions.logged import Logged
from gd_analyze.motions.reading import Treatment
from gd_analyze.motions.smoothing import smoothed
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.velocities import completed
from recordings import Motion, instants, readings, rms

SECONDS = 15.0


def log_of(motion, rate=125.0, deviation=1e-4, jitter=0.0, seed=0, **more):
    time = instants(rate, SECONDS, jitter, seed)
    noise = np.random.default_rng(seed).normal(size=(len(time), 2))
    return readings(time, motion.at(time) + deviation * noise, **more)


@pytest.mark.parametrize(("rate", "jitter"), [(1000.0, 0.0), (125.0, 0.0), (125.0, 0.5), (30.0, 0.06)])
def test_accelerations_come_near_the_true_ones(rate, jitter):
    motion = Motion.of(1)
    found = Trajectory.from_log(log_of(motion, rate, jitter=jitter), None)
    truth = motion.at(found.time, 2)
    # Noise and the motion that is taken for it count alike at the best cut-off, and ends have 2.4 times the
    # noise: three times the noise stated are room for both.
    assert (rms(found.qdd - truth) < 3 * found.recording.noise_qdd).all()
    assert (rms(found.qd - motion.at(found.time, 1)) < 0.01 * rms(motion.at(found.time, 1))).all()
    assert (rms(found.qdd - truth) < 0.1 * rms(truth)).all()
    # Ten times better than a spline through the readings.
    raw = completed(found.time, found.recording.q, None, None)[1]
    assert (rms(found.qdd - truth) < 0.1 * rms(raw - truth)).all()


@given(seed=st.integers(0, 10_000))
@settings(max_examples=15)
def test_errors_are_within_what_is_stated(seed):
    motion = Motion.of(seed)
    found = Trajectory.from_log(log_of(motion, seed=seed), None)
    error = rms(found.qdd - motion.at(found.time, 2))
    # As above; from below, the statement is no idle one: within a factor of five of the error.
    assert (error < 3 * found.recording.noise_qdd).all()
    assert (error > 0.2 * found.recording.noise_qdd).all()
    # The readings' noise is known within its estimate's scatter: 1875 values.
    np.testing.assert_allclose(found.recording.noise_q, 1e-4, rtol=0.1)


def test_motion_too_fast_for_the_readings_warns():
    time = instants(30.0, SECONDS)
    q = 0.3 * np.sin(2 * np.pi * 0.5 * time) + 2e-3 * np.sin(2 * np.pi * 8.0 * time)
    noise = 1e-5 * np.random.default_rng(1).normal(size=(len(time), 2))
    log = readings(time, np.column_stack([q, 0.3 * np.sin(time)]) + noise)
    with pytest.warns(GdAnalyzeWarning, match="above 6.00 Hz.*joint 1"):
        Trajectory.from_log(log, None)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        Trajectory.from_log(readings(time, log.q[:, 1:]), None)


def test_it_is_the_same_every_time():
    log = log_of(Motion.of(2))
    assert Trajectory.from_log(log, None).fingerprint == Trajectory.from_log(log, None).fingerprint


def test_every_reading_is_a_set_point_and_kept_as_read():
    log = log_of(Motion.of(2))
    found = Trajectory.from_log(log, None)
    assert (found.time == log.time).all()
    assert (found.recording.q == log.q).all()
    assert found.recording.measured
    assert found.derived == ("qd", "qdd")


def test_a_given_cutoff_is_taken():
    found = Trajectory.from_log(log_of(Motion.of(2)), None, Treatment(cutoff=3.0))
    assert found.recording.cutoff.tolist() == [3.0, 3.0]
    assert "cut-off 3.00 Hz (as asked for)" in found.derivatives_from
    both = Trajectory.from_log(log_of(Motion.of(2)), None, Treatment(cutoff=(3.0, 6.0)))
    assert both.recording.cutoff.tolist() == [3.0, 6.0]
    # Noise grows as f_c^2.5: 5.7 times; its estimates scatter.
    assert 4.0 < both.recording.noise_qdd[1] / both.recording.noise_qdd[0] < 8.0


@pytest.mark.parametrize(
    ("cutoff", "message", "found"),
    [(40.0, "too high for so few readings", "40.0 Hz"), ((1.0, 2.0, 3.0), "wrong number of cut-offs", "3")],
)
def test_cutoffs_that_do_not_suit_are_refused(cutoff, message, found):
    with pytest.raises(TrajectoryError, match=message) as error:
        Trajectory.from_log(log_of(Motion.of(2)), None, Treatment(cutoff=cutoff))
    assert error.value.details["where"] == "--cutoff"
    assert error.value.details["found"] == found


@pytest.mark.parametrize("wrong", [{"cutoff": 0.0}, {"cutoff": (1.0, float("nan"))}, {"largest_gap": -1.0}])
def test_treatments_that_cannot_be_are_refused(wrong):
    with pytest.raises(UsageError, match=f"impossible {next(iter(wrong))}"):
        Treatment(**wrong)


def test_of_another_number_of_joints_is_refused(puma):
    with pytest.raises(TrajectoryError, match="the log does not fit arm puma560") as error:
        Trajectory.from_log(log_of(Motion.of(2)), puma)
    assert error.value.details["expected"] == "6 joints"


def test_nothing_is_smoothed_across_a_gap():
    motion = Motion.of(3)
    log = log_of(motion)
    kept = (log.time < 6.0) | (log.time > 9.0)
    first, last = log.time < 6.0, log.time > 9.0
    both = Trajectory.from_log(readings(log.time[kept], log.q[kept]), None, Treatment(cutoff=5.0))
    assert both.gaps == (np.count_nonzero(first),)
    parts = [readings(log.time[part], log.q[part]) for part in (first, last)]
    alone = [Trajectory.from_log(part, None, Treatment(cutoff=5.0)) for part in parts]
    for name in ("q", "qd", "qdd"):
        np.testing.assert_array_equal(
            getattr(both, name), np.concatenate([getattr(one, name) for one in alone])
        )


def test_measured_velocities_are_used_where_they_are_quieter():
    motion = Motion.of(4)
    log = log_of(motion, deviation=1e-3)
    qd = motion.at(log.time, 1) + 1e-4 * np.random.default_rng(9).normal(size=log.q.shape)
    found = Trajectory.from_log(replace(log, qd=qd), None)
    assert found.derived == ("qdd",)
    assert "from the measured velocities" in found.derivatives_from
    assert (found.recording.noise_qdd < Trajectory.from_log(log, None).recording.noise_qdd).all()
    error = rms(found.qdd - motion.at(found.time, 2))
    assert (error < 3 * found.recording.noise_qdd).all()
    positions = Trajectory.from_log(replace(log, qd=qd), None, Treatment(use_velocities=False))
    assert positions.derived == ("qd", "qdd")


def test_measured_velocities_that_are_noisier_are_not_used():
    motion = Motion.of(4)
    log = log_of(motion, deviation=1e-6)
    qd = motion.at(log.time, 1) + 0.05 * np.random.default_rng(9).normal(size=log.q.shape)
    assert "from the measured positions" in Trajectory.from_log(replace(log, qd=qd), None).derivatives_from


def test_measured_velocities_that_contradict_the_positions_warn_and_are_not_used():
    motion = Motion.of(4)
    log = log_of(motion)
    with pytest.warns(GdAnalyzeWarning, match="57.3 times the derivative of q.*are not used"):
        found = Trajectory.from_log(replace(log, qd=np.degrees(motion.at(log.time, 1))), None)
    assert found.derived == ("qd", "qdd")


def test_torques_pass_the_same_filter_and_may_lack_cells():
    motion = Motion.of(5)
    log = log_of(motion)
    torque = motion.at(log.time, 2)
    torque[100:103] = np.nan
    found = Trajectory.from_log(replace(log, torque=torque), None, Treatment(cutoff=6.0)).recording
    assert np.isnan(found.torque[100:103]).all()
    assert np.isfinite(found.torque_filtered).all()
    # As the accelerations themselves: both are sines, whose shares H are above 1 - (1.4 / 6)^6 = 0.9998.
    truth = motion.at(log.time, 2)
    assert (rms(found.torque_filtered - truth) < 0.02 * rms(truth)).all()


def test_a_plan_is_not_smoothed():
    motion = Motion.of(6)
    log = log_of(motion, measured=False)
    found = Trajectory.from_log(log, None)
    assert (found.q == log.q).all()
    assert not found.recording.measured
    assert found.derivatives_from == "qd and qdd derived: C4 (quintic) spline through the given q"


def test_given_accelerations_are_smoothed_too():
    motion = Motion.of(7)
    log = log_of(motion)
    noise = 0.05 * np.random.default_rng(1).normal(size=log.q.shape)
    log = replace(log, qd=motion.at(log.time, 1), qdd=motion.at(log.time, 2) + noise)
    found = Trajectory.from_log(log, None, Treatment(cutoff=5.0))
    error = rms(found.qdd - motion.at(found.time, 2))
    assert (error < 3 * found.recording.noise_qdd).all()
    assert (found.recording.noise_qdd < 0.05).all()
    assert found.derived == ()


def test_wrapped_angles_are_unwrapped_for_an_arm_without_limits(two_link):
    free = replace(two_link, joints=tuple(replace(j, lower=None, upper=None) for j in two_link.joints))
    time = instants(125.0, 10.0)
    q = np.column_stack([time, -0.5 * time])
    wrapped = (q + np.pi) % (2 * np.pi) - np.pi
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        found = Trajectory.from_log(readings(time, wrapped), free)
    np.testing.assert_allclose(found.q, q, atol=1e-9)
    # A straight line stays one; eps of 10 rad through splines of 4 to 240 knots a second.
    np.testing.assert_allclose(found.qdd, 0.0, atol=1e-6)
    assert any("jumps of full turns undone" in told for told in found.recording.treatment)


def test_velocities_of_other_rows_are_not_used():
    """Topics that were merged have rows of positions and rows of velocities."""
    motion = Motion.of(3)
    log = log_of(motion)
    velocities = np.full_like(log.q, np.nan)
    velocities[:100] = motion.at(log.time[:100], 1)
    with pytest.warns(GdAnalyzeWarning, match=f"qd left out, given in 100 of {len(log.q)} rows"):
        found = Trajectory.from_log(replace(log, qd=velocities), None)
    assert found.n_set_points == len(log.q)
    assert found.derived == ("qd", "qdd")


NOISY = 20.0


def noise_in(time, x, rate, order=2):
    return Noise.of([time], [x], rate, order, min(30.0, 0.2 * rate))


def best_cutoff(noises, highest):
    return Source(np.empty(0), 2, tuple(noises)).best_cutoff(highest)


def error_at(time, x, truth, cutoff):
    """Error of the accelerations, ends included."""
    return float(rms((smoothed(time, x, cutoff).derivative(2)(time) - truth)[:, None])[0])


@pytest.mark.parametrize("rate", [125.0, 1000.0])
@pytest.mark.parametrize("deviation", [1e-5, 1e-3])
def test_the_rule_comes_close_to_the_best_cutoff_there_is(rate, deviation):
    time, motion = instants(rate, NOISY), Motion.of(1, 1)
    truth = motion.at(time, 2)[:, 0]
    x = motion.at(time)[:, 0] + deviation * np.random.default_rng(2).normal(size=len(time))
    cutoff = best_cutoff([noise_in(time, x, rate)], min(30.0, 0.2 * rate))
    best = min(error_at(time, x, truth, tried) for tried in np.geomspace(0.5, min(30.0, 0.2 * rate), 20))
    # The error grows as f_c^2.5 with the noise and f_c^-6 with the motion: a cut-off 1.5 times off the best
    # costs up to 1.5^2.5 = 2.8.
    assert error_at(time, x, truth, cutoff) < 2.8 * best


def test_late_and_early_stamps_are_noise_too():
    """Positions read at other instants than stamped err by their velocity: no white noise."""
    rate, motion = 500.0, Motion.of(3, 1)
    time = instants(rate, NOISY)
    late = np.cumsum(np.random.default_rng(4).normal(size=len(time))) * 2e-5
    x = motion.at(time + late)[:, 0]
    found = noise_in(time, x, rate)
    cutoff = best_cutoff([found], 30.0)
    assert cutoff < 15.0
    actual = smoothed(time, x - motion.at(time)[:, 0], cutoff).derivative(2)(time).std()
    # The law of such noise is fitted, not known.
    assert 0.5 < found.left(cutoff) / actual < 2.0


def test_two_frequencies_with_quiet_between_are_both_motion():
    time = instants(500.0, NOISY)
    x = 0.3 * np.sin(2 * np.pi * 0.5 * time) + 2e-3 * np.sin(2 * np.pi * 8.0 * time)
    x += 1e-5 * np.random.default_rng(5).normal(size=len(time))
    assert best_cutoff([noise_in(time, x, 500.0)], 30.0) > 12.0


def test_joints_at_rest_and_without_noise():
    rate, rng = 200.0, np.random.default_rng(7)
    time, motion = instants(rate, NOISY), Motion.of(6, 1)
    q = motion.at(time)[:, 0]
    exact = noise_in(time, q, rate)
    assert best_cutoff([exact], 30.0) > 10.0
    assert exact.left(5.0) < 1e-3
    moving = noise_in(time, q + 1e-4 * rng.normal(size=len(time)), rate)
    still = noise_in(time, 1e-4 * rng.normal(size=len(time)), rate)
    assert best_cutoff([still], 30.0) < 1.0
    # The noise of the five counts, as its expected square grows as f_c^5, by up to (1 + 5 * 100)^(1/5) = 3.5
    # where ends decide; the motion up to 1.4 Hz still passes.
    assert 2.0 < best_cutoff([moving, *[still] * 5], 30.0) <= best_cutoff([moving], 30.0)


@given(seed=st.integers(0, 10_000), rate=st.sampled_from([60.0, 500.0]), fine=st.booleans())
@settings(max_examples=20)
def test_the_noise_left_is_what_is_stated(seed, rate, fine):
    """White noise of known size, motion drawn anew: the statement holds within a third."""
    deviation = 1e-5 if fine else 3e-4
    time, motion = instants(rate, NOISY), Motion.of(seed, 1)
    noise = deviation * np.random.default_rng(seed).normal(size=len(time))
    found = noise_in(time, motion.at(time)[:, 0] + noise, rate)
    omega = 2 * np.pi * 4.0
    # 20 s have 2 * 20 * 4 values of the pass band, twenty to fifty of which make the law that is fitted: its
    # level is known within some 15 % and its slope within 0.3, of which the sum takes an octave. What motion
    # of up to 1.4 Hz leaks beyond its band counts as noise.
    assert 0.7 < found.left(4.0) / (deviation * np.sqrt(omega**5 / rate / 18)) < 1.6


def test_white_noise_has_its_density_in_pieces_too():
    rate = 200.0
    time = instants(rate, 60.0)
    x = np.random.default_rng(8).normal(size=len(time))
    for times, parts in (([time], [x]), ([time[:6000], time[6000:]], [x[:6000], x[6000:]])):
        found = Noise.of(times, parts, rate, 2, 40.0)
        # White noise of variance 1 has the density 2 / rate (2 pi f)^4; averaged pieces, wide windows.
        expected = 2 / rate * (2 * np.pi * found.frequency) ** 4
        high = found.frequency > 5.0
        assert np.median((found.motion + found.noise)[high] / expected[high]) == pytest.approx(1.0, rel=0.1)


def drawn(seed: int) -> tuple[Logged, Treatment | None]:
    """Readings of any number, rate and size; stamps shaken, rounded, torn, shuffled or of a date; holes."""
    rng = np.random.default_rng(seed)
    count, rate = int(rng.choice([1, 2, 16, 17, 40, 100, 400])), 10.0 ** rng.uniform(-3, 5)
    time = np.arange(count) / rate
    changes = [
        lambda t: t + rng.uniform(-1, 1, count) / rate * rng.choice([0.1, 0.6, 3.0]),
        lambda t: np.round(t * rate / 3) * 3 / rate,
        lambda t: np.where(np.arange(count) < count // 2, t, t + 10.0 ** rng.uniform(-2, 9)),
        rng.permutation,
        lambda t: t + 1.7e9,
        lambda t: np.where(np.arange(count) == 0, rng.choice([np.nan, 1e12, -1e12]), t),
        lambda t: np.where(np.arange(count) < count // 2, t + count / rate / 3, t),
    ]
    for change in changes:
        if rng.random() < 0.15:
            time = change(time)
    q = rng.normal(size=(count, 2)) * 10.0 ** rng.uniform(-12, 10)
    q = [q, np.cumsum(q, axis=0), np.ones_like(q)][rng.integers(3)]
    if rng.random() < 0.2:
        q[rng.integers(0, count, size=max(count // 20, 1)), 0] = np.nan
    qd, qdd, torque = (rng.normal(size=(count, 2)) if rng.random() < 0.3 else None for _ in range(3))
    if torque is not None:
        torque[rng.random(torque.shape) < 0.3] = np.nan
    cutoff = 10.0 ** rng.uniform(-6, 2) if rng.random() < 0.2 else None
    gap = 10.0 ** rng.uniform(-3, 9) if rng.random() < 0.2 else None
    return Logged(time, q, qd, qdd, torque, bool(rng.random() < 0.8)), Treatment(
        cutoff=cutoff, largest_gap=gap
    )


def test_whatever_is_logged_is_a_motion_or_an_error(two_link):
    made = 0
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        for seed in range(250):
            logged, treatment = drawn(seed)
            try:
                motion = Trajectory.from_log(logged, two_link, treatment)
            except TrajectoryError:
                continue
            made += 1
            recording = motion.recording
            assert np.isfinite(recording.q).all(), seed
            for noise in (recording.noise_q, recording.noise_qdd):
                assert np.isfinite(noise).all(), seed
                assert (noise >= 0.0).all(), seed
            assert (np.diff(motion.time) > 0).all(), seed
    assert made > 30
