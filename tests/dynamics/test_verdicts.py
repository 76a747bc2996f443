"""What is said of a joint: each verdict for a robot that is so."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.measured_torque import compare_torque
from gd_analyze.motions.states import states_of
from gd_analyze.results.motion_tables import measured_torque_table
from gd_analyze.robots.arm import RobotArm
from recorded_logs import friction_of, recorded, swinging, with_torques
from strategies import examples


def verdicts(arm: RobotArm, **how: object) -> tuple[str, ...]:
    return compare_torque(arm, recorded(arm, **how)).verdicts


def test_the_right_model(puma: RobotArm) -> None:
    assert set(verdicts(puma, noise=0.01)) == {"follows"}


def with_large_friction(
    arm: RobotArm, times: float, gain: float = 1.0, noise: float = 0.02
) -> tuple[str, ...]:
    """Friction so many times the spread of each joint's own torque."""
    motion = swinging(arm)
    exact = torque_of(arm, states_of(motion))
    size = exact.std(axis=0)
    drawn = np.random.default_rng(3).normal(size=exact.shape)
    torque = gain * exact + size * (times * friction_of(motion, 1.0, 0.2, 0.5) + noise * drawn)
    return compare_torque(arm, with_torques(motion, torque)).verdicts


@pytest.mark.parametrize("times", [1.0, 5.0, 20.0])
def test_friction_beside_the_right_model(puma: RobotArm, times: float) -> None:
    assert set(with_large_friction(puma, times)) == {"follows but for friction"}


@given(gain=st.floats(1.5, 30.0), friction=st.sampled_from([0.0, 0.3, 2.0]))
@examples(15)
def test_too_light(puma: RobotArm, gain: float, friction: float) -> None:
    assert set(with_large_friction(puma, friction, gain)) == {"too light"}


@given(gain=st.floats(0.2, 0.7), friction=st.sampled_from([0.0, 0.3, 2.0]))
@examples(15)
def test_too_heavy(puma: RobotArm, gain: float, friction: float) -> None:
    assert set(with_large_friction(puma, friction, gain)) == {"too heavy"}


@given(gain=st.floats(0.3, 3.0), friction=st.sampled_from([0.0, 2.0]))
@examples(10)
def test_other_sign(puma: RobotArm, gain: float, friction: float) -> None:
    assert set(with_large_friction(puma, friction, -gain)) == {"other sign"}


def test_friction_and_noise_that_hide_the_model(puma: RobotArm) -> None:
    assert set(with_large_friction(puma, 20.0, noise=3.0)) == {"below friction"}


def test_friction_that_is_not_quite_coulombs(puma: RobotArm) -> None:
    """It depends on the pose by a tenth, and hides that nothing of the model's torque is there."""
    motion = swinging(puma)
    size = torque_of(puma, states_of(motion)).std(axis=0)
    friction = 8.0 * size * np.sign(motion.qd) * (1.0 + 0.1 * np.sin(2.0 * motion.q))
    assert set(compare_torque(puma, with_torques(motion, friction)).verdicts) == {"below friction"}


def test_columns_in_another_order(puma: RobotArm) -> None:
    motion = swinging(puma)
    exact = torque_of(puma, states_of(motion))
    order = [0, 2, 1, 3, 5, 4]
    found = compare_torque(puma, with_torques(motion, exact[:, order]))
    assert found.verdicts[1:3] == ("another joint's",) * 2
    assert found.verdicts[4:] == ("another joint's",) * 2
    assert found.resembles == (0, 3, 2, 0, 6, 5)


def test_readings_of_something_else(puma: RobotArm) -> None:
    motion = swinging(puma)
    size = torque_of(puma, states_of(motion)).std(axis=0)
    other = np.cos(np.outer(motion.time, 7.0 + np.arange(6)))
    assert set(compare_torque(puma, with_torques(motion, 0.3 * size * other)).verdicts) == {"does not follow"}


def test_a_log_that_was_not_filtered(two_link: RobotArm) -> None:
    log = recorded(two_link)
    table = measured_torque_table(compare_torque(two_link, log), log)
    assert table.attrs["filter"] == 0
    np.testing.assert_array_equal(table.measured, table.filtered)
    assert log.recording is not None
    treated = replace(log.recording, torque_filtered=2.0 * log.recording.torque, cutoff=np.array([5.0, 8.0]))
    smooth = replace(log, recording=treated)
    table = measured_torque_table(compare_torque(two_link, smooth), smooth)
    assert table.attrs["filter"] == 1
    np.testing.assert_array_equal(2.0 * table.measured, table.filtered)
