"""The file as it is, its drives included, beside the file whose links and drives are fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.diagnosis.answer import is_for_identification
from gd_analyze.diagnosis.log_verdict import log_verdict
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.types import RobotArm
from logs_of_arms import TrueArm, fourier


@pytest.fixture(scope="module")
def robot(puma) -> TrueArm:
    """A robot as its file says, with the file's drives, and friction."""
    friction = np.column_stack([np.full(6, 2.0), np.full(6, 1.0), np.zeros(6)])
    return TrueArm(replace(puma, drives=()), puma.drive_inertia, friction)


@pytest.fixture(scope="module")
def log(robot, puma) -> Trajectory:
    time, states = fourier(puma, 10.0, 100.0, 2)
    return robot.log(time, states, seed=2)


def with_drive_inertia(arm: RobotArm, factor: float) -> RobotArm:
    drives = (replace(drive, inertia=factor * drive.inertia) for drive in arm.drives)
    return replace(arm, drives=tuple(drives))


def test_a_right_file_needs_no_fit(puma, log):
    diagnosis = log_verdict(puma, [log]).diagnosis
    assert diagnosis is not None
    # Noise of 1 % of the torques, and accelerations of noisy positions.
    assert (diagnosis.as_filed.share < 0.1).all()
    assert diagnosis.needing_a_fit == ()
    assert not is_for_identification(diagnosis)


def test_drive_inertia_that_a_file_states_is_judged(puma, log):
    """A fit finds the right one, whatever the file says; the file as it is leaves much of the torque."""
    wrong = with_drive_inertia(puma, 10.0)
    verdict = log_verdict(wrong, [log])
    assert verdict.diagnosis is not None
    assert verdict.diagnosis.needing_a_fit
    assert verdict.word != "agrees"
    assert "As it is" in verdict.opening
    assert is_for_identification(verdict.diagnosis)


def test_the_residual_as_filed_is_that_of_the_compared_torques(puma, log):
    """Two ways: some samples, by the regressor, and all readings, by Newton and Euler."""
    wrong = with_drive_inertia(puma, 3.0)
    diagnosis = log_verdict(wrong, [log]).diagnosis
    assert diagnosis is not None
    compared = gd.compare_torque(wrong, log)
    share = compared.friction.rms / compared.rms_measured
    # The samples include readings near a reversal, which the comparison leaves out as the filter smears
    # friction there; the RMS of 400 independent ones is uncertain by 4 %.
    ratio = diagnosis.as_filed.share / share
    assert (ratio > 0.9).all()
    assert (ratio < 1.25).all()
