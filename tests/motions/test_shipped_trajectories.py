"""The shipped trajectories: remade from the command recorded in each, and within every limit."""

from __future__ import annotations

import shlex
from pathlib import Path

import numpy as np
import pytest

from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.motions.limits import limit_report
from gd_analyze.motions.planning import Plan, Schedule, plan
from gd_analyze.motions.read import read_trajectory, shipped_trajectories
from gd_analyze.motions.trajectory import Trajectory, recorded_command
from gd_analyze.robots.catalogue import load_arm

SHIPPED = shipped_trajectories()


def replan(command: str) -> tuple[Plan, Path]:
    """Plan what a recorded command plans; the file it names."""
    program, verb, arm, *rest = shlex.split(command)
    assert (program, verb) == ("gd-analyze", "plan")
    options = list(zip(rest[::2], rest[1::2], strict=True))
    single = dict(options)
    assert set(single) <= {"--from", "--to", "--via", "--points", "--duration", "--profile", "-o"}

    def knot(text: str) -> np.ndarray:
        return np.deg2rad([float(value) for value in text.split(",")])

    planned = plan(
        load_arm(arm),
        knot(single["--from"]),
        knot(single["--to"]),
        [knot(value) for option, value in options if option == "--via"],
        schedule=Schedule(
            float(single["--duration"]), single["--profile"], n_set_points=int(single["--points"])
        ),
    )
    return planned, Path(single["-o"])


def command_of(name: str) -> str:
    command = recorded_command(SHIPPED[name].read_text(encoding="utf-8").splitlines())
    assert command is not None
    return command


def shipped(name: str) -> Trajectory:
    return read_trajectory(name, load_arm(shlex.split(command_of(name))[2]))


@pytest.mark.parametrize("name", SHIPPED)
def test_remade_from_its_command(name: str) -> None:
    planned, file = replan(command_of(name))
    assert file.name == SHIPPED[name].name
    kept = shipped(name)
    assert kept.n_set_points == 31
    assert planned.limits.violations == ()  # all the time
    # The file holds full precision; another machine's linear algebra may round differently, amplified by
    # the condition of the profiles' systems (1e5 at most, see test_profiles).
    tolerance = 1e5 * np.finfo(float).eps
    for what in ("time", "q", "qd", "qdd"):
        remade, values = getattr(planned.trajectory, what), getattr(kept, what)
        np.testing.assert_allclose(remade, values, rtol=0, atol=tolerance * np.abs(values).max())


def test_the_slew_is_near_the_limits_of_the_large_joints_and_the_wrist_move_is_one() -> None:
    rows = limit_report(load_arm("puma560"), shipped("large-slew")).rows
    shares = [row.velocity / row.joint.velocity_limit for row in rows]
    assert min(shares[:2]) > 0.9
    assert shares[2] > 0.5
    assert shares[3:] == [0, 0, 0]
    travel = np.ptp(shipped("wrist-move").q, axis=0)
    assert travel[3:].min() > 10 * travel[:3].max()


def test_the_pick_and_place_lifts_carries_and_turns_a_part() -> None:
    planned, _ = replan(command_of("pick-and-place"))
    arm, trajectory = load_arm("puma560"), planned.trajectory
    kinematics = solve_kinematics(arm, np.ascontiguousarray(trajectory.q.T))
    height, approach = kinematics.link_origins[-1, 2], kinematics.link_rotations[-1, 2, 2]
    # The comments of the file: at the ends the hand points down within 8 degrees, in between it rises.
    assert (approach[[0, -1]] < -np.cos(np.deg2rad(8))).all()
    assert height.max() - max(height[0], height[-1]) > 0.15
    assert all(np.ptp(trajectory.q, axis=0) > np.deg2rad(15))
