"""One arm as sentences and tables: what is suspicious, chain, placements, masses, limits, drives, sources."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

import numpy as np

import gd_analyze as gd
from gd_analyze.arrays import FloatArray
from gd_analyze.cli.terminal import WIDTH, line, sentence, table
from gd_analyze.robots.frames import angles_of
from gd_analyze.robots.parts import Placement
from gd_analyze.text import number

_MOMENTS, _PRODUCTS = ("Ixx", "Iyy", "Izz"), ("Ixy", "Ixz", "Iyz")
_OFF_DIAGONAL = ([0, 0, 1], [1, 2, 2])


def show_arm(arm: gd.RobotArm, suspicious: Sequence[str]) -> None:
    """Print everything there is to know of an arm, what is suspicious first."""
    title = f"{arm.title} ({arm.name})" if arm.title and arm.title != arm.name else arm.name
    sentence(f"{title}, {arm.n_joints} joint{'s' if arm.n_joints > 1 else ''}", bold=True)
    if files := _files(arm):
        sentence(f"read from {', '.join(files)}")
    sentence(f"gravity {' '.join(_cells(arm.gravity))} m/s² along x, y, z of the base frame")
    if suspicious:
        _show_sentences("Suspicious", [_in_short(told, files) for told in suspicious])
    _show_chain(arm)
    if arm.dh_table:
        _show_dh_table(arm)
    else:
        _show_placements(arm)
    _show_links(arm)
    _say_what_is_special(arm)
    _show_link_uncertainties(arm)
    _show_limits(arm)
    if arm.drives:
        _show_drives(arm)
    _show_sentences("Sources", arm.sources)
    _show_sentences("Assumptions", arm.assumptions)


def _files(arm: gd.RobotArm) -> list[str]:
    places = [joint.source for joint in arm.joints] + [link.source for link in arm.links]
    return list(dict.fromkeys(str(place.path) for place in places if place is not None))


def _in_short(told: str, files: Sequence[str]) -> str:
    """Leave out the file, where it is the only one there is."""
    return told.removeprefix(f"{files[0]}, ") if len(files) == 1 else told


def _show_sentences(heading: str, sentences: Sequence[str]) -> None:
    if sentences:
        line()
        sentence(heading, bold=True)
        for told in sentences:
            sentence(f"- {told}", indent="  ")


def _cells(values: Iterable[float | None]) -> list[str]:
    """Numbers as they are given; ? where none is stated."""
    return ["?" if value is None else f"{value:g}" for value in values]


def _labelled(title: str, headings: Sequence[str], names: Sequence[str], rows: Sequence[list[str]]) -> None:
    """Print rows of numbers by name; by the number of the joint where names make them too wide."""
    named = [[name, *row] for name, row in zip(names, rows, strict=True)]
    if _width(headings, named) > WIDTH:
        headings = ["", *headings[1:]]
        named = [[str(i), *row] for i, row in enumerate(rows, start=1)]
    table(title, headings, named)


def _show_chain(arm: gd.RobotArm) -> None:
    whole = float(arm.mass.sum()) or 1.0
    rows = []
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        lines = [str(place.line) for place in (joint.source, link.source) if place and place.line]
        share = f"{100 * link.mass / whole:.0f}"
        rows.append([str(i), joint.name, link.name, number(link.mass), share, ", ".join(lines)])
    headings = ["", "joint", "moves link", "kg", "%", "at lines"]
    if not any(row[-1] for row in rows) or _width(headings, rows) > WIDTH:
        headings, rows = headings[:-1], [row[:-1] for row in rows]
    table(f"Chain, {number(float(arm.mass.sum()))} kg in all", headings, rows, "rllrrr")


def _width(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> int:
    """Columns that a table takes, with two between its own."""
    return sum(max(map(len, column)) + 2 for column in zip(headings, *rows, strict=True)) - 2


def _show_dh_table(arm: gd.RobotArm) -> None:
    rows = []
    for joint, row in zip(arm.joints, arm.dh_table, strict=True):
        theta, d, a, alpha = _cells([math.degrees(row.theta), row.d, row.a, math.degrees(row.alpha)])
        if joint.kind == "revolute":
            theta = f"q + {theta}" if row.theta else "q"
        else:
            d = f"q + {d}" if row.d else "q"
        rows.append([joint.name, joint.kind, theta, d, a, alpha])
    title = arm.convention[:1].upper() + arm.convention[1:]
    table(title, ["joint", "kind", "theta °", "d m", "a m", "alpha °"], rows, "ll")


def _show_placements(arm: gd.RobotArm) -> None:
    headings = ["", "x", "y", "z", "roll", "pitch", "yaw"]
    rows = [
        [str(i), *_placed(joint.placement), _axis(joint.axis) + (", slides" * (joint.kind == "prismatic"))]
        for i, joint in enumerate(arm.joints, start=1)
    ]
    table(
        "Joint frames, each in the frame of the link before: place (m), angles about x, y, z (°), and the "
        "axis that the joint turns about or slides along",
        [*headings, "axis"],
        rows,
        "rrrrrrrl",
    )
    frames = [link.frame for link in arm.links]
    if any(frame.translation.any() or (frame.rotation != np.eye(3)).any() for frame in frames):
        rows = [[str(i), *_placed(frame)] for i, frame in enumerate(frames, start=1)]
        table("Link frames, each in its joint's: place (m), angles about x, y, z (°)", headings, rows)


def _placed(placement: Placement) -> list[str]:
    # Twelve digits of a degree are round-off; a zero has no sign.
    angles = (round(math.degrees(angle), 9) + 0.0 for angle in angles_of(placement.rotation))
    return _cells([*(placement.translation + 0.0), *angles])


def _axis(axis: FloatArray) -> str:
    if np.count_nonzero(axis) == 1:
        index = int(np.abs(axis).argmax())
        return ("-" if axis[index] < 0 else "") + "xyz"[index]
    return " ".join(f"{x:.4g}" for x in axis)


def _show_links(arm: gd.RobotArm) -> None:
    names = [link.name for link in arm.links]
    _labelled(
        "Links: mass (kg) and centre of mass (m) in the link's frame",
        ["link", "mass", "x", "y", "z"],
        names,
        [_cells([link.mass, *link.com]) for link in arm.links],
    )
    title = "Inertia about the centre of mass (kg m²), along the axes of the link's frame"
    moments = [_cells(link.inertia_com.diagonal()) for link in arm.links]
    products = [_cells(link.inertia_com[_OFF_DIAGONAL]) for link in arm.links]
    if all(cell == "0" for row in products for cell in row):
        _labelled(f"{title}; all products of inertia are zero", ["link", *_MOMENTS], names, moments)
        return
    title += ", as it stands in the tensor"
    both = [a + b for a, b in zip(moments, products, strict=True)]
    if _width([*_MOMENTS, *_PRODUCTS], both) + 4 > WIDTH:
        _labelled(title, ["link", *_MOMENTS], names, moments)
        _labelled("Products of inertia of the same", ["link", *_PRODUCTS], names, products)
    else:
        _labelled(title, ["link", *_MOMENTS, *_PRODUCTS], names, both)


def _say_what_is_special(arm: gd.RobotArm) -> None:
    for links, told in (
        ([link.name for link in arm.links if link.as_measured], "Kept as measured"),
        ([link.name for link in arm.links if link.axial_only], "About the joint's axis only"),
    ):
        if links:
            sentence(f"{told}: {', '.join(links)}.")


def _show_link_uncertainties(arm: gd.RobotArm) -> None:
    stated = [(link.name, link.uncertainty) for link in arm.links if link.uncertainty is not None]
    if not stated:
        return
    unknown = [None] * 3
    rows = []
    for _, known in stated:
        com = unknown if known.com is None else known.com
        moments = unknown if known.inertia is None else known.inertia.diagonal()
        rows.append(_cells([known.mass, *com, *moments]))
    _labelled(
        "Standard uncertainties of mass (kg), centre of mass (m) and inertia (kg m²); ? where none is stated",
        ["link", "mass", "x", "y", "z", *_MOMENTS],
        [name for name, _ in stated],
        rows,
    )
    products = [(name, known.inertia[_OFF_DIAGONAL]) for name, known in stated if known.inertia is not None]
    if any(values.any() for _, values in products):
        table(
            "Standard uncertainties of products of inertia (kg m²)",
            ["link", *_PRODUCTS],
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
        ends = (joint.lower, joint.upper)
        lower, upper = _cells(end if end is None else end * scale for end in ends)
        limits = ((joint.velocity_limit, "s"), (joint.acceleration_limit, "s²"))
        rows.append(
            [joint.name, "?" if ends == (None, None) else f"{lower} .. {upper} {unit}"]
            + ["?" if limit is None else f"{limit:g} {joint.unit}/{per}" for limit, per in limits]
        )
    table("Limits", ["joint", "range", "rate", "acceleration"], rows)


def _show_drives(arm: gd.RobotArm) -> None:
    rows = []
    for drive in arm.drives:
        values = (drive.inertia, drive.inertia_uncertainty, drive.gear_ratio, drive.viscous)
        rows.append(_cells([*values, *drive.coulomb, drive.torque_limit]))
    slides = not all(arm.is_revolute)
    _labelled(
        f"Drives: inertia at the joint (kg m²{'; kg where it slides' * slides}), gear ratio, friction at the "
        f"motor (N m s and N m), torque limit at the joint (N m{'; N where it slides' * slides})",
        ["joint", "inertia", "±", "ratio", "viscous", "Coulomb +", "Coulomb -", "limit"],
        [joint.name for joint in arm.joints],
        rows,
    )
