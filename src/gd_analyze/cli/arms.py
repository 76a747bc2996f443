"""`gd-analyze arms`: the built-in arms, or one arm in full."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot, robot_or_none
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import line, lines, sentence, table


@click.command(short_help="List the built-in arms, or show one.")
@robot_or_none
@click.option("--toml", is_flag=True, help="Print the arm's TOML file, a template for your own arm.")
@reporting
def arms(robot: GivenRobot | None, toml: bool, output: Output) -> None:
    r"""List the built-in arms, or show one: table, masses, limits, drives, sources.

    \b
    Examples:
      gd-analyze arms puma560
      gd-analyze arms puma560 --toml > my_arm.toml
    """
    if toml and (robot is None or output.as_json):
        raise click.UsageError("--toml needs the name of an arm, and goes without --json")
    with output.working():
        shown = [gd.load_arm(name) for name in gd.builtin_arms()] if robot is None else [robot.load()]
    if toml and robot is not None:
        from gd_analyze.robots.arm_file import text_of_arm_file

        lines(text_of_arm_file(Path(gd.builtin_arms().get(robot.name, robot.name))))
    elif robot is None:
        output.give(lambda: [_summary(arm) for arm in shown], lambda: _list(shown))
    else:
        output.give(lambda: _document(shown[0]), lambda: _show(shown[0]))


def _summary(arm: gd.RobotArm) -> dict[str, Any]:
    return {"name": arm.name, "title": arm.title, "joints": arm.n_joints, "drives": bool(arm.drives)}


def _document(arm: gd.RobotArm) -> dict[str, Any]:
    from gd_analyze.robots import describe_in_full, fingerprint

    return {**describe_in_full(arm), "fingerprint": fingerprint(arm)}


def _list(catalogue: list[gd.RobotArm]) -> None:
    from gd_analyze.trajectories import shipped_trajectories

    rows = [[a.name, a.title, str(a.n_joints), "yes" if a.drives else "no"] for a in catalogue]
    table("Built-in arms", ["name", "title", "joints", "drives"], rows, "llrl")
    line()
    sentence("Shipped trajectories: " + ", ".join(shipped_trajectories()))
    sentence("Your own arm is a TOML file: `gd-analyze arms puma560 --toml` prints one to start from.")


def _show(arm: gd.RobotArm) -> None:
    sentence(f"{arm.title} ({arm.name}), {arm.n_joints} joints", bold=True)
    sentence(f"gravity {' '.join(_cells(arm.gravity))} m/s² along x, y, z of the base frame")
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
            for told in sentences:
                sentence(f"- {told}", indent="  ")


def _cells(values: Iterable[float | None]) -> list[str]:
    """Numbers as they are given; ? where none is stated."""
    return ["?" if value is None else f"{value:g}" for value in values]


def _show_dh_table(arm: gd.RobotArm) -> None:
    rows = []
    for joint, row in zip(arm.joints, arm.dh_table, strict=True):
        revolute = joint.kind == "revolute"
        theta, d, a, alpha = _cells([math.degrees(row.theta), row.d, row.a, math.degrees(row.alpha)])
        if revolute:
            theta = f"q + {theta}" if row.theta else "q"
        else:
            d = f"q + {d}" if row.d else "q"
        rows.append([joint.name, joint.kind, theta, d, a, alpha])
    title = arm.convention[:1].upper() + arm.convention[1:]
    table(title, ["joint", "kind", "theta °", "d m", "a m", "alpha °"], rows, "ll")


_BODY = ("link", "mass", "x", "y", "z", "Ixx", "Iyy", "Izz")
_PRODUCTS = ("link", "Ixy", "Ixz", "Iyz")
_OFF_DIAGONAL = ([0, 0, 1], [1, 2, 2])


def _show_links(arm: gd.RobotArm) -> None:
    rows = [[link.name, *_cells([link.mass, *link.com, *link.inertia_com.diagonal()])] for link in arm.links]
    products = [(link.name, link.inertia_com[_OFF_DIAGONAL]) for link in arm.links]
    some = any(values.any() for _, values in products)
    table(
        "Links: mass (kg), centre of mass (m) and inertia about it (kg m²), in the link's frame"
        + ("" if some else "; all products of inertia are zero"),
        _BODY,
        rows,
    )
    # A table of their own: beside the rest they would not fit into a terminal.
    if some:
        table(
            "Products of inertia about the centre of mass (kg m²), as they stand in the tensor",
            _PRODUCTS,
            [[name, *_cells(values)] for name, values in products],
        )


def _show_link_uncertainties(arm: gd.RobotArm) -> None:
    stated = [(link.name, link.uncertainty) for link in arm.links if link.uncertainty is not None]
    if not stated:
        return
    unknown = [None] * 3
    rows = []
    for name, known in stated:
        com = unknown if known.com is None else known.com
        moments = unknown if known.inertia is None else known.inertia.diagonal()
        rows.append([name, *_cells([known.mass, *com, *moments])])
    table(
        "Standard uncertainties of mass (kg), centre of mass (m) and inertia (kg m²); ? where none is stated",
        _BODY,
        rows,
    )
    products = [(name, known.inertia[_OFF_DIAGONAL]) for name, known in stated if known.inertia is not None]
    if any(values.any() for _, values in products):
        table(
            "Standard uncertainties of products of inertia (kg m²)",
            _PRODUCTS,
            [[name, *_cells(values)] for name, values in products],
        )
    about_origin = [
        name for name, known in stated if known.inertia is not None and known.inertia_about == "origin"
    ]
    if about_origin:
        sentence(f"Of the inertia about the link frame's origin: {', '.join(about_origin)}.")


def _show_limits(arm: gd.RobotArm) -> None:
    rows = []
    for joint in arm.joints:
        scale, unit = (math.degrees(1.0), "°") if joint.kind == "revolute" else (1.0, "m")
        lower, upper = _cells(end if end is None else end * scale for end in (joint.lower, joint.upper))
        limits = ((joint.rate_limit, "s"), (joint.acceleration_limit, "s²"))
        rows.append(
            [joint.name, f"{lower} .. {upper} {unit}"]
            + ["?" if limit is None else f"{limit:g} {joint.unit}/{per}" for limit, per in limits]
        )
    table("Limits", ["joint", "range", "rate", "acceleration"], rows)


def _show_drives(arm: gd.RobotArm) -> None:
    rows = []
    for joint, drive in zip(arm.joints, arm.drives, strict=True):
        values = (drive.inertia, drive.inertia_uncertainty, drive.gear_ratio, drive.viscous)
        rows.append([joint.name, *_cells([*values, *drive.coulomb, drive.torque_limit])])
    slides = not all(arm.is_revolute)
    table(
        f"Drives: inertia at the joint (kg m²{'; kg where it slides' * slides}), gear ratio, friction at the "
        f"motor (N m s and N m), torque limit at the joint (N m{'; N where it slides' * slides})",
        ["joint", "inertia", "±", "ratio", "viscous", "Coulomb +", "Coulomb -", "limit"],
        rows,
    )
