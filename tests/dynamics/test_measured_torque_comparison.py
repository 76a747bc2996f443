"""Measured torque beside the exact one: numbers of known differences, and what is left out."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import gd_analyze as gd
from gd_analyze.arrays import CHUNK
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.measured_torque import compare_torque
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from recorded_logs import recorded, swinging, with_torques
from strategies import arms, examples


def changed(arm: RobotArm, change: np.ndarray, motion: Trajectory | None = None) -> Trajectory:
    """A log whose torques are exact, and something beside."""
    motion = swinging(arm) if motion is None else motion
    return with_torques(motion, torque_of(arm, states_of(motion)) + change)


@given(gain=st.floats(0.1, 10.0), offset=st.floats(-100.0, 100.0), sign=st.sampled_from([-1.0, 1.0]))
@examples(30)
def test_a_gain_and_an_offset(two_link: RobotArm, gain: float, offset: float, sign: float) -> None:
    motion = swinging(two_link)
    exact = torque_of(two_link, states_of(motion))
    found = compare_torque(two_link, with_torques(motion, sign * gain * exact + offset))
    left = (sign * gain - 1.0) * exact + offset
    # Round-off of sums of 500 terms, of torques up to some 1000 N m with offsets of 100, relative to the
    # spread of the smallest, some 10: below eps * 500 * 1000 / 10.
    close = {"rtol": 1e-9, "atol": 1e-9}
    np.testing.assert_allclose(found.correlation, sign, **close)
    np.testing.assert_allclose(found.slope, sign * gain, **close)
    np.testing.assert_allclose(found.slope_beside_friction, sign * gain, **close)
    np.testing.assert_allclose(found.bias, left.mean(axis=0), **close)
    np.testing.assert_allclose(found.rms, np.sqrt((left**2).mean(axis=0)), **close)
    np.testing.assert_allclose(found.explained, 1.0 - (1.0 - sign / gain) ** 2, **close)
    np.testing.assert_allclose(found.peak_model, np.abs(exact).max(axis=0))
    np.testing.assert_allclose(found.peak_measured, np.abs(sign * gain * exact + offset).max(axis=0))


@given(arm=arms(massive=True), seed=st.integers(0, 99))
@examples(15)
def test_numbers_are_numpys(arm: RobotArm, seed: int) -> None:
    """For any arm and noise as large as its torques, over more than one block of set points."""
    motion = swinging(arm, CHUNK + 300)
    exact = torque_of(arm, states_of(motion))
    noise = np.random.default_rng(seed).normal(size=exact.shape) * np.abs(exact).max(axis=0)
    found = compare_torque(arm, with_torques(motion, exact + noise + 0.1))
    for i in range(arm.n_joints):
        if np.ptp(exact[:, i]) > 1e-9:
            measured = exact[:, i] + noise[:, i] + 0.1
            assert found.correlation[i] == pytest.approx(np.corrcoef(exact[:, i], measured)[0, 1], abs=1e-9)
            assert found.slope[i] == pytest.approx(np.polyfit(exact[:, i], measured, 1)[0], rel=1e-7)


def test_a_joint_without_readings_is_left_out(puma: RobotArm) -> None:
    log = recorded(puma)
    assert log.recording is not None
    assert log.recording.torque is not None
    torque = log.recording.torque.copy()
    torque[:, 1], torque[:, 4] = 0.0, np.nan
    found = compare_torque(puma, with_torques(log, torque))
    assert [joint for joint in range(6) if found.verdicts[joint] == "not measured"] == [1, 4]
    whole = compare_torque(puma, log)
    others = [0, 2, 3, 5]
    for name in ("correlation", "slope", "bias", "rms", "explained", "slope_beside_friction"):
        assert np.isnan(getattr(found, name)[[1, 4]]).all(), name
        # The same sums, of columns in other places: round-off as above.
        np.testing.assert_allclose(
            getattr(found, name)[others], getattr(whole, name)[others], rtol=1e-9, atol=1e-9, err_msg=name
        )
    assert np.isnan(found.friction.terms[[1, 4]]).all()


def test_set_points_without_a_reading_do_not_count(two_link: RobotArm) -> None:
    change = np.zeros((500, 2))
    change[100:150, 0] = np.nan
    log = changed(two_link, change)
    found = compare_torque(two_link, log)
    assert found.compared == 500
    # Otherwise exact; round-off as above.
    np.testing.assert_allclose(found.rms, 0.0, atol=1e-9)


def test_where_the_filter_has_not_settled_nothing_is_compared(two_link: RobotArm) -> None:
    """At both ends of a recording and of its gaps, for half a period of the cut-off."""
    motion, cutoff = swinging(two_link, gaps=(200,)), 5.0
    change = np.zeros((500, 2))
    for end in (0, 199, 200, 499):
        near = np.abs(motion.time - motion.time[end]) < 0.49 / cutoff
        change[near] = 1000.0
    torque = torque_of(two_link, states_of(motion)) + change
    found = compare_torque(two_link, with_torques(motion, torque, cutoff))
    np.testing.assert_allclose(found.rms, 0.0, atol=1e-9)
    # 0.1 s at 125 Hz, 13 readings at each of the four ends.
    assert found.compared == 500 - 4 * 13


def test_a_constant_reading_has_no_correlation(two_link: RobotArm) -> None:
    motion = swinging(two_link)
    found = compare_torque(two_link, with_torques(motion, np.full((500, 2), 3.0)))
    assert np.isnan(found.correlation).all()
    assert found.verdicts == ("does not follow", "does not follow")


def test_drives_inertia_is_part_of_the_model_where_it_acts(puma: RobotArm) -> None:
    log = recorded(puma)  # torques of the links and of the drives
    assert set(compare_torque(puma, log).verdicts) == {"follows"}
    np.testing.assert_allclose(compare_torque(puma, log).rms, 0.0, atol=1e-9)
    assert (compare_torque(puma, log, drives=False).rms > 1e-3).all()


def test_a_plan_has_no_measured_torques(puma: RobotArm, pick_and_place: Trajectory) -> None:
    with pytest.raises(UsageError, match="no measured torques to compare with") as caught:
        compare_torque(puma, pick_and_place)
    assert caught.value.details["found"] == "a plan"
    log = recorded(puma)
    assert log.recording is not None
    silent = replace(log, recording=replace(log.recording, torque=None))
    with pytest.raises(UsageError, match="no measured torques") as caught:
        gd.compare_torque(puma, silent)
    assert caught.value.details["found"] == "a recording without torques"
    assert "columns of measured torques" in caught.value.details["next"]
