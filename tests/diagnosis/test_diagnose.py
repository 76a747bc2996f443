"""What is said of logs with one fault each, or none; every option mends the log it is said of."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st

import gd_analyze as gd
from diagnosis_trial import Robot
from gd_analyze.cli.app import app
from gd_analyze.diagnosis.answer import answer
from gd_analyze.diagnosis.correction import Correction
from gd_analyze.diagnosis.equations import columns_of, equations_of, file_errors
from gd_analyze.diagnosis.faults import faults_of
from gd_analyze.diagnosis.fit import fitted
from gd_analyze.diagnosis.hypothesis import Problem, signs
from gd_analyze.diagnosis.samples import samples_of
from gd_analyze.diagnosis.settings import SETTINGS
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.errors import UsageError
from gd_analyze.motions.logged import Logged
from gd_analyze.motions.trajectory import Trajectory

Arrays = tuple[np.ndarray, np.ndarray, np.ndarray]


@pytest.fixture(scope="module")
def robot(two_link) -> Robot:
    """A robot whose links are up to 20 % off."""
    return Robot.of(two_link, 3, seconds=10.0)


@pytest.fixture(scope="module")
def good(robot) -> Arrays:
    return robot.as_it_is


def log_of(time: np.ndarray, q: np.ndarray, torque: np.ndarray) -> Trajectory:
    return Trajectory.from_log(Logged(time, q, None, None, torque, measured=True))


def written(folder: Path, time: np.ndarray, q: np.ndarray, torque: np.ndarray) -> str:
    path = folder / "log.csv"
    head = ",".join(["time", "q1", "q2", "torque1", "torque2"])
    np.savetxt(path, np.column_stack([time, q, torque]), delimiter=",", header=head, comments="")
    return str(path)


def said(*words: str) -> dict:
    done = CliRunner().invoke(app, ["diagnose", "two_link", *words, "--measured", "--json", "--quiet"])
    assert done.exit_code == 0, done.output
    return json.loads(done.stdout)


def late(time: np.ndarray, torque: np.ndarray, lag: float) -> np.ndarray:
    return np.column_stack([np.interp(time - lag, time, column) for column in torque.T])


def spoilt(kind: str, time: np.ndarray, q: np.ndarray, torque: np.ndarray) -> Arrays:
    coupling = np.array([[1.0, 0.0], [1.0, 1.0]])
    return {
        "torque sign": lambda: (time, q, -torque),
        "one torque sign": lambda: (time, q, torque * [1.0, -1.0]),
        "direction": lambda: (time, q * [-1.0, 1.0], torque * [-1.0, 1.0]),
        "scale": lambda: (time, q, 1000.0 * torque),
        "zero": lambda: (time, q + np.array([np.pi / 2.0, 0.0]), torque),
        "coupled": lambda: (time, q @ coupling.T, torque @ np.linalg.inv(coupling)),
        "lag": lambda: (time, q, late(time, torque, 0.06)),
        "time": lambda: (1000.0 * time, q, torque),
        "exchanged": lambda: (time, q, torque[:, ::-1]),
    }[kind]()


@pytest.mark.parametrize(
    ("kind", "option"),
    [
        ("torque sign", "--torque-sign"), ("one torque sign", "--torque-sign"),
        ("direction", "--position-sign"),
        ("scale", "--torque-constant"), ("zero", "--offset"), ("coupled", "--couple"), ("lag", "--lag"),
        ("exchanged", "--map"), ("time", "--time-unit"),
    ],
)  # fmt: skip
def test_the_option_mends_the_log(kind, option, good, tmp_path):
    """What is said is typed, and then nothing needs an explanation."""
    log = written(tmp_path, *spoilt(kind, *good))
    found = said(log, *(["--time-unit", "s"] if kind == "time" else []))
    assert found["remedy"].startswith(option)
    assert found["remains_after"] < 0.5 * found["remains_before"]
    mended = said(log, *found["remedy"].split())
    assert mended["cause"] is None
    assert mended["remains_before"] < 0.5 * found["remains_before"]
    # Interpolated and smoothed again, with another draw of the samples.
    assert mended["remains_before"] < 2.0 * found["remains_after"] + 0.02


def test_nothing_is_wrong(robot, good, two_link):
    """A file off by up to 20 % is no cause, and its links are told to be off."""
    found = gd.diagnose(two_link, log_of(*good))
    assert found.causes == ()
    assert found.tells
    assert 0.0 < found.before.off < 0.4
    assert found.ranking
    assert all(one.fall <= SETTINGS.margin for one in found.ranking)


def test_the_file_of_another_arm_is_doubted(robot, good, two_link):
    """Whatever explains its torques best, the links would have to be far off."""
    rod, load = two_link.links
    other = replace(two_link, links=(replace(rod, mass=8.0 * rod.mass), replace(load, com=0.2 * load.com)))
    diagnosis = gd.diagnose(other, log_of(*good))
    assert diagnosis.is_far_off
    assert "the file is of this arm" in answer(diagnosis)
    own = gd.diagnose(two_link, log_of(*good))
    assert not own.is_far_off
    assert "the file is of this arm" not in answer(own)


def test_another_mounting(robot, two_link):
    """An arm that hangs from the ceiling, and one that compensates its gravity."""
    from diagnosis_trial import ceiling, compensated

    for made, wanted in ((ceiling, -two_link.gravity), (compensated, np.zeros(3))):
        log, *_ = made(robot)
        found = gd.diagnose(two_link, log)
        # The zero of a first joint whose axis is level is the same.
        named = [one for one in (*found.causes, *found.rivals) if one.name == "gravity"]
        assert len(named) == 1
        assert np.allclose(named[0].correction.gravity, wanted)
        assert named[0].remedy.startswith("--gravity")


def test_a_load_put_on(robot, two_link):
    """The instant of a change is told to half a second."""
    from gd_analyze.robots.payload import with_payload

    loaded = robot.torque(with_payload(robot.arm, 0.8, np.array([0.1, 0.0, 0.0])))
    torque = robot.noisy(np.where((robot.time > 6.0)[:, None], loaded, robot.torque()))
    found = gd.diagnose(two_link, robot.log(robot.time, robot.states.q, torque))
    assert found.cause is not None
    assert found.cause.name == "change in time"
    when = float(found.cause.what.split(" at ")[1].split()[0])
    assert abs(when - 6.0) < 0.5


@pytest.mark.parametrize("kind", ["dead column", "frozen column", "clipped torque", "spikes"])
def test_faulty_readings_are_told_and_left_out(kind, good, two_link):
    time, q, torque = good
    torque = torque.copy()
    if kind == "dead column":
        torque[:, 1] = 0.0
    elif kind == "frozen column":
        torque[300:500, 1] = torque[300, 1]
    elif kind == "clipped torque":
        end = np.quantile(np.abs(torque[:, 1]), 0.8)
        torque[:, 1] = np.clip(torque[:, 1], -end, end)
    else:
        torque[100::97, 1] += 30.0 * np.abs(torque[:, 1]).max()
    faults, usable = faults_of(two_link, [log_of(time, q, torque)])
    assert [(fault.name, fault.joint) for fault in faults] == [(kind, 1)]
    assert usable[0][:, 0].all()
    assert not usable[0][:, 1].all()
    found = gd.diagnose(two_link, log_of(time, q, torque))
    assert [fault.name for fault in found.faults] == [kind]
    assert found.causes == ()


def test_too_little_motion(two_link):
    """With 1 % of a motion and noise the log tells nothing, and this is said."""
    robot = Robot.of(two_link, 3, seconds=10.0, share=0.01)
    torque = robot.torque() + 0.2 * robot.rng.normal(size=robot.states.q.shape)
    try:
        found = gd.diagnose(two_link, robot.log(robot.time, robot.states.q, torque))
    except UsageError:
        return
    assert not found.tells
    assert found.causes == ()


def test_without_torques_or_masses_it_is_refused(two_link, swing):
    with pytest.raises(UsageError):
        gd.diagnose(two_link, swing)


def problem_of(robot: Robot, arrays: Arrays) -> Problem:
    log = log_of(*arrays)
    samples = samples_of(robot.file, [log], [np.ones(log.q.shape, dtype=bool)], SETTINGS)
    return Problem(samples, Correction.none(2), SETTINGS)


def test_columns_times_the_files_numbers_are_its_torque(robot, good):
    """The column of the file's torque, and those of its errors, are what the regressor gives."""
    problem = problem_of(robot, good)
    columns, _, shared = columns_of(problem.samples, problem.correction, SETTINGS)
    states = gd.States(problem.samples.q, problem.samples.qd, problem.samples.qdd)
    from gd_analyze.dynamics.decomposition import torque_of

    torque = torque_of(robot.file, states, drives=False)
    # Some hundred roundings of the largest.
    assert np.abs(columns[:, :, shared + 4].T - torque).max() < 1e-12 * np.abs(torque).max()


