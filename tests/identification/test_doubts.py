"""Logs that are wrong in one way: no confident arm comes of them, and sound logs raise no doubt.

Thresholds are those of the code, argued there; the arms, motions and mistakes here were not used to set them.
"""

from __future__ import annotations

import re
import warnings
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze import Trajectory
from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, UsageError
from gd_analyze.identification.identification import Residuals
from gd_analyze.studies.identification_result import identification_result
from gd_analyze.tables import states_in_box, with_payload
from gd_analyze.types import ArmDynamics, Identification, States
from logs_of_arms import TrueArm, fourier, with_torque
from long_cases import long

SECONDS, RATE = 16.0, 50.0


@pytest.fixture(scope="module")
def true(puma) -> TrueArm:
    return TrueArm.near(puma, 31)


@pytest.fixture(scope="module")
def states(puma) -> tuple[FloatArray, States]:
    return fourier(puma, SECONDS, RATE, 32)


@pytest.fixture(scope="module")
def sound(true, states) -> Trajectory:
    return true.log(*states, seed=33)


def quietly(arm, log, **how) -> Identification:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", GdAnalyzeWarning)
        return gd.identify(arm, log, **how)


def headline(found: Identification) -> str:
    return identification_result(found, None, {}).headline


def error_of(arm: gd.types.RobotArm, true: TrueArm) -> float:
    """RMS error of the torque of links and drives at independent states, over the torque's RMS."""
    independent = states_in_box(true.arm, 200)
    links = ArmDynamics(true.arm).torque(*independent.arrays, drives=False)
    wanted = links + true.drives * independent.qdd
    error = ArmDynamics(arm).torque(*independent.arrays) - wanted
    return float(np.linalg.norm(error) / np.linalg.norm(wanted))


def test_a_sound_log_raises_no_doubt_and_improves_the_file(puma, true, sound):
    found = gd.identify(puma, sound)  # a warning would be an error
    assert found.doubts == ()
    assert found.kept == ()
    # Links off by some 20 %; noise of 1 % over five hundred rows leaves far less.
    assert error_of(found.arm, true) < 0.05 < 0.1 < error_of(puma, true)
    assert "stay" not in headline(found)
    page = ElementTree.fromstring(f"<p>{found._repr_html_()}</p>")
    assert [len(row) for row in page.iter("tr")] == [5] * (1 + puma.n)


@pytest.mark.slow
@pytest.mark.parametrize("factor", [1000.0, 100.0, 0.01])
def test_torques_in_another_unit_are_refused(puma, sound, factor):
    with pytest.raises(UsageError, match="multiplied by") as caught:
        quietly(puma, with_torque(sound, factor * sound.recording.torque))
    # Links and drives off by some 20 % are a part of the ratio.
    ratio = re.search(r"multiplied by ([\d.e+-]+)", caught.value.what)
    assert float(ratio[1]) == pytest.approx(1.0 / factor, rel=0.5)


@pytest.mark.parametrize("factor", [2.0, long(0.5)])
def test_constants_off_by_two_are_doubted(puma, sound, factor):
    found = quietly(puma, with_torque(sound, factor * sound.recording.torque))
    assert found.doubts
    assert headline(found).startswith("Doubtful: ")
    # The arm's file says it again wherever it is read.
    assert set(found.doubts) <= set(found.arm.doubts)


@pytest.mark.slow
def test_an_arm_that_hangs_is_refused(puma, true, states):
    hanging = replace(true, arm=replace(true.arm, gravity_vector=-true.arm.gravity_vector))
    with pytest.raises(UsageError, match="ceiling"):
        quietly(puma, hanging.log(*states))
    assert any("ceiling" in text for text in quietly(puma, hanging.log(*states), anyway=True).doubts)


@pytest.mark.slow
def test_what_a_refusal_advises_is_an_option_of_identify(puma, true, states):
    """A payload, which other links explain, is told beside a reversed torque, and needs no option."""
    loaded = replace(true, arm=with_payload(true.arm, 3.0, np.array([0.0, 0.0, 0.1]))).log(*states, seed=33)
    assert loaded.recording is not None
    with pytest.raises(UsageError) as caught:
        quietly(puma, with_torque(loaded, loaded.recording.torque * [-1.0, 1.0, 1.0, 1.0, 1.0, 1.0]))
    told, _, advised = str(caught.value).partition("next: ")
    assert "carries" in told
    assert "`torque_sign='-1,1,1,1,1,1'`" in advised
    assert "--torque-sign -1,1,1,1,1,1" in caught.value.with_options()
    assert "payload" not in advised


@pytest.mark.slow
def test_a_zero_that_is_off_is_told_and_doubted(puma, true, states):
    time, moved = states
    log = true.log(time, moved)
    shifted = log.q + np.pi / 2.0 * (np.arange(6) == 2)
    with pytest.raises(UsageError, match=r"joint 3 .* -90 deg"):
        quietly(puma, replace(log, q=shifted))
    found = quietly(puma, replace(log, q=shifted), anyway=True)
    assert any("joint 3" in text for text in found.doubts)


