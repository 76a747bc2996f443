"""Writes an arm as a TOML file that reads back as the same arm, number by number.

An arm that a Denavit-Hartenberg table describes keeps it; any other is written by placements.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.errors import ArmError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import CONVENTIONS, angles_of, roll_pitch_yaw
from gd_analyze.robots.parts import DHRow, Drive, Joint, Link, Placement
from gd_analyze.robots.text_file import UNIT_SUFFIXES

# Digits up to which an angle in degrees is short enough to be a person's.
_SHORT = 6
_ALONG_Z = (0.0, 0.0, 1.0)
_DEGREE = UNIT_SUFFIXES["_deg"]
_ENTRIES = {"xx": (0, 0), "yy": (1, 1), "zz": (2, 2), "xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}

# Key, with the suffix of its unit, and value.
_Entries = Iterator[tuple[str, Any]]


def toml_of(arm: RobotArm) -> str:
    """TOML of an arm, of which `read_arm` makes the same one, to the last bit of every number.

    ArmError if a payload's link has uncertainties: a file cannot keep the two apart.

    Examples
    --------
    >>> from gd_analyze.robots.catalogue import load_arm
    >>> print(toml_of(load_arm("two_link")).splitlines()[1])
    format = "gd-analyze arm 1"
    """
    convention = _convention(arm)
    placed = convention not in CONVENTIONS
    rows = [None] * arm.n_joints if placed else arm.dh_table
    tables = [
        *(("joints", _joint(joint, row)) for joint, row in zip(arm.joints, rows, strict=True)),
        *(("links", _link(link, placed)) for link in arm.links),
        *(("drives", _drive(drive)) for drive in arm.drives),
    ]
    blocks = [_lines(_head(arm, convention)), *(f"[[{kind}]]\n{_lines(entries)}" for kind, entries in tables)]
    return "# Numbers are in SI units and radians unless a key says otherwise.\n" + "\n\n".join(blocks) + "\n"


def _lines(entries: _Entries) -> str:
    return "\n".join(f"{key} = {_value(value)}" for key, value in entries)


def _value(value: Any) -> str:
    """A value as TOML: numbers in the fewest digits that read back; JSON's escapes are TOML's too."""
    if isinstance(value, str | bool):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_value(inner)}' for key, inner in value.items())} }}"
    is_list_of_texts = any(isinstance(inner, str) for inner in value)
    listed = (",\n    " if is_list_of_texts else ", ").join(map(_value, value))
    return f"[\n    {listed},\n]" if is_list_of_texts else f"[{listed}]"


def _head(arm: RobotArm, convention: str) -> _Entries:
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", arm.name)
    name = name if re.match(r"[A-Za-z0-9]", name) else f"arm{name}"
    yield "format", "gd-analyze arm 1"
    yield "name", name
    if (arm.title or arm.name) != name:
        yield "title", arm.title or arm.name
    yield "convention", convention
    yield "gravity", arm.gravity
    yield from ((key, getattr(arm, key)) for key in ("sources", "assumptions", "doubts") if getattr(arm, key))


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


def _same(a: ArrayLike, b: ArrayLike) -> bool:
    """Bit by bit: the sign of a zero is part of a fingerprint."""
    return np.asarray(a, dtype=float).tobytes() == np.asarray(b, dtype=float).tobytes()


def _joint(joint: Joint, row: DHRow | None) -> _Entries:
    is_revolute = joint.kind == "revolute"
    yield "name", joint.name
    if not is_revolute:
        yield "kind", joint.kind
    if row is not None:
        for key in ("theta", "d", "a", "alpha"):
            value = getattr(row, key)
            if not _same(value, 0.0):
                yield _angles(key, value) if key in ("theta", "alpha") else (key, value)
    else:
        yield from _placement(joint.placement, "")
        if not _same(joint.axis, _ALONG_Z):
            yield "axis", joint.axis
    ends = [
        -math.inf if joint.lower is None else joint.lower,
        math.inf if joint.upper is None else joint.upper,
    ]
    if any(map(math.isfinite, ends)):
        yield _angles("range", ends) if is_revolute else ("range", ends)
    for key in ("velocity_limit", "acceleration_limit"):
        limit = getattr(joint, key)
        if limit is not None and math.isfinite(limit):
            yield _angles(key, limit) if is_revolute else (key, limit)


def _link(link: Link, placed: bool) -> _Entries:
    yield "name", link.name
    if placed:
        yield from _placement(link.frame, "frame_")
    yield "mass", link.mass
    yield "com", link.com
    yield "inertia", _tensor(link.inertia_com)
    if link.as_measured:
        yield "as_measured", True
    if link.axial_only:
        yield "axial_only", True
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
        yield "mass_uncertainty", known.mass
    if known.com is not None:
        yield "com_uncertainty", known.com
    if known.inertia is not None:
        yield "inertia_uncertainty", _tensor(known.inertia)
        if known.inertia_about != "com":
            yield "inertia_uncertainty_about", known.inertia_about


def _drive(drive: Drive) -> _Entries:
    """What differs from the default, and always the inertia; a torque limit of 0 is none."""
    default = Drive(torque_limit=0.0)
    yield "inertia", drive.inertia
    for key in ("inertia_uncertainty", "gear_ratio", "viscous", "torque_limit", "coulomb"):
        value = getattr(drive, key)
        if value is not None and value != getattr(default, key):
            yield key, value


def _placement(placement: Placement, prefix: str) -> _Entries:
    """Place and orientation; the shortest angles in degrees that make the rotation bit by bit."""
    rotation = placement.rotation
    if not _same(placement.translation, np.zeros(3)):
        yield f"{prefix}xyz", placement.translation
    if _same(rotation, np.eye(3)):
        return
    angles = angles_of(rotation)
    short = ([round(math.degrees(a), digits) * _DEGREE + 0.0 for a in angles] for digits in range(_SHORT + 1))
    for found in (*short, list(angles)):
        if _same(roll_pitch_yaw(*found), rotation):
            yield _angles(f"{prefix}rpy", found)
            return
    yield f"{prefix}rotation", rotation


def _angles(key: str, value: float | Sequence[float]) -> tuple[str, Any]:
    """In degrees where that is short and says the same, to the last bit."""
    degrees = [_in_degrees(angle) for angle in ([value] if isinstance(value, float) else value)]
    if None in degrees:
        return key, value
    return f"{key}_deg", degrees[0] if isinstance(value, float) else degrees


def _in_degrees(angle: float) -> float | None:
    if not math.isfinite(angle):
        return angle
    rounded = (round(math.degrees(angle), digits) for digits in range(_SHORT + 1))
    return next((degrees for degrees in rounded if degrees * _DEGREE == angle), None)


def _tensor(inertia: ArrayLike) -> dict[str, float]:
    """Entries, the mean of two that are one but for round-off; products that are not 0."""
    mean = 0.5 * (np.asarray(inertia) + np.transpose(inertia))
    return {key: mean[at] for key, at in _ENTRIES.items() if at[0] == at[1] or not _same(mean[at], 0.0)}
