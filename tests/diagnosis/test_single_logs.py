"""Several logs of one arm: where single ones differ from the others, they and the difference are named."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import gd_analyze as gd
from diagnosed_logs import told_numbers, written
from faulty_logs import Robot, loads, ur_like
from gd_analyze.cli.app import app
from gd_analyze.diagnosis.answer import answer, word_of
from gd_analyze.errors import UsageError
from gd_analyze.motions.pool import pool
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.types import Diagnosis
from logs_of_arms import with_torque
from long_cases import long


@pytest.fixture(scope="module", params=["two_link", long("ur_like")])
def robot(request, two_link) -> Robot:
    """A robot whose file is off."""
    return Robot.of(ur_like() if request.param == "ur_like" else two_link, 3)


@pytest.fixture(scope="module")
def mass(robot) -> float:
    """A load that is put on: of an arm like a UR5e 2 kg."""
    return 0.11 * float(robot.file.mass.sum())


@pytest.fixture(scope="module")
def logs(robot) -> list[Trajectory]:
    """Three logs without a fault."""
    return loads(robot, [0.0, 0.0, 0.0])


def torques(log: Trajectory) -> np.ndarray:
    assert log.recording is not None
    assert log.recording.torque is not None
    return log.recording.torque


def names_in(diagnosis: Diagnosis) -> list[str]:
    """Logs that the causes name."""
    told = " ".join([*(cause.what for cause in diagnosis.causes), *(log for log, _ in diagnosis.apart)])
    return [name for name in diagnosis.logs if name in told]


def test_of_equal_logs_nothing_is_said(robot, logs):
    found = gd.diagnose(robot.file, logs)
    assert not found.causes
    assert not found.apart
    assert word_of(found) == "agrees"


@pytest.mark.parametrize("which", [1, long(0), long(2)])
def test_a_load_of_one_log_is_told_with_its_name(robot, mass, which):
    masses = [mass if k == which else 0.0 for k in range(3)]
    found = gd.diagnose(robot.file, loads(robot, masses))
    assert [cause.name for cause in found.causes] == ["load of a log"]
    assert names_in(found) == [f"log-{which + 1}"]
    (value,), (error,) = told_numbers(found.causes[0].what)
    assert abs(value - mass) < 2.0 * error < 0.4 * mass
    assert "more" in found.causes[0].what
    # What remains is noise again.
    assert found.after.remains < 0.04 < 0.1 < found.before.remains
    assert word_of(found) == "does not agree"


def test_a_load_that_one_log_lacks(robot, mass):
    """All but one carry it: the file lacks it, and that one carries less."""
    found = gd.diagnose(robot.file, loads(robot, [mass, mass, 0.0]))
    assert names_in(found) == ["log-3"]
    assert any("less" in cause.what for cause in found.causes)


def test_of_two_logs_one_carries_more(robot, mass):
    """Either may be the other's difference: that which carries more is named."""
    found = gd.diagnose(robot.file, loads(robot, [mass, 0.0]))
    assert names_in(found) == ["log-1"]
    assert "more" in found.causes[0].what


def test_two_logs_of_four_carry_the_same(robot, mass):
    found = gd.diagnose(robot.file, loads(robot, [0.0, mass, 0.0, mass]))
    assert names_in(found) == ["log-2", "log-4"]


@pytest.mark.parametrize("first_joint", [0, 1])
def test_friction_of_another_day(robot, logs, first_joint):
    colder = robot.along(7, seconds=10.0)
    colder.friction[first_joint:, :3] *= 1.7
    torque = colder.noisy(colder.torque())
    other = replace(colder.log(colder.time, colder.states.q, torque), name="monday")
    found = gd.diagnose(robot.file, [*logs[:2], other])
    assert [cause.name for cause in found.causes] == ["friction of a log"]
    assert names_in(found) == ["monday"]
    # Other drives do not make the file wrong.
    assert word_of(found) == "agrees in part"


@pytest.mark.parametrize("factor", [-1.0, 1.5, long(1000.0)])
def test_torques_of_one_log_in_another_scale(robot, logs, factor):
    first, second, third = logs
    found = gd.diagnose(robot.file, [first, with_torque(second, factor * torques(second)), third])
    assert [cause.name for cause in found.causes] == ["torque scale of a log"]
    assert names_in(found) == ["log-2"]
    if factor == 1.5:
        (value,), (error,) = told_numbers(found.causes[0].what)
        assert abs(value - factor) < 3.0 * error < 0.2


def test_another_fault_of_one_log_is_found_by_itself(robot, logs):
    """No common answer explains the three."""
    first, second, third = logs
    signs = np.where(np.arange(robot.file.n_joints) == 1, -1.0, 1.0)
    found = gd.diagnose(robot.file, [first, second, with_torque(third, signs * torques(third))])
    ((log, cause),) = found.apart
    assert (log, cause.name) == ("log-3", "torque sign")
    assert cause.remedy.options in answer(found)
    assert word_of(found) == "does not agree"


@pytest.mark.parametrize("seed", [0, 1, 2, 3, *map(long, range(4, 20))])
def test_no_difference_is_claimed_of_good_logs(robot, seed):
    """Files are off by 5 to 25 %; motions, slow ones too, differ."""
    robot = Robot.of(robot.file, 200 + seed)
    good = []
    for k, share in enumerate([0.9, 0.5, 0.9][: 2 + seed % 2]):
        moved = robot.along(1000 + 10 * seed + k, seconds=10.0, share=share)
        good.append(moved.log(moved.time, moved.states.q, moved.noisy(moved.torque())))
    found = gd.diagnose(robot.file, good)
    assert not found.causes
    assert not found.apart


def test_motions_of_a_pool_are_told_apart(robot, mass):
    """As where the main job reads a folder."""
    found = gd.diagnose(robot.file, pool(loads(robot, [0.0, mass, 0.0])))
    assert names_in(found) == ["log-2"]


def test_logs_that_differ_are_not_identified_together(robot, mass):
    with pytest.raises(UsageError, match="log-2"):
        gd.identify(robot.file, loads(robot, [0.0, mass, 0.0]))


def test_a_folder_is_its_logs(tmp_path, two_link):
    """For verbs that compare torques, as for the main job."""
    robot = Robot.of(two_link, 3)
    folder = tmp_path / "logs"
    folder.mkdir()
    for name in ("b", "a"):
        moved = robot.along(ord(name), seconds=10.0)
        Path(written(tmp_path, *moved.as_it_is)).rename(folder / f"{name}.csv")
    for verb in (["diagnose"], ["identify", "--no-model"]):
        words = [*verb, "two_link", str(folder), "--measured", "--json", "--quiet"]
        done = CliRunner().invoke(app, words)
        assert done.exit_code == 0, done.output
        assert json.loads(done.stdout)["logs"] == ["a", "b"]
