"""Read an arm from a TOML file: keys, units and valid values, and the line of an error.

Units are SI and radians unless a key has a suffix, such as `alpha_deg` and `a_mm`; docs/arms.md has all keys.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.frames import CONVENTIONS, roll_pitch_yaw
from gd_analyze.robots.parts import (
    ORTHONORMAL_TOLERANCE,
    DHRow,
    Drive,
    Joint,
    Link,
    LinkUncertainty,
    Placement,
    checked,
    is_name,
    is_rotation,
    is_sentence,
    of_point_mass,
    symmetric_tensor,
)
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.robots.text_file import UNIT_SUFFIXES, TableLines, parsed_toml, read_text
from gd_analyze.text import in_python

# Bytes of a thousand joints with their links and drives.
_LARGEST_FILE_BYTES = 1_000_000
_EXAMPLE = "`gd-analyze arms puma560 --to toml` prints a complete example"


@dataclass(frozen=True)
class Place:
    """A value's place in the file, such as links[1].mass."""

    lines: TableLines
    keys: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        return "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in self.keys).lstrip(".")

    def at(self, *keys: str | int) -> Place:
        """A place within this one."""
        return Place(self.lines, (*self.keys, *keys))

    @property
    def where(self) -> Location:
        """Line of the place, for messages."""
        return self.lines.locate(self.keys)

    def error(self, problem: str, expected: str | None, found: str | None = None, hint: str = "") -> ArmError:
        """Error about the value at this place."""
        next_step = f"{hint} {_EXAMPLE}".strip()
        message = f"{self} {problem}"
        return ArmError(message, where=self.where, expected=expected, found=found, next_step=next_step)


Reader = Callable[[Any, Place], Any]
REQUIRED = object()


@dataclass(frozen=True)
class Key:
    """Reader of a key's value, default of a missing one, and the suffix of its unit."""

    read: Reader
    default: Any = REQUIRED
    suffix: str | None = None  # "_deg", "_mm", or "" if it depends on the kind of joint


def _numbers(*shape: int, nonnegative: bool = False) -> Reader:
    def read(value: Any, place: Place) -> Any:
        if _has_truth(value):
            raise place.error("is not made of numbers", "numbers", in_python(value))
        array = checked(value, shape, str(place), place.where, nonnegative=nonnegative)
        return array if shape else float(array)

    return read


def _has_truth(value: Any) -> bool:
    return isinstance(value, bool) or (isinstance(value, list) and any(map(_has_truth, value)))


def _that(holds: Callable[[Any], bool], expected: str, read: Reader = lambda value, _: value) -> Reader:
    def read_checked(value: Any, place: Place) -> Any:
        checked_value = read(value, place)
        if not holds(checked_value):
            raise place.error(f"is not {expected}", None, in_python(value))
        return checked_value

    return read_checked


def _one_of(*words: str) -> Reader:
    return _that(lambda value: value in words, " or ".join(words))


def _ends(value: Any, place: Place) -> Any:
    """Lower and upper end, infinite where unknown."""
    unknown = (-math.inf, math.inf)
    if not isinstance(value, list) or len(value) != 2:
        return _numbers(2)(value, place)
    is_open = [end == unknown_end for end, unknown_end in zip(value, unknown, strict=True)]
    numbers = [0.0 if skipped else end for end, skipped in zip(value, is_open, strict=True)]
    return np.where(is_open, unknown, _numbers(2)(numbers, place))


def _rows(value: Any, place: Place) -> list[list[float]]:
    """A list of lists of numbers."""
    if not isinstance(value, list) or not all(isinstance(row, list) for row in value):
        raise place.error("is not a list of lists of numbers", "rows of numbers", in_python(value))
    return [_numbers(len(row))(row, place.at(k)).tolist() for k, row in enumerate(value)]


def _tensor(nonnegative: bool = False) -> Reader:
    number = _numbers(nonnegative=nonnegative)
    keys = dict.fromkeys(("xx", "yy", "zz"), Key(number))
    keys |= dict.fromkeys(("xy", "xz", "yz"), Key(number, 0.0))

    def read(value: Any, place: Place) -> Any:
        if not isinstance(value, dict):
            raise place.error("is not a table", "{ xx = ..., yy = ..., zz = ... }", in_python(value))
        return symmetric_tensor(**_table(value, keys, place))

    return read


_NUMBER, _VECTOR, _NONNEGATIVE = _numbers(), _numbers(3), _numbers(nonnegative=True)
_NAME = _that(is_name, "one short line of printable text")
_IDENTIFIER = _that(
    lambda name: re.match(r"[A-Za-z0-9][\w.-]*$", name, re.ASCII) is not None, "a word", _NAME
)
_SENTENCES = _that(
    lambda texts: isinstance(texts, list) and all(map(is_sentence, texts)), "texts without control characters"
)
_TRUTH = _that(lambda value: isinstance(value, bool), "true or false")
_TABLES = _that(
    lambda tables: isinstance(tables, list) and all(isinstance(table, dict) for table in tables), "tables"
)
_ROTATION = _that(is_rotation, "a rotation: three orthonormal rows, right-handed", _numbers(3, 3))
_DIRECTION = _that(lambda axis: abs(math.hypot(*axis) - 1) <= ORTHONORMAL_TOLERANCE, "a unit vector", _VECTOR)
_POSITIVE = _that(lambda value: value > 0, "a number above 0", _NUMBER)
_ABOUT = _one_of("com", "origin")

