"""All data of an arm as a `Result`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.result import Column, Part, Result, Section, Shown, ShownAs, Table, Value
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe, fingerprint
from gd_analyze.robots.frames import angles_of
from gd_analyze.robots.parts import Placement

# Rows and columns of a tensor's entries, in the order of the tables' columns.
_MOMENTS = ([0, 1, 2], [0, 1, 2])
_PRODUCTS = ([0, 0, 1], [1, 2, 2])
_POSE = ("x", "y", "z", "roll", "pitch", "yaw")
_SHOWN: dict[str, ShownAs] = {"#": "count", "joint": "name", "link": "name", "moves link": "name"}


def inspection(arm: RobotArm, suspicious: Sequence[str] = ()) -> Result:
    """Tables of an arm, preceded by the warnings of reading it."""
    document = {"suspicious": list(suspicious), **describe(arm), "fingerprint": fingerprint(arm)}
    places = [*(joint.source for joint in arm.joints), *(link.source for link in arm.links)]
    files = list(dict.fromkeys(str(place.path) for place in places if place is not None))
    file_prefix = f"{files[0]}, " if len(files) == 1 else ""
    gravity = " ".join(_cells(arm.gravity_vector))
    return Result(
        f"{arm.title} ({arm.name})" if arm.title and arm.title != arm.name else arm.name,
        facts=(
            *(Value(key, value) for key, value in document.items()),
            *((Shown("File", ", ".join(files)),) if files else ()),
            Shown("Gravity", f"{gravity} m/s² along x, y, z of the base frame"),
        ),
        parts=(
            *_sentences("Suspicious", [text.removeprefix(file_prefix) for text in suspicious]),
            _chain(arm),
            *_geometry(arm),
            *_links(arm),
            *_uncertainties(arm),
            _limits(arm),
            *_drives(arm),
            *_sentences("Sources", arm.sources),
            *_sentences("Assumptions", arm.assumptions),
        ),
    )


def arm_tables(arm: RobotArm) -> tuple[Part, ...]:
    """Geometry, limits, links and drives of an arm, for reports of other results."""
    return (*_geometry(arm), _limits(arm), *_links(arm), *_drives(arm))


def _sentences(title: str, sentences: Sequence[str]) -> list[Section]:
    facts = tuple(Shown("-", sentence) for sentence in sentences)
    return [Section(None, title, facts)] if facts else []


def _cells(values: Iterable[float | None]) -> list[str]:
    """Numbers as given; ? if not stated."""
    return ["?" if value is None else f"{value:g}" for value in values]


def _table(
    key: str, title: str, headings: Sequence[str], rows: Sequence[Sequence[object]], note: str = ""
) -> Table:
    columns = (
        Column(heading, list(cells), shown=_SHOWN.get(heading, "number"))
        for heading, cells in zip(headings, zip(*rows, strict=True), strict=True)
    )
    return Table(key, title, tuple(columns), note)


def _chain(arm: RobotArm) -> Table:
    whole, rows = float(arm.mass.sum()), []
    for i, (joint, link) in enumerate(zip(arm.joints, arm.links, strict=True), start=1):
        lines = ", ".join(str(place.line) for place in (joint.source, link.source) if place and place.line)
        share = f"{100 * link.mass / (whole or 1.0):.0f}"
        rows.append([i, joint.name, link.name, f"{link.mass:.3g}", share, lines])
    headings = ["#", "joint", "moves link", "kg", "%", "at lines"]
    if not any(row[-1] for row in rows):
        headings, rows = headings[:-1], [row[:-1] for row in rows]
    return _table("chain", f"Chain, {whole:.4g} kg in all", headings, rows)


def _geometry(arm: RobotArm) -> Iterator[Table]:
    """Denavit-Hartenberg parameters, or the frames of joints and links."""
    return _dh_table(arm) if arm.dh_table else _placements(arm)


def _dh_table(arm: RobotArm) -> Iterator[Table]:
    rows = []
    for joint, row in zip(arm.joints, arm.dh_table, strict=True):
        theta, d, a, alpha = _cells([math.degrees(row.theta), row.d, row.a, math.degrees(row.alpha)])
        if joint.kind == "revolute":
            theta = f"q + {theta}" if row.theta else "q"
        else:
            d = f"q + {d}" if row.d else "q"
        rows.append([joint.name, joint.kind, theta, d, a, alpha])
    title = f"{arm.convention.capitalize()} Denavit-Hartenberg"
    yield _table("geometry", title, ["joint", "kind", "theta °", "d m", "a m", "alpha °"], rows)


def _placements(arm: RobotArm) -> Iterator[Table]:
    joints = enumerate(arm.joints, start=1)
    rows = [[i, *_pose(joint.placement), _axis(joint.axis), joint.kind] for i, joint in joints]
    title = "Joint frames in the preceding link's frame: position (m), angles about x, y, z (°), axis"
    yield _table("joint_frames", title, ["#", *_POSE, "axis", "kind"], rows)
    frames = [link.frame for link in arm.links]
    if any(frame.translation.any() or (frame.rotation != np.eye(3)).any() for frame in frames):
        title = "Link frames in their joint's frame: position (m), angles about x, y, z (°)"
        yield _table(
            "link_frames",
            title,
            ["#", *_POSE],
            [[i, *_pose(frame)] for i, frame in enumerate(frames, start=1)],
        )


def _pose(placement: Placement) -> list[str]:
    # Beyond twelve digits degrees are round-off; a zero has no sign.
    angles = (round(math.degrees(angle), 9) + 0.0 for angle in angles_of(placement.rotation))
    return _cells([*(placement.translation + 0.0), *angles])


def _axis(axis: FloatArray) -> str:
    along = np.flatnonzero(axis)
    if len(along) == 1:
        return ("-" if axis[along[0]] < 0 else "") + "xyz"[along[0]]
    return " ".join(f"{x:.4g}" for x in axis)


def _links(arm: RobotArm) -> Iterator[Table | Shown]:
    rows = [[link.name, *_cells([link.mass, *link.com])] for link in arm.links]
    title = "Links: mass (kg) and centre of mass (m) in the link's frame"
    yield _table("arm_links", title, ["link", "mass", "x", "y", "z"], rows)
    title = "Inertia about the centre of mass (kg m²), along the axes of the link's frame"
    rows = [[link.name, *_cells(link.inertia_com[_MOMENTS])] for link in arm.links]
    has_products = arm.inertia_com[:, *_PRODUCTS].any()
    note = "" if has_products else "All products of inertia are zero."
    yield _table("inertias", title, ["link", "xx", "yy", "zz"], rows, note)
    if has_products:
        rows = [[link.name, *_cells(link.inertia_com[_PRODUCTS])] for link in arm.links]
        yield _table(
            "products", "Products of inertia, entries of the tensor", ["link", "xy", "xz", "yz"], rows
        )
    measured = ", ".join(link.name for link in arm.links if link.as_measured)
    axial = ", ".join(link.name for link in arm.links if link.axial_only)
    if measured:
        yield Shown("Inertia kept as measured", measured)
    if axial:
        yield Shown("Inertia about the joint's axis only", axial)


def _uncertainties(arm: RobotArm) -> Iterator[Table]:
    unknown, rows, products, about_origin = [None] * 3, [], [], []
    for link in arm.links:
        uncertainty = link.uncertainty
        if uncertainty is None:
            continue
        tensor = uncertainty.inertia
        moments = unknown if tensor is None else tensor[_MOMENTS]
        com = unknown if uncertainty.com is None else uncertainty.com
        rows.append([link.name, *_cells([uncertainty.mass, *com, *moments])])
        if tensor is not None:
            products.append([link.name, *_cells(tensor[_PRODUCTS])])
            about_origin += [link.name] if uncertainty.inertia_about == "origin" else []
    if rows:
        title = "Standard uncertainties of mass (kg), centre of mass (m) and inertia (kg m²); ? if not stated"
        yield _table("uncertainties", title, ["link", "mass", "x", "y", "z", "xx", "yy", "zz"], rows)
    if about_origin or any(cell != "0" for row in products for cell in row[1:]):
        note = f"About the origin of the link frame: {', '.join(about_origin)}." if about_origin else ""
        title = "Standard uncertainties of products of inertia (kg m²)"
        yield _table("product_uncertainties", title, ["link", "xy", "xz", "yz"], products, note)


def _limits(arm: RobotArm) -> Table:
    rows = []
    for joint in arm.joints:
        scale, unit = (math.degrees(1.0), "°") if joint.kind == "revolute" else (1.0, "m")
        ends = (joint.lower, joint.upper)
        lower, upper = _cells(end if end is None else end * scale for end in ends)
        span = "?" if ends == (None, None) else f"{lower} .. {upper} {unit}"
        velocity, acceleration = _cells([joint.velocity_limit, joint.acceleration_limit])
        velocity += "" if velocity == "?" else f" {joint.unit}/s"
        acceleration += "" if acceleration == "?" else f" {joint.unit}/s²"
        rows.append([joint.name, span, velocity, acceleration])
    return _table("limits", "Limits", ["joint", "range", "velocity", "acceleration"], rows)


def _drives(arm: RobotArm) -> Iterator[Table]:
    if not arm.drives:
        return
    kg, newton = ("", "") if all(arm.is_revolute) else ("; kg if prismatic", "; N if prismatic")
    title = (
        f"Drives: inertia at the joint (kg m²{kg}), gear ratio, friction at the motor (N m s and N m), "
        f"torque limit at the joint (N m{newton})"
    )
    headings = ["joint", "inertia", "±", "ratio", "viscous", "Coulomb +", "Coulomb -", "limit"]
    rows = []
    for joint, x in zip(arm.joints, arm.drives, strict=True):
        inertia = x.inertia if arm.counts_drives() else None  # that nobody states
        numbers = (inertia, x.inertia_uncertainty, x.gear_ratio, x.viscous, *x.coulomb, x.torque_limit)
        rows.append([joint.name, *_cells(numbers)])
    yield _table("drives", title, headings, rows)
