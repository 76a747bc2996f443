"""What may be claimed of a log: causes that explain it, those that are one and the same, and no others."""

from __future__ import annotations

import shlex
from dataclasses import replace

import numpy as np
import pytest

import gd_analyze as gd
from diagnosed_logs import Arrays, late, log_of, said, written
from faulty_logs import Robot, ur_like
from gd_analyze.diagnosis.answer import answer, word_of
from gd_analyze.diagnosis.causes import is_same
from gd_analyze.diagnosis.fit import MOST_CHANGES
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.motions.states import States
from gd_analyze.results.beside_log import joint_verdicts
from gd_analyze.tables import with_payload
from gd_analyze.types import Diagnosis, Drive, RobotArm


@pytest.fixture(scope="module")
def robot(two_link) -> Robot:
    """A robot whose links are up to 20 % off."""
    return Robot.of(two_link, 3, seconds=10.0)


@pytest.fixture(scope="module")
def good(robot) -> Arrays:
    return robot.as_it_is


def is_claim_sound(found: Diagnosis) -> bool:
    """Whether what remains is clearly less than without the causes, and less than half of the torque."""
    ratio = found.after.remains / found.before.remains
    return not found.causes or (ratio <= 0.8 and found.after.remains <= 0.5)


# Whatever is wrong.


@pytest.mark.parametrize("kind", range(5))
def test_no_cause_leaves_nearly_as_much(good, two_link, kind):
    """Logs with several faults, or with torques that no hypothesis explains."""
    time, q, torque = good
    noise = np.sqrt((torque**2).mean(axis=0)) * np.random.default_rng(kind).normal(size=torque.shape)
    zeros, logged = [
        ([0.0, 0.33], late(time, torque, 0.015)),
        ([0.0, 0.8], late(time, torque, 0.08) * [1.0, -1.0]),
        ([0.0, 0.0], late(time, torque[::-1], 0.05)),
        ([0.0, 0.0], torque * [1.0, -1.0] + 0.6 * noise),
        ([0.5, 0.0], noise),
    ][kind]
    assert is_claim_sound(gd.diagnose(two_link, log_of(time, q + np.array(zeros), logged)))


def test_torques_of_another_motion_have_no_cause(robot, good, two_link):
    """Friction explains none of them, however their unit makes them small; there is a doubt all the same."""
    time, q, torque = good
    found = gd.diagnose(two_link, log_of(time, q, torque[::-1]))
    assert is_claim_sound(found)
    assert "No sign, unit, payload or column mends it" in answer(found)


def test_a_position_that_never_changes_is_told(good, two_link):
    """The column of another joint, or of none, while the joint moves."""
    time, q, torque = good
    found = gd.diagnose(two_link, log_of(time, q * [0.0, 1.0] + [0.3, 0.0], torque))
    assert not found.causes
    assert "The position of joint 1 never changes" in answer(found)
    assert "--map q:1=COLUMN" in answer(found)


def test_links_that_are_absurd_explain_nothing(good, two_link):
    """What remains is that of links within a file's error, though others would explain the log."""
    time, q, torque = good
    found = gd.diagnose(two_link, log_of(time, q, 3.3 * torque))
    assert found.before.changed > MOST_CHANGES
    # To the rounding of a price that is halved forty times.
    assert float(np.square(found.before.shared).sum()) <= MOST_CHANGES * (1.0 + 1e-6)
    assert found.before.remains > 3.0 * found.after.remains


# Two causes.


@pytest.mark.slow
def test_both_of_two_causes_are_named(robot, good, two_link, tmp_path):
    """Neither explains the log alone; what is said of both, typed, mends it."""
    time, q, torque = good
    log = written(tmp_path, time, q - [0.0, 0.6], torque * [-1.0, 1.0])
    found = said(log)
    assert {row["name"] for row in found["causes"] if not row["rival"]} == {"torque sign", "zero of a joint"}
    mended = said(log, *shlex.split(found["remedy"]))
    assert mended["cause"] is None
    # Smoothed again, with another draw of the samples.
    assert mended["remains_before"] < 1.5 * found["remains_after"] + 0.01


def test_a_payload_beside_a_reversed_torque(robot, two_link):
    """Each is worth nothing without the other at the first joint."""
    loaded = robot.torque(with_payload(robot.arm, 0.8, np.array([0.1, 0.0, 0.0])))
    torque = robot.noisy(loaded) * [-1.0, 1.0]
    found = gd.diagnose(two_link, robot.log(robot.time, robot.states.q, torque))
    assert found.causes
    assert found.causes[0].name == "torque sign"
    assert is_claim_sound(found)


# Causes that are one and the same.