FILE = {
    "format": Key(_one_of("gd-analyze arm 1")),
    "name": Key(_IDENTIFIER),
    "title": Key(_NAME, ""),
    "convention": Key(_one_of(*CONVENTIONS, "placement"), "standard"),
    "gravity": Key(_VECTOR, [0.0, 0.0, -9.8062]),
    "sources": Key(_SENTENCES, []),
    "assumptions": Key(_SENTENCES, []),
    "doubts": Key(_SENTENCES, []),
    "joints": Key(_TABLES),
    "links": Key(_TABLES),
    "drives": Key(_TABLES, []),
    "spread": Key(_rows, None),
}
JOINT = {
    "name": Key(_NAME, ""),
    "kind": Key(_one_of("revolute", "prismatic"), "revolute"),
    "range": Key(_ends, (-math.inf, math.inf), ""),
    "velocity_limit": Key(_NUMBER, None, ""),
    "acceleration_limit": Key(_NUMBER, None, ""),
}
DH_JOINT = {
    "theta": Key(_NUMBER, 0.0, "_deg"),
    "d": Key(_NUMBER, 0.0, "_mm"),
    "a": Key(_NUMBER, 0.0, "_mm"),
    "alpha": Key(_NUMBER, 0.0, "_deg"),
}
PLACED_JOINT = {
    "xyz": Key(_VECTOR, [0.0, 0.0, 0.0], "_mm"),
    "rpy": Key(_VECTOR, None, "_deg"),
    "rotation": Key(_ROTATION, None),
    "axis": Key(_DIRECTION, [0.0, 0.0, 1.0]),
}
LINK = {
    "name": Key(_NAME, ""),
    "mass": Key(_NUMBER),
    "com": Key(_VECTOR, suffix="_mm"),
    "inertia": Key(_tensor()),
    "inertia_about": Key(_ABOUT, "com"),
    "as_measured": Key(_TRUTH, False),
    "axial_only": Key(_TRUTH, False),
    "mass_uncertainty": Key(_NONNEGATIVE, None),
    "com_uncertainty": Key(_numbers(3, nonnegative=True), None, "_mm"),
    "inertia_uncertainty": Key(_tensor(nonnegative=True), None),
    "inertia_uncertainty_about": Key(_ABOUT, None),
}
PLACED_LINK = {
    "frame_xyz": Key(_VECTOR, [0.0, 0.0, 0.0], "_mm"),
    "frame_rpy": Key(_VECTOR, None, "_deg"),
    "frame_rotation": Key(_ROTATION, None),
}
DRIVE = {
    "inertia": Key(_NONNEGATIVE, 0.0),
    "inertia_uncertainty": Key(_NONNEGATIVE, None),
    "gear_ratio": Key(_NUMBER, 1.0),
    "viscous": Key(_NONNEGATIVE, 0.0),
    "coulomb": Key(_numbers(2), (0.0, 0.0)),
    "torque_limit": Key(_POSITIVE, None),
}


def read_arm(path: str | Path) -> RobotArm:
    """Read an arm from a TOML file; warns of implausible numbers; an ArmError names the faulty line."""
    path = Path(path)
    content = text_of_arm_file(path)
    document = parsed_toml(path, content, "arm file")
    arm = _arm(document, Place(TableLines(path, content)))
    warn_of_implausible(arm, stacklevel=3)
    return arm


def arm_in(document: dict[str, Any], name: str) -> RobotArm:
    """The arm of a document in memory, called `name` in an ArmError."""
    return _arm(document, Place(TableLines(Path(name), "")))


def read_drives(path: str | Path) -> tuple[Drive, ...]:
    """Drives of a TOML file with only a [[drives]] table per joint; ArmError as for an arm."""
    content = text_of_arm_file(Path(path))
    place = Place(TableLines(Path(path), content))
    tables = _table(parsed_toml(Path(path), content, "file of drives"), {"drives": FILE["drives"]}, place)
    rows = (_table(table, DRIVE, place.at("drives", i)) for i, table in enumerate(tables["drives"]))
    return tuple(Drive(**row) for row in rows)


def text_of_arm_file(path: Path) -> str:
    """Text of an arm file; ArmError if it cannot be read, is not text, or is too long."""
    return read_text(path, "arm file", _LARGEST_FILE_BYTES)


