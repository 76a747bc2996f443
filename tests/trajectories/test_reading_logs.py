"""Logs where a trajectory is asked for: which files these are, and the motion that comes of them."""

from __future__ import annotations

import io
import os
import threading
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.csv_file import read_trajectory, shipped_trajectories
from gd_analyze.motions.log_file import keeps_contract
from gd_analyze.motions.reading import Reading
from gd_analyze.robots.arm import RobotArm

CsvFile = Callable[[str | bytes], Path]
TIME = np.arange(200) * 0.01
Q = np.column_stack([0.5 * np.sin(2 * TIME), 0.4 * np.cos(3 * TIME)])


def rows(*columns: np.ndarray, sign: str = ",") -> str:
    return "".join(sign.join(map(repr, row)) + "\n" for row in np.column_stack(columns).tolist())


MEASURED = "timestamp,actual_q_0,actual_q_1\n" + rows(TIME, Q)


def test_a_measured_log_keeps_its_readings_and_how_it_was_understood(
    csv_file: CsvFile, two_link: RobotArm
) -> None:
    motion = read_trajectory(csv_file(MEASURED), two_link)
    assert motion.recording is not None
    np.testing.assert_array_equal(motion.recording.q, Q)
    assert [use.role for use in motion.recording.columns] == ["time", "q", "q"]
    # The readings are a smooth motion to round-off: smoothing may bend them by far less than they move.
    np.testing.assert_allclose(motion.q, Q, atol=1e-4)
    np.testing.assert_allclose(motion.qd[50:-50, 0], np.cos(2 * TIME)[50:-50], atol=1e-3)


def test_a_plan_is_taken_as_it_is(csv_file: CsvFile, two_link: RobotArm) -> None:
    path = csv_file("t,target_q_0,target_q_1\n" + rows(TIME, Q))
    motion = read_trajectory(path, two_link)
    np.testing.assert_array_equal(motion.q, Q)
    assert motion.rates_from.startswith("qd and qdd derived: C4 (quintic) spline")
    assert motion.origin == f"read from {path}"


def test_what_the_user_says_of_a_file_of_set_points(csv_file: CsvFile, two_link: RobotArm) -> None:
    path = csv_file("time,q1,q2\n" + rows(1000 * TIME, Q))
    in_seconds = read_trajectory(path, two_link, Reading(time_unit="ms"))
    np.testing.assert_allclose(in_seconds.time, TIME, rtol=1e-15)
    np.testing.assert_array_equal(in_seconds.q, Q)  # still a plan
    measured = read_trajectory(path, two_link, Reading(time_unit="ms", measured=True))
    assert measured.recording is not None
    assert measured.fingerprint != in_seconds.fingerprint


def test_decimal_commas(csv_file: CsvFile, two_link: RobotArm) -> None:
    text = "time;q1;q2\n" + rows(TIME, Q, sign=";").replace(".", ",")
    # The parser of decimal commas may miss the last place.
    np.testing.assert_allclose(read_trajectory(csv_file(text), two_link).q, Q, rtol=1e-15, atol=1e-15)


def test_standard_input_and_pipes(
    two_link: RobotArm, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("sys.stdin", SimpleNamespace(buffer=io.BytesIO(MEASURED.encode())))
    motion = read_trajectory("-", two_link)
    assert (motion.name, motion.origin) == ("stdin", "read from standard input")
    assert motion.recording is not None
    pipe = tmp_path / "pipe"
    os.mkfifo(pipe)
    writer = threading.Thread(target=pipe.write_text, args=(MEASURED,))
    writer.start()
    through = read_trajectory(pipe, two_link)
    writer.join()
    assert through.fingerprint == motion.fingerprint


@pytest.mark.parametrize(
    ("content", "kept"),
    [
        ("time,q1,q2\n0,1,2\n", True),
        ("# a\n\n TIME , q1_deg ,QDD2\n", True),
        ("time,q1,q1\n", True),
        ("time,q1,q2\n0,1,x\n", True),
        ("", True),
        ("a\0b", True),
        ('"time', True),
        ("time," + "q" * 300, True),
        ("time,q0,q1\n", False),
        ("time,q1,elbow\n", False),
        ("0,1,2\n", False),
        ("time;q1\n0,5;1\n", False),
        ("time q1 q2\n0 1 2\n", False),
    ],
)
def test_which_files_are_held_to_the_contract(content: str, kept: bool) -> None:
    assert keeps_contract(content.encode()) is kept


def test_shipped_trajectories_are() -> None:
    for path in shipped_trajectories().values():
        assert keeps_contract(path.read_bytes()[:100_000])


def test_angles_that_look_like_degrees(csv_file: CsvFile, two_link: RobotArm, warned) -> None:
    path = csv_file("time,position_1,position_2\n" + rows(TIME, np.degrees(Q)))
    with warned() as texts:
        read_trajectory(path, two_link)
    assert any("looks like degrees" in text and "say --degrees of a log" in text for text in texts)
    with warned() as texts:
        motion = read_trajectory(path, two_link, Reading(degrees=True))
    assert not any("degrees" in text for text in texts)
    np.testing.assert_allclose(motion.q, Q, atol=1e-4)  # smoothed, as above


def test_rates_beyond_any_motion_name_the_file(csv_file: CsvFile, two_link: RobotArm) -> None:
    text = "time [ns],q_ref_1,q_ref_2\n" + rows(1e-9 * TIME, Q)
    path = csv_file(text)
    with pytest.raises(TrajectoryError, match="too large for any motion") as caught:
        read_trajectory(path, two_link)
    assert f"where: {path}" in str(caught.value)
    assert "check the unit of its time" in str(caught.value)
