"""Verbs about motions: `columns`, how a log is understood, and `plan`, set points from rest to rest."""

from __future__ import annotations

from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, joint_values, robot_given
from gd_analyze.cli.log_options import log_options_listed, reading_asked
from gd_analyze.cli.options import TRAJECTORY, Amount, command_line
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.cli.rules import excludes, is_given, needs
from gd_analyze.cli.terminal import lines
from gd_analyze.errors import UsageError
from gd_analyze.units import Quantity, joint_units

# As in `gd_analyze.motions.profiles.PROFILES`, which loads NumPy.
PROFILE_NAMES = ("4-3-4", "3-5-3", "quintic", "cubic", "trapezoidal")


@click.command(short_help="Show how the columns of a log are read.")
@robot_given
@click.argument("log", type=TRAJECTORY, help="CSV, bag or Parquet file of a robot's motion.")
@log_options_listed
@reporting
def columns(robot: GivenRobot, log: str, output: Output) -> None:
    r"""Show role, joint and unit of each column of a log, and why.

    The numbers are checked, too, as by the main job. The options work in every verb that reads logs.

    \b
    Examples:
      gd-analyze columns puma560 log.csv
      gd-analyze columns my_robot.urdf log.csv --map 'q=Pos*:deg' --map time=:ms
    """
    with output.working() as progress:
        from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
        from gd_analyze.motions.read import motion_of
        from gd_analyze.motions.states import states_of
        from gd_analyze.result import Fact, Result, Value
        from gd_analyze.results.motion_result import columns_table

        arm, path = robot.load(logs=[log], masses=False), TRAJECTORY.path_of(log)
        reading, treatment = reading_asked()
        logged = gd.read_log(path, arm, reading, progress=progress)
        motion = motion_of(logged, path, arm, treatment)
        warn_of_torque_limits(arm, states_of(motion))
        recording = motion.recording
        measured = recording is not None and recording.measured
    output.give(
        Result(
            title=f"Columns of {logged.name}, as read for arm",
            subtitle=arm.title or arm.name,
            facts=(
                Value("log", logged.name),
                Value("arm", arm.name),
                Fact("measured", "Kind", measured, text="readings" if measured else "plan"),
                Fact("rows", "Rows", len(logged.time), shown="count"),
                Fact("seconds", "Duration", float(logged.time[-1] - logged.time[0]), "s"),
            ),
            parts=(columns_table(logged.columns),),
        )
    )


@click.command(short_help="Plan a trajectory and compare it with the arm's limits.")
@robot_given
@click.option("--from", "start", metavar="LIST", help="Start, comma-separated; degrees or m.")
@click.option("--to", "goal", metavar="LIST", help="Goal, comma-separated; degrees or m.")
@click.option("--via", multiple=True, metavar="LIST", help="A point in between; repeatable, in order.")
@click.option(
    "--points",
    "n_set_points",
    type=click.IntRange(2, 1_000_000),
    default=31,
    metavar="NUMBER",
    help="Number of set points, evenly spaced; with --exciting by default 100 per second.",
)
@click.option(
    "--duration",
    required=True,
    type=Amount("time", most=600.0),
    metavar="SECONDS",
    help="Time from start to goal.",
)
@click.option(
    "--profile",
    type=click.Choice(PROFILE_NAMES),
    default="4-3-4",
    metavar="NAME",
    help=f"{', '.join(PROFILE_NAMES[:-1])} or {PROFILE_NAMES[-1]}.",
)
@click.option(
    "--allow-violations", is_flag=True, help="Only warn of velocities and accelerations above limits."
)
@click.option(
    "--exciting",
    is_flag=True,
    help="In place of --from and --to: the motion that excites links, drives and friction best, for "
    "`identify`.",
)
@click.option(
    "--within",
    metavar="LIST",
    help="With --exciting: box for the end effector, x,y,z of its lower and of its upper corner, m, base "
    "frame.",
)
@options.number("--seed", 0, "With --exciting: seed of the search.")
@options.out("CSV file.  [default: standard output]")
@reporting
def plan(
    robot: GivenRobot,
    start: str | None,
    goal: str | None,
    via: tuple[str, ...],
    n_set_points: int,
    duration: float,
    profile: str,
    allow_violations: bool,
    exciting: bool,
    within: str | None,
    seed: int,
    out: Path | None,
    output: Output,
) -> None:
    r"""Plan set points from rest to rest and compare them with the arm's limits.

    \b
    Examples:
      gd-analyze plan two_link --from 0,0 --to 60,-45 --duration 2 -o swing.csv
      gd-analyze plan two_link --from 0,0 --to 60,-45 --duration 2 |
          gd-analyze two_link -
      gd-analyze plan puma560 --exciting --duration 20 -o exciting.csv
    """
    of_points = ("--from", "--to", "--via", "--profile", "--allow-violations")
    excludes("--exciting", *of_points, as_it="plans the whole motion")
    needs("--within", "--exciting")
    needs("--seed", "--exciting")
    for end in of_points[:2]:
        if not exciting and not is_given(end):
            raise click.UsageError(f"{end} is missing: give --from and --to, or --exciting")
    require_outputs(out)
    with output.working() as progress:
        progress.stage("planning")
        from gd_analyze.dynamics.torque_limits import warn_of_torque_limits
        from gd_analyze.files import replaces_own
        from gd_analyze.motions.planning import plan_motion, plan_result
        from gd_analyze.motions.states import states_of
        from gd_analyze.motions.trajectory import trajectory_csv

        if out is not None:
            replaces_own(out, "gd-analyze plan", "plan")
        arm, name = robot.load(masses=False), out.stem if out is not None else None
        if start is None or goal is None:
            planned = gd.exciting_motion(
                arm,
                duration,
                n_set_points if is_given("--points") else None,
                within=None if within is None else _box(within),
                seed=seed,
                name=name,
            )
        else:
            planned = plan_motion(
                arm,
                joint_values(arm, start, "--from"),
                joint_values(arm, goal, "--to"),
                duration,
                via=[joint_values(arm, point, "--via") for point in via],
                profile=profile,
                n_set_points=n_set_points,
                allow_violations=allow_violations,
                name=name,
            )
            warn_of_torque_limits(arm, states_of(planned.trajectory))
        if out is not None:
            gd.write_trajectory(planned.trajectory, out, [command_line()])
    if out is None and not output.as_json:
        lines(trajectory_csv(planned.trajectory, [command_line()]))
    else:
        output.give(plan_result(planned), out)


def _box(listed: str) -> gd.types.Workspace:
    """Comma-separated corners of a box, m."""
    from gd_analyze.identification.excitation import Workspace

    quantities = [Quantity.parse(entry) for entry in listed.split(",")]
    values = [None if quantity is None else quantity.of_joint(revolute=False) for quantity in quantities]
    numbers = [value for value in values if value is not None]
    if not len(numbers) == len(values) == 6:
        raise UsageError(
            "--within is not six numbers",
            where="--within",
            expected=f"x,y,z of the lower corner, then of the upper one, each {joint_units(revolute=False)}",
            found=repr(listed),
        )
    return Workspace(numbers[:3], numbers[3:])
