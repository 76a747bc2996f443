"""Readings that are faulty by themselves: left out and named, and the arm is as good as without them."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gd_analyze as gd
from faulty_logs import Robot
from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.errors import GdAnalyzeWarning, UsageError
from gd_analyze.identification.identified_arm import base_matrix
from gd_analyze.studies.identification_result import identification_result
from gd_analyze.tables import states_in_box
from gd_analyze.types import ArmDynamics, Identification, Log
from logs_of_arms import TrueArm, fourier
from long_cases import long

SECONDS, RATE = 16.0, 100.0
Readings = tuple[FloatArray, FloatArray, FloatArray]


@pytest.fixture(scope="module")
def true(two_link) -> TrueArm:
    return TrueArm.near(two_link, 31)


@pytest.fixture(scope="module")
def readings(two_link, true) -> Readings:
    """Time, positions and torques with noise of 0.1 mrad and 1 %."""
    time, states = fourier(two_link, SECONDS, RATE, 32)
    recording = true.log(time, states, seed=33).recording
    return time, recording.q, recording.torque


def log_of(arm, time: FloatArray, q: FloatArray, torque: FloatArray) -> Trajectory:
    return Trajectory.from_log(Log(time, q, None, None, torque, measured=True), arm)


def quietly(arm, *arrays: FloatArray) -> Identification:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        return gd.identify(arm, log_of(arm, *arrays))


def error_of(arm, true: TrueArm) -> float:
    """RMS error of the torque of links and drives at independent states, over the torque's RMS."""
    states = states_in_box(true.arm, 200)
    links = ArmDynamics(true.arm).torque(*states.arrays, drives=False)
    wanted = links + true.drives * states.qdd
    error = ArmDynamics(arm).torque(*states.arrays) - wanted
    return float(np.linalg.norm(error) / np.linalg.norm(wanted))


