"""Every remedy, typed as it is printed: the log reads, and what file and log disagreed on is gone."""

from __future__ import annotations

import shlex
from collections.abc import Callable
from dataclasses import replace
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from hypothesis import given
from hypothesis import strategies as st

import faulty_logs
import gd_analyze as gd
from chains import generic_chain
from diagnosed_logs import written
from faulty_logs import FAULTS, Robot, log_of
from gd_analyze.arrays import FloatArray
from gd_analyze.cli.app import app
from gd_analyze.diagnosis.causes import CLEAR_FALL, HYPOTHESES, is_unexplained
from gd_analyze.diagnosis.faults import without_faults
from gd_analyze.diagnosis.hypothesis import Candidate, Problem, signs, swapped
from gd_analyze.diagnosis.remedies import (
    ONE_DEGREE,
    Remedy,
    at_pace,
    corrected,
    in_unit,
    nothing,
    reordered,
    with_constants,
)
from gd_analyze.diagnosis.samples import Samples, samples_of
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.motions.correction import Correction, at_instants
from gd_analyze.motions.read import read_log
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.types import Reading, RobotArm
from long_cases import long

# Remedies that are no options: what is done to robot, file or recording is said.
EDITS = {
    "load put on": "split the log at",
    "gain that drifts": "calibrate",
    "hand left out": "hand out of the file",
}


class _Read(Exception):  # noqa: N818  (carries what a verb has read)
    def __init__(self, arm: RobotArm, motions: list[Trajectory]) -> None:
        super().__init__()
        self.arm, self.motion = arm, motions[0]


@pytest.fixture
def typed(monkeypatch) -> Callable[..., tuple[RobotArm, Trajectory]]:
    """Arm and motion that `gd-analyze diagnose` reads as it is typed."""

    def caught(arm: RobotArm, motions: list[Trajectory]) -> None:
        raise _Read(arm, motions)

    def read(*words: str) -> tuple[RobotArm, Trajectory]:
        with monkeypatch.context() as patch:
            patch.setattr(gd, "diagnose", caught)
            done = CliRunner().invoke(app, ["diagnose", *words, "--measured", "--quiet"])
        assert isinstance(done.exception, _Read), done.output
        return done.exception.arm, done.exception.motion

    return read


def problem_of(arm: RobotArm, motion: Trajectory) -> Problem:
    _, motion = without_faults(arm, motion)
    usable = np.ones((motion.n_set_points, 1), dtype=bool)
    return Problem(samples_of(arm, [motion], [usable]), Trial.none(arm.n_joints))


def told_of(problem: Problem, name: str) -> Candidate:
    """The best cause of a kind."""
    causes = [
        cause for hypothesis in HYPOTHESES if hypothesis.name == name for cause in hypothesis.judged(problem)
    ]
    return max(causes, key=lambda cause: cause.fall)


def position_unit(sizes: list[float]) -> faulty_logs.Fault:
    """Positions in units of these sizes."""
    return lambda robot: log_of(
        robot, "unit of positions", Trial.none(len(sizes)).with_position(np.diag(sizes))
    )


def columns_exchanged(what: str) -> faulty_logs.Fault:
    """Positions alone, or torques one column late, of an arm of any number of joints."""

    def made(robot: Robot) -> faulty_logs.Made:
        none, n = Trial.none(robot.file.n_joints), robot.file.n_joints
        if what == "positions":
            return log_of(robot, "order of joints", none.with_position(swapped(n, 1, 2)))
        return log_of(robot, "order of torques", none.with_torque(np.roll(np.eye(n), 1, axis=0)))

    return made


def motor_side(robot: Robot) -> faulty_logs.Made:
    """Positions and torques of the motors of a file with gears."""
    ratios = np.array([drive.gear_ratio for drive in robot.file.drives])
    return log_of(robot, "motor side", Trial.none(len(ratios)).with_joints(np.diag(1.0 / ratios)))


def positions_the_other_way(robot: Robot) -> faulty_logs.Made:
    """Positions of one joint reversed, and not its torques."""
    return log_of(robot, "direction of a joint", Trial.none(2).with_position(signs(2, [0])))


