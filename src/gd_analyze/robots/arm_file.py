"""The keys of an arm's description, and the arm that a TOML file or a description in memory states.

The tables of keys say what there is: units, valid values and defaults. Numbers are in SI and radians unless
a key has a suffix, such as `alpha_deg` and `a_mm`; docs/arms.md explains all keys.
"""

from __future__ import annotations

import difflib
import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.errors import ArmError, Location
from gd_analyze.robots.arm import USUAL_GRAVITY, RobotArm
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
FORMAT = "gd-analyze arm 1"
_EXAMPLE = "`gd-analyze arms puma560 --to toml` prints a complete example"


@dataclass(frozen=True)
class Place:
    """A value's place in a file or in a description in memory, such as links[1].mass."""

    lines: TableLines | None  # None in memory
    keys: tuple[str | int, ...] = ()

    def __str__(self) -> str:
        return "".join(f"[{key + 1}]" if isinstance(key, int) else f".{key}" for key in self.keys).lstrip(".")

    def at(self, *keys: str | int) -> Place:
        """A place within this one."""
        return Place(self.lines, (*self.keys, *keys))

    @property
    def line(self) -> Location | None:
        """Line of the place in a file."""
        return None if self.lines is None else self.lines.locate(self.keys)

    @property
    def where(self) -> Location | str:
        """The line, or in memory the keys, for messages."""
        return self.line or str(self)

    def error(self, problem: str, expected: str | None, found: str | None = None, hint: str = "") -> ArmError:
        """Error about the value at this place."""
        next_step = f"{hint} {_EXAMPLE}".strip()
        message = f"{self} {problem}"
        return ArmError(message, where=self.where, expected=expected, found=found, next_step=next_step)


Reader = Callable[[Any, Place], Any]
REQUIRED = object()


@dataclass(frozen=True)
class Key:
    """Reader of a key's value, default of a missing one, and what its numbers are."""

    read: Reader
    default: Any = REQUIRED
    unit: str = ""  # in SI, "rad or m" if it depends on the kind of joint
    components: tuple[str, ...] = ()  # names of several numbers, as in link3.com.x

    def suffix(self, kind: str = "") -> str:
        """Suffix of the key with another unit for a kind of joint: _deg, _mm, or "" if there is none."""
        of_kind = {"revolute": "rad", "prismatic": "m"}.get(kind, "")
        unit = of_kind if self.unit in _UNITS_OF_VARIABLES else self.unit
        return {"rad": "_deg", "m": "_mm"}.get(unit, "")


# Of a joint's variable and its derivatives.
_UNITS_OF_VARIABLES = ("rad or m", "rad/s or m/s", "rad/s^2 or m/s^2")


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
    """Lower and upper end, infinite where unknown; JSON, which has no infinity, states null."""
    unknown = (-math.inf, math.inf)
    if not isinstance(value, list) or len(value) != 2:
        return _numbers(2)(value, place)
    is_open = [end is None or end == unknown_end for end, unknown_end in zip(value, unknown, strict=True)]
    numbers = [0.0 if skipped else end for end, skipped in zip(value, is_open, strict=True)]
    return np.where(is_open, unknown, _numbers(2)(numbers, place))


def _sentences(value: Any, place: Place) -> tuple[str, ...]:
    if not isinstance(value, list) or not all(map(is_sentence, value)):
        raise place.error("is not texts without control characters", None, in_python(value))
    return tuple(value)


def _table_of(keys: Mapping[str, Key]) -> Reader:
    def read(value: Any, place: Place) -> dict[str, Any]:
        if not isinstance(value, dict):
            example = ", ".join(f"{key} = ..." for key, entry in keys.items() if entry.default is REQUIRED)
            raise place.error("is not a table", f"{{ {example} }}", in_python(value))
        return _values(value, keys, place)

    return read


def _tensor(nonnegative: bool = False) -> Reader:
    moment, product = Key(_numbers(nonnegative=nonnegative)), Key(_numbers(nonnegative=nonnegative), 0.0)
    entries = _table_of({key: product if key in PRODUCTS else moment for key in _TENSOR})
    return lambda value, place: symmetric_tensor(**entries(value, place))


_XYZ, _TENSOR, PRODUCTS = ("x", "y", "z"), ("xx", "yy", "zz", "xy", "xz", "yz"), ("xy", "xz", "yz")
_NUMBER, _VECTOR, _NONNEGATIVE = _numbers(), _numbers(3), _numbers(nonnegative=True)
_NAME = _that(is_name, "one short line of printable text")
_TRUTH = _that(lambda value: isinstance(value, bool), "true or false")
_TABLES = _that(
    lambda tables: isinstance(tables, list) and all(isinstance(table, dict) for table in tables), "tables"
)
_ROTATION = _that(is_rotation, "a rotation: three orthonormal rows, right-handed", _numbers(3, 3))
_DIRECTION = _that(lambda axis: abs(math.hypot(*axis) - 1) <= ORTHONORMAL_TOLERANCE, "a unit vector", _VECTOR)
_POSITIVE = _that(lambda value: value > 0, "a number above 0", _NUMBER)
_ABOUT = _one_of("com", "origin")
_NOT_TURNED = np.eye(3).tolist()

