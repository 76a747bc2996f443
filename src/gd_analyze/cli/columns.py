"""`gd-analyze columns`: how the columns of a log are understood."""

from __future__ import annotations

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import log_options_listed, progress_shown, reading_asked
from gd_analyze.cli.options import TRAJECTORY
from gd_analyze.cli.output import Output, reporting


@click.command(short_help="Show how the columns of a log are read.")
@robot_given
@click.argument("log", type=TRAJECTORY, help="CSV, bag, Parquet or YAML file of a robot's motion.")
@log_options_listed
@reporting
def columns(robot: GivenRobot, log: str, output: Output) -> None:
    r"""Show role, joint and unit of each column of a log, the reason, and which columns are left out.

    --save-mapping writes this as a small TOML file; --mapping reads similar logs by it.

    \b
    Examples:
      gd-analyze columns puma560 log.csv
      gd-analyze columns my_robot.urdf log.csv --save-mapping ours.toml
      gd-analyze my_robot.urdf log.csv --mapping ours.toml
    """
    with output.working() as stage:
        stage("reading")
        from gd_analyze.result import Fact, Result, Table, columns_of

        arm = robot.load()
        logged = gd.read_log(TRAJECTORY.path_of(log), arm, reading_asked()[0], progress=progress_shown())
    labels = {"column": "column", "role": "role", "joint": "joint", "unit": "unit", "why": "reason"}
    shown = columns_of(logged.columns, *((key, label, "text") for key, label in labels.items()))
    output.give(
        Result(
            title=f"Columns of {logged.name}",
            subtitle=arm.title or arm.name,
            facts=(
                Fact("log", "", logged.name),
                Fact("arm", "", arm.name),
                Fact("measured", "Kind", logged.measured, text="readings" if logged.measured else "plan"),
                Fact("rows", "Rows", len(logged.time), shown="count"),
                Fact("seconds", "Duration", float(logged.time[-1] - logged.time[0]), "s"),
            ),
            parts=(Table("columns", "Columns", tuple(shown)),),
        )
    )
