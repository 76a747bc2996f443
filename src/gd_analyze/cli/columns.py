"""`gd-analyze columns`: how the columns of a log are understood."""

from __future__ import annotations

from dataclasses import asdict
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import log_options_listed, reading_asked, told_by_stages
from gd_analyze.cli.options import TRAJECTORY
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import line, sentence, table

if TYPE_CHECKING:
    from gd_analyze.motions.logged import Logged


@click.command(short_help="Show how the columns of a log are understood.")
@robot_given
@click.argument("log", type=TRAJECTORY, help="CSV, bag, Parquet or YAML file of a robot's motion.")
@log_options_listed
@reporting
def columns(robot: GivenRobot, log: str, output: Output) -> None:
    r"""Show which column of a log is taken for what, by what it was understood, and what is left out.

    With --save-mapping this is written as a small TOML file; --mapping reads logs alike by it.

    \b
    Examples:
      gd-analyze columns puma560 log.csv
      gd-analyze columns my_robot.urdf log.csv --save-mapping ours.toml
      gd-analyze my_robot.urdf log.csv --mapping ours.toml
    """
    with output.working() as stage:
        stage("reading")
        arm = robot.load()
        logged = gd.read_log(TRAJECTORY.path_of(log), arm, reading_asked(), progress=told_by_stages())
    output.give(lambda: _document(logged, arm) | output.about(None), lambda: _show(logged, arm))


def _document(logged: Logged, arm: gd.RobotArm) -> dict[str, Any]:
    return {
        "log": logged.name,
        "arm": arm.name,
        "measured": logged.measured,
        "rows": len(logged.time),
        "seconds": float(logged.time[-1]),
        "columns": [asdict(use) for use in logged.columns],
    }


def _show(logged: Logged, arm: gd.RobotArm) -> None:
    from gd_analyze.motions.told import reasons_told, unused_told
    from gd_analyze.text import number

    kind = "readings" if logged.measured else "a plan"
    sentence(
        f"{logged.name}: {len(logged.time)} rows of {kind} for {arm.title or arm.name}, "
        f"{number(float(logged.time[-1]))} s",
        bold=True,
    )
    used = [use for use in logged.columns if use.role != "unused"]
    # Where all begin with the same topic, that is told once.
    first, *others = [use.column for use in used if use.role != "time"]
    ends = [k + 1 for k, sign in enumerate(first) if sign == "/"]
    shared = next((first[:k] for k in reversed(ends) if all(x.startswith(first[:k]) for x in others)), "")
    table(
        "What is used" + (f"; {shared} stands before the columns' names" if shared else ""),
        ["column", "role", "joint", "unit"],
        [[use.column.removeprefix(shared), use.role, use.joint, use.unit] for use in used],
        "llll",
    )
    line()
    for told in reasons_told(used):
        sentence(f"{told}.", indent="  ")
    unused = unused_told(logged.columns)
    if unused:
        line()
        sentence("Left out:", bold=True)
        for told in unused:
            sentence(f"- {told}", indent="  ")
