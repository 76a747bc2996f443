"""What is possible but looks wrong: warnings, each naming the joint, the set point and the amount."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.limits import check_against_arm, limit_report
from gd_analyze.motions.read import read_trajectory
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm

CsvFile = Callable[[str | bytes], Path]
Warned = Callable[[], object]


def motion(q: list[list[float]], **others: object) -> Trajectory:
    """Set points every 0.1 s; velocities and accelerations of zero unless given."""
    rows = np.array(q, dtype=float)
    still = np.zeros_like(rows)
    given = {"qd": still, "qdd": still} | others
    return Trajectory(np.arange(len(rows)) / 10, rows, name="m", **given)


def test_a_sound_motion_is_not_remarked_upon(two_link: RobotArm, warned: Warned) -> None:
    with warned() as texts:
        check_against_arm(motion([[0, 0], [3.1, -2.6]]), two_link)
    assert texts == []


def test_wrong_number_of_joints(puma: RobotArm) -> None:
    with pytest.raises(TrajectoryError, match="not for arm puma560") as caught:
        check_against_arm(motion([[0, 0]]), puma)
    assert "expected: 6 joints" in str(caught.value)
    assert "found: 2 joints" in str(caught.value)
    assert "gd-analyze arms" in str(caught.value)


def test_positions_past_both_ends(two_link: RobotArm, warned: Warned) -> None:
    with warned() as texts:
        check_against_arm(motion([[0, 0], [np.deg2rad(190), 0], [0, np.deg2rad(-152)]]), two_link)
    assert len(texts) == 2
    assert "joint 1 (shoulder): position 3.316 rad (190 deg), 0.1745 rad (10 deg) above its upper" in texts[0]
    assert "at set point 2 (0.1 s)" in texts[0]
    assert "joint 2 (elbow): position -2.653 rad (-152 deg), 0.03491 rad (2 deg) below its lower" in texts[1]
    assert "at set point 3 (0.2 s)" in texts[1]


def test_velocities_and_accelerations_above_limits(two_link: RobotArm, warned: Warned) -> None:
    velocities = np.array([[0.0, 0.0], [-3.3, 4.0]])
    with warned() as texts:
        check_against_arm(motion([[0, 0], [0, 0]], qd=velocities, qdd=5 * velocities), two_link)
    assert len(texts) == 3
    assert "joint 1 (shoulder): velocity 3.3 rad/s, 0.3 rad/s (10 %) above the limit 3 rad/s" in texts[0]
    assert "acceleration 16.5 rad/s^2" in texts[1]
    assert "joint 2 (elbow): acceleration 20 rad/s^2, 5 rad/s^2 (33 %)" in texts[2]
    assert not any("derived" in text for text in texts)


def test_derived_velocities_are_suspected_first(
    csv_file: CsvFile, two_link: RobotArm, warned: Warned
) -> None:
    rows = [f"{k / 100},{0.05 * (k == 5)},0" for k in range(12)]
    with warned() as texts:
        read_trajectory(csv_file("\n".join(["time,q1,q2", *rows])), two_link)
    assert len(texts) == 2
    assert "velocity" in texts[0]
    assert "qd is derived" in texts[0]
    assert "acceleration" in texts[1]
    assert "qdd is derived" in texts[1]


def test_exactly_at_a_limit_is_within(two_link: RobotArm, warned: Warned) -> None:
    with warned() as texts:
        check_against_arm(motion([[np.pi, np.deg2rad(-150)]], qd=np.array([[3.0, -4.0]])), two_link)
        check_against_arm(motion([[3.1415926536, 0]]), two_link)
    assert texts == []
    assert limit_report(two_link, motion([[np.pi + 1e-7, 0]])).violations


def test_degrees_taken_for_radians(puma: RobotArm, warned: Warned) -> None:
    with warned() as texts:
        check_against_arm(motion([[33, -17, 187, 0, 1, -30], [108, -23, 190, 0, 1, 45]]), puma)
    assert len(texts) == 1
    assert "joint 1 (waist), joint 2 (shoulder), joint 3 (elbow), joint 6 (flange)" in texts[0]
    assert "190 rad" in texts[0]
    assert "q1_deg" in texts[0]


def test_far_out_but_not_degrees_either(two_link: RobotArm, warned: Warned) -> None:
    with warned() as texts:
        check_against_arm(motion([[400, 0]]), two_link)
    assert len(texts) == 1
    assert "above its upper limit" in texts[0]


def test_a_joint_without_limits_may_turn_twice(slider: RobotArm, warned: Warned) -> None:
    with warned() as texts:
        check_against_arm(motion([[12.5, 0.1]]), slider)
    assert texts == []
    with warned() as texts:
        check_against_arm(motion([[90, 0.1]]), slider)
    assert len(texts) == 1
    assert "joint 1 read as radians reach 90 rad (5157 deg)" in texts[0]


def test_sliding_joints_are_never_in_degrees(slider: RobotArm, warned: Warned) -> None:
    with warned() as texts:
        check_against_arm(motion([[0, 20]]), slider)
    assert len(texts) == 1
    assert "position 20 m, 19.5 m above its upper limit 0.5 m" in texts[0]


def test_radians_in_columns_of_degrees(csv_file: CsvFile, two_link: RobotArm, warned: Warned) -> None:
    rows = [f"{k / 10},{0.5 * k},1" for k in range(7)]
    content = "\n".join(["time,q1_deg,q2_deg", *rows])
    with warned() as texts:
        read_trajectory(csv_file(content), two_link)
    assert len(texts) == 1
    assert "trajectory motion: angles in degrees stay within 3 of zero" in texts[0]
    # Seven times as far, or not moving at all, is nothing to remark upon.
    with warned() as texts:
        read_trajectory(csv_file(content.replace("q2_deg", "q2").replace(",3.0,", ",4.0,")), two_link)
        read_trajectory(
            csv_file("\n".join(["time,q1_deg,q2_deg", *(f"{k},0,1" for k in range(7))])), two_link
        )
    assert texts == []


def test_milliseconds_that_nothing_says(csv_file: CsvFile, two_link: RobotArm, warned: Warned) -> None:
    rows = [f"{10 * k},{0.5 * np.sin(0.02 * k)},{0.3 * np.cos(0.02 * k)}" for k in range(300)]
    with warned() as texts:
        read_trajectory(csv_file("\n".join(["time,q1,q2", *rows])), two_link)
    assert len(texts) == 1
    assert "velocity limits, in time read as seconds" in texts[0]
    assert "--time-unit ms" in texts[0]
    # Nothing is remarked upon in seconds, of what rests, or of what has its velocities.
    with warned() as texts:
        read_trajectory(
            csv_file(
                "\n".join(["time,q1,q2", *(f"{k / 100}{r[r.index(',') :]}" for k, r in enumerate(rows))])
            ),
            two_link,
        )
        read_trajectory(
            csv_file("\n".join(["time,q1,q2", *(f"{10 * k},0.1,{1e-3 * k / 300}" for k in range(300))])),
            two_link,
        )
        check_against_arm(motion([[0, 0], [1, 1]]), two_link)
    assert texts == []