FILE = {
    "format": Key(_one_of(FORMAT)),
    "name": Key(_NAME),
    "title": Key(_NAME, ""),
    "convention": Key(_one_of(*CONVENTIONS, "placement"), "standard"),
    "gravity": Key(_VECTOR, USUAL_GRAVITY, "m/s^2", _XYZ),
    "sources": Key(_sentences, ()),
    "assumptions": Key(_sentences, ()),
    "doubts": Key(_sentences, ()),
    "joints": Key(_TABLES),
    "links": Key(_TABLES),
    "drives": Key(_TABLES, ()),
    "spread": Key(_that(lambda rows: isinstance(rows, list), "rows of numbers"), None),
}
JOINT = {
    "name": Key(_NAME, ""),
    "kind": Key(_one_of("revolute", "prismatic"), "revolute"),
    "range": Key(_ends, (-math.inf, math.inf), "rad or m", ("lower", "upper")),
    "velocity_limit": Key(_NUMBER, None, "rad/s or m/s"),
    "acceleration_limit": Key(_NUMBER, None, "rad/s^2 or m/s^2"),
}
DH_JOINT = {
    "theta": Key(_NUMBER, 0.0, "rad"),
    "d": Key(_NUMBER, 0.0, "m"),
    "a": Key(_NUMBER, 0.0, "m"),
    "alpha": Key(_NUMBER, 0.0, "rad"),
}
PLACED_JOINT = {
    "xyz": Key(_VECTOR, (0.0, 0.0, 0.0), "m", _XYZ),
    "rpy": Key(_VECTOR, None, "rad", _XYZ),
    "rotation": Key(_ROTATION, _NOT_TURNED),
    "axis": Key(_DIRECTION, (0.0, 0.0, 1.0)),
}
LINK = {
    "name": Key(_NAME, ""),
    "mass": Key(_NONNEGATIVE, unit="kg"),
    "com": Key(_VECTOR, unit="m", components=_XYZ),
    "inertia": Key(_tensor(), unit="kg m^2", components=_TENSOR),
    "inertia_about": Key(_ABOUT, "com"),
    "as_measured": Key(_TRUTH, False),
    "axial_only": Key(_TRUTH, False),
    "mass_uncertainty": Key(_NONNEGATIVE, None, "kg"),
    "com_uncertainty": Key(_numbers(3, nonnegative=True), None, "m", _XYZ),
    "inertia_uncertainty": Key(_tensor(nonnegative=True), None, "kg m^2", _TENSOR),
    "inertia_uncertainty_about": Key(_ABOUT, None),
}
# Numbers of a link without the payload that is merged into it.
LINK["without_payload"] = Key(_table_of({key: LINK[key] for key in ("mass", "com", "inertia")}), None)
PLACED_LINK = {
    "frame_xyz": Key(_VECTOR, (0.0, 0.0, 0.0), "m", _XYZ),
    "frame_rpy": Key(_VECTOR, None, "rad", _XYZ),
    "frame_rotation": Key(_ROTATION, _NOT_TURNED),
}
DRIVE = {
    "inertia": Key(_NONNEGATIVE, 0.0, "kg m^2 or kg"),
    "inertia_uncertainty": Key(_NONNEGATIVE, None, "kg m^2 or kg"),
    "gear_ratio": Key(_NUMBER, 1.0),
    "viscous": Key(_NONNEGATIVE, 0.0, "N m s"),
    "coulomb": Key(_numbers(2), (0.0, 0.0), "N m", ("positive", "negative")),
    "torque_limit": Key(_POSITIVE, None, "N m or N"),
}


def keys_of(convention: str) -> dict[str, dict[str, Key]]:
    """Keys of the tables of joints, links and drives in a description of this convention."""
    if convention in CONVENTIONS:
        return {"joints": JOINT | DH_JOINT, "links": LINK, "drives": DRIVE}
    return {"joints": JOINT | PLACED_JOINT, "links": LINK | PLACED_LINK, "drives": DRIVE}


def read_arm(path: str | Path) -> RobotArm:
    """Read an arm from a TOML file; warns of implausible numbers; an ArmError names the faulty line."""
    path = Path(path)
    content = text_of_arm_file(path)
    place = Place(TableLines(path, content))
    arm = _arm(parsed_toml(path, content, "arm file"), place)
    if re.fullmatch(r"[A-Za-z0-9][\w.-]*", arm.name, re.ASCII) is None:
        raise place.at("name").error("is not a word", None, in_python(arm.name))
    warn_of_implausible(arm)
    return arm


def arm_in(description: dict[str, Any]) -> RobotArm:
    """The arm of a description in memory, which has the keys of arm files; else ArmError, with the key."""
    return _arm(description, Place(None, ("arm",)))


