"""From a log to a motion: errors against a motion known exactly, and what is stated of them."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError, UsageError
from gd_analyze.motions.derived_rates import complete_rates
from gd_analyze.motions.measured import motion_of
from gd_analyze.motions.treatment import Treatment
from recordings import Motion, instants, readings, rms

SECONDS = 15.0


def log_of(motion, rate=125.0, deviation=1e-4, jitter=0.0, seed=0, **more):
    time = instants(rate, SECONDS, jitter, seed)
    noise = np.random.default_rng(seed).normal(size=(len(time), 2))
    return readings(time, motion.at(time) + deviation * noise, **more)


@pytest.mark.parametrize(("rate", "jitter"), [(1000.0, 0.0), (125.0, 0.0), (125.0, 0.5), (30.0, 0.06)])
def test_accelerations_come_near_the_true_ones(rate, jitter):
    motion = Motion.of(1)
    found = motion_of(log_of(motion, rate, jitter=jitter), None)
    truth = motion.at(found.time, 2)
    # Noise and the motion that is taken for it count alike at the best cut-off, and ends have 2.4 times the
    # noise: three times the noise stated are room for both.
    assert (rms(found.qdd - truth) < 3 * found.recording.noise_qdd).all()
    assert (rms(found.qd - motion.at(found.time, 1)) < 0.01 * rms(motion.at(found.time, 1))).all()
    assert (rms(found.qdd - truth) < 0.1 * rms(truth)).all()
    # Ten times better than a spline through the readings.
    raw = complete_rates(found.time, found.recording.q, None, None)[1]
    assert (rms(found.qdd - truth) < 0.1 * rms(raw - truth)).all()


@given(seed=st.integers(0, 10_000))
@settings(max_examples=15)
def test_errors_are_within_what_is_stated(seed):
    motion = Motion.of(seed)
    found = motion_of(log_of(motion, seed=seed), None)
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
    with pytest.warns(GdAnalyzeWarning, match="joint 1 of the log accelerates at frequencies above 6.00 Hz"):
        motion_of(log, None)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        motion_of(readings(time, log.q[:, 1:]), None)


def test_it_is_the_same_every_time():
    log = log_of(Motion.of(2))
    assert motion_of(log, None).fingerprint == motion_of(log, None).fingerprint


def test_every_reading_is_a_set_point_and_kept_as_read():
    log = log_of(Motion.of(2))
    found = motion_of(log, None)
    assert (found.time == log.time).all()
    assert (found.recording.q == log.q).all()
    assert found.recording.measured
    assert found.derived == ("qd", "qdd")


def test_a_given_cutoff_is_taken_and_said():
    found = motion_of(log_of(Motion.of(2)), None, Treatment(cutoff=3.0))
    assert found.recording.cutoff.tolist() == [3.0, 3.0]
    assert "cut-off 3.00 Hz (as asked for)" in found.rates_from
    both = motion_of(log_of(Motion.of(2)), None, Treatment(cutoff=(3.0, 6.0)))
    assert both.recording.cutoff.tolist() == [3.0, 6.0]
    # Noise grows as f_c^2.5: 5.7 times; its estimates scatter.
    assert 4.0 < both.recording.noise_qdd[1] / both.recording.noise_qdd[0] < 8.0


@pytest.mark.parametrize(
    ("cutoff", "message", "found"),
    [
        (40.0, "too high for so few readings", "40.0 Hz"),
        ((1.0, 2.0, 3.0), "not one for all joints, or one each", "3"),
    ],
)
def test_cutoffs_that_do_not_suit_are_refused(cutoff, message, found):
    with pytest.raises(TrajectoryError, match=message) as error:
        motion_of(log_of(Motion.of(2)), None, Treatment(cutoff=cutoff))
    assert error.value.details["where"] == "--cutoff"
    assert error.value.details["found"] == found


@pytest.mark.parametrize("wrong", [{"cutoff": 0.0}, {"cutoff": (1.0, float("nan"))}, {"largest_gap": -1.0}])
def test_treatments_that_cannot_be_are_refused(wrong):
    with pytest.raises(UsageError, match=f"{next(iter(wrong))} cannot be that"):
        Treatment(**wrong)


def test_of_another_number_of_joints_is_refused(puma):
    with pytest.raises(TrajectoryError, match="the log does not fit arm puma560") as error:
        motion_of(log_of(Motion.of(2)), puma)
    assert error.value.details["expected"] == "6 joints"


def test_nothing_is_smoothed_across_a_gap():
    motion = Motion.of(3)
    log = log_of(motion)
    kept = (log.time < 6.0) | (log.time > 9.0)
    first, last = log.time < 6.0, log.time > 9.0
    both = motion_of(readings(log.time[kept], log.q[kept]), None, Treatment(cutoff=5.0))
    assert both.gaps == (np.count_nonzero(first),)
    parts = [readings(log.time[part], log.q[part]) for part in (first, last)]
    alone = [motion_of(part, None, Treatment(cutoff=5.0)) for part in parts]
    for name in ("q", "qd", "qdd"):
        np.testing.assert_array_equal(
            getattr(both, name), np.concatenate([getattr(one, name) for one in alone])
        )


def test_measured_rates_are_used_where_they_are_quieter():
    motion = Motion.of(4)
    log = log_of(motion, deviation=1e-3)
    qd = motion.at(log.time, 1) + 1e-4 * np.random.default_rng(9).normal(size=log.q.shape)
    found = motion_of(replace(log, qd=qd), None)
    assert found.derived == ("qdd",)
    assert "from the measured rates" in found.rates_from
    assert (found.recording.noise_qdd < motion_of(log, None).recording.noise_qdd).all()
    error = rms(found.qdd - motion.at(found.time, 2))
    assert (error < 3 * found.recording.noise_qdd).all()
    positions = motion_of(replace(log, qd=qd), None, Treatment(use_rates=False))
    assert positions.derived == ("qd", "qdd")


def test_measured_rates_that_are_noisier_are_not_used():
    motion = Motion.of(4)
    log = log_of(motion, deviation=1e-6)
    qd = motion.at(log.time, 1) + 0.05 * np.random.default_rng(9).normal(size=log.q.shape)
    assert "from the measured positions" in motion_of(replace(log, qd=qd), None).rates_from


def test_measured_rates_that_contradict_the_positions_warn_and_are_not_used():
    motion = Motion.of(4)
    log = log_of(motion)
    with pytest.warns(GdAnalyzeWarning, match="57.3 times the derivative of q.*are not used"):
        found = motion_of(replace(log, qd=np.degrees(motion.at(log.time, 1))), None)
    assert found.derived == ("qd", "qdd")


def test_torques_pass_the_same_filter_and_may_lack_cells():
    motion = Motion.of(5)
    log = log_of(motion)
    torque = motion.at(log.time, 2)
    torque[100:103] = np.nan
    found = motion_of(replace(log, torque=torque), None, Treatment(cutoff=6.0)).recording
    assert np.isnan(found.torque[100:103]).all()
    assert np.isfinite(found.torque_filtered).all()
    # As the accelerations themselves: both are sines, whose shares H are above 1 - (1.4 / 6)^6 = 0.9998.
    truth = motion.at(log.time, 2)
    assert (rms(found.torque_filtered - truth) < 0.02 * rms(truth)).all()


def test_a_plan_is_not_smoothed():
    motion = Motion.of(6)
    log = log_of(motion, measured=False)
    found = motion_of(log, None)
    assert (found.q == log.q).all()
    assert not found.recording.measured
    assert found.rates_from == "qd and qdd derived: C4 (quintic) spline through the given q"


def test_given_accelerations_are_smoothed_too():
    motion = Motion.of(7)
    log = log_of(motion)
    noise = 0.05 * np.random.default_rng(1).normal(size=log.q.shape)
    log = replace(log, qd=motion.at(log.time, 1), qdd=motion.at(log.time, 2) + noise)
    found = motion_of(log, None, Treatment(cutoff=5.0))
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
        found = motion_of(readings(time, wrapped), free)
    np.testing.assert_allclose(found.q, q, atol=1e-9)
    # A straight line stays one; eps of 10 rad through splines of 4 to 240 knots a second.
    np.testing.assert_allclose(found.qdd, 0.0, atol=1e-6)
    assert any("jumps of full turns undone" in told for told in found.recording.treatment)


def test_rates_of_other_rows_are_not_used():
    """Topics that were merged have rows of positions and rows of rates."""
    motion = Motion.of(3)
    log = log_of(motion)
    rates = np.full_like(log.q, np.nan)
    rates[:100] = motion.at(log.time[:100], 1)
    with pytest.warns(GdAnalyzeWarning, match=f"rates stand in 100 of {len(log.q)} rows that hold positions"):
        found = motion_of(replace(log, qd=rates), None)
    assert found.n_set_points == len(log.q)
    assert found.derived == ("qd", "qdd")
