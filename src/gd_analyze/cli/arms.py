"""`gd-analyze arms`: the built-in arms, one arm in full, or as a TOML file."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot, robot_or_none
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import line, lines, sentence, table


@click.command(short_help="List the built-in arms, or show one.")
@robot_or_none
@click.option(
    "--to",
    "form",
    type=click.Choice(["toml"]),
    help="Print the arm as a TOML file instead: to keep, to change, or as a template for your own arm.",
)
@reporting
def arms(robot: GivenRobot | None, form: str | None, output: Output) -> None:
    r"""List the built-in arms, or inspect one.

    First comes what is suspicious; then the chain of joints and the links they move, where they are placed,
    masses, limits, drives, sources and assumptions. With --to toml the arm is printed as a TOML file that
    gives the same torques; of a file that is TOML already, and that nothing is added to, as it stands.

    \b
    Examples:
      gd-analyze arms my_robot.urdf
      gd-analyze arms my_robot.urdf --tip tool0 --to toml > my_arm.toml
      gd-analyze arms puma560 --to toml > my_arm.toml
    """
    if form is not None and (robot is None or output.as_json):
        raise click.UsageError("--to needs a ROBOT, and goes without --json")
    if robot is None:
        with output.working():
            catalogue = [gd.load_arm(name) for name in gd.builtin_arms()]
        output.give(lambda: [_summary(arm) for arm in catalogue], lambda: _list(catalogue))
    elif form is not None:
        with output.working():
            text = _toml(robot)
        lines(text)
    else:
        with output.working():
            from gd_analyze.cli.arm_tables import show_arm

            arm, suspicious = _inspected(robot)
        output.give(lambda: _document(arm, suspicious), lambda: show_arm(arm, suspicious))


def _toml(robot: GivenRobot) -> str:
    from gd_analyze.robots.arm_file import text_of_arm_file
    from gd_analyze.robots.arm_toml import toml_of
    from gd_analyze.robots.catalogue import is_xml

    arm, path = robot.load(), Path(gd.builtin_arms().get(robot.name, robot.name))
    return toml_of(arm) if robot.limits or is_xml(path) else text_of_arm_file(path)


def _inspected(robot: GivenRobot) -> tuple[gd.RobotArm, list[str]]:
    """Read an arm; what would be warned of stands before everything else that is shown."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", gd.GdAnalyzeWarning)
        arm = robot.load()
    return arm, list(dict.fromkeys(str(item.message) for item in caught))


def _summary(arm: gd.RobotArm) -> dict[str, Any]:
    return {"name": arm.name, "title": arm.title, "joints": arm.n_joints, "drives": bool(arm.drives)}


def _document(arm: gd.RobotArm, suspicious: list[str]) -> dict[str, Any]:
    from gd_analyze.robots.description import describe_in_full, fingerprint

    return {"suspicious": suspicious, **describe_in_full(arm), "fingerprint": fingerprint(arm)}


def _list(catalogue: list[gd.RobotArm]) -> None:
    from gd_analyze.motions.csv_file import shipped_trajectories

    rows = [[a.name, a.title, str(a.n_joints), "yes" if a.drives else "no"] for a in catalogue]
    table("Built-in arms", ["name", "title", "joints", "drives"], rows, "llrl")
    line()
    sentence("Shipped trajectories: " + ", ".join(shipped_trajectories()))
    sentence(
        "Your own arm is a URDF, MJCF or TOML file: `gd-analyze arms puma560 --to toml` prints one to start "
        "from."
    )
