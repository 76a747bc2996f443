"""The shipped trajectories: remade by the command recorded in each, which refuses what exceeds a limit."""

from __future__ import annotations

import shlex

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.cli.entry import main
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.formats import shipped_trajectories
from gd_analyze.motions.trajectory import recorded_command

SHIPPED = shipped_trajectories()


@pytest.mark.parametrize("name", SHIPPED)
def test_remade_from_its_command(name, tmp_path, monkeypatch) -> None:
    words = shlex.split(recorded_command(SHIPPED[name].read_text(encoding="utf-8").splitlines()))
    monkeypatch.chdir(tmp_path)
    main(words[1:])
    remade, shipped = (gd.read_trajectory(path, words[2]) for path in (SHIPPED[name].name, name))
    assert shipped.n_set_points == 31
    # The file holds full precision; another machine's linear algebra may round differently, amplified by
    # the condition of the profiles' systems (1e5 at most, see test_planning).
    for quantity in ("time", "q", "qd", "qdd"):
        values = getattr(shipped, quantity)
        tolerance = 1e5 * np.finfo(float).eps * np.abs(values).max()
        np.testing.assert_allclose(getattr(remade, quantity), values, rtol=0, atol=tolerance)


def test_the_pick_and_place_lifts_carries_and_turns_a_part(puma, pick_and_place) -> None:
    kinematics = solve_kinematics(puma, np.ascontiguousarray(pick_and_place.q.T))
    height, approach = kinematics.link_origins[-1, 2], kinematics.link_rotations[-1, 2, 2]
    # The comments of the file: at the ends the hand points down within 8 degrees, in between it rises.
    assert (approach[[0, -1]] < -np.cos(np.deg2rad(8))).all()
    assert height.max() - max(height[0], height[-1]) > 0.15


@pytest.mark.parametrize("name", ["pick-and-place", "large-slew"])
def test_angles_are_not_read_as_metres(name):
    """The Stanford arm slides where the PUMA, for which the motion was planned, turns."""
    with pytest.raises(TrajectoryError, match="joint 3") as caught:
        gd.read_trajectory(name, "stanford")
    assert "rad" in caught.value.details["found"]
    assert "puma560" in caught.value.details["next"]
