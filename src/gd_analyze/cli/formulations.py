"""`gd-analyze formulations`: every formulation of one arm's dynamics, side by side."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.output import Output, reporting

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link


@click.command(short_help="Compare the formulations' operations and torques.")
@robot_given
@options.trajectory("Without one, torques are compared at random states.")
@log_options
@options.payload
@click.option(
    "--symbolic",
    is_flag=True,
    help="Only print [FGL87]'s two-link arm in symbols, by every formulation (needs SymPy).",
)
@reporting
def formulations(
    robot: GivenRobot,
    trajectory: str | None,
    payload: Link | None,
    symbolic: bool,
    output: Output,
) -> None:
    r"""Count and compare every formulation of the arm's dynamics.

    Operations are counted by running each formulation's own code on counting numbers; torques are compared
    with each other and with Pinocchio.

    \b
    Examples:
      gd-analyze formulations puma560
      gd-analyze formulations puma560 pick-and-place --payload 2,0,0,0.1
      gd-analyze formulations two_link --symbolic
    """
    if symbolic:
        from gd_analyze.studies.symbolic import symbolic_result

        output.give(symbolic_result(robot.name))
        return
    with output.working() as progress:
        from gd_analyze.studies.formulations import formulations_compared

        arm = robot.load(payload)
        motion = None if trajectory is None else read_motion(trajectory, arm, progress)
        result = formulations_compared(arm, motion, progress=progress)
    output.warn(result.notices)
    output.give(result)
