"""`gd-analyze arms`: the built-in arms, or one arm in full."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import ROBOT, reporting

if TYPE_CHECKING:
    from gd_analyze.robots import RobotArm


@click.command()
@click.argument("robot", type=ROBOT, required=False)
@click.option("--toml", is_flag=True, help="Print the arm's TOML file, a template for your own arm.")
@reporting
def arms(robot: str | None, toml: bool, as_json: bool, quiet: bool, debug: bool) -> None:
    """List the built-in arms, or show one: table, masses, limits, drives, sources.

    \b
    Example:
      gd-analyze arms puma560 --toml > my_arm.toml
    """
    from gd_analyze.cli.terminal import print_json, warnings_told
    from gd_analyze.robots import builtin_arms, load_arm

    with warnings_told(quiet):
        if robot is None:
            if toml:
                raise click.UsageError("--toml needs the name of an arm.")
            catalogue = {name: load_arm(name) for name in builtin_arms()}
        else:
            arm = load_arm(robot)
    if robot is None:
        if as_json:
            print_json([{"name": a.name, "title": a.title, "joints": a.n_joints} for a in catalogue.values()])
        elif not quiet:
            _list(catalogue)
    elif toml:
        click.echo(Path(builtin_arms().get(robot, robot)).read_text(encoding="utf-8"), nl=False)
    elif as_json:
        print_json(_document(arm))
    elif not quiet:
        _show(arm)


def _document(arm: RobotArm) -> dict[str, Any]:
    from dataclasses import asdict

    from gd_analyze.robots import describe, fingerprint

    return {
        **describe(arm),
        "fingerprint": fingerprint(arm),
        "drives": [asdict(drive) for drive in arm.drives],
        "dh_table": [asdict(row) for row in arm.dh_table],
        "convention": arm.convention,
        "sources": list(arm.sources),
        "assumptions": list(arm.assumptions),
    }


def _list(catalogue: dict[str, RobotArm]) -> None:
    from gd_analyze.cli.terminal import console, table
    from gd_analyze.trajectories import shipped_trajectories

    screen = console()
    rows = [[a.name, a.title, str(a.n_joints), "yes" if a.drives else "no"] for a in catalogue.values()]
    headings = [("name", "left"), ("title", "left"), ("joints", "right"), ("drives", "left")]
    screen.print(table("Built-in arms", headings, rows))
    screen.print("Shipped trajectories: " + ", ".join(shipped_trajectories()))
    screen.print("Your own arm: a TOML file, see `gd-analyze arms puma560 --toml`.")


def _show(arm: RobotArm) -> None:
    from gd_analyze.cli.terminal import console, table

    screen = console()
    screen.print(f"[bold]{arm.title}[/bold] ({arm.name}), {arm.n_joints} joints, gravity {_vector(arm.gravity)} m/s²")
    if arm.dh_table:
        screen.print(_dh(arm))
    screen.print(
        table(
            "Links: centre of mass in the link frame, inertia about it",
            [("link", "left"), ("mass kg", "right"), ("x, y, z m", "right"), ("Ixx Iyy Izz kg m²", "right")]
            + [("Ixy Ixz Iyz", "right")],
            [
                [
                    link.name,
                    f"{link.mass:g}",
                    _vector(link.com),
                    _vector(link.inertia_com.diagonal()),
                    _vector(link.inertia_com[[0, 0, 1], [1, 2, 2]]),
                ]
                for link in arm.links
            ],
        )
    )
    screen.print(_limits(arm))
    if arm.drives:
        screen.print(
            table(
                "Drives: inertia at the joint kg m², friction at the motor N m s, N m, limit N m",
                [("joint", "left"), ("inertia", "right"), ("ratio", "right"), ("viscous", "right")]
                + [("Coulomb", "right"), ("limit", "right")],
                [
                    [
                        joint.name,
                        f"{d.inertia:g}" + (f" ± {d.inertia_uncertainty:g}" if d.inertia_uncertainty else ""),
                        f"{d.gear_ratio:g}",
                        f"{d.viscous:.3g}",
                        f"{d.coulomb[0]:.3g} / {d.coulomb[1]:.3g}",
                        f"{d.torque_limit:g}" if d.torque_limit else "",
                    ]
                    for joint, d in zip(arm.joints, arm.drives, strict=True)
                ],
            )
        )
    for heading, sentences in (("Sources", arm.sources), ("Assumptions", arm.assumptions)):
        if sentences:
            screen.print(f"[bold]{heading}[/bold]")
            for sentence in sentences:
                screen.print(f"- {sentence}", markup=False)


def _dh(arm: RobotArm) -> Any:
    from gd_analyze.cli.terminal import table

    rows = []
    for joint, row in zip(arm.joints, arm.dh_table, strict=True):
        revolute = joint.kind == "revolute"
        theta, d = f"{math.degrees(row.theta):g}", f"{row.d:g}"
        rows.append(
            [
                joint.name,
                joint.kind,
                f"q + {theta}" if revolute and row.theta else "q" if revolute else theta,
                d if revolute else f"q + {d}" if row.d else "q",
                f"{row.a:g}",
                f"{math.degrees(row.alpha):g}",
            ]
        )
    headings = [("joint", "left"), ("kind", "left"), ("theta °", "right"), ("d m", "right"), ("a m", "right")]
    return table(arm.convention, [*headings, ("alpha °", "right")], rows)


def _limits(arm: RobotArm) -> Any:
    from gd_analyze.cli.terminal import table

    rows = []
    for joint in arm.joints:
        scale = math.degrees(1.0) if joint.kind == "revolute" else 1.0
        ends = [f"{end * scale:g}" if end is not None else "?" for end in (joint.lower, joint.upper)]
        rates = [f"{x:g}" if x is not None else "?" for x in (joint.rate_limit, joint.acceleration_limit)]
        unit = "°" if joint.kind == "revolute" else "m"
        rows.append([joint.name, f"{ends[0]} .. {ends[1]} {unit}", *(f"{rates[k]} {joint.unit}/s{'²' * k}" for k in (0, 1))])
    headings = [("joint", "left"), ("range", "right"), ("rate", "right"), ("acceleration", "right")]
    return table("Limits", headings, rows)


def _vector(values: Any) -> str:
    return " ".join(f"{value:g}" for value in values)