@pytest.mark.parametrize("round_off", [-1e-12, 0.0, 3e-13])
@pytest.mark.parametrize("angle", [-np.pi / 2.0, 0.7])
def test_a_zero_and_gravity_of_a_planar_arm_are_one(good, two_link, round_off, angle):
    """Both are said, the zero first, whatever round-off prefers."""
    time, q, torque = good
    found = gd.diagnose(two_link, log_of(time, q - [angle, 0.0], (1.0 + round_off) * torque))
    assert [cause.name for cause in (*found.causes, *found.rivals)] == ["zero of a joint", "gravity"]
    assert is_same(*found.causes, *found.rivals)
    gravity = found.rivals[0].correction.gravity
    assert gravity is not None
    size = float(np.linalg.norm(two_link.gravity_vector))
    # By a degree, the error of such an angle in a log with noise.
    assert abs(gravity[1] / size + np.cos(angle)) < np.radians(1.0)


def test_three_causes_that_are_one(good, two_link):
    """Half a turn of a planar arm is an arm that hangs, and one whose joints count the other way."""
    time, q, torque = good
    found = gd.diagnose(two_link, log_of(time, q - [np.pi, 0.0], torque))
    names = [cause.name for cause in (*found.causes, *found.rivals)]
    assert names == ["direction of a joint", "zero of a joint", "gravity"]


def test_every_remedy_of_causes_that_are_one_mends_the_log(good, tmp_path):
    time, q, torque = good
    log = written(tmp_path, time, q - [0.7, 0.0], torque)
    remedies = [row["remedy"] for row in said(log)["causes"]]
    assert [remedy.split()[0] for remedy in remedies] == ["--offset", "--gravity"]
    for remedy in remedies:
        assert said(log, *shlex.split(remedy))["cause"] is None


def test_a_factor_of_torques_or_of_masses(good, two_link):
    """They are told together; a factor that is no unit may be that of another size, too."""
    time, q, torque = good
    found = gd.diagnose(two_link, log_of(time, q, 3.3 * torque))
    assert found.causes
    assert found.causes[0].name == "torque scale"
    assert "masses" in found.causes[0].unsure
    assert "size" in found.causes[0].unsure


# Units of positions, and gears.


def test_radians_that_were_read_as_degrees(good, tmp_path):
    log = written(tmp_path, *good)
    found = said(log, "--map", "q=:deg")
    assert found["cause"] == "unit of positions"
    assert found["remedy"].startswith("--map q=:rad")
    assert said(log)["cause"] is None


@pytest.mark.slow
def test_millimetres_of_a_slide(tmp_path):
    """A short Stanford arm's boom, and nothing else of it."""
    robot = Robot.of(gd.load_arm("stanford"), 5, seconds=8.0)
    time, q, torque = robot.as_it_is
    log = written(tmp_path, time, q * [1.0, 1.0, 1000.0, 1.0, 1.0, 1.0], torque)
    found = said(log, arm="stanford")
    assert found["cause"] == "unit of positions"
    assert said(log, *shlex.split(found["remedy"]), arm="stanford")["cause"] is None


@pytest.mark.parametrize("factor", [0.01, 0.1])
def test_forces_of_a_slide_in_another_scale_are_no_millimetres(factor):
    """A vertical slide whose motion is left out needs friction and a constant alone, whatever its forces."""
    slides = Robot.of(gd.load_arm("scara"), 3, seconds=10.0)
    time, q, torque = slides.as_it_is
    scale = np.where(slides.file.is_revolute, 1.0, factor)
    found = gd.diagnose(slides.file, log_of(time, q, torque * scale))
    assert not any("millimetres" in cause.what for cause in found.causes)
    assert word_of(found) != "agrees"


def test_a_constant_that_no_file_explains_is_told(good, two_link):
    """A bias of as much as half the torque; the usual few per cent are left to friction."""
    time, q, torque = good
    size = np.sqrt((torque**2).mean(axis=0))
    small, large = (
        gd.diagnose(two_link, log_of(time, q, torque + share * size * [0.0, 1.0])) for share in (0.05, 0.6)
    )
    assert not small.offsets
    assert large.offsets.keys() == {2}
    # What links off by a file's usual error take of it.
    assert large.offsets[2] == pytest.approx(0.6 * size[1], rel=0.3)
    assert word_of(large) == "agrees in part"
    assert "A constant" in answer(large)
    assert "at joint 2 is not the file's" in answer(large)


@pytest.mark.filterwarnings("ignore::gd_analyze.GdAnalyzeWarning")
def test_a_joint_with_a_constant_does_not_just_fit(good, two_link):
    time, q, torque = good
    size = np.sqrt((torque**2).mean(axis=0))
    findings = gd.analyze(two_link, log_of(time, q, torque + 0.6 * size * [0.0, 1.0]), level="element")
    assert joint_verdicts(findings)[1] == "offset"


