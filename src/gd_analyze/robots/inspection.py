"""Everything there is to know of an arm, as a `Result`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.result import Column, Fact, Result, Section, Table
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.description import describe_in_full, fingerprint
from gd_analyze.robots.frames import angles_of
from gd_analyze.robots.parts import Placement

_MOMENTS = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2)}
_PRODUCTS = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
_POSE = ("x", "y", "z", "roll", "pitch", "yaw")


def inspection(arm: RobotArm, suspicious: Sequence[str] = ()) -> Result:
    """Tables of an arm; what was warned of when it was read stands first."""
    document = {"suspicious": list(suspicious), **describe_in_full(arm), "fingerprint": fingerprint(arm)}
    places = [*(joint.source for joint in arm.joints), *(link.source for link in arm.links)]
    files = list(dict.fromkeys(str(place.path) for place in places if place is not None))
    only = f"{files[0]}, " if len(files) == 1 else ""
    gravity = " ".join(_cells(arm.gravity))
    return Result(
        f"{arm.title} ({arm.name})" if arm.title and arm.title != arm.name else arm.name,
        facts=(
            *(Fact(key, "", value) for key, value in document.items()),
            Fact("", "File" * bool(files), ", ".join(files), shown="text"),
            Fact("", "Gravity", f"{gravity} m/s² along x, y, z of the base frame", shown="text"),
        ),
        parts=(
            *_sentences("Suspicious", [text.removeprefix(only) for text in suspicious]),
            _chain(arm),
            *(_dh_table(arm) if arm.dh_table else _placements(arm)),
            *_links(arm),
            *_uncertainties(arm),
            _limits(arm),
            *_drives(arm),
            *_sentences("Sources", arm.sources),
            *_sentences("Assumptions", arm.assumptions),
        ),
    )


def _sentences(title: str, sentences: Sequence[str]) -> list[Section]:
    facts = tuple(Fact("", "-", sentence, shown="text") for sentence in sentences)
    return [Section("", title, facts)] if facts else []


def _cells(values: Iterable[float | None]) -> list[str]:
    """Numbers as they are given; ? where none is stated."""
    return ["?" if value is None else f"{value:g}" for value in values]


def _entries(tensor: FloatArray, of: Mapping[str, tuple[int, int]]) -> list[str]:
    return _cells(float(tensor[at]) for at in of.values())


def _table(
    title: str, first: Column, headings: Iterable[str], rows: Sequence[Sequence[str]], note: str = ""
) -> Table:
    columns = zip(headings, zip(*rows, strict=True), strict=True)
    return Table("", title, (first, *(Column("", heading, list(cells)) for heading, cells in columns)), note)


def _names(heading: str, names: Sequence[str]) -> Column:
    return Column("", heading, names, shown="name")


def _of_joints(arm: RobotArm) -> Column:
    return _names("joint", [joint.name for joint in arm.joints])


def _numbers(arm: RobotArm) -> Column:
    return Column("", "#", range(1, arm.n_joints + 1), shown="count")


def _chain(arm: RobotArm) -> Table:
    whole = float(arm.mass.sum())
    places = [
        ", ".join(str(place.line) for place in (joint.source, link.source) if place and place.line)
        for joint, link in zip(arm.joints, arm.links, strict=True)
    ]
    columns = (
        _numbers(arm),
        _of_joints(arm),
        _names("moves link", [link.name for link in arm.links]),
        Column("", "kg", [f"{mass:.3g}" for mass in arm.mass]),
        Column("", "%", [f"{100 * mass / (whole or 1.0):.0f}" for mass in arm.mass]),
        Column("", "at lines" * any(places), places),
    )
    return Table("", f"Chain, {whole:.4g} kg in all", columns)


def _dh_table(arm: RobotArm) -> Iterator[Table]:
    rows = []
    for joint, row in zip(arm.joints, arm.dh_table, strict=True):
        theta, d, a, alpha = _cells([math.degrees(row.theta), row.d, row.a, math.degrees(row.alpha)])
        if joint.kind == "revolute":
            theta = f"q + {theta}" if row.theta else "q"
        else:
            d = f"q + {d}" if row.d else "q"
        rows.append([joint.kind, theta, d, a, alpha])
    title = arm.convention[:1].upper() + arm.convention[1:]
    yield _table(title, _of_joints(arm), ["kind", "theta °", "d m", "a m", "alpha °"], rows)


def _placements(arm: RobotArm) -> Iterator[Table]:
    rows = [[*_pose(joint.placement), _axis(joint.axis), joint.kind] for joint in arm.joints]
    title = "Joint frames, each in the frame of the link before: place (m), angles about x, y, z (°), axis"
    yield _table(title, _numbers(arm), [*_POSE, "axis", "kind"], rows)
    frames = [link.frame for link in arm.links]
    if any(frame.translation.any() or (frame.rotation != np.eye(3)).any() for frame in frames):
        title = "Link frames, each in its joint's: place (m), angles about x, y, z (°)"
        yield _table(title, _numbers(arm), _POSE, list(map(_pose, frames)))


def _pose(placement: Placement) -> list[str]:
    # Twelve digits of a degree are round-off; a zero has no sign.
    angles = (round(math.degrees(angle), 9) + 0.0 for angle in angles_of(placement.rotation))
    return _cells([*(placement.translation + 0.0), *angles])


def _axis(axis: FloatArray) -> str:
    along = np.flatnonzero(axis)
    if len(along) == 1:
        return ("-" if axis[along[0]] < 0 else "") + "xyz"[along[0]]
    return " ".join(f"{x:.4g}" for x in axis)


def _links(arm: RobotArm) -> Iterator[Table | Fact]:
    names = _names("link", [link.name for link in arm.links])
    masses = [_cells([link.mass, *link.com]) for link in arm.links]
    yield _table(
        "Links: mass (kg) and centre of mass (m) in the link's frame", names, ["mass", "x", "y", "z"], masses
    )
    moments, products = (
        [_entries(link.inertia_com, of) for link in arm.links] for of in (_MOMENTS, _PRODUCTS)
    )
    has_products = any(cell != "0" for row in products for cell in row)
    title = "Inertia about the centre of mass (kg m²), along the axes of the link's frame"
    yield _table(title, names, _MOMENTS, moments, "" if has_products else "All products of inertia are zero.")
    if has_products:
        yield _table("Products of inertia, as they stand in the tensor", names, _PRODUCTS, products)
    measured = [link.name for link in arm.links if link.as_measured]
    axial = [link.name for link in arm.links if link.axial_only]
    for label, links in (
        ("Inertia kept as measured", measured),
        ("Inertia about the joint's axis only", axial),
    ):
        if links:
            yield Fact("", label, ", ".join(links), shown="text")


def _uncertainties(arm: RobotArm) -> Iterator[Table]:
    stated = [(link.name, link.uncertainty) for link in arm.links if link.uncertainty is not None]
    if not stated:
        return
    names, rows = _names("link", [name for name, _ in stated]), []
    for _, known in stated:
        moments = ["?"] * 3 if known.inertia is None else _entries(known.inertia, _MOMENTS)
        rows.append([*_cells([known.mass, *([None] * 3 if known.com is None else known.com)]), *moments])
    title = "Standard uncertainties of mass (kg), centre of mass (m) and inertia (kg m²); ? if not stated"
    yield _table(title, names, ["mass", "x", "y", "z", *_MOMENTS], rows)
    tensors = [(name, known.inertia) for name, known in stated if known.inertia is not None]
    about_origin = ", ".join(
        name for name, known in stated if known.inertia is not None and known.inertia_about == "origin"
    )
    products = [_entries(tensor, _PRODUCTS) for _, tensor in tensors]
    if about_origin or any(cell != "0" for row in products for cell in row):
        note = f"About the origin of the link frame: {about_origin}." if about_origin else ""
        title = "Standard uncertainties of products of inertia (kg m²)"
        yield _table(title, _names("link", [name for name, _ in tensors]), _PRODUCTS, products, note)


def _limits(arm: RobotArm) -> Table:
    rows = []
    for joint in arm.joints:
        scale, unit = (math.degrees(1.0), "°") if joint.kind == "revolute" else (1.0, "m")
        ends = (joint.lower, joint.upper)
        lower, upper = _cells(end if end is None else end * scale for end in ends)
        limits = ((joint.velocity_limit, "s"), (joint.acceleration_limit, "s²"))
        rows.append(
            ["?" if ends == (None, None) else f"{lower} .. {upper} {unit}"]
            + ["?" if limit is None else f"{limit:g} {joint.unit}/{per}" for limit, per in limits]
        )
    return _table("Limits", _of_joints(arm), ["range", "velocity", "acceleration"], rows)


def _drives(arm: RobotArm) -> Iterator[Table]:
    if not arm.drives:
        return
    kg, newton = ("", "") if all(arm.is_revolute) else ("; kg if prismatic", "; N if prismatic")
    title = (
        f"Drives: inertia at the joint (kg m²{kg}), gear ratio, friction at the motor (N m s and N m), "
        f"torque limit at the joint (N m{newton})"
    )
    headings = ["inertia", "±", "ratio", "viscous", "Coulomb +", "Coulomb -", "limit"]
    rows = [
        _cells([*(x.inertia, x.inertia_uncertainty, x.gear_ratio, x.viscous), *x.coulomb, x.torque_limit])
        for x in arm.drives
    ]
    yield _table(title, _of_joints(arm), headings, rows)
