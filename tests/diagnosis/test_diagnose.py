"""What is said of logs with one fault each, or none; every option mends the log it is said of."""

from __future__ import annotations

import re
import shlex
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import gd_analyze as gd
from diagnosed_logs import Arrays, late, log_of, said, told_numbers, written
from faulty_logs import Robot, ceiling, compensated, ur_like
from gd_analyze.diagnosis.answer import TELLS_NOTHING, answer
from gd_analyze.diagnosis.causes import CLEAR_FALL, is_unexplained
from gd_analyze.diagnosis.equations import (
    COM_ERROR,
    COM_ERROR_M,
    MASS_ERROR,
    corrected_columns,
    equations_of,
    file_errors,
)
from gd_analyze.diagnosis.fit import MOST_CHANGES, fitted
from gd_analyze.diagnosis.hypothesis import Problem, signs
from gd_analyze.diagnosis.log_verdict import DISPUTED, log_verdict
from gd_analyze.diagnosis.of_the_arm import carried
from gd_analyze.diagnosis.remedies import reordered
from gd_analyze.diagnosis.samples import FEWEST_SAMPLES, samples_of
from gd_analyze.diagnosis.trial import Trial
from gd_analyze.dynamics.base_parameters import parameters_of
from gd_analyze.errors import UsageError
from gd_analyze.motions.measured import settled
from gd_analyze.tables import with_payload
from long_cases import long
from robot_files import two_joints


@pytest.fixture(scope="module")
def robot(two_link) -> Robot:
    """A robot whose links are up to 20 % off."""
    return Robot.of(two_link, 3, seconds=10.0)


@pytest.fixture(scope="module")
def good(robot) -> Arrays:
    return robot.as_it_is


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
        "degrees": lambda: (time, np.degrees(q), torque),
        "degrees of one": lambda: (time, np.degrees(q) * [1.0, 0.0] + q * [0.0, 1.0], torque),
        "counts": lambda: (time, q * 8192 / (2.0 * np.pi), torque),
    }[kind]()


@pytest.mark.parametrize(
    ("kind", "option"),
    [
        ("torque sign", "--torque-sign"), long("one torque sign", "--torque-sign"),
        long("direction", "--position-sign"),
        long("scale", "--torque-constant"), long("coupled", "--couple"),
        ("zero", "--offset"), ("lag", "--lag"),
        long("exchanged", "--map"), ("time", "--map"),
        ("degrees", "--map"), ("degrees of one", "--torque-constant"),
        long("counts", "--torque-constant"),
    ],
)  # fmt: skip
def test_the_option_mends_the_log(kind, option, good, tmp_path):
    """What is said is typed, and then nothing needs an explanation."""
    log = written(tmp_path, *spoilt(kind, *good))
    as_logged = {"time": ["--map", "time=:s"], "degrees": ["--map", "q=:rad"]}
    found = said(log, *as_logged.get(kind, []))
    assert found["remedy"].startswith(option)
    assert found["remains_after"] < 0.5 * found["remains_before"]
    mended = said(log, *shlex.split(found["remedy"]))
    assert mended["cause"] is None
    assert mended["remains_before"] < 0.5 * found["remains_before"]
    # Interpolated and smoothed again, with another draw of the samples.
    assert mended["remains_before"] < 2.0 * found["remains_after"] + 0.02


@pytest.mark.slow
def test_the_zero_of_a_slide(tmp_path):
    """The boom of a Stanford arm, whose reach other joints feel."""
    robot = Robot.of(gd.load_arm("stanford"), 5)
    time, q, torque = robot.as_it_is
    log = written(tmp_path, time, q - 0.3 * (np.arange(6) == 2), torque)
    found = said(log, arm="stanford")
    assert found["remedy"].startswith("--offset 3=")
    assert found["remedy"].endswith("mm")
    assert said(log, *shlex.split(found["remedy"]), arm="stanford")["cause"] is None


@pytest.mark.slow
def test_joints_of_a_wrist_that_move_each_other(puma, tmp_path):
    """Axes 4 and 5 of a PUMA cross; power is the same in either pair of variables."""
    robot = Robot.of(puma, 4)
    time, q, torque = robot.as_it_is
    coupling = np.eye(6)
    coupling[4, 3] = 1.0
    log = written(tmp_path, time, q @ coupling.T, torque @ np.linalg.inv(coupling))
    found = said(log, arm="puma560")
    assert found["remedy"] == "--couple q5=q5-q4"
    assert said(log, *shlex.split(found["remedy"]), arm="puma560")["cause"] is None


