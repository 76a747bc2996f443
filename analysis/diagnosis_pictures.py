"""Draws the pictures of docs/diagnose.md from synthetic logs: `python analysis/diagnosis_pictures.py`.

One log with one cause each, of an arm like a UR5e whose links are up to 25 % off; what remains of a joint is drawn
against its position, velocity, acceleration and time.
"""

from __future__ import annotations

import sys
import warnings
from dataclasses import replace
from pathlib import Path

import numpy as np

import gd_analyze as gd
from gallery import BLANK
from gd_analyze.diagnosis.hypothesis import signs, swapped
from gd_analyze.figures.diagnosis import where_figure
from gd_analyze.figures.svg import figure_svg
from gd_analyze.files import write_text
from gd_analyze.results.diagnosis_result import diagnosis_table

sys.path.append(str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))  # makers that tests share

from faulty_logs import (
    Fault,
    Made,
    Robot,
    all_reversed,
    ceiling,
    late,
    load_put_on,
    log_of,
    no_correction,
    payload_missing,
    ur_like,
)

FOLDER = Path(__file__).parents[1] / "docs" / "diagnose"
SEED = 7


def other_way(robot: Robot) -> Made:
    """Joint 3 counts the other way."""
    turned = signs(6, [2])
    return log_of(robot, "", no_correction(robot).with_joints(turned))


def another_unit(robot: Robot) -> Made:
    """Torques in N mm."""
    return log_of(robot, "", no_correction(robot).with_torque(1e-3 * np.eye(6)))


def exchanged(robot: Robot) -> Made:
    """Torques of joints 2 and 3 exchanged."""
    return log_of(robot, "", no_correction(robot).with_torque(swapped(6, 1, 2)))


def zero(robot: Robot) -> Made:
    """The zero of joint 3 is off by 90 degrees."""
    return log_of(robot, "", no_correction(robot).with_offset(2, np.pi / 2.0))


def coupled(robot: Robot) -> Made:
    """Joint 3 measured against the base."""
    matrix = np.eye(6)
    matrix[2, 1] = -1.0
    return log_of(robot, "", no_correction(robot).with_joints(matrix))


def slow_time(robot: Robot) -> Made:
    """Time runs at half its pace."""
    return log_of(robot, "", replace(no_correction(robot), pace=0.5))


# The cause, and the joint that is drawn, from 1.
PICTURES: dict[str, tuple[Fault, int]] = {
    "reversed": (all_reversed, 2), "other_way": (other_way, 3), "unit": (another_unit, 2),
    "exchanged": (exchanged, 2), "zero": (zero, 3), "coupled": (coupled, 3), "late": (late, 1),
    "time": (slow_time, 1), "ceiling": (ceiling, 2), "payload": (payload_missing, 5),
    "change": (load_put_on, 3),
}  # fmt: skip


def main() -> None:
    """Draw all, or those named, and print what is said of each log."""
    warnings.simplefilter("ignore", gd.GdAnalyzeWarning)
    FOLDER.mkdir(exist_ok=True)
    for name in sys.argv[1:] or PICTURES:
        fault, joint = PICTURES[name]
        made = fault(Robot.of(ur_like(), SEED))
        assert made is not None  # every fault suits this arm
        log, arm, *_ = made
        table = diagnosis_table(gd.diagnose(arm, log))
        drawing = figure_svg(where_figure(table, arm, [joint - 1]))
        write_text(FOLDER / f"{name}.svg", drawing.replace(">", f">{BLANK}", 1))
        print(name, np.round(table.remains_before.values, 2), table.attrs["answer"], flush=True)


if __name__ == "__main__":
    main()