def one_constant(robot: Robot) -> faulty_logs.Made:
    """The torque of one joint times a factor."""
    return log_of(robot, "torque scale by joint", Trial.none(2).with_torque(np.diag([1.0, 5.0])))


def in_milliseconds(robot: Robot) -> faulty_logs.Made:
    """Time in ms, and no column that says so."""
    return log_of(robot, "unit of time", replace(Trial.none(2), pace=1e-3))


def drifting(robot: Robot) -> faulty_logs.Made:
    """A gain that grows by a half."""
    time, q, torque = robot.as_it_is
    gain = 1.0 + 0.5 * (time / time[-1])[:, None]
    return robot.log(time, q, gain * torque), robot.file, "drift of torques", lambda cause: True, None


# A planar arm of two joints has neither a wrist nor a slide, and a payload is hardly told from its links.
FITTING = [name for name in FAULTS if name not in ("joint coupled across", "zero of a slide", "payload")]
CASES: dict[tuple[str, str], faulty_logs.Fault] = {
    **{("two_link", name): FAULTS[name] for name in FITTING},
    ("two_link", "degrees"): position_unit([ONE_DEGREE, ONE_DEGREE]),
    ("two_link", "degrees of one joint"): position_unit([1.0, ONE_DEGREE]),
    ("two_link", "counts"): position_unit([2.0 * np.pi / 8192, 2.0 * np.pi / 8192]),
    ("two_link", "positions alone the other way"): positions_the_other_way,
    ("two_link", "one torque constant"): one_constant,
    ("two_link", "time in ms"): in_milliseconds,
    ("two_link", "gain that drifts"): drifting,
    ("stanford", "payload"): FAULTS["payload"],
    ("stanford", "zero of a slide"): FAULTS["zero of a slide"],
    ("stanford", "millimetres of the slide"): position_unit([1.0, 1.0, 1e-3, 1.0, 1.0, 1.0]),
    ("puma560", "joint coupled across"): FAULTS["joint coupled across"],
    ("puma560", "positions exchanged"): columns_exchanged("positions"),
    ("puma560", "torques one column early"): columns_exchanged("torques"),
    ("puma560", "motor side"): motor_side,
}
LONG = ("millimetres of the slide", "torques one column early", "motor side", "payload")
# Seeds of robots whose logs show the fault; others have 3.
SEEDS = {"torques in another unit": 4, "torques times a factor": 6}


@pytest.mark.filterwarnings("ignore:log log. qd of every joint")
@pytest.mark.parametrize(("arm", "fault"), [long(*case) if case[1] in LONG else case for case in CASES])
def test_the_remedy_is_typed_as_printed_and_mends_the_log(arm, fault, typed, tmp_path):
    robot = Robot.of(gd.load_arm(arm), SEEDS.get(fault, 3), seconds=6.0, rate=80.0)
    made = CASES[arm, fault](robot)
    assert made is not None
    log, file, name, _, _ = made
    assert log.recording is not None
    assert log.recording.torque is not None
    path = written(tmp_path, log.time, log.recording.q, log.recording.torque, log.recording.qd)
    # Units that are not stated follow from the numbers where these tell; the arm with a hand is in no file.
    as_logged = ["--map", "time=:s"] if fault == "time in ms" else ["--map", "q=:rad", "--map", "qd=:rad"]
    problem = problem_of(file, log) if fault == "hand left out" else problem_of(*typed(arm, path, *as_logged))
    cause = told_of(problem, name)
    assert cause.fit is not None
    if fault in EDITS:
        assert cause.fall > 0.0
        assert EDITS[fault] in str(cause.remedy)
        assert not cause.remedy.options
        return
    assert cause.fall > CLEAR_FALL
    mended = problem_of(*typed(arm, path, *shlex.split(str(cause.remedy))))
    # Interpolated and smoothed again, of other samples, and of numbers with few digits.
    assert mended.null.remains < 1.5 * cause.fit.remains + 0.02
    assert not is_unexplained(mended.null)


# Two remedies.

JOINTS = 3
SIGNS = st.tuples(*[st.sampled_from([1.0, -1.0])] * JOINTS).map(np.diag)
ORDERS = st.sampled_from([np.eye(JOINTS)[list(order)] for order in permutations(range(JOINTS))])