@pytest.mark.slow
def test_velocity_columns_tell_the_unit_of_time(robot, good, tmp_path):
    """With them a pace that is no known unit is found, and without a wrong one it is not looked for."""
    time, q, torque = good
    found = said(written(tmp_path, 2.5 * time, q, torque, robot.states.qd))
    assert found["cause"] == "unit of time"
    assert "velocity columns" in found["ranking"][0]["what"]
    mended = said(written(tmp_path, 2.5 * time, q, torque, robot.states.qd), *shlex.split(found["remedy"]))
    assert mended["cause"] is None
    right = said(written(tmp_path, time, q, torque, robot.states.qd))
    assert "unit of time" not in {row["name"] for row in right["ranking"]}
    assert "faults" not in right


def test_velocities_in_another_unit(robot, good, tmp_path):
    """Positions alone are used; which columns disagree is told, and the option leaves them out."""
    time, q, torque = good
    log = written(tmp_path, time, q, torque, robot.states.qd * [1.0, np.degrees(1.0)])
    found = said(log)
    assert [(fault["name"], fault["joint"]) for fault in found["faults"]] == [("velocity column", 2)]
    assert found["cause"] is None
    assert found["faults"][0]["remedy"].endswith("--map qd=none")
    assert "faults" not in said(log, "--map", "qd=none")


@pytest.mark.filterwarnings("ignore:arm bench_arm does not state all limits")
def test_a_hand_of_the_file_that_the_robot_lacks(tmp_path):
    """The edit that is named, made, leaves nothing to explain."""
    hand = """<link name="hand"><inertial><origin xyz="0 0 0.1"/><mass value="30"/>
    <inertia ixx="0.02" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
    <joint name="grip" type="fixed"><parent link="lower"/><child link="hand"/>
    <origin xyz="0 0 0.5"/></joint>"""
    text = two_joints(hand)
    with_hand, without = tmp_path / "with.urdf", tmp_path / "without.urdf"
    with_hand.write_text(text)
    without.write_text(text.replace(hand, ""))
    arm, bare = gd.load_arm(with_hand), gd.load_arm(without)
    assert [end.name for end in arm.ends] == ["hand"]
    assert bare.ends == ()
    # What is named is what the file has more.
    assert abs(arm.links[-1].mass - arm.ends[0].mass - bare.links[-1].mass) < 1e-12 * arm.links[-1].mass
    robot = Robot.of(bare, 6)
    log = robot.log(*robot.as_it_is)
    found = gd.diagnose(arm, log)
    assert found.cause is not None
    assert found.cause.name == "payload"
    assert "hand" in str(found.cause.remedy).split()
    assert gd.diagnose(bare, log).causes == ()


def test_a_payload_that_was_not_carried(good, tmp_path):
    log = written(tmp_path, *good)
    mass = 8.0 * float(gd.load_arm("two_link").mass.sum())
    found = said(log, "--payload", f"{mass},0,0,0")
    assert found["remedy"] == "leave out --payload"
    assert said(log)["cause"] is None


def test_the_ranking_has_figures(good, tmp_path):
    time, q, torque = good
    rows = said(written(tmp_path, time, q, -torque))["ranking"]
    assert rows[0]["remedy"] == "--torque-sign -1"
    for row in rows:
        assert len(row["residuals"]) == 2
        assert row["remains"] > 0.0
    # The quadratic mean over joints.
    assert np.allclose([np.sqrt(np.mean(np.square(row["residuals"]))) for row in rows],
                       [row["remains"] for row in rows])  # fmt: skip