@pytest.mark.parametrize("torques_alone", [True, False])
def test_motors_by_the_files_own_gears(good, tmp_path, two_link, torques_alone):
    """Torques, or positions and torques, are those of the motors; no number is fitted."""
    time, q, torque = good
    ratios = np.array([80.0, -50.0])
    geared = replace(two_link, drives=tuple(Drive(gear_ratio=float(ratio)) for ratio in ratios))
    turned = q if torques_alone else q * ratios
    found = gd.diagnose(geared, log_of(time, turned, torque / ratios))
    assert found.cause is not None
    assert found.cause.name == "motor side"
    assert found.cause.numbers == 0
    log, arm = written(tmp_path, time, turned, torque / ratios), tmp_path / "geared.toml"
    gd.save_arm(geared, arm)
    mended = said(log, *shlex.split(found.cause.remedy.options), arm=str(arm))
    assert mended["cause"] is None
    assert mended["remains_before"] < 1.5 * found.after.remains + 0.01


def test_positions_beyond_reach_have_no_other_cause(good, two_link):
    """Torques that fit nothing are not explained before the unit of positions is known."""
    time, q, torque = good
    rng = np.random.default_rng(1)
    found = gd.diagnose(
        two_link, log_of(time, 400.0 * q, torque[:, ::-1] * [-1.0, 3.0] + rng.normal(size=q.shape))
    )
    assert {cause.name for cause in found.causes} <= {"unit of positions", "motor side"}
    if not found.causes:
        assert "--map q=:deg" in answer(found)


# Effects that a log does not show.


def still(states: States) -> States:
    return States(states.q, np.zeros_like(states.q), np.zeros_like(states.q))


def test_a_hand_that_moves_the_arm(robot, two_link):
    """Torques that hold gravity are named as that: no unit of time makes the motion slow enough."""
    torque = robot.noisy(torque_of(robot.arm, still(robot.states), drives=False))
    found = gd.diagnose(two_link, robot.log(robot.time, robot.states.q, torque))
    assert [cause.name for cause in found.causes] == ["gravity alone"]
    assert "unit of time" not in {cause.name for cause in (*found.causes, *found.rivals)}
    driven = gd.diagnose(two_link, robot.log(*robot.as_it_is))
    assert driven.causes == ()


@pytest.mark.parametrize("joint", [1, 3])
def test_joints_that_tremble_take_no_part(joint):
    """One joint moves, the others are held within a quarter of a degree: no other joint is compared."""
    robot, rng = Robot.of(ur_like(), 5, seconds=8.0), np.random.default_rng(0)
    arrays = []
    for values in robot.states.arrays:
        alone = np.zeros_like(values)
        alone[:, joint] = values[:, joint]
        arrays.append(alone)
    coulomb, viscous, *_ = robot.friction.T
    states = States(*arrays)
    torque = torque_of(robot.arm, states, drives=False) + coulomb * np.sign(states.qd) + viscous * states.qd
    trembling = 0.004 * np.sin(np.outer(robot.time, rng.uniform(1.0, 9.0, 6)) + rng.uniform(0.0, 6.0, 6))
    trembling[:, joint] = 0.0
    found = gd.diagnose(robot.file, robot.log(robot.time, states.q + trembling, robot.noisy(torque)))
    assert found.problem.moving == [joint]
    assert is_claim_sound(found)
    assert not {cause.name for cause in found.causes} & {
        "order of joints",
        "order of torques",
        "coupled joints",
    }


# Another arm.


def resized(arm: RobotArm, factors: np.ndarray) -> RobotArm:
    """An arm whose links are so many times as heavy."""
    links = [
        replace(link, mass=factor * link.mass, inertia_com=factor * link.inertia_com)
        for link, factor in zip(arm.links, factors, strict=True)
    ]
    return replace(arm, links=tuple(links))


@pytest.mark.slow
@pytest.mark.parametrize("seed", [5, 6])
def test_a_file_of_another_size_is_not_a_log_of_currents(seed):
    robot = Robot.of(resized(ur_like(), np.array([3.0, 2.0, 2.5, 0.5, 3.0, 2.0])), seed, seconds=8.0)
    found = gd.diagnose(ur_like(), robot.log(*robot.as_it_is))
    assert found.causes
    assert found.causes[0].name in ("another arm", "torque scale")
    assert "size" in answer(found)
    assert "currents" not in answer(found)


@pytest.mark.slow
def test_currents_are_named_all_the_same():
    robot = Robot.of(ur_like(), 7, seconds=8.0)
    time, q, torque = robot.as_it_is
    found = gd.diagnose(ur_like(), robot.log(time, q, torque / [9.0, 14.0, 8.0, 25.0, 12.0, 30.0]))
    assert found.cause is not None
    assert found.cause.name == "torque scale by joint"
