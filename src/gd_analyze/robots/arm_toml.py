"""Write an arm as a TOML file that reads back as the same arm, number by number.

An arm given by a Denavit-Hartenberg table keeps it; any other is written with placements.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, OutputError, require_type
from gd_analyze.files import path_of, write_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import DH_JOINT, DRIVE, JOINT, LINK, PLACED_JOINT, PLACED_LINK, REQUIRED, Key
from gd_analyze.robots.frames import CONVENTIONS, angles_of, roll_pitch_yaw
from gd_analyze.robots.parts import DHRow, Joint, Link
from gd_analyze.robots.text_file import UNIT_SUFFIXES
from gd_analyze.text import visible

# Most decimals of an angle in degrees as a person would write it.
_MOST_DECIMALS = 6
_DEGREE = UNIT_SUFFIXES["_deg"]


def save_arm(arm: RobotArm, path: str | Path) -> None:
    """Write an arm as a TOML file, atomically; `load_arm` reads the same arm back.

    Parameters
    ----------
    arm
        Any arm: read, made in Python or identified.
    path
        The file, .toml; an existing one is replaced.

    Raises
    ------
    ArmError
        If a payload was merged into a link with uncertainties: a file cannot keep the two apart.
    OutputError
        If the name does not end in .toml, or the file cannot be written.
    """
    require_type(arm, RobotArm, "arm", "a RobotArm, such as `load_arm` returns")
    require_name_of_toml(path_of(path))
    write_text(path, toml_of(arm))


def require_name_of_toml(path: Path) -> None:
    """Raise an OutputError unless a file that is to hold an arm will be read as TOML."""
    if path.suffix.lower() != ".toml":
        name = visible(path.name)
        message, expected = "an arm is written as TOML", "a name that ends in .toml"
        raise OutputError(message, where=visible(str(path)), expected=expected, found=name)


def toml_of(arm: RobotArm) -> str:
    """TOML from which `read_arm` makes the same arm, to the last bit of every number.

    ArmError if a payload's link has uncertainties: a file cannot keep the two apart.
    """
    convention = table_convention(arm)
    placed = convention not in CONVENTIONS
    rows = [None] * arm.n_joints if placed else arm.dh_table
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", arm.name)
    name = name if re.match(r"[A-Za-z0-9]", name) else f"arm{name}"
    title = arm.title or arm.name
    head: dict[str, Any] = {"format": "gd-analyze arm 1", "name": name, "title": title}
    head["convention"] = convention
    head |= {key: getattr(arm, key) for key in ("gravity", "sources", "assumptions", "doubts")}
    if arm.spread is not None:
        head["spread"] = arm.spread.reshape(len(arm.spread), -1).tolist()
    written = {key: value for key, value in head.items() if len(value) and (key != "title" or value != name)}
    joint_keys = JOINT | (PLACED_JOINT if placed else DH_JOINT)
    blocks = [
        "# Numbers are in SI units and radians unless a key says otherwise.\n" + _lines(written.items()),
        *(_block("joints", _joint(*pair), joint_keys) for pair in zip(arm.joints, rows, strict=True)),
        *(_block("links", _link(link), LINK | (PLACED_LINK if placed else {})) for link in arm.links),
        *(_block("drives", vars(x) | {"torque_limit": x.torque_limit or None}, DRIVE) for x in arm.drives),
    ]
    return "\n\n".join(blocks) + "\n"


def _block(kind: str, values: Mapping[str, Any], keys: Mapping[str, Key]) -> str:
    """Values other than None and defaults; angles in degrees where that is short and exact."""
    entries = []
    for key, entry in keys.items():
        value = values[key]
        if value is None or (entry.default is not REQUIRED and _value(value) == _value(entry.default)):
            continue
        is_angle = entry.suffix == "_deg" or (entry.suffix == "" and values["kind"] == "revolute")
        degrees = [_in_degrees(angle) for angle in np.ravel(value).tolist()] if is_angle else [None]
        if None not in degrees:
            key, value = f"{key}_deg", degrees[0] if isinstance(value, float) else degrees
        entries.append((key, value))
    return f"[[{kind}]]\n{_lines(entries)}"


def _lines(entries: Iterable[tuple[str, Any]]) -> str:
    return "\n".join(f"{key} = {_value(value)}" for key, value in entries)


def _value(value: Any) -> str:
    """A value as TOML: numbers in the fewest exact digits; TOML shares JSON's escapes."""
    if value is None or isinstance(value, str | bool):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, dict):
        return f"{{ {', '.join(f'{key} = {_value(inner)}' for key, inner in value.items())} }}"
    has_texts = any(isinstance(inner, str | list) for inner in value)
    listed = (",\n    " if has_texts else ", ").join(map(_value, value))
    return f"[\n    {listed},\n]" if has_texts else f"[{listed}]"


