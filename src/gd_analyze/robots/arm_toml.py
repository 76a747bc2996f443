"""Writes an arm as a TOML file that reads back as the same arm, number by number.

An arm that a Denavit-Hartenberg table describes keeps it; any other is written by placements.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Sequence

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_schema import UNIT_SUFFIXES
from gd_analyze.robots.frames import CONVENTIONS, angles_of, placements_of, roll_pitch_yaw
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, LinkUncertainty, Placement

# Digits up to which an angle is short enough in degrees to be a person's.
_SHORT = 6


def toml_of(arm: RobotArm) -> str:
    """Write an arm as the text of a TOML file, docs/arms.md.

    Parameters
    ----------
    arm
        The arm; of two entries of an inertia that are one but for round-off the mean is written.

    Returns
    -------
    str
        The text; `read_arm` makes the same arm of it, to the last bit of every number.

    Raises
    ------
    ArmError
        If the last link carries a payload whose link has uncertainties: a file cannot keep the two apart.

    Examples
    --------
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> print(toml_of(load_arm("two_link")).splitlines()[1])
    format = "gd-analyze arm 1"
    """
    convention = _convention(arm)
    placed = convention == "placement"
    rows = [None] * arm.n_joints if placed else arm.dh_table
    tables = [("joints", _joint(joint, row)) for joint, row in zip(arm.joints, rows, strict=True)]
    tables += [("links", _link(link, placed)) for link in arm.links]
    tables += [("drives", _drive(drive)) for drive in arm.drives]
    blocks, explained = [list(_head(arm, convention))], set[str]()
    for kind, entries in tables:
        blocks.append([f"[[{kind}]]", *(_line(key, value, kind, explained) for key, value in entries)])
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


# What a value is, and in which unit, where its key stands first; by key without the suffix of a unit.
_COMMENTS = {
    "theta": "rad",
    "alpha": "rad",
    "a": "m",
    "d": "m",
    "xyz": "m, the joint frame in the frame of the link before",
    "rpy": "rad, about x, then y, then z of that frame",
    "rotation": "the same as a matrix, row by row",
    "axis": "in the joint frame",
    "range": "rad (m of a joint that slides)",
    "velocity_limit": "rad/s (m/s)",
    "acceleration_limit": "rad/s^2 (m/s^2)",
    "mass": "kg",
    "com": "m, in the link frame",
    "links.inertia": "kg m^2, about the centre of mass",
    "drives.inertia": "kg m^2 (kg of a joint that slides), at the joint",
    "frame_xyz": "m, the link frame in the joint frame",
    "inertia_uncertainty": "kg m^2",
    "viscous": "N m s, at the motor",
    "coulomb": "N m, at the motor, forwards and backwards",
    "torque_limit": "N m or N, at the joint",
}

# Key, with the suffix of its unit, and value as TOML.
_Entry = tuple[str, str]


def _line(key: str, value: str, kind: str, explained: set[str]) -> str:
    """Line of a table, with a comment where its key is not among those explained; then it is."""
    bare = key.removesuffix("_deg")
    comment = _COMMENTS.get(bare) or _COMMENTS.get(f"{kind}.{bare}")
    if comment is None or f"{kind}.{key}" in explained or "\n" in value:
        return f"{key} = {value}"
    explained.add(f"{kind}.{key}")
    if key != bare:
        comment = re.sub(r" \(m.*\)", "", comment.replace("rad", "degrees"))
    return f"{key} = {value}  # {comment}"


def _head(arm: RobotArm, convention: str) -> Iterator[str]:
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", arm.name)
    name = name if re.match(r"[A-Za-z0-9]", name) else f"arm{name}"
    title = arm.title or ("" if name == arm.name else arm.name)
    yield "# Numbers are in SI units and radians unless a key says otherwise."
    yield 'format = "gd-analyze arm 1"'
    yield f"name = {_text(name)}"
    if title and title != name:
        yield f"title = {_text(title)}"
    yield f"convention = {_text(convention)}"
    yield f"gravity = {_numbers(arm.gravity)}  # m/s^2, in the base frame"
    for key in ("sources", "assumptions", "doubts"):
        if texts := getattr(arm, key):
            yield f"{key} = [\n" + "".join(f"    {_text(text)},\n" for text in texts) + "]"


def _convention(arm: RobotArm) -> str:
    """The word for the arm's table, or for placements where it has none that makes the same arm."""
    for word, called in CONVENTIONS.items():
        if arm.dh_table and arm.convention == called:
            made = [
                placements_of(word, joint.kind, row)
                for joint, row in zip(arm.joints, arm.dh_table, strict=True)
            ]
            along_z = np.array([0.0, 0.0, 1.0])
            if all(
                _is_same(joint.axis, along_z)
                and _is_placed(joint.placement, before)
                and _is_placed(link.frame, behind)
                for joint, link, (before, behind) in zip(arm.joints, arm.links, made, strict=True)
            ):
                return word
    return "placement"


def _is_same(a: FloatArray, b: FloatArray) -> bool:
    """Bit by bit: the sign of a zero is part of a fingerprint."""
    return a.tobytes() == b.tobytes()


def _is_placed(a: Placement, b: Placement) -> bool:
    return _is_same(a.rotation, b.rotation) and _is_same(a.translation, b.translation)


