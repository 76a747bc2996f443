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
from gd_analyze.robots.frames import CONVENTIONS, angles_of, roll_pitch_yaw
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, Placement

# Digits up to which an angle in degrees is short enough to be a person's.
_SHORT = 6
_ALONG_Z = np.array([0.0, 0.0, 1.0])

# Meaning and unit of a key, where it stands first; by key without the suffix of a unit.
_COMMENTS = {
    "theta": "rad",
    "alpha": "rad",
    "a": "m",
    "d": "m",
    "xyz": "m, the joint frame in the frame of the link before",
    "rpy": "rad, about x, then y, then z of that frame",
    "rotation": "the same as a matrix, row by row",
    "axis": "in the joint frame",
    "range": "rad (m of a prismatic joint)",
    "velocity_limit": "rad/s (m/s)",
    "acceleration_limit": "rad/s^2 (m/s^2)",
    "mass": "kg",
    "com": "m, in the link frame",
    "links.inertia": "kg m^2, about the centre of mass",
    "drives.inertia": "kg m^2 (kg of a prismatic joint), at the joint",
    "frame_xyz": "m, the link frame in the joint frame",
    "inertia_uncertainty": "kg m^2",
    "viscous": "N m s, at the motor",
    "coulomb": "N m, at the motor, forwards and backwards",
    "torque_limit": "N m or N, at the joint",
}

# Key, with the suffix of its unit, and value as TOML.
_Entry = tuple[str, str]


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
    rows = arm.dh_table if convention in CONVENTIONS else [None] * arm.n_joints
    tables = [("joints", _joint(joint, row)) for joint, row in zip(arm.joints, rows, strict=True)]
    tables += [("links", _link(link, placed=convention not in CONVENTIONS)) for link in arm.links]
    tables += [("drives", _drive(drive)) for drive in arm.drives]
    blocks, explained = [list(_head(arm, convention))], set[str]()
    for kind, entries in tables:
        blocks.append([f"[[{kind}]]", *(_line(key, value, kind, explained) for key, value in entries)])
    return "\n\n".join("\n".join(block) for block in blocks) + "\n"


def _line(key: str, value: str, kind: str, explained: set[str]) -> str:
    """Line of a table, with a comment where its key stands for the first time."""
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
    title = arm.title or arm.name
    yield "# Numbers are in SI units and radians unless a key says otherwise."
    yield 'format = "gd-analyze arm 1"'
    yield f"name = {_text(name)}"
    if title != name:
        yield f"title = {_text(title)}"
    yield f"convention = {_text(convention)}"
    yield f"gravity = {_numbers(arm.gravity)}  # m/s^2, in the base frame"
    for key in ("sources", "assumptions", "doubts"):
        if texts := getattr(arm, key):
            yield f"{key} = [\n" + "".join(f"    {_text(text)},\n" for text in texts) + "]"


def _convention(arm: RobotArm) -> str:
    """The convention of the arm's table, or "placement" where it has none that makes the same arm."""
    for word, (name, placements_of) in CONVENTIONS.items():
        if not arm.dh_table or arm.convention != name:
            continue
        frames = []
        for joint, link, row in zip(arm.joints, arm.links, arm.dh_table, strict=True):
            before, behind = placements_of(joint.kind, row)
            frames += [(joint.placement, before), (link.frame, behind)]
        if all(_same(joint.axis, _ALONG_Z) for joint in arm.joints) and all(
            _same(a.rotation, b.rotation) and _same(a.translation, b.translation) for a, b in frames
        ):
            return word
    return "placement"


def _same(a: FloatArray, b: FloatArray) -> bool:
    """Bit by bit: the sign of a zero is part of a fingerprint."""
    return a.tobytes() == b.tobytes()