def _in_degrees(angle: float) -> float | None:
    """The same angle, to the last bit, in degrees with few digits; None if there is none."""
    if not math.isfinite(angle):
        return angle
    rounded = (round(math.degrees(angle), digits) for digits in range(_MOST_DECIMALS + 1))
    return next((degrees for degrees in rounded if degrees * _DEGREE == angle), None)


def table_convention(arm: RobotArm) -> str:
    """The convention of the arm's table, or "placement" if no table gives the same arm."""
    for word, (name, placements_of) in CONVENTIONS.items():
        if not arm.dh_table or arm.convention != name:
            continue
        frames = []
        for joint, link, row in zip(arm.joints, arm.links, arm.dh_table, strict=True):
            before, behind = placements_of(joint.kind, row)
            frames += [(joint.placement, before), (link.frame, behind)]
        if all(_same(joint.axis, np.array([0.0, 0.0, 1.0])) for joint in arm.joints) and all(
            _same(a.rotation, b.rotation) and _same(a.translation, b.translation) for a, b in frames
        ):
            return word
    return "placement"


def _same(a: FloatArray, b: FloatArray) -> bool:
    """Whether arrays are equal bit by bit: the sign of a zero is part of a fingerprint."""
    return a.tobytes() == b.tobytes()


def _joint(joint: Joint, row: DHRow | None) -> dict[str, Any]:
    lower, upper = joint.lower, joint.upper
    ends = [-math.inf if lower is None else lower, math.inf if upper is None else upper]
    values = vars(joint) | {"range": ends, "xyz": joint.placement.translation}
    for key in ("velocity_limit", "acceleration_limit"):
        values[key] = None if values[key] == math.inf else values[key]
    return values | (_turn(joint.placement.rotation, "") if row is None else vars(row))


def _turn(rotation: FloatArray, prefix: str) -> dict[str, Any]:
    """A rotation as the shortest angles that reproduce it bit by bit, or else as a matrix."""
    unset, angles = {f"{prefix}rpy": None, f"{prefix}rotation": None}, angles_of(rotation)
    if _same(rotation, np.eye(3)):
        return unset
    short = (
        [round(math.degrees(a), digits) * _DEGREE + 0.0 for a in angles]
        for digits in range(_MOST_DECIMALS + 1)
    )
    matches = (rpy for rpy in (*short, list(angles)) if _same(roll_pitch_yaw(*rpy), rotation))
    rpy = next(matches, None)
    return unset | ({f"{prefix}rotation": rotation} if rpy is None else {f"{prefix}rpy": rpy})


def _link(link: Link) -> dict[str, Any]:
    values = vars(link) | {"inertia": _tensor(link.inertia_com), "inertia_about": "com"}
    values |= {"frame_xyz": link.frame.translation} | _turn(link.frame.rotation, "frame_")
    uncertainty = link.uncertainty
    if uncertainty is not None and uncertainty.body_mass is not None:
        message = f"link {link.name} carries a payload, and its uncertainties are for the link alone"
        hint = "write the arm without its payload, and give the payload where the arm is used"
        raise ArmError(message, where=link.place, next_step=hint)
    inertia = None if uncertainty is None or uncertainty.inertia is None else _tensor(uncertainty.inertia)
    about = (
        None
        if uncertainty is None or inertia is None or uncertainty.inertia_about == "com"
        else uncertainty.inertia_about
    )
    return values | {
        "mass_uncertainty": uncertainty and uncertainty.mass,
        "com_uncertainty": uncertainty and uncertainty.com,
        "inertia_uncertainty": inertia,
        "inertia_uncertainty_about": about,
    }


def _tensor(inertia: FloatArray) -> dict[str, float]:
    """Entries of a tensor, symmetric ones averaged over round-off; without products that are 0."""
    mean = 0.5 * (inertia + inertia.T)
    entries = {"xx": mean[0, 0], "yy": mean[1, 1], "zz": mean[2, 2]}
    products = {"xy": mean[0, 1], "xz": mean[0, 2], "yz": mean[1, 2]}
    return entries | {key: value for key, value in products.items() if repr(float(value)) != "0.0"}