def test_the_main_job_diagnoses_its_log(robot, good, two_link, tmp_path):
    """One notice with the option; ranking and samples are stored; a log that agrees is not told of."""
    time, q, torque = good
    with pytest.warns(gd.GdAnalyzeWarning, match="--torque-sign -1"):
        found = gd.analyze(two_link, log_of(time, q, -torque), tmp_path / "run", level="element")
    notices = [text for text in found.warnings if "does not fit" in text]
    assert len(notices) == 1
    assert "--torque-sign -1" in notices[0]
    again = gd.load_findings(tmp_path / "run" / "analysis.h5").tables["diagnosis"]
    assert again.identical(found.tables["diagnosis"])
    assert again.cause_remedy.values[0] == "--torque-sign -1"
    page = (tmp_path / "run" / "report.html").read_text(encoding="utf-8")
    assert "figure-where" in page
    # It stands first: whatever else the page says is about another robot.
    lead = page.index('<p class="headline">')
    assert "does not fit" in page[lead : page.index("</p>", lead)]
    notices = page.index('<ul class="notices">')
    assert lead < notices
    assert "--torque-sign -1" in re.sub(r"<[^>]*>", "", page[notices : page.index("</li>", notices)])
    as_filed = log_of(time, q, gd.types.ArmDynamics(two_link).torque(*robot.states.arrays, drives=False))
    agreeing = gd.analyze(two_link, as_filed, level="element")
    assert agreeing.tables["measured_torque"].attrs["verdict"] == "agrees"
    assert not agreeing.tables["diagnosis"].sizes["cause"]
    assert not [text for text in agreeing.warnings if "The file" in text]


def test_the_verdict_on_a_log(good, two_link):
    """In a word and in sentences: of a sound log, a wrong one, noise or limits of a torque, and of rest.

    Single spikes put no log in doubt.
    """
    time, q, torque = good
    noise = 0.4 * np.sqrt((torque**2).mean(axis=0)) * np.random.default_rng(6).normal(size=torque.shape)
    spiky = torque.copy()
    spiky[100::200] *= 30.0
    clipped = np.clip(torque, *np.quantile(torque, [0.2, 0.8], axis=0))
    openings = {
        "agrees": "The file describes this robot: with friction",
        "agrees in part": "The file ",
        "does not agree": "The file does not fit this log: all torques are reversed.",
        "tells nothing": "The log does not tell whether the file describes this robot:",
    }
    for word, logged in (
        ("agrees", good),
        ("agrees", (time, q, spiky)),
        ("agrees in part", (time, q, clipped)),
        ("does not agree", (time, q, -torque)),
        ("agrees in part", (time, q, torque + noise)),
        ("tells nothing", (time, np.zeros_like(q), torque)),
    ):
        verdict = log_verdict(two_link, [log_of(*logged)])
        assert verdict.word == word
        assert verdict.text.startswith(verdict.opening)
        assert verdict.opening.startswith(openings[word])
        assert ("gd-analyze diagnose" in verdict.text) == (word in DISPUTED)
        assert (verdict.diagnosis is None) == (word == "tells nothing")


def test_constant_torques_tell_nothing(good, two_link):
    """Of one joint they are a wrong column; where every joint has them, nothing tells of the file."""
    time, q, torque = good
    constant = torque.copy()
    constant[:, 0] = 7.0
    verdict = log_verdict(two_link, [log_of(time, q, constant)])
    assert verdict.contradicted == (1,)
    assert "The torque of joint 1 is constant while it moves" in verdict.text
    verdict = log_verdict(two_link, [log_of(time, q, np.full_like(torque, 7.0))])
    assert (verdict.word, verdict.contradicted) == ("tells nothing", ())
    assert verdict.opening.startswith(f"{TELLS_NOTHING}. The torque of joint 1 is constant")


def test_nothing_is_wrong(robot, good, two_link):
    """A file off by up to 20 % is no cause, and its links are told to be off."""
    found = gd.diagnose(two_link, log_of(*good))
    page = ElementTree.fromstring(f"<p>{found._repr_html_()}</p>")
    assert [len(row) for row in page.iter("tr")] == [3] * (1 + two_link.n)
    assert found.causes == ()
    assert found.tells
    assert 0.0 < found.before.off < 0.4
    assert found.ranking
    assert all(one.fall <= CLEAR_FALL for one in found.ranking)


def test_the_file_of_another_arm_is_doubted(robot, good, two_link):
    """It is named as that, and a file that is its own is not."""
    rod, load = two_link.links
    other = replace(two_link, links=(replace(rod, mass=8.0 * rod.mass), replace(load, com=0.2 * load.com)))
    diagnosis = gd.diagnose(other, log_of(*good))
    assert diagnosis.cause is not None
    assert diagnosis.cause.name == "another arm"
    assert diagnosis.before.changed > MOST_CHANGES
    assert "links" in answer(diagnosis)
    own = gd.diagnose(two_link, log_of(*good))
    assert not own.is_far_off
    assert "links" not in answer(own)