def test_errors_of_a_file_are_its_derivatives(puma):
    """A mass one standard deviation larger, and a centre moved, change the ten numbers so, to first order."""
    from dataclasses import replace

    errors = file_errors(puma, SETTINGS)
    before = parameters_of(puma)[2]
    link, small = puma.links[2], 1e-6
    heavier = replace(link, mass=link.mass * (1.0 + small * SETTINGS.mass))
    moved = small * (SETTINGS.lever * abs(link.com[1]) + SETTINGS.lever_m)
    shifted = replace(link, com=link.com + np.array([0.0, moved, 0.0]))
    for k, changed in ((0, heavier), (2, shifted)):
        arm = replace(puma, links=(*puma.links[:2], changed, *puma.links[3:]))
        # Second order in the step, and rounding over it.
        assert np.allclose((parameters_of(arm)[2] - before) / small, errors[2, :, k], atol=1e-6)


@settings(max_examples=10)
@given(factor=st.floats(0.01, 100.0), joint=st.integers(0, 1))
def test_the_score_knows_no_unit(robot, good, factor, joint):
    """The score of torques in another unit, converted, is that of the torques."""
    time, q, torque = good
    problem = problem_of(robot, good)
    other = torque.copy()
    other[:, joint] *= factor
    changed = problem_of(robot, (time, q, other))
    matrix = np.eye(2)
    matrix[joint, joint] = 1.0 / factor
    first = problem.fit(problem.correction)
    second = changed.fit(changed.correction.with_torque(matrix))
    # Logarithms of squared residuals, each of some hundred.
    assert abs(first.score - second.score) < 1e-3 * max(abs(first.score), 1.0)
    assert np.allclose(first.residuals, second.residuals, rtol=1e-4)


def test_reversed_torques_are_noticed_in_products_alone(robot, good):
    """A fit from products equals one whose torques were reversed before."""
    time, q, torque = good
    reversed_ = problem_of(robot, (time, q, -torque))
    equations = equations_of(reversed_.samples, reversed_.correction, SETTINGS)
    alone = fitted(equations, signs(2, [0, 1]), SETTINGS)
    assert abs(alone.score - problem_of(robot, good).null.score) < 1e-6 * abs(alone.score)