def test_times_that_are_ten_times_too_long(puma, true, states):
    """Accelerations a hundredth of the true ones: inertias a hundred times too large."""
    time, moved = states
    slow = States(moved.q, moved.qd / 10.0, moved.qdd / 100.0)
    log = replace(true.exact_log(10.0 * time, slow), gaps=())
    log = with_torque(log, true.torque(moved))
    try:
        found = quietly(puma, log)
    except UsageError:
        return
    assert found.doubts or error_of(found.arm, true) < 1.2 * error_of(puma, true)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_log_of_tiny_motions_is_no_worse_than_the_file(puma, seed):
    """What 2 % of a motion does not tell keeps the file's values: judged by the truth, not by residuals."""
    true = TrueArm.near(puma, 40 + seed)
    time, large = fourier(puma, SECONDS, RATE, 50 + seed)
    middle = large.q.mean(axis=0)
    small = States(middle + 0.02 * (large.q - middle), 0.02 * large.qd, 0.02 * large.qdd)
    try:
        found = quietly(puma, true.log(time, small, seed=seed))
    except UsageError:  # no arm is no wrong arm
        return
    # Ten percent for the draw of noise along what gravity tells.
    assert error_of(found.arm, true) <= 1.1 * error_of(puma, true)


def test_a_right_file_stays_at_every_joint(puma, states):
    """Nothing to gain: the file's links are the arm's."""
    exact = replace(TrueArm.near(puma, 7), arm=replace(puma, drives=()), drives=puma.drive_inertia)
    found = quietly(puma, exact.log(*states, noise=(1e-4, 0.05), seed=8))
    assert len(found.kept) >= 4
    assert error_of(found.arm, exact) < 0.02
    assert "stay" in headline(found)


@pytest.mark.slow
def test_joints_that_do_not_improve_have_the_files_torque(puma, true, states, sound):
    """A column of noise at joint 5: its torque is the file's, and the others are as good as without."""
    torque = sound.recording.torque.copy()
    torque[:, 4] = 3.0 * np.random.default_rng(3).normal(size=len(torque))
    found = quietly(puma, with_torque(sound, torque))
    assert 5 in found.kept
    assert "5" in headline(found).split("At joint")[1]
    assert error_of(found.arm, true) < 0.05


def residuals(gain: float) -> Residuals:
    rng, count = np.random.default_rng(1), 400
    measured = rng.normal(size=count)
    friction, identified = measured + rng.normal(size=count), measured + (1.0 - gain) * rng.normal(size=count)
    held, loaded = np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
    return Residuals(np.arange(count) * 1.0, measured, friction, friction, identified, held, loaded)


def test_better_means_by_a_standard_error():
    # Squares of 400 normal residuals differ by 0.1 at one standard deviation; 0.3 and -0.3 are far out.
    assert residuals(0.3).is_better
    assert not residuals(-0.3).is_better
    same = residuals(0.0)
    assert not replace(same, identified=same.friction).is_better


def test_less_than_its_error_is_not_identifiable(puma, sound):
    found = quietly(puma, sound)
    assert all(abs(one.value) >= one.error for one in found.parameters if one.identifiable)


@pytest.mark.slow
def test_torques_beyond_the_drives_are_doubted(puma, true, states):
    strong = replace(puma, drives=tuple(replace(drive, torque_limit=1e3) for drive in puma.drives))
    weak = replace(puma, drives=tuple(replace(drive, torque_limit=40.0) for drive in puma.drives))
    heavier = replace(true, arm=with_payload(true.arm, 3.0, np.array([0.0, 0.0, 0.1])))
    log = heavier.log(*states)
    assert not any("limit" in text for text in quietly(strong, log).doubts)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        found = gd.identify(weak, log)
    said = any("limit" in text for text in found.doubts)
    assert said == any("limit" in str(each.message) for each in caught)


def test_a_known_mass_calibrates_the_torques(puma, true, states):
    """Constants 15 % too small: the stated error holds it, and the mass removes it."""
    mass = 2.5
    gripping = replace(true, arm=with_payload(true.arm, mass, np.array([0.02, 0.0, 0.1])))
    bare = true.log(*states, seed=1)
    loaded = gripping.log(*fourier(puma, SECONDS, RATE, 60), seed=2)
    bare, loaded = (with_torque(log, 0.85 * log.recording.torque) for log in (bare, loaded))
    found = quietly(puma, bare, loaded=loaded)
    off = abs(found.payload[0][0] - mass)
    assert off < 3.0 * found.payload[1][0]
    calibrated = quietly(puma, bare, loaded=loaded, mass=mass)
    scale, error = calibrated.torque_scale
    assert abs(scale - 1.0 / 0.85) < 4.0 * error < 0.2
    np.testing.assert_allclose(calibrated.payload[0][0], mass, rtol=0.01)
    assert error_of(calibrated.arm, true) < 0.3 * error_of(found.arm, true)
    for how in ({"mass": 2.0}, {"mass": -1.0, "loaded": loaded}):
        with pytest.raises(UsageError, match="calibrates torques"):
            quietly(puma, bare, **how)


def test_rods_are_not_called_a_file(puma, sound):
    nothing = [replace(link, mass=0.0, com=np.zeros(3), inertia_com=np.zeros((3, 3))) for link in puma.links]
    found = quietly(replace(puma, links=tuple(nothing), drives=()), sound)
    assert found.kept == ()
    assert "rods err" in headline(found)
    assert "file" not in headline(found)
    result = identification_result(found, None, {})
    values = result.values()
    for name in ("joints", "parameters"):
        keys = {*values[name][0]}
        assert "rods" in keys
        assert "file" not in keys