def _joint(joint: Joint, row: DHRow | None) -> Iterator[_Entry]:
    yield "name", _text(joint.name)
    if joint.kind != "revolute":
        yield "kind", _text(joint.kind)
    if row is not None:
        for key in ("theta", "d", "a", "alpha"):
            value = getattr(row, key)
            if value != 0.0 or math.copysign(1.0, value) < 0.0:
                yield _angles(key, value) if key in ("theta", "alpha") else (key, _number(value))
    else:
        yield from _placement(joint.placement, "")
        if not _is_same(joint.axis, np.array([0.0, 0.0, 1.0])):
            yield "axis", _numbers(joint.axis)
    turns = joint.kind == "revolute"
    lower = -math.inf if joint.lower is None else joint.lower
    upper = math.inf if joint.upper is None else joint.upper
    if math.isfinite(lower) or math.isfinite(upper):
        yield _angles("range", [lower, upper]) if turns else ("range", _numbers([lower, upper]))
    for key in ("velocity_limit", "acceleration_limit"):
        limit = getattr(joint, key)
        if limit is not None and math.isfinite(limit):
            yield _angles(key, limit) if turns else (key, _number(limit))


def _link(link: Link, placed: bool) -> Iterator[_Entry]:
    yield "name", _text(link.name)
    if placed:
        yield from _placement(link.frame, "frame_")
    yield "mass", _number(link.mass)
    yield "com", _numbers(link.com)
    yield "inertia", _tensor(link.inertia_com)
    for key in ("as_measured", "axial_only"):
        if getattr(link, key):
            yield key, "true"
    if link.uncertainty is not None:
        yield from _uncertainty(link, link.uncertainty)


def _uncertainty(link: Link, known: LinkUncertainty) -> Iterator[_Entry]:
    if known.body_mass is not None:
        raise ArmError(
            f"link {link.name} carries a payload, and states uncertainties that are of the link alone",
            where=link.place,
            expected="a link whose uncertainties are its own",
            next_step="write the arm without its payload, and give the payload where the arm is used",
        )
    if known.mass is not None:
        yield "mass_uncertainty", _number(known.mass)
    if known.com is not None:
        yield "com_uncertainty", _numbers(known.com)
    if known.inertia is not None:
        yield "inertia_uncertainty", _tensor(known.inertia)
        if known.inertia_about != "com":
            yield "inertia_uncertainty_about", _text(known.inertia_about)


def _drive(drive: Drive) -> Iterator[_Entry]:
    """What is not said by default, but always the inertia; no torque at all is no limit that is stated."""
    default = Drive()
    yield "inertia", _number(drive.inertia)
    for key in ("inertia_uncertainty", "gear_ratio", "viscous", "torque_limit"):
        value = getattr(drive, key)
        if value is not None and value != getattr(default, key) and not (key == "torque_limit" and not value):
            yield key, _number(value)
    if drive.coulomb != default.coulomb:
        yield "coulomb", _numbers(drive.coulomb)


def _placement(placement: Placement, prefix: str) -> Iterator[_Entry]:
    if not _is_same(placement.translation, np.zeros(3)):
        yield f"{prefix}xyz", _numbers(placement.translation)
    rotation = placement.rotation
    if _is_same(rotation, np.eye(3)):
        return
    for angles in _candidates(rotation):
        if _is_same(roll_pitch_yaw(*angles), rotation):
            yield _angles(f"{prefix}rpy", angles)
            return
    rows = "".join(f"    {_numbers(row)},\n" for row in rotation)
    yield f"{prefix}rotation", f"[\n{rows}]"


def _candidates(rotation: FloatArray) -> Iterator[list[float]]:
    """Angles that may make a rotation to the last bit: as short in degrees as they come, and as they are."""
    angles = angles_of(rotation)
    for digits in range(_SHORT + 1):
        yield [round(math.degrees(angle), digits) * UNIT_SUFFIXES["_deg"] + 0.0 for angle in angles]
    yield list(angles)


def _angles(key: str, value: float | Sequence[float]) -> _Entry:
    """In degrees where that is short and says the same, to the last bit."""
    values = [value] if isinstance(value, float) else list(value)
    short = [_in_degrees(angle) for angle in values]
    suffix = ""
    if None not in short:
        suffix, values = "_deg", [angle for angle in short if angle is not None]
    return f"{key}{suffix}", _number(values[0]) if isinstance(value, float) else _numbers(values)


def _in_degrees(angle: float) -> float | None:
    if not math.isfinite(angle):
        return angle
    for digits in range(_SHORT + 1):
        degrees = round(math.degrees(angle), digits)
        if degrees * UNIT_SUFFIXES["_deg"] == angle:
            return degrees
    return None


def _tensor(inertia: FloatArray) -> str:
    mean = 0.5 * (inertia + inertia.T)
    entries = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    told = [
        f"{name} = {_number(mean[place])}"
        for name, place in entries.items()
        if name in ("xx", "yy", "zz") or not _is_same(mean[place], np.zeros(()))
    ]
    return f"{{ {', '.join(told)} }}"


def _numbers(values: Iterable[float]) -> str:
    return f"[{', '.join(map(_number, values))}]"


def _number(value: float) -> str:
    """The fewest digits that read back as the same number."""
    return repr(float(value))


def _text(text: str) -> str:
    """A text in quotes; JSON's escapes are TOML's too."""
    return json.dumps(text, ensure_ascii=False)