def spoilt(kind: str, time: FloatArray, q: FloatArray, torque: FloatArray) -> Readings:
    q, torque, rng = q.copy(), torque.copy(), np.random.default_rng(5)
    rows = rng.choice(np.arange(1, len(time)), len(time) // 20, replace=False)
    if kind == "clipped torque":
        end = np.quantile(np.abs(torque[:, 1]), 0.7)
        torque[:, 1] = np.clip(torque[:, 1], -end, end)
    elif kind == "frozen column, of torques":
        torque[500:700, 1] = torque[500, 1]
    elif kind == "frozen column, of positions":
        q[500:700, 1] = q[500, 1]
    elif kind == "frozen column, of all":
        q[500:700], torque[500:700] = q[500], torque[500]
    elif kind == "spikes, doubled":
        torque[rows, 1] *= 2.0
    elif kind == "spikes, far":
        torque[rows, 1] += 50.0 * torque[:, 1].std()
    else:
        q[rows], torque[rows] = q[rows - 1], torque[rows - 1]
    return time, q, torque


@pytest.mark.parametrize(
    "kind",
    [
        "clipped torque", "frozen column, of positions", "spikes, doubled", "repeated rows",
        *map(long, ("frozen column, of torques", "frozen column, of all", "spikes, far")),
    ],
)  # fmt: skip
def test_faulty_readings_are_left_out_and_named(two_link, true, readings, kind):
    log = log_of(two_link, *spoilt(kind, *readings))
    with pytest.warns(GdAnalyzeWarning, match="left out"):
        identification = gd.identify(two_link, log)
    assert {fault.name for fault in identification.faults} == {kind.split(",")[0]}
    assert 1 in {fault.joint for fault in identification.faults}
    # A twentieth to a third of one joint's readings are gone; the file is off by 16 %.
    assert error_of(identification.arm, true) < 0.01
    assert identification.doubts == ()
    table = next(
        part
        for part in identification_result(identification, None, {}).parts
        if getattr(part, "key", "") == "faults"
    )
    assert len(table.columns[0].values) == len(identification.faults)


@given(share=st.floats(0.5, 0.9), joint=st.integers(0, 1))
@settings(max_examples=4)
def test_what_is_clipped_does_not_bend_the_arm(two_link, true, readings, share, joint):
    time, q, torque = readings
    end = np.quantile(np.abs(torque[:, joint]), share)
    clipped = torque.copy()
    clipped[:, joint] = np.clip(torque[:, joint], -end, end)
    identification = quietly(two_link, time, q, clipped)
    (fault,) = identification.faults
    assert (fault.name, fault.joint) == ("clipped torque", joint)
    # Peaks shorter than four readings are not taken for clipped ones, and count little.
    assert abs(fault.share - (1.0 - share)) < 0.05
    assert error_of(identification.arm, true) < 0.01


@given(step=st.floats(0.005, 0.1), phase=st.floats(0.0, 1.0), noisy=st.booleans())
@settings(max_examples=8)
def test_steps_of_a_sensor_are_no_fault(two_link, true, readings, step, phase, noisy):
    time, q, torque = readings
    if not noisy:
        torque = true.torque(fourier(two_link, SECONDS, RATE, 32)[1])
    size = step * np.abs(torque).max(axis=0)
    coarse = size * np.floor(torque / size + phase)
    assert quietly(two_link, time, q, coarse).faults == ()


@pytest.mark.parametrize("sign", [1.0, long(-1.0)])
def test_a_copied_torque_is_refused(two_link, readings, sign):
    time, q, torque = readings
    with pytest.raises(UsageError) as caught:
        quietly(two_link, time, q, torque[:, [1, 1]] * [1.0, sign])
    assert "joints 1 and 2" in caught.value.what
    assert "`map=['torque:2=COLUMN']`" in caught.value.details["next"]
    assert "--map torque:2=COLUMN" in caught.value.with_options()


def test_copied_positions_are_refused(two_link, readings):
    time, q, torque = readings
    with pytest.raises(UsageError) as caught:
        quietly(two_link, time, q[:, [0, 0]], torque)
    assert "joints 1 and 2" in caught.value.what
    assert "`map=['q:2=COLUMN']`" in caught.value.details["next"]


@pytest.mark.parametrize(
    ("growth", "joints"),
    [(0.6, (1,)), long(0.6, (0,)), long(-0.4, (1,)), long(0.3, (0, 1)), long(0.3, (1,))],
)
def test_a_gain_that_drifts_is_doubted(two_link, readings, growth, joints):
    time, q, torque = readings
    gain = np.ones_like(torque)
    gain[:, joints] += growth * (time / time[-1])[:, None]
    try:
        identification = quietly(two_link, time, q, gain * torque)
    except UsageError as error:
        whose = "all torques" if len(joints) == 2 else f"joint {joints[0] + 1}'s torque"
        if f"the gain of {whose}" not in error.what:  # clear enough for a diagnosis
            raise
        return
    (doubt,) = [text for text in identification.doubts if "gain" in text]
    assert ("every joint" if len(joints) == 2 else f"joint {joints[0] + 1}") in doubt
    # Over the gain in the middle.
    change = float(doubt.rsplit("by ", 1)[1].split(" %")[0].split(",")[0]) / 100.0
    assert change == pytest.approx(growth / (1.0 + growth / 2.0), rel=0.15)


def test_a_window_counts_by_the_readings_that_it_has(two_link, true, readings):
    """Every third torque is missing, at one joint in another phase than at the other."""
    time, q, torque = readings
    gappy = torque.copy()
    gappy[::3, 0], gappy[1::3, 1] = np.nan, np.nan
    identification = gd.identify(two_link, log_of(two_link, time, q, gappy))
    whole = gd.identify(two_link, log_of(two_link, time, q, torque))
    for few, all_rows in zip(identification.residuals, whole.residuals, strict=True):
        assert len(few.time) > 0.95 * len(all_rows.time)
    assert error_of(identification.arm, true) < 0.01


@pytest.mark.parametrize("multiple", [1.0, long(0.0), long(2.0)])
def test_errors_hold_where_friction_is_not_the_models(two_link, multiple):
    """Stribeck and load-dependent friction, which no column describes: 95 % within 1.96 standard errors."""
    within, count = 0, 0
    for seed in range(500, 512):
        robot = Robot.of(two_link, seed, seconds=12.0)
        robot.friction[:, 2:4] *= multiple
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", GdAnalyzeWarning)
            identification = gd.identify(two_link, robot.log(*robot.as_it_is), anyway=True)
        truth = base_matrix(robot.arm)[1] @ np.concatenate([parameters_of(robot.arm).ravel(), robot.drives])
        for parameter, value in zip(identification.parameters, truth, strict=True):
            if parameter.identifiable:
                within += abs(parameter.value - value) < 1.96 * parameter.error
                count += 1
    # Of some fifty numbers, 95 % with a standard deviation of 3 %.
    assert count > 40
    assert within >= 0.89 * count
