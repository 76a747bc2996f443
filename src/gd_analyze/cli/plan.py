"""`gd-analyze plan`: set points from rest to rest, checked against the arm's limits."""

from __future__ import annotations

import math
import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import ROBOT, reporting
from gd_analyze.errors import UsageError

if TYPE_CHECKING:
    from gd_analyze.robots import RobotArm
    from gd_analyze.trajectories import Plan


@click.command()
@click.argument("robot", type=ROBOT)
@click.option("--from", "start", required=True, metavar="LIST", help="Start: degrees (m), comma-separated.")
@click.option("--to", "goal", required=True, metavar="LIST", help="Goal: degrees (m), comma-separated.")
@click.option("--via", multiple=True, metavar="LIST", help="A point in between; repeatable, in order.")
@click.option("--points", default=31, show_default=True, help="Number of set points.")
@click.option("--duration", required=True, type=float, metavar="SECONDS", help="Time from start to goal.")
@click.option(
    "--profile",
    default="4-3-4",
    show_default=True,
    metavar="NAME",
    help="4-3-4, 3-5-3, quintic, cubic or trapezoidal.",
)
@click.option("--allow-violations", is_flag=True, help="Warn when rates or accelerations exceed their limits.")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="CSV file; standard output if left out.")
@reporting
def plan(
    robot: str,
    start: str,
    goal: str,
    via: tuple[str, ...],
    points: int,
    duration: float,
    profile: str,
    allow_violations: bool,
    out: Path | None,
    as_json: bool,
    quiet: bool,
    debug: bool,
) -> None:
    """Plan set points from rest to rest and report them against the arm's limits.

    \b
    Example:
      gd-analyze plan two_link --from 0,0 --to 60,-45 --duration 2 \\
          --profile quintic -o swing.csv
    """
    from gd_analyze.cli.terminal import console, print_json, warnings_told
    from gd_analyze.robots import load_arm
    from gd_analyze.trajectories import make_plan, trajectory_csv, write_trajectory

    with warnings_told(quiet):
        arm = load_arm(robot)
        made = make_plan(
            arm,
            _joint_values(arm, start, "--from"),
            _joint_values(arm, goal, "--to"),
            [_joint_values(arm, point, "--via") for point in via],
            duration=duration,
            n_set_points=points,
            profile=profile,
            allow_violations=allow_violations,
            name=out.stem if out is not None else None,
        )
    comments = [shlex.join(["gd-analyze", *sys.argv[1:]])]
    if out is not None:
        write_trajectory(made.trajectory, out, comments)
    elif not as_json:
        click.echo(trajectory_csv(made.trajectory, comments), nl=False)
    if as_json:
        print_json(_document(made, out))
    elif not quiet and out is not None:
        screen = console()
        screen.print(_limits(made))
        if made.shortest_duration is not None:
            screen.print(f"The limits allow this motion in {made.shortest_duration:.3g} s at the shortest.")
        screen.print(f"wrote {out}", soft_wrap=True)


def _joint_values(arm: RobotArm, text: str, option: str) -> list[float]:
    """Comma-separated degrees (m for sliding joints) as rad (m)."""
    entries = [entry.strip() for entry in text.split(",")]
    if len(entries) != arm.n_joints:
        raise UsageError(
            f"{option} has a wrong number of joint values",
            where=option,
            expected=f"{arm.n_joints} values for {arm.name}, comma-separated",
            found=f"{len(entries)}: {text!r}",
        )
    values = []
    for column, (entry, joint) in enumerate(zip(entries, arm.joints, strict=True), start=1):
        try:
            value = float(entry)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise UsageError(
                f"{option} holds something that is not a number",
                where=f"{option}, value {column}",
                expected="degrees" if joint.kind == "revolute" else "metres",
                found=repr(entry),
            )
        values.append(math.radians(value) if joint.kind == "revolute" else value)
    return values


def _rows(made: Plan) -> list[dict[str, Any]]:
    from dataclasses import asdict

    return [asdict(joint) for joint in made.limits.rows]


def _document(made: Plan, out: Path | None) -> dict[str, Any]:
    return {
        "file": str(out) if out is not None else None,
        "set_points": made.trajectory.n_set_points,
        "knot_times": made.knot_times.tolist(),
        "shortest_duration": made.shortest_duration,
        "joints": _rows(made),
    }


def _limits(made: Plan) -> Any:
    """Extremes of the motion beside the limits, angles in degrees."""
    from gd_analyze.cli.terminal import table

    rows = []
    for row in made.limits.rows:
        scale, unit = (math.degrees(1.0), "°") if row.unit == "rad" else (1.0, "m")

        def shown(value: float | None, scale: float = scale) -> str:
            return "?" if value is None else f"{value * scale:.3g}"

        rows.append(
            [
                f"{row.joint} {row.name}",
                f"{shown(row.lowest)} .. {shown(row.highest)}",
                f"{shown(row.lower)} .. {shown(row.upper)}",
                unit,
                f"{row.rate:.3g} / {shown(row.rate_limit, 1.0)}",
                f"{row.acceleration:.3g} / {shown(row.acceleration_limit, 1.0)}",
                row.unit,
            ]
        )
    headings = [("joint", "left"), ("motion", "right"), ("range", "right"), ("", "left")]
    headings += [("rate / limit", "right"), ("acc. / limit", "right"), ("per s, s²", "left")]
    return table("Extremes of the motion, between the set points too", headings, rows)
