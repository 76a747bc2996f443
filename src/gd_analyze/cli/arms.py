"""`gd-analyze arms`: the built-in arms, or one arm in full."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import ROBOT, ROBOT_HELP
from gd_analyze.cli.output import Output, reporting

if TYPE_CHECKING:
    from gd_analyze.robots import RobotArm
    from gd_analyze.vectors import FloatArray


@click.command(short_help="List the built-in arms, or show one.")
@click.argument("robot", type=ROBOT, required=False, help=ROBOT_HELP)
@click.option("--toml", is_flag=True, help="Print the arm's TOML file, a template for your own arm.")
@reporting
def arms(robot: str | None, toml: bool, output: Output) -> None:
    r"""List the built-in arms, or show one: table, masses, limits, drives, sources.

    \b
    Examples:
      gd-analyze arms puma560
      gd-analyze arms puma560 --toml > my_arm.toml
    """
    if toml and (robot is None or output.as_json):
        raise click.UsageError("--toml needs the name of an arm, and goes without --json")
    with output.working():
        from gd_analyze.robots import builtin_arms, load_arm

        shown = [load_arm(name) for name in (builtin_arms() if robot is None else [robot])]
    if toml and robot is not None:
        click.echo(Path(builtin_arms().get(robot, robot)).read_text(encoding="utf-8"), nl=False)
    elif robot is None:
        output.give(lambda: [_summary(arm) for arm in shown], lambda: _list(shown))
    else:
        output.give(lambda: _document(shown[0]), lambda: _show(shown[0]))


def _summary(arm: RobotArm) -> dict[str, Any]:
    return {"name": arm.name, "title": arm.title, "joints": arm.n_joints, "drives": bool(arm.drives)}


def _document(arm: RobotArm) -> dict[str, Any]:
    from gd_analyze.robots import describe_in_full, fingerprint

    return {**describe_in_full(arm), "fingerprint": fingerprint(arm)}


def _list(catalogue: list[RobotArm]) -> None:
    from gd_analyze.cli.terminal import line, sentence, table
    from gd_analyze.trajectories import shipped_trajectories

    rows = [[a.name, a.title, str(a.n_joints), "yes" if a.drives else "no"] for a in catalogue]
    table(
        "Built-in arms", [("name", "left"), ("title", "left"), ("joints", "right"), ("drives", "left")], rows
    )
    line()
    sentence("Shipped trajectories: " + ", ".join(shipped_trajectories()))
    sentence("Your own arm is a TOML file: `gd-analyze arms puma560 --toml` prints one to start from.")


def _show(arm: RobotArm) -> None:
    from gd_analyze.cli.terminal import line, sentence

    sentence(f"{arm.title} ({arm.name}), {arm.n_joints} joints", bold=True)
    sentence(f"gravity {' '.join(f'{g:g}' for g in arm.gravity)} m/s² along x, y, z of the base frame")
    if arm.dh_table:
        _show_dh_table(arm)
    _show_links(arm)
    _show_link_uncertainties(arm)
    _show_limits(arm)
    if arm.drives:
        _show_drives(arm)
    for heading, sentences in (("Sources", arm.sources), ("Assumptions", arm.assumptions)):
        if sentences:
            line()
            sentence(heading, bold=True)
            for text in sentences:
                sentence(f"- {text}", indent="  ")


def _show_dh_table(arm: RobotArm) -> None:
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
    table(arm.convention[:1].upper() + arm.convention[1:], [*headings, ("alpha °", "right")], rows)


def _show_links(arm: RobotArm) -> None:
    from gd_analyze.cli.terminal import table

    products = arm.inertia_com[:, [0, 0, 1], [1, 2, 2]]
    rows = [
        [link.name, *(f"{value:g}" for value in (link.mass, *link.com, *link.inertia_com.diagonal()))]
        for link in arm.links
    ]
    columns = ("mass", "x", "y", "z", "Ixx", "Iyy", "Izz")
    table(
        "Links: mass (kg), centre of mass (m) and inertia about it (kg m²), in the link's frame"
        + ("" if products.any() else "; all products of inertia are zero"),
        [("link", "left"), *((column, "right") for column in columns)],
        rows,
    )
    # A table of their own: beside the rest they would not fit into a terminal.
    if products.any():
        table(
            "Products of inertia about the centre of mass (kg m²), as they stand in the tensor",
            [("link", "left"), *((column, "right") for column in ("Ixy", "Ixz", "Iyz"))],
            [
                [link.name, *(f"{value:g}" for value in row)]
                for link, row in zip(arm.links, products, strict=True)
            ],
        )


def _show_link_uncertainties(arm: RobotArm) -> None:
    from gd_analyze.cli.terminal import sentence, table

    stated = [(link.name, link.uncertainty) for link in arm.links if link.uncertainty is not None]
    if not stated:
        return

    def cells(values: FloatArray | None) -> list[str]:
        return ["?"] * 3 if values is None else [f"{value:g}" for value in values]

    rows = [
        [
            name,
            "?" if known.mass is None else f"{known.mass:g}",
            *cells(known.com),
            *cells(None if known.inertia is None else known.inertia.diagonal()),
        ]
        for name, known in stated
    ]
    columns = ("mass", "x", "y", "z", "Ixx", "Iyy", "Izz")
    table(
        "Standard uncertainties of mass (kg), centre of mass (m) and inertia (kg m²); ? where none is stated",
        [("link", "left"), *((column, "right") for column in columns)],
        rows,
    )
    inertias = [
        (name, known.inertia, known.inertia_about) for name, known in stated if known.inertia is not None
    ]
    products = [(name, inertia[[0, 0, 1], [1, 2, 2]]) for name, inertia, _ in inertias]
    if any(values.any() for _, values in products):
        table(
            "Standard uncertainties of products of inertia (kg m²)",
            [("link", "left"), *((column, "right") for column in ("Ixy", "Ixz", "Iyz"))],
            [[name, *cells(values)] for name, values in products],
        )
    about_origin = [name for name, _, about in inertias if about == "origin"]
    if about_origin:
        sentence(f"Of the inertia about the link frame's origin: {', '.join(about_origin)}.")


def _show_limits(arm: RobotArm) -> None:
    from gd_analyze.cli.terminal import table

    rows = []
    for joint in arm.joints:
        scale, unit = (math.degrees(1.0), "°") if joint.kind == "revolute" else (1.0, "m")
        ends = [f"{end * scale:g}" if end is not None else "?" for end in (joint.lower, joint.upper)]
        limits = [joint.rate_limit, joint.acceleration_limit]
        rows.append(
            [joint.name, f"{ends[0]} .. {ends[1]} {unit}"]
            + [
                f"{limit:g} {joint.unit}/s{'²' * k}" if limit is not None else "?"
                for k, limit in enumerate(limits)
            ]
        )
    headings = [("joint", "left"), ("range", "right"), ("rate", "right"), ("acceleration", "right")]
    table("Limits", headings, rows)


def _show_drives(arm: RobotArm) -> None:
    from gd_analyze.cli.terminal import table

    rows = [
        [
            joint.name,
            f"{drive.inertia:g}",
            f"{drive.inertia_uncertainty:g}" if drive.inertia_uncertainty is not None else "?",
            f"{drive.gear_ratio:g}",
            f"{drive.viscous:g}",
            f"{drive.coulomb[0]:g}",
            f"{drive.coulomb[1]:g}",
            f"{drive.torque_limit:g}" if drive.torque_limit is not None else "?",
        ]
        for joint, drive in zip(arm.joints, arm.drives, strict=True)
    ]
    columns = ("inertia", "±", "ratio", "viscous", "Coulomb +", "Coulomb -", "limit")
    table(
        "Drives: inertia at the joint (kg m²), gear ratio, friction at the motor (N m s and N m), "
        "torque limit at the joint (N m)",
        [("joint", "left"), *((column, "right") for column in columns)],
        rows,
    )