def coupling(i: int, j: int, factor: float) -> FloatArray:
    matrix = np.eye(JOINTS)
    matrix[i, j] = factor
    return matrix


COUPLINGS = st.sampled_from(
    [coupling(i, j, factor) for i, j in permutations(range(JOINTS), 2) for factor in (1.0, -1.0, 0.5)]
)
NONE = Correction.none(JOINTS)
CONSTANTS = st.tuples(*[st.sampled_from([1.0, 0.001, 12.5])] * JOINTS).map(np.array)
OFFSETS = st.tuples(st.integers(0, JOINTS - 1), st.sampled_from([0.5, -1.25]))
# One thing that is wrong with a log, as a function of its samples.
WRONG: st.SearchStrategy[Callable[[Samples], Remedy]] = st.one_of(
    SIGNS.map(lambda signs: lambda log: corrected(log, NONE.with_torque(signs))),
    SIGNS.map(lambda signs: lambda log: corrected(log, NONE.with_joints(signs))),
    COUPLINGS.map(lambda matrix: lambda log: corrected(log, NONE.with_joints(matrix))),
    CONSTANTS.map(lambda constants: lambda log: with_constants(log, constants)),
    OFFSETS.map(lambda offset: lambda log: corrected(log, NONE.with_offset(*offset))),
    ORDERS.map(lambda order: lambda log: reordered(log, order, order)),
    ORDERS.map(lambda order: lambda log: reordered(log, np.eye(JOINTS), order)),
    st.just(lambda log: in_unit(log, np.full(JOINTS, ONE_DEGREE))),
    st.just(lambda log: in_unit(log, np.array([1.0, ONE_DEGREE, 1.0]))),
    st.just(lambda log: at_pace(log, 1e-3)),
    st.just(lambda log: corrected(log, replace(NONE, lag=0.02))),
)


@pytest.fixture(scope="module")
def problem_of_three(tmp_path_factory) -> Callable[[], tuple[Problem, Path]]:
    """Of a log with columns of three joints, and its path; in a function, whose representation is short."""
    arm = generic_chain(JOINTS)
    time = np.arange(0.0, 1.0, 0.02)
    angles = np.sin(np.outer(time, [3.0, 4.0, 5.0]))
    path = written(tmp_path_factory.mktemp("three"), time, angles, 2.0 * angles[:, ::-1] + 1.0)
    log = gd.read_trajectory(path, arm, Reading(measured=True))
    problem = problem_of(arm, log)
    return lambda: (problem, Path(path))


@given(wrong=WRONG, too=WRONG)
def test_two_remedies_typed_together_do_what_both_do(problem_of_three, wrong, too):
    """The log as read with the options has the numbers of the two corrections, one after the other."""
    problem, path = problem_of_three()
    first, second = wrong(problem.samples), too(problem.samples)
    both = first.then(second)
    if not both.is_typed:
        return
    arm = problem.arm
    raw = read_log(path, arm, Reading(measured=True))
    log = read_log(path, arm, Reading.of(**both.reading, measured=True))
    once = Problem(problem.samples, problem.mended(first))
    trial = once.mended(second)
    assert log.torque is not None
    assert raw.torque is not None
    # Factors of twelve digits.
    np.testing.assert_allclose(log.q, trial.of_positions(raw.q), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(log.time, trial.pace * raw.time, rtol=1e-9)
    late = at_instants(raw.time + trial.lag, raw.time, trial.of_torques(raw.torque))
    scale = np.nanmax(np.abs(late))
    np.testing.assert_allclose(log.torque, late, rtol=1e-9, atol=1e-9 * scale)


def test_what_cannot_be_typed_together_is_not(problem_of_three):
    """Torques alone in another order, of joints that are coupled, have no option."""
    problem, _ = problem_of_three()
    coupled = corrected(problem.samples, NONE.with_joints(coupling(0, 1, 0.5)))
    exchanged = reordered(problem.samples, np.eye(JOINTS), swapped(JOINTS, 0, 2))
    assert coupled.is_typed
    assert exchanged.then(coupled).is_typed
    assert not coupled.then(exchanged).is_typed
    assert str(nothing(problem.samples)) == ""