def _joint(joint: Joint, row: DHRow | None) -> Iterator[_Entry]:
    is_revolute = joint.kind == "revolute"
    yield "name", _text(joint.name)
    if not is_revolute:
        yield "kind", _text(joint.kind)
    if row is not None:
        for key in ("theta", "d", "a", "alpha"):
            value = getattr(row, key)
            if value != 0.0 or math.copysign(1.0, value) < 0.0:
                yield _angles(key, value) if key in ("theta", "alpha") else (key, _number(value))
    else:
        yield from _placement(joint.placement, "")
        if not _same(joint.axis, _ALONG_Z):
            yield "axis", _numbers(joint.axis)
    lower = -math.inf if joint.lower is None else joint.lower
    upper = math.inf if joint.upper is None else joint.upper
    if math.isfinite(lower) or math.isfinite(upper):
        yield _angles("range", [lower, upper]) if is_revolute else ("range", _numbers([lower, upper]))
    for key in ("velocity_limit", "acceleration_limit"):
        limit = getattr(joint, key)
        if limit is not None and math.isfinite(limit):
            yield _angles(key, limit) if is_revolute else (key, _number(limit))


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
    known = link.uncertainty
    if known is None:
        return
    if known.body_mass is not None:
        raise ArmError(
            f"link {link.name} carries a payload, and its uncertainties are of the link alone",
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
    """What differs from the default, and always the inertia; a torque limit of 0 is none."""
    default = Drive()
    yield "inertia", _number(drive.inertia)
    for key in ("inertia_uncertainty", "gear_ratio", "viscous", "torque_limit"):
        value = getattr(drive, key)
        if value is not None and value != getattr(default, key) and not (key == "torque_limit" and not value):
            yield key, _number(value)
    if drive.coulomb != default.coulomb:
        yield "coulomb", _numbers(drive.coulomb)


def _placement(placement: Placement, prefix: str) -> Iterator[_Entry]:
    """Place and orientation; the shortest angles in degrees that make the rotation bit by bit."""
    rotation = placement.rotation
    if not _same(placement.translation, np.zeros(3)):
        yield f"{prefix}xyz", _numbers(placement.translation)
    if _same(rotation, np.eye(3)):
        return
    angles, degree = angles_of(rotation), UNIT_SUFFIXES["_deg"]
    short = ([round(math.degrees(a), digits) * degree + 0.0 for a in angles] for digits in range(_SHORT + 1))
    for found in (*short, list(angles)):
        if _same(roll_pitch_yaw(*found), rotation):
            yield _angles(f"{prefix}rpy", found)
            return
    yield f"{prefix}rotation", "[\n" + "".join(f"    {_numbers(row)},\n" for row in rotation) + "]"


def _angles(key: str, value: float | Sequence[float]) -> _Entry:
    """In degrees where that is short and says the same, to the last bit."""
    values = [value] if isinstance(value, float) else list(value)
    short = [_in_degrees(angle) for angle in values]
    if None not in short:
        key, values = f"{key}_deg", [angle for angle in short if angle is not None]
    return key, _number(values[0]) if isinstance(value, float) else _numbers(values)


def _in_degrees(angle: float) -> float | None:
    if not math.isfinite(angle):
        return angle
    rounded = (round(math.degrees(angle), digits) for digits in range(_SHORT + 1))
    return next((degrees for degrees in rounded if degrees * UNIT_SUFFIXES["_deg"] == angle), None)


def _tensor(inertia: FloatArray) -> str:
    mean = 0.5 * (inertia + inertia.T)
    entries = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}
    stated = [
        f"{name} = {_number(mean[at])}"
        for name, at in entries.items()
        if at[0] == at[1] or not _same(mean[at], np.zeros(()))
    ]
    return f"{{ {', '.join(stated)} }}"


def _numbers(values: Iterable[float]) -> str:
    return f"[{', '.join(map(_number, values))}]"


def _number(value: float) -> str:
    """The fewest digits that read back as the same number."""
    return repr(float(value))


def _text(text: str) -> str:
    """A text in quotes; JSON's escapes are TOML's too."""
    return json.dumps(text, ensure_ascii=False)
