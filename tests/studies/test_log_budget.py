"""A budget from a log: what an error leaves, how far it is halved, and what models and exports say of it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import diagnosed_logs
import gd_analyze as gd
from gd_analyze.certification.held import Held
from gd_analyze.diagnosis.log_resolution import LogResolution
from gd_analyze.diagnosis.log_verdict import log_verdict
from gd_analyze.errors import UsageError
from gd_analyze.motions.measured import filtered_torque
from gd_analyze.motions.states import States, states_of
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.results.beside_log import joint_verdicts, joints_beside_log
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.model_file import measured_at
from gd_analyze.studies.against_log import with_log, within_log
from logs_of_arms import TrueArm, fourier, with_torque


@pytest.fixture(scope="module")
def log(two_link) -> Trajectory:
    """A log of a robot whose links are a little off the file's, with friction."""
    true = TrueArm.near(two_link, 3)
    time, states = fourier(two_link, 8.0, 100.0, 1)
    return true.log(time, states, seed=1)


@pytest.fixture(scope="module")
def resolution(two_link, log) -> LogResolution:
    verdict = log_verdict(two_link, [log])
    assert verdict.word == "agrees"
    assert verdict.resolution is not None
    return verdict.resolution


@pytest.fixture(scope="module")
def model(two_link, log) -> gd.types.SimplifiedModel:
    return gd.simplify(two_link, log, "log", at_set_points=True)


def test_what_friction_and_drives_explain_leaves_nothing_more(resolution):
    numbers = np.array([[0.2, 1.0, 0.7, -0.3], [0.1, 0.0, 0.4, 2.0]])
    error = np.einsum("itc,ic->ti", resolution.own, numbers)
    growth = resolution.growth(error)
    # Least squares removes what its columns span to some eps of their size, over what is left.
    tolerance = 1e3 * np.finfo(float).eps * np.abs(error).max() / resolution.left.min()
    np.testing.assert_allclose(growth.fitted, 0.0, atol=tolerance)
    np.testing.assert_allclose(growth.held_out, 0.0, atol=tolerance)


@given(seed=st.integers(0, 2**32 - 1), size=st.floats(1e-3, 10.0))
def test_no_error_shows_by_more_than_its_own_size(resolution, seed, size):
    """The triangle inequality: the RMS left grows by no more than the error's RMS, on the rows fitted."""
    error = size * np.random.default_rng(seed).normal(size=resolution.difference.shape)
    is_fitted = ~resolution.is_held_out[:, None] & np.isfinite(resolution.difference)

    def rms(values):
        return np.sqrt(np.nanmean(np.where(is_fitted, values, np.nan) ** 2, axis=0))

    most = rms(error) / rms(resolution.difference)
    growth = resolution.growth(error)
    assert (growth.fitted <= most * (1.0 + 1e-9)).all()  # rounding of sums of squares
    assert (growth.most >= 0.0).all()


def test_shares_are_halved_until_the_log_shows_no_error(two_link, log, resolution):
    exact = with_log(ExactDynamics.of(two_link, log), log_verdict(two_link, [log]))
    tried = []

    def search(budget: Budget) -> Held:
        tried.append(budget)
        torques = Budget.of_torques(exact.allowed(budget))
        return Held(gd.simplify(two_link, log, torques, at_set_points=True))

    assert within_log(exact, resolution, Budget.parse("log"), [search]) is not None
    shares = np.array([[entry[0].amount for entry in budget.of_joints(2)] for budget in tried])
    assert (shares[0] == 1.0).all()
    assert np.isin(shares[1:] / shares[:-1], [0.5, 1.0]).all()
    assert (shares >= 1.0 / 16.0).all()


def test_no_model_is_within_a_log_where_too_many_terms_matter(two_link, log, resolution):
    exact = with_log(ExactDynamics.of(two_link, log), log_verdict(two_link, [log]))
    assert within_log(exact, resolution, Budget.parse("50% log"), [lambda budget: None]) is None


def test_a_model_says_what_the_log_says_of_it(two_link, log, model):
    stated = model.accuracy.log
    assert stated is not None
    compared = gd.compare_torque(two_link, log)
    np.testing.assert_array_equal(stated.rms_exact, compared.friction.rms)
    assert stated.readings == compared.compared
    assert (stated.below_95 < compared.peak_measured).all()
    assert stated.contradicted == ()
    # The RMS of all readings, whose friction is fitted to all of them, is no larger than that of the samples
    # not fitted by more than what links explain.
    assert (stated.rms < compared.rms_measured).all()
    assert model.accuracy.asked.wholes == {"log"}
    assert (model.accuracy.errors.largest <= model.accuracy.allowed).all()


def test_a_model_keeps_what_the_log_says_in_its_file(model, tmp_path):
    gd.save_model(model, tmp_path / "model.json")
    loaded = gd.load_model(tmp_path / "model.json")
    for name, value in vars(model.accuracy.log).items():
        np.testing.assert_array_equal(getattr(loaded.accuracy.log, name), value)
    np.testing.assert_array_equal(loaded.accuracy.allowed, model.accuracy.allowed)


def test_a_header_states_both_errors(model, tmp_path):
    gd.export(model, "c").save(tmp_path)
    (text,) = [path.read_text() for path in tmp_path.glob("*.h")]
    stated = model.accuracy.log
    assert f"Against the log {stated.name}, {stated.readings} readings" in text
    assert stated.fingerprint in text
    assert f"{stated.rms[0]:.3g}" in text.partition("Against the log")[2]
    assert "CONTRADICTED" not in text