@pytest.mark.slow
def test_another_mounting(robot, two_link):
    """An arm that hangs from the ceiling, and one that compensates its gravity."""
    for made, wanted in ((ceiling, -two_link.gravity_vector), (compensated, np.zeros(3))):
        log, *_ = made(robot)
        found = gd.diagnose(two_link, log)
        # The zero of a first joint whose axis is level is the same.
        named = [one for one in (*found.causes, *found.rivals) if one.name == "gravity"]
        assert np.allclose(named[0].correction.gravity, wanted)
        assert all(one.remedy.options.startswith("--gravity") for one in named)
        # Gravity along the axes of both joints makes no torque either.
        axis = np.array([0.0, 0.0, 1.0])
        assert all(np.allclose(np.cross(one.correction.gravity, axis), 0.0) for one in named[1:])
        assert len(named) == (1 if np.any(wanted) else 2)


def test_a_load_put_on(robot, two_link):
    """The instant of a change is told to half a second."""
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
    is_faulty = np.zeros(len(time), dtype=bool)
    if kind == "dead column":
        is_faulty[:] = True
        torque[:, 1] = 0.0
    elif kind == "frozen column":
        is_faulty[300:500] = True
        torque[300:500, 1] = torque[300, 1]
    elif kind == "clipped torque":
        end = np.quantile(np.abs(torque[:, 1]), 0.8)
        is_faulty = np.abs(torque[:, 1]) > end
        torque[:, 1] = np.clip(torque[:, 1], -end, end)
    else:
        is_faulty[100::97] = True
        torque[is_faulty, 1] += 30.0 * np.abs(torque[:, 1]).max()
    found = gd.diagnose(two_link, log_of(time, q, torque))
    assert [(fault.name, fault.joint) for fault in found.faults] == [(kind, 1)]
    assert found.causes == ()
    samples = found.problem.samples
    is_faulty_sample = is_faulty[samples.row]
    assert is_faulty_sample.any()
    assert not samples.counts[is_faulty_sample, 1].any()
    assert samples.counts[is_faulty_sample, 0].any()
    assert samples.counts[:, 1].any() == (kind != "dead column")


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
    samples = samples_of(robot.file, [log], [np.ones(log.q.shape, dtype=bool)])
    return Problem(samples, Trial.none(2))


def test_columns_times_the_files_numbers_are_its_torque(robot, good):
    """The column of the file's torque, and those of its errors, are what the regressor gives."""
    problem = problem_of(robot, good)
    columns, _, shared = corrected_columns(problem.samples, problem.correction)
    states = gd.types.States(problem.samples.q, problem.samples.qd, problem.samples.qdd)
    torque = gd.types.ArmDynamics(robot.file).torque(*states.arrays, drives=False)
    # Some hundred roundings of the largest.
    assert np.abs(columns[:, :, shared + 4].T - torque).max() < 1e-12 * np.abs(torque).max()


def test_errors_of_a_file_are_its_derivatives(puma):
    """A mass one standard deviation larger, and a centre moved, change the ten numbers so, to first order."""
    from dataclasses import replace

    errors = file_errors(puma)
    before = parameters_of(puma)[2]
    link, small = puma.links[2], 1e-6
    heavier = replace(link, mass=link.mass * (1.0 + small * MASS_ERROR))
    moved = small * (COM_ERROR * abs(link.com[1]) + COM_ERROR_M)
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
    equations = equations_of(reversed_.samples, reversed_.correction)
    alone = fitted(equations, signs(2, [0, 1]), FEWEST_SAMPLES)
    assert abs(alone.score - problem_of(robot, good).null.score) < 1e-6 * abs(alone.score)


