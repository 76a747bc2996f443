"""`gd-analyze compare`: two files of one robot, their torques side by side, and what makes the difference."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import ROBOT
from gd_analyze.cli.output import Output, reporting
from gd_analyze.errors import UsageError
from gd_analyze.files import shipped


@click.command(short_help="Compare two files of one robot, torque by torque.")
@robot_given
@click.argument(
    "other", type=ROBOT, required=False, metavar="OTHER", help="Another file of that robot, or another arm."
)
@options.trajectory("Without one, states are drawn within the arm's limits.")
@log_options
@options.states
@reporting
def compare(
    robot: GivenRobot,
    other: str | None,
    trajectory: str | None,
    states: int,
    seed: int,
    output: Output,
) -> None:
    r"""Compare the torques of two files of one robot, and say which of their numbers make the difference.

    Joints are paired by name, or from base to tip where the names differ; base and link frames may differ.
    Options of arms are for both files; --tip and --base may name a link for each: --tip tool0,link6.

    \b
    Examples:
      gd-analyze compare my_robot.urdf my_robot.xml
      gd-analyze compare my_robot.urdf my_arm.toml move.csv
      gd-analyze compare a.urdf b.urdf --tip tool0,link6
    """
    if other is None or other in shipped("trajectories", ".csv") or Path(other).suffix.lower() == ".csv":
        raise UsageError(
            "compare needs a second file of the robot",
            where="OTHER",
            expected="the path of an arm's file, or a built-in arm",
            found="none" if other is None else other,
            next_step=f"`gd-analyze formulations {robot.name}` compares the formulations of one arm",
        )
    with output.working() as progress:
        from gd_analyze.motions.states import states_of
        from gd_analyze.studies.comparison import Comparison, states_for_both
        from gd_analyze.studies.comparison_result import compared_result

        first, second = (given.load() for given in _two(robot, other))
        if trajectory is None:
            chosen = states_for_both(first, second, states, seed)
        else:
            chosen = states_of(read_motion(trajectory, first, progress))
        progress.stage("comparing")
        result = compared_result(Comparison.of(first, second, chosen), (robot.name, other), progress)
    output.give(result)


def _two(robot: GivenRobot, other: str) -> tuple[GivenRobot, GivenRobot]:
    """Both robots with the options for both; of a link for each, the first is the first one's."""
    from gd_analyze.robots.catalogue import is_xml

    links = {name: (getattr(robot, name) or "").split(",", 1) for name in ("tip", "base")}
    has_tree = any(is_xml(Path(word)) for word in (robot.name, other))
    given = []
    for place, word in enumerate((robot.name, other)):
        tip, base = (words[place % len(words)] or None for words in links.values())
        picked = replace(robot, name=word, tip=tip, base=base)
        # Beside a URDF or MJCF, a chain alone has nothing to choose.
        is_chain = has_tree and not is_xml(Path(word))
        given.append(replace(picked, tip=None, base=None, lock=()) if is_chain else picked)
    return given[0], given[1]