def _table(table: Mapping[str, Any], keys: Mapping[str, Key], place: Place) -> dict[str, Any]:
    """Values of a table by key, in SI units."""
    of_kind = "_mm" if table.get("kind") == "prismatic" else "_deg"
    suffixes = {key: entry.suffix or of_kind for key, entry in keys.items() if entry.suffix is not None}
    suffixed = {key + suffix: key for key, suffix in suffixes.items()}
    values: dict[str, Any] = {}
    for word, value in table.items():
        key = suffixed.get(word, word)
        if key not in keys:
            likely = _likely(word, keys)
            hint = f"did you mean {likely}?" if likely else ""
            raise place.at(word).error("is not a key of an arm file", ", ".join(keys), hint=hint)
        if key in values:
            raise place.at(key).error("is given twice", "it once, with a unit suffix or without")
        read = keys[key].read(value, place.at(word))
        values[key] = read if word == key else read * UNIT_SUFFIXES[suffixes[key]]
    for key, entry in keys.items():
        if values.setdefault(key, entry.default) is REQUIRED:
            raise place.at(key).error("is missing", f"the key {key}")
    for prefix in ("", "frame_"):
        if values.get(f"{prefix}rpy") is not None and values.get(f"{prefix}rotation") is not None:
            raise place.at(f"{prefix}rpy").error("and rotation are both given", "one of the two")
    return values


def _likely(word: str, keys: Iterable[str]) -> str:
    """Key most similar to a misspelt one; its unit suffix is kept unless it is the fault."""
    suffix = next((suffix for suffix in UNIT_SUFFIXES if word.endswith(suffix)), "")
    bare = word.removesuffix(suffix)
    near = difflib.get_close_matches(bare, list(keys), n=1)
    return "" if not near else bare if near[0] == bare else near[0] + suffix


def _arm(document: dict[str, Any], place: Place) -> RobotArm:
    file = _table(document, FILE, place)
    n, placed = len(file["joints"]), file["convention"] == "placement"
    for part in ("joints", "links", "drives"):
        count = len(file[part])
        if (count != n and (count or part == "links")) or not n:
            where, expected = place.at(part, max(0, count - 1)).where, f"{n or 'some'} [[{part}]] tables"
            problem = f"the arm file needs one [[{part}]] table per joint"
            raise ArmError(problem, where=where, expected=expected, found=str(count))
    joints, links, rows = [], [], []
    for i, (joint_table, link_table) in enumerate(zip(file["joints"], file["links"], strict=True)):
        joint_place, link_place, axis = place.at("joints", i), place.at("links", i), np.array([0.0, 0.0, 1.0])
        joint = _table(joint_table, JOINT | (PLACED_JOINT if placed else DH_JOINT), joint_place)
        link = _table(link_table, LINK | (PLACED_LINK if placed else {}), link_place)
        if placed:
            before, behind, axis = _placement(joint, ""), _placement(link, "frame_"), joint["axis"]
        else:
            rows.append(DHRow(**{key: joint[key] for key in DH_JOINT}))
            before, behind = CONVENTIONS[file["convention"]][1](joint["kind"], rows[-1])
        lower, upper = (float(end) if math.isfinite(end) else None for end in joint["range"])
        limits = (lower, upper, joint["velocity_limit"], joint["acceleration_limit"])
        name = joint["name"] or str(i + 1)
        joints.append(Joint(name, joint["kind"], before, axis, *limits, joint_place.where))
        links.append(_link(link, link["name"] or str(i + 1), behind, link_place.where))
    drives = [_table(table, DRIVE, place.at("drives", i)) for i, table in enumerate(file["drives"])]
    texts: dict[str, Any] = {key: tuple(file[key]) for key in ("sources", "assumptions", "doubts")}
    return RobotArm(
        name=file["name"],
        title=file["title"] or file["name"],
        gravity=file["gravity"],
        joints=tuple(joints),
        links=tuple(links),
        drives=tuple(Drive(**drive) for drive in drives),
        spread=_spread(file["spread"], n, place.at("spread")),
        dh_table=tuple(rows),
        convention="placements" if placed else CONVENTIONS[file["convention"]][0],
        **texts,
    )


def _spread(rows: list[list[float]] | None, n: int, place: Place) -> np.ndarray | None:
    """Rows of eleven numbers per link."""
    if rows is None:
        return None
    for k, row in enumerate(rows):
        if len(row) != 11 * n:
            raise place.at(k).error("does not fit the arm", f"{11 * n} numbers, 11 per link", str(len(row)))
    return np.array(rows).reshape(-1, n, 11)


def _link(link: Mapping[str, Any], name: str, behind: Placement, where: Location) -> Link:
    mass, com, inertia = link["mass"], link["com"], link["inertia"]
    if link["inertia_about"] == "origin":
        inertia = inertia - of_point_mass(mass, com)
    uncertainties = link["mass_uncertainty"], link["com_uncertainty"], link["inertia_uncertainty"]
    about = link["inertia_uncertainty_about"] or link["inertia_about"]
    stated = None if all(value is None for value in uncertainties) else LinkUncertainty(*uncertainties, about)
    return Link(name, mass, com, inertia, behind, link["as_measured"], link["axial_only"], stated, where)


def _placement(table: Mapping[str, Any], prefix: str) -> Placement:
    rpy, rotation = table[f"{prefix}rpy"], table[f"{prefix}rotation"]
    turned = np.eye(3) if rpy is None else roll_pitch_yaw(*rpy)
    return Placement(turned if rotation is None else rotation, table[f"{prefix}xyz"])