@pytest.mark.parametrize("seed", [3, *map(long, range(4, 8))])
def test_torque_constants_are_told_with_errors_and_their_digits(two_link, seed):
    robot = Robot.of(two_link, seed, seconds=10.0)
    time, q, torque = robot.as_it_is
    constants = np.array([12.0, 40.0])
    ranking = gd.diagnose(two_link, robot.log(time, q, torque / constants)).ranking
    cause = next(one for one in ranking if one.name == "torque scale by joint" and one.numbers == 2)
    values, errors = told_numbers(cause.what)
    assert (np.abs(values - constants) < 3.0 * errors).all()
    # Links off by up to 25 % leave no less than some percent.
    assert (errors > 0.01 * values).all()
    # The option has their digits, and no more: two of the error, and the value to these.
    assert [float(word) for word in cause.remedy.options.split()[1].split(",")] == values.tolist()
    told = re.findall(r"([\d.]+) ± ", cause.what)
    for word, error in zip(told, errors, strict=True):
        assert len(word.partition(".")[2]) == max(0, 1 - int(np.floor(np.log10(error))))


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_a_payload_is_told_with_errors(puma, seed):
    robot, place = Robot.of(puma, seed), np.array([0.03, 0.05, 0.1])
    mass = 0.15 * float(robot.arm.mass.sum())
    torque = robot.noisy(robot.torque(with_payload(robot.arm, mass, place)))
    cause = next(
        one
        for one in gd.diagnose(puma, robot.log(robot.time, robot.states.q, torque)).ranking
        if one.name == "payload"
    )
    (value,), (error,) = told_numbers(cause.what)
    assert abs(value - mass) < 3.0 * error < value
    assert float(cause.remedy.options.split()[1].split(",")[0]) == value


@pytest.mark.slow
def test_errors_of_a_payload_hold(puma):
    """Mass and mass moment lie within two standard errors in nine of ten logs; of a normal law 95 %."""
    deviations = []
    for seed in range(40):
        robot = Robot.of((puma, ur_like())[seed % 2], 500 + seed)
        mass = robot.rng.uniform(0.08, 0.2) * float(robot.arm.mass.sum())
        place = 0.08 * robot.file.reach * robot.rng.uniform(-1.0, 1.0, 3)
        torque = robot.noisy(robot.torque(with_payload(robot.arm, mass, place)))
        log = robot.log(robot.time, robot.states.q, torque)
        samples = samples_of(robot.file, [log], [settled(log)[:, None]])
        problem = Problem(samples, Trial.none(robot.file.n_joints))
        load = carried(problem)
        fit = problem.fit(problem.correction.with_added(load))
        body, errors = (x[-len(load.sizes) :] * load.sizes for x in (fit.free, fit.errors))
        deviations.append((body[:4] - [mass, *(mass * place)]) / errors[:4])
    assert ((np.abs(deviations) < 2.0).mean(axis=0) >= 0.9).all()
    # Nor are they far too large.
    assert (np.sqrt(np.square(deviations).mean(axis=0)) > 0.5).all()


# Maps, small zeros, friction alone and a gain that drifts.


@pytest.fixture(scope="module")
def problem_of_columns(tmp_path_factory) -> Problem:
    """Of a log with columns, all of whose joints move."""
    robot = Robot.of(gd.load_arm("puma560"), 5, seconds=4.0)
    path = written(tmp_path_factory.mktemp("columns"), *robot.as_it_is)
    return gd.diagnose(robot.file, path).problem


@pytest.mark.parametrize(
    ("first", "second"),
    [
        ("012435", "012435"), ("021345", "013245"), ("543210", "120354"), ("250143", "315204"),
        ("123450", "501234"),
    ],
)  # fmt: skip
def test_maps_of_two_causes_give_every_joint_one_column(problem_of_columns, first, second):
    """Typed together, they take the columns that both orders, one after the other, take."""
    first, second = list(map(int, first)), list(map(int, second))
    problem, roles = problem_of_columns, ("q", "torque")
    both = [reordered(problem.samples, matrix, matrix) for matrix in (np.eye(6)[first], np.eye(6)[second])]
    words = [word for word in shlex.split(both[0].then(both[1]).options) if word != "--map"]
    maps = [re.fullmatch(r"(\w+):(.+)=[a-z]+(\d)", word).groups() for word in words]
    assert len({(role, joint) for role, joint, _ in maps}) == len(maps)
    names = [joint.name for joint in problem.arm.joints]
    columns = {(role, name): i for role in roles for i, name in enumerate(names)}
    columns |= {(role, name): int(column) - 1 for role, name, column in maps}
    expected = {(role, name): first[second[i]] for role in roles for i, name in enumerate(names)}
    assert columns == expected


