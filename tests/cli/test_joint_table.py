"""Tables of joints on a terminal: names of any length, and what is round-off beside the rest of its row."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from gd_analyze.cli.joint_table import joint_table
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import load_arm
from gd_analyze.text import short_name

LONG = ("panda_joint1", "left_gripper_extension_joint_r", "shoulder_pan_joint", "a" * 80, "wrist", "6")


@pytest.fixture(scope="module")
def arm() -> RobotArm:
    puma = load_arm("puma560")
    joints = (replace(joint, name=name) for joint, name in zip(puma.joints, LONG, strict=True))
    return replace(puma, joints=tuple(joints))


@pytest.mark.parametrize("columns", [1, 5, 7])
def test_rows_are_no_wider_than_a_terminal(arm, columns, capsys):
    joint_table("Torques, {units}", arm, [(f"column {k}", np.full(6, 1.23)) for k in range(columns)])
    rows = capsys.readouterr().out.rstrip("\n").split("\n")[3:]
    # Names are never shorter than 12 characters: more columns are wider, as they were.
    assert max(map(len, rows)) <= max(80, 12 + 10 * columns)
    assert [row.split()[0] for row in rows[1:]] == list("123456")
    assert "1 panda_joint1" in rows[1] or "1 pand…oint1" in rows[1]


def test_round_off_is_told_as_such(arm, capsys):
    bound = np.array([2e-9, 0.0, 1e-3, 3.0, 0.5, 1.0])
    joint_table("Torques, {units}", arm, [("peak", np.full(6, 15.0)), ("proven", bound)])
    cells = [row.split()[-2:] for row in capsys.readouterr().out.rstrip("\n").split("\n")[4:]]
    assert cells == [["≈", "0"], ["15", "0"], ["15", "0.001"], ["15", "3"], ["15", "0.5"], ["15", "1"]]


@pytest.mark.parametrize("most", [3, 8, 12, 40])
def test_names_keep_their_ends(most):
    for name in LONG:
        short = short_name(name, most)
        assert len(short) <= max(most, 3)
        assert (short == name) == (len(name) <= most)
        first, _, last = short.partition("…")
        assert name.startswith(first)
        assert name.endswith(last)