def test_friction_is_exported_with_the_values_fitted_to_the_log(model, tmp_path):
    gd.export(model, "python", what=["friction"]).save(tmp_path)
    (path,) = tmp_path.glob("*.py")
    functions: dict[str, object] = {}
    exec(path.read_text(), functions)
    (friction,) = [value for name, value in functions.items() if name.endswith("friction")]
    speed = np.array([0.5, -0.4])
    stated = model.accuracy.log
    expected = stated.coulomb * np.sign(speed) + stated.viscous * speed + stated.offset
    np.testing.assert_allclose(friction(speed), expected, rtol=1e-12)


def test_a_contradicted_file_gets_no_budget_from_the_log(two_link, log):
    assert log.recording is not None
    reversed_log = with_torque(log, -log.recording.torque)
    with (
        pytest.warns(gd.GdAnalyzeWarning, match="reversed"),
        pytest.raises(UsageError, match="this log gives no budget") as error,
    ):
        gd.simplify(two_link, reversed_log, "log")
    assert "reversed" in str(error.value)


def test_a_header_says_that_the_log_contradicts_the_file(two_link, log, tmp_path):
    assert log.recording is not None
    reversed_log = with_torque(log, -log.recording.torque)
    with pytest.warns(gd.GdAnalyzeWarning, match="reversed"):
        model = gd.simplify(two_link, reversed_log, "5%", at_set_points=True)
    gd.export(model, "c").save(tmp_path)
    (text,) = [path.read_text() for path in tmp_path.glob("*.h")]
    assert "CONTRADICTED BY THE LOG at every joint" in text
    assert "--torque-sign -1" in text


def test_a_plan_gives_no_budget(two_link):
    with pytest.raises(UsageError, match="no measured torques"):
        gd.simplify(two_link, "two-link-swing", "log")


def test_the_main_job_takes_the_budget_of_a_log_that_agrees(two_link, log):
    findings = gd.analyze(two_link, log)
    assert findings.model.accuracy.asked.wholes == {"log"}
    assert findings.tables["stops"].budget.values.tolist()[1:] == ["1%", "1% or 10% friction"][:1]
    asked = gd.analyze(two_link, log, budget="1%")
    assert asked.model.accuracy.budget == "1%"


def test_the_main_job_offers_no_model_where_the_log_contradicts(two_link, log):
    assert log.recording is not None
    reversed_log = replace(with_torque(log, -log.recording.torque), name="reversed")
    with pytest.warns(gd.GdAnalyzeWarning, match="reversed"):
        findings = gd.analyze(two_link, reversed_log)
    assert findings.model.is_exact
    assert findings.model.accuracy.log.contradicted == (1, 2)


def test_a_bound_that_a_file_states_is_not_called_proven(two_link, log, tmp_path):
    findings = gd.analyze(two_link, log, tmp_path / "run", budget="60%", formats=["h5"])
    assert findings.model.saves
    loaded = gd.load_findings(tmp_path / "run" / "analysis.h5")
    for shown, proof in ((findings, "proven"), (loaded, "stated in the file")):
        (heading,) = [column.label for column in joints_beside_log(shown).columns if column.key == "bound"]
        assert heading == f"error, {proof}"


def test_a_model_within_a_logs_budget_is_measured_and_judged_again(two_link, log, tmp_path):
    """What the log left is stated in the file: there is no log where it is read."""
    model = gd.simplify(two_link, log, "log")
    model.save(tmp_path / "model.json")
    loaded = gd.load_model(tmp_path / "model.json")
    again = measured_at(loaded, states_of(log))
    np.testing.assert_array_equal(again.accuracy.allowed, model.accuracy.allowed)
    evaluation = gd.evaluate(loaded, log, fail_over="log")
    assert evaluation.verdict == "passed"


def test_a_row_of_the_table_is_of_one_set_of_samples(two_link, log):
    """Share times the RMS measured is the residual, and 95 % of a sample are below twice its RMS or so."""
    findings = gd.analyze(two_link, log, level="element")
    table = joints_beside_log(findings)
    columns = {column.key: np.array(column.values) for column in table.columns}
    measured = findings.tables["measured_torque"].rms_measured.values
    # 400 of 800 readings: their RMS is uncertain by 1 / sqrt(2 * 400), 4 %; 3 sigma.
    np.testing.assert_allclose(columns["residual"], columns["share_left"] * measured, rtol=0.12)
    assert (columns["residual_below_95"] > columns["residual"]).all()


def test_of_a_log_that_tells_nothing_no_joint_fits(two_link):
    true = TrueArm.near(two_link, 3)
    time, wide = fourier(two_link, 8.0, 100.0, 1)
    small = States(wide.q[0] + 0.02 * (wide.q - wide.q[0]), 0.02 * wide.qd, 0.02 * wide.qdd)
    log = true.log(time, small, seed=1)
    assert log.recording is not None
    noise = np.random.default_rng(0).normal(size=small.q.shape)
    with pytest.warns(gd.GdAnalyzeWarning, match="does not tell"):
        findings = gd.analyze(two_link, with_torque(log, log.recording.torque + noise), level="element")
    assert findings.tables["measured_torque"].attrs["verdict"] == "tells nothing"
    assert {*joint_verdicts(findings)} == {"not told"}


def test_missing_torques_are_not_compared(two_link, log):
    """The filter bridges them; what it makes there is no reading."""
    assert log.recording is not None
    assert log.recording.torque is not None
    torque = log.recording.torque.copy()
    torque[: len(torque) // 3] = np.nan
    motion = diagnosed_logs.log_of(log.time, log.recording.q, torque)
    assert np.isnan(filtered_torque(motion)[: len(torque) // 3]).all()
    assert np.isfinite(filtered_torque(motion)[len(torque) // 3 :]).all()
    verdict = log_verdict(two_link, [motion])
    assert verdict.word == "agrees"
