"""Write an arm as a TOML file that reads back as the same arm, number by number.

An arm given by a Denavit-Hartenberg table keeps it; any other is written with placements.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import OutputError, require_type
from gd_analyze.files import path_of, write_text
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import PRODUCTS, REQUIRED, Key, keys_of
from gd_analyze.robots.description import are_same, describe
from gd_analyze.robots.frames import angles_of, roll_pitch_yaw
from gd_analyze.robots.text_file import UNIT_SUFFIXES
from gd_analyze.text import visible

# Most decimals of an angle in degrees as a person would write it.
_MOST_DECIMALS = 6
_DEGREE = UNIT_SUFFIXES["_deg"]
# A range without ends.
_NO_ENDS = (-math.inf, math.inf)


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
    """TOML from which `read_arm` makes the same arm, to the last bit of every number."""
    description = describe(arm)
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", arm.name)
    description["name"] = name if re.match(r"[A-Za-z0-9]", name) else f"arm{name}"
    if description["title"] == description["name"]:
        del description["title"]
    blocks = [
        f"[[{part}]]\n{_lines(_entries(table, keys))}"
        for part, keys in keys_of(description["convention"]).items()
        for table in description.pop(part)
    ]
    head = _lines((key, value) for key, value in description.items() if len(value))
    comment = "# Numbers are in SI units and radians unless a key says otherwise."
    return "\n\n".join([f"{comment}\n{head}", *blocks]) + "\n"


def _entries(table: Mapping[str, Any], keys: Mapping[str, Key]) -> Iterator[tuple[str, Any]]:
    """Values other than defaults; angles, and in degrees, where that is short and exact."""
    for key, value in table.items():
        if key == "range":
            value = [unknown if end is None else end for end, unknown in zip(value, _NO_ENDS, strict=True)]
        default = keys[key].default
        if default is not REQUIRED and _value(value) == _value(default):
            continue
        if key.endswith("rotation") and (angles := _angles(np.array(value))):
            key, value = key.replace("rotation", "rpy"), angles
        is_angle = keys[key].suffix(table.get("kind", "")) == "_deg"
        if is_angle and (degrees := _in_degrees(np.ravel(value).tolist())):
            key, value = f"{key}_deg", degrees[0] if isinstance(value, float) else degrees
        yield key, value


def _lines(entries: Iterable[tuple[str, Any]]) -> str:
    return "\n".join(f"{key} = {_value(value)}" for key, value in entries)


def _value(value: Any) -> str:
    """A value as TOML: numbers in the fewest exact digits; TOML shares JSON's escapes."""
    if value is None or isinstance(value, str | bool):
        return json.dumps(value, ensure_ascii=False)
    if isinstance(value, float):
        return repr(float(value))
    if isinstance(value, dict):
        entries = [(key, _value(inner)) for key, inner in value.items()]
        stated = [f"{key} = {text}" for key, text in entries if text != "0.0" or key not in PRODUCTS]
        return f"{{ {', '.join(stated)} }}"
    has_texts = any(isinstance(inner, str | list) for inner in value)
    listed = (",\n    " if has_texts else ", ").join(map(_value, value))
    return f"[\n    {listed},\n]" if has_texts else f"[{listed}]"


def _rounded(angles: list[float]) -> Iterator[list[float]]:
    """Angles in degrees, with more and more decimals."""
    return ([round(math.degrees(x), decimals) for x in angles] for decimals in range(_MOST_DECIMALS + 1))


def _in_degrees(angles: list[float]) -> list[float] | None:
    """The same angles, to the last bit, in degrees with few digits; None if there are none."""
    return next((degrees for degrees in _rounded(angles) if [x * _DEGREE for x in degrees] == angles), None)


def _angles(rotation: FloatArray) -> list[float] | None:
    """The shortest angles that reproduce a rotation bit by bit; None if there are none."""
    angles = list(angles_of(rotation))
    short = ([x * _DEGREE + 0.0 for x in degrees] for degrees in _rounded(angles))
    return next((rpy for rpy in (*short, angles) if are_same(roll_pitch_yaw(*rpy), rotation)), None)
