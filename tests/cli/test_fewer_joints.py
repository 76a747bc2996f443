"""A log with fewer joints than the robot's file: the options that are printed are typed, and read it."""

from __future__ import annotations

import re

import numpy as np
import pytest

import gd_analyze as gd
from gd_analyze.motions.states import States
from log_arms import UR
from remedies import remedies
from robot_files import INERTIAL, assert_same_torque, joint, link, mjcf, urdf

SEVEN = [f"panda_joint{k}" for k in range(1, 8)]
RAIL_BELOW_UR = ["rail_joint", *UR]
UR_WITH_GRIPPER = [*UR, "gripper_joint"]
RAIL_BELOW_KUKA = ["rail", *(f"joint_a{k}" for k in range(1, 7))]
NAMED = ["yaw", "shoulder", "elbow", "forearm", "hand", "flange"]


def robot(names: list[str]) -> str:
    """A chain in which rails and grippers slide; link k moves with joint k, from 1."""
    joints = [
        joint(name, f"link{k}", f"link{k + 1}", "prismatic" if name[:4] in ("rail", "grip") else "revolute")
        for k, name in enumerate(names)
    ]
    return urdf(*(link(f"link{k}", 3.0) for k in range(len(names) + 1)), *joints)


def log(columns: list[str]) -> str:
    """Column k swings about k."""
    time = 0.01 * np.arange(100)
    numbers = [time, *(k + np.sin(3 * time + k) for k in range(len(columns)))]
    rows = [",".join(f"{x:.9f}" for x in row) for row in np.transpose(numbers)]
    return "\n".join([",".join(["time", *columns]), *rows, ""])


def numbered(pattern: str, numbers: str = "123456") -> list[str]:
    return [pattern.replace("*", number) for number in numbers]