def read_drives(path: str | Path) -> tuple[Drive, ...]:
    """Drives of a TOML file with only a [[drives]] table per joint; ArmError as for an arm."""
    content = text_of_arm_file(Path(path))
    place = Place(TableLines(Path(path), content))
    file = _values(parsed_toml(Path(path), content, "file of drives"), {"drives": FILE["drives"]}, place)
    rows = (_values(table, DRIVE, place.at("drives", i)) for i, table in enumerate(file["drives"]))
    return tuple(Drive(**row) for row in rows)


def text_of_arm_file(path: Path) -> str:
    """Text of an arm file; ArmError if it cannot be read, is not text, or is too long."""
    return read_text(path, "arm file", _LARGEST_FILE_BYTES)


def _values(table: Mapping[str, Any], keys: Mapping[str, Key], place: Place) -> dict[str, Any]:
    """Values of a table by key, in SI units."""
    kind = "prismatic" if table.get("kind") == "prismatic" else "revolute"
    suffixes = {key: entry.suffix(kind) for key, entry in keys.items()}
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
    for prefix in ("", "frame_"):
        if f"{prefix}rpy" in values and f"{prefix}rotation" in values:
            raise place.at(f"{prefix}rpy").error("and rotation are both given", "one of the two")
    for key, entry in keys.items():
        if values.setdefault(key, entry.default) is REQUIRED:
            raise place.at(key).error("is missing", f"the key {key}")
    return values


def _likely(word: str, keys: Iterable[str]) -> str:
    """Key most similar to a misspelt one; its unit suffix is kept unless it is the fault."""
    suffix = next((suffix for suffix in UNIT_SUFFIXES if word.endswith(suffix)), "")
    bare = word.removesuffix(suffix)
    near = difflib.get_close_matches(bare, list(keys), n=1)
    return "" if not near else bare if near[0] == bare else near[0] + suffix


def _arm(description: dict[str, Any], place: Place) -> RobotArm:
    file = _values(description, FILE, place)
    convention, keys = file["convention"], keys_of(file["convention"])
    n, given = len(file["joints"]), {part: file.pop(part) for part in keys}
    for part, count in ((part, len(tables)) for part, tables in given.items()):
        if (count != n and (count or part == "links")) or not n:
            where, expected = place.at(part, max(0, count - 1)).where, f"{n or 'some'} [[{part}]] tables"
            problem = f"the arm file needs one [[{part}]] table per joint"
            raise ArmError(problem, where=where, expected=expected, found=str(count))
    joints, links, drives = (
        [_values(table, keys[part], place.at(part, i)) for i, table in enumerate(tables)]
        for part, tables in given.items()
    )
    made_joints, made_links, rows = [], [], []
    for i, (joint, link) in enumerate(zip(joints, links, strict=True)):
        for part, values in (("joints", joint), ("links", link)):
            values |= {"name": values["name"] or str(i + 1), "source": place.at(part, i).line}
        if convention in CONVENTIONS:
            rows.append(DHRow(**{key: joint.pop(key) for key in DH_JOINT}))
            before, behind = CONVENTIONS[convention](joint["kind"], rows[-1])
        else:
            before, behind = _placement(joint, ""), _placement(link, "frame_")
        lower, upper = map(float, joint.pop("range"))
        made_joints.append(Joint(**joint, placement=before, lower=lower, upper=upper))
        made_links.append(_link(link, behind))
    if file["spread"] is not None:
        spread = [_numbers(11 * n)(row, place.at("spread", k)) for k, row in enumerate(file["spread"])]
        file["spread"] = np.array(spread).reshape(-1, n, 11)
    file["title"] = file["title"] or file["name"]
    gravity = file.pop("gravity")
    del file["format"]
    return RobotArm(
        **file,
        gravity_vector=gravity,
        joints=tuple(made_joints),
        links=tuple(made_links),
        drives=tuple(Drive(**drive) for drive in drives),
        dh_table=tuple(rows),
    )


def _placement(values: dict[str, Any], prefix: str) -> Placement:
    """The placement that values state, which is taken from among them."""
    xyz, rpy, rotation = (values.pop(f"{prefix}{key}") for key in ("xyz", "rpy", "rotation"))
    return Placement(rotation if rpy is None else roll_pitch_yaw(*rpy), xyz)


def _link(values: dict[str, Any], behind: Placement) -> Link:
    inertia, about, bare = (values.pop(key) for key in ("inertia", "inertia_about", "without_payload"))
    if about == "origin":
        inertia = inertia - of_point_mass(values["mass"], values["com"])
    stated_about = values.pop("inertia_uncertainty_about") or about
    stated = {key: values.pop(f"{key}_uncertainty") for key in ("mass", "com", "inertia")}
    if any(value is not None for value in stated.values()):
        values["uncertainty"] = LinkUncertainty(**stated, inertia_about=stated_about)
    link = Link(**values, inertia_com=inertia, frame=behind)
    if bare is None:
        return link
    return replace(link, bare=replace(link, mass=bare["mass"], com=bare["com"], inertia_com=bare["inertia"]))
