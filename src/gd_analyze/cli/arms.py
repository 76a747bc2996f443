"""`gd-analyze arms`: the built-in arms, one arm in full, or as a TOML file."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot, robot_or_none
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.rules import excludes
from gd_analyze.cli.terminal import lines

if TYPE_CHECKING:
    from gd_analyze.result import Result


@click.command(short_help="List the built-in arms, or show one.")
@robot_or_none
@click.option(
    "--to",
    "form",
    type=click.Choice(["toml"]),
    help="Print the arm as a TOML file that gives the same torques.",
)
@reporting
def arms(robot: GivenRobot | None, form: str | None, output: Output) -> None:
    r"""List the built-in arms, or inspect one.

    Implausible numbers come first, then chain, placements, masses, limits, drives, sources and assumptions.

    \b
    Examples:
      gd-analyze arms my_robot.urdf
      gd-analyze arms my_robot.urdf --tip tool0 --to toml > my_arm.toml
      gd-analyze arms puma560 --to toml > my_arm.toml
    """
    excludes("--to", "--json", as_it="prints a TOML file")
    if form is not None and robot is None:
        raise click.UsageError("--to needs a ROBOT")
    with output.working():
        answer = _catalogue() if robot is None else _toml(robot) if form else _inspection(robot)
    if isinstance(answer, str):
        lines(answer)
    else:
        output.give(answer)


def _toml(robot: GivenRobot) -> str:
    from gd_analyze.robots.arm_file import text_of_arm_file
    from gd_analyze.robots.arm_toml import toml_of
    from gd_analyze.robots.catalogue import is_xml

    arm, path = robot.load(masses=False), Path(gd.builtin_arms().get(robot.name, robot.name))
    return toml_of(arm) if robot.limits or is_xml(path) else text_of_arm_file(path)


def _catalogue() -> Result:
    from gd_analyze.motions.formats import shipped_trajectories
    from gd_analyze.result import Fact, Result, attributes_of
    from gd_analyze.schema import declared_table

    built_in = [gd.load_arm(name) for name in gd.builtin_arms()]
    values = attributes_of(built_in, "name", "title") | {
        "joints": [arm.n_joints for arm in built_in],
        "drives": [bool(arm.drives) for arm in built_in],
    }
    table = declared_table("arms", "arms", "", values, [*values])
    trajectories = Fact("trajectories", "Shipped trajectories", list(shipped_trajectories()))
    note = "Your own arm is a URDF, MJCF or TOML file; `gd-analyze arms puma560 --to toml` prints an example."
    return Result("Built-in arms", parts=(table, trajectories), notices=(note,))


def _inspection(robot: GivenRobot) -> Result:
    """Inspect an arm; its warnings come first."""
    from gd_analyze.dynamics.torque_limits import warn_of_weight
    from gd_analyze.robots.inspection import inspection

    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", gd.GdAnalyzeWarning)
        arm = robot.load(masses=False)
        warn_of_weight(arm)
    return inspection(arm, list(dict.fromkeys(str(item.message) for item in caught)))