# Joints of the file, columns of the log, and options that are printed, each with the joints that then move.
CASES = {
    "numbers, the last is missing": (SEVEN, numbered("q*"), {"--tip link6": SEVEN[:6]}),
    "numbers from 0": (SEVEN, numbered("actual_q_*", "01234"), {"--tip link5": SEVEN[:5]}),
    "names, the last is missing": (SEVEN, SEVEN[:6], {"--tip link6": SEVEN[:6]}),
    "the first three joints": (NAMED, NAMED[:3], {"--tip link3": NAMED[:3]}),
    "names, one within": (NAMED, [*NAMED[:2], *NAMED[3:]], {"--lock elbow=0": [*NAMED[:2], *NAMED[3:]]}),
    "names, one within and the last": (
        NAMED,
        [*NAMED[:2], *NAMED[3:5]],
        {"--lock elbow=0 --lock flange=0": [*NAMED[:2], *NAMED[3:5]]},
    ),
    "numbers in names, one within": (
        SEVEN,
        [*SEVEN[:3], *SEVEN[4:]],
        {"--lock panda_joint4=0": [*SEVEN[:3], *SEVEN[4:]]},
    ),
    "a gripper": (UR_WITH_GRIPPER, list(UR), {"--tip link6": UR}),
    "a gripper, numbers": (UR_WITH_GRIPPER, numbered("actual_q_*", "012345"), {"--tip link6": UR}),
    "a rail": (RAIL_BELOW_UR, list(UR), {"--lock rail_joint=0": UR}),
    "a rail, numbers": (
        RAIL_BELOW_UR,
        numbered("actual_q_*", "012345"),
        {"--lock rail_joint=0": UR, "--tip link6": RAIL_BELOW_UR[:6]},
    ),
    "a rail, set points": (
        RAIL_BELOW_UR,
        numbered("q*"),
        {"--lock rail_joint=0": UR, "--tip link6": RAIL_BELOW_UR[:6]},
    ),
    "a rail, numbers in names": (RAIL_BELOW_KUKA, numbered("A*"), {"--lock rail=0": RAIL_BELOW_KUKA[1:]}),
    "an unknown word": (NAMED, numbered("foo*", "12345"), {"--tip link5 --map q=foo*": NAMED[:5]}),
    "an unknown word, one within": (
        SEVEN,
        numbered("foo*", "123567"),
        {"--lock panda_joint4=0 --map q=foo*": [*SEVEN[:3], *SEVEN[4:]]},
    ),
    "letters": (
        NAMED,
        [f"pos_{letter}" for letter in "slurb"],
        {"--tip link5 --map joints=s,l,u,r,b": NAMED[:5]},
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_what_is_printed_holds_the_joints_that_are_missing(case, run, here):
    names, columns, expected = CASES[case]
    (here / "robot.urdf").write_text(robot(names))
    (here / "log.csv").write_text(log(columns))
    line = "columns robot.urdf log.csv"
    refused = run(line)
    assert refused.code == 2
    advice = re.search("next: (.*)", refused.err)[1]
    printed = [words for words, complete in remedies(advice) if complete]
    assert [" ".join(words) for words in printed] == [*expected]
    for words, moving in zip(printed, expected.values(), strict=True):
        typed = run(line, *words, "--json")
        assert typed.code == 0, typed.err
        used = {row["column"]: row["joint"] for row in typed.json["columns"] if row["role"] == "q"}
        assert used == dict(zip(columns, moving, strict=True))


def test_one_option_takes_the_place_of_another(run, here):
    """Who has chosen a tip already chooses one further in."""
    (here / "robot.urdf").write_text(robot(SEVEN))
    (here / "log.csv").write_text(log(numbered("q*", "12345")))
    line = "columns robot.urdf log.csv --tip link6"
    advice = re.search("next: (.*)", run(line).err)[1]
    (words,) = [words for words, complete in remedies(advice) if complete]
    assert words == ["--tip", "link5"]
    assert run(line, *words).code == 0


def test_of_mjcf(run, here):
    body = (
        '<body name="upper arm"><joint name="pan" axis="0 0 1"/>{}<body name="hand">'
        '<joint name="lift" axis="0 1 0"/><joint name="twist" axis="1 0 0"/>{}</body></body>'
    )
    (here / "robot.xml").write_text(mjcf(body.format(INERTIAL, INERTIAL)))
    # A body with two joints is two links.
    for columns, tip in (["pan"], "upper arm"), (["pan", "lift"], "hand:lift"):
        (here / "log.csv").write_text(log([f"{name}.pos" for name in columns]))
        refused = run("columns robot.xml log.csv")
        advice = re.search("next: (.*)", refused.err)[1]
        assert [words for words, complete in remedies(advice) if complete] == [["--tip", tip]]
        typed = run("columns robot.xml log.csv", "--tip", tip, "--json")
        assert [row["joint"] for row in typed.json["columns"] if row["role"] == "q"] == columns


def test_only_what_the_file_can_do_is_printed(run, here):
    """A TOML file has no joints to hold, and of numbers that would mean other joints nothing is said."""
    (here / "log.csv").write_text(log(numbered("q*", "12345")))
    assert "--tip" not in run("columns puma560 log.csv").err
    (here / "robot.urdf").write_text(robot(NAMED))
    (here / "log.csv").write_text(log(numbered("actual_q_*", "01245")))
    refused = run("columns robot.urdf log.csv")
    assert refused.code == 2
    assert not re.search("--tip|--lock", refused.err)


def test_the_arm_that_is_left_moves_as_the_robot_does(run, here):
    """Torques of the robot with the missing joints at 0 are those of the arm that the options select."""
    (here / "robot.urdf").write_text(robot(NAMED))
    moving = [*NAMED[:2], *NAMED[3:5]]
    (here / "log.csv").write_text(log(moving))
    advice = re.search("next: (.*)", run("columns robot.urdf log.csv").err)[1]
    ((words, _),) = [pair for pair in remedies(advice) if pair[1]]
    arm = gd.load_arm("robot.urdf", lock=[word for word in words if word != "--lock"])
    rng = np.random.default_rng(0)
    states = States(*rng.normal(size=(3, 5, 4)))
    assert_same_torque(here / "robot.urdf", arm, states, {"elbow": 0.0, "flange": 0.0})