@pytest.mark.slow
@pytest.mark.parametrize("order", [[0, 2, 3, 1, 4, 5], [0, 1, 2, 4, 3, 5]])
@pytest.mark.parametrize("what", ["positions", "torques"])
def test_columns_in_any_order_are_put_in_place(puma, order, what, tmp_path):
    """Three columns in turn, or two exchanged, of positions or torques alone; as typed, the maps mend it."""
    time, q, torque = Robot.of(puma, 7).as_it_is
    if what == "positions":
        q = q[:, order]
    else:
        torque = torque[:, order]
    path = written(tmp_path, time, q, torque)
    found = said(path, arm="puma560")
    assert found["remedy"].startswith("--map")
    mended = said(path, *shlex.split(found["remedy"]), arm="puma560")
    assert mended["cause"] is None
    assert mended["remains_before"] < 1.5 * found["remains_after"] + 0.01


@pytest.mark.parametrize("degrees", [-9.0, -5.0, 6.0, 8.0])
def test_a_small_zero_is_seen(robot, two_link, degrees):
    """Of a robot whose links are the file's, which would pass for it otherwise; to a degree."""
    exact = replace(robot, arm=two_link)
    time, q, torque = exact.time, exact.states.q, exact.noisy(exact.torque())
    found = gd.diagnose(two_link, log_of(time, q - np.radians([0.0, degrees]), torque))
    rows = [cause for cause in found.ranking if cause.name == "zero of a joint"]
    assert any(abs(np.degrees(cause.correction.offset[1]) - degrees) < 1.0 for cause in rows)


@pytest.mark.slow
@pytest.mark.parametrize("length", [-0.06, 0.05])
def test_a_small_zero_of_a_slide_is_seen(length):
    """Of a Stanford arm's boom, to a centimetre."""
    file = gd.load_arm("stanford")
    robot = replace(Robot.of(file, 5), arm=file)
    torque = robot.noisy(robot.torque())
    found = gd.diagnose(file, log_of(robot.time, robot.states.q - length * (np.arange(6) == 2), torque))
    rows = [cause for cause in found.ranking if cause.remedy.options.startswith("--offset 3=")]
    assert any(abs(cause.correction.offset[2] - length) < 0.01 for cause in rows)


@pytest.mark.parametrize("viscous", [0.0, 3.0])
def test_friction_alone_has_no_other_cause(robot, good, two_link, viscous):
    """Torques that hold no weight and no inertia, in any unit."""
    time, q, torque = good
    speed = robot.states.qd
    noise = 0.05 * np.random.default_rng(0).normal(size=torque.shape)
    found = gd.diagnose(two_link, log_of(time, q, 5.0 * np.sign(speed) + viscous * speed + noise))
    assert found.causes == ()
    assert not found.tells
    assert answer(found).startswith(f"{TELLS_NOTHING}: friction alone")


@pytest.mark.parametrize(
    ("growth", "joints"), [(-0.3, (0, 1)), (0.4, (0, 1)), (0.6, (0, 1)), (0.6, (0,)), (-0.4, (1,))]
)
def test_a_gain_that_drifts_is_no_change_of_load(good, two_link, growth, joints):
    """One number, to a tenth of the torque, of the right joints; links off by 20 % beside."""
    time, q, torque = good
    gain = np.ones_like(torque)
    gain[:, joints] += growth * (time / time[-1])[:, None]
    found = gd.diagnose(two_link, log_of(time, q, torque * gain))
    assert [cause.name for cause in found.causes] == ["drift of torques"]
    seen = found.causes[0].correction.gain
    assert seen is not None
    expected = np.where(np.isin([0, 1], joints), growth, 0.0)
    assert np.abs(seen[-1] / seen[0] - 1.0 - expected).max() < 0.1


@pytest.mark.parametrize("lag", [0.0, 0.03])
def test_a_little_lag_is_looked_for_where_links_would_hide_it(robot, two_link, lag):
    """As before an identification: a log that fits is accepted, and one that is late is not."""
    exact = replace(robot, arm=two_link)
    torque = late(exact.time, exact.noisy(exact.torque()), lag)
    found = gd.diagnose(two_link, log_of(exact.time, exact.states.q, torque))
    assert [cause.name for cause in found.causes] == ["lag of torque"] * (lag > 0.0)
    assert not is_unexplained(found.before)
