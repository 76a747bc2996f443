"""Limits that a user adds to an arm's, joint values with units, and finite limits for a box of states.

Neither URDF nor MJCF has a place for limits of acceleration. MoveIt keeps them in joint_limits.yaml.
"""

from __future__ import annotations

import dataclasses
import math
import re
import tomllib
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ArmError, GdAnalyzeWarning, Location, UsageError
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.parts import Joint
from gd_analyze.text import LARGEST, in_python, number_in, visible

# Limits as a user gives them.
Given = Mapping[str, float] | Sequence[str] | str | Path | None

# MoveIt writes 0.2 kB per joint.
LARGEST_FILE = 200_000
# MoveIt's keys: what says that a limit holds, and by the keys of its values the arm's names.
_KEYS: tuple[tuple[str, dict[str, str]], ...] = (
    ("has_acceleration_limits", {"max_acceleration": "acceleration_limit"}),
    ("has_velocity_limits", {"max_velocity": "velocity_limit"}),
    ("has_position_limits", {"min_position": "lower", "max_position": "upper"}),
)
_UNITS = {"deg": math.pi / 180, "mm": 1e-3, "rad": 1.0, "m": 1.0}
# Limits of a box where an arm states none: a full turn or half a metre, per s and s^2.
_RANGE = {"revolute": np.pi, "prismatic": 0.5}
_VELOCITY, _ACCELERATION = 2.0, 5.0


def value_in(given: object) -> float | None:
    """SI value of a number, or of a text with or without a unit (90deg, 20mm); None where it is none."""
    if isinstance(given, int | float) and not isinstance(given, bool):
        value: float | None = float(given) if abs(given) <= LARGEST else None
    elif isinstance(given, str):
        text = given.strip()
        unit = next((unit for unit in _UNITS if text.endswith(unit)), "")
        value = number_in(text.removesuffix(unit).rstrip())
        value = None if value is None or abs(value) > LARGEST else value * _UNITS.get(unit, 1.0)
    else:
        value = None
    return value


def locks_of(given: Mapping[str, float] | Sequence[str] | None) -> dict[str, float]:
    """Joints to lock and their values, rad or m, of a mapping or of texts such as elbow=90deg.

    Raises
    ------
    UsageError
        If one is not joint=value, or a joint is given twice.
    """
    pairs = given.items() if isinstance(given, Mapping) else [_pair(text) for text in given or ()]
    values: dict[str, float] = {}
    for joint, value in pairs:
        number = value_in(value)
        if number is None:
            raise _not_a_lock(f"{joint}={value}")
        if joint in values:
            raise UsageError(f"joint {joint} is locked twice", where="--lock", next_step="give one value")
        values[joint] = number
    return values


def _pair(text: object) -> tuple[str, str]:
    name, equals, value = str(text).rpartition("=")
    if not isinstance(text, str) or not equals or not name.strip():
        raise _not_a_lock(in_python(text))
    return name.strip(), value


def _not_a_lock(found: str) -> UsageError:
    expected = "joint=value in rad or m, or with a unit: elbow=1.57, elbow=90deg, slide=20mm"
    return UsageError("this locks no joint", where="--lock", expected=expected, found=found)


def with_limits(arm: RobotArm, given: Given) -> RobotArm:
    """Add limits to an arm's.

    Parameters
    ----------
    arm
        The arm.
    given
        Accelerations by joint, rad/s^2 or m/s^2; or texts, each "joint=value", "all=value", or values of all
        joints in order with commas between; or the path of a YAML or TOML file with `joint_limits`.

    Raises
    ------
    UsageError
        If one of them is none of these, or names an unknown joint.
    ArmError
        If a file cannot be read or holds what is no limit.
    """
    if given is None or not given:
        return arm
    if isinstance(given, Mapping):
        limits = _by_joint(arm, given)
        text = ", ".join(f"{name} {limit['acceleration_limit']:g}" for name, limit in limits.items())
        return _replaced(arm, limits, f"Acceleration limits as given, per s^2: {text}.")
    for word in [given] if isinstance(given, str | Path) else given:
        if isinstance(word, PathLike) or str(word).lower().endswith((".yaml", ".yml", ".toml")):
            found = _from_file(arm, Path(word))
            arm = _replaced(arm, found, f"Limits of {', '.join(found)} from {visible(Path(word).name)}.")
        else:
            note = f"Acceleration limits as given: {visible(str(word))}."
            arm = _replaced(arm, _from_text(arm, word), note)
    return arm


def _replaced(arm: RobotArm, limits: Mapping[str, Mapping[str, Any]], note: str) -> RobotArm:
    joints = tuple(dataclasses.replace(joint, **limits.get(joint.name, {})) for joint in arm.joints)
    return dataclasses.replace(arm, joints=joints, assumptions=(*arm.assumptions, note))


def _not_a_limit(found: str, arm: RobotArm) -> UsageError:
    return UsageError(
        "this is no acceleration limit",
        where="--limits",
        expected=f"joint=value, all=value, {arm.n_joints} values with commas between, or a .yaml or .toml "
        "file; values above 0 in rad/s^2 or m/s^2, or with a unit: 600deg, 500mm",
        found=found,
    )


def _from_text(arm: RobotArm, text: object) -> dict[str, dict[str, float]]:
    if not isinstance(text, str):
        raise _not_a_limit(in_python(text), arm)
    name, equals, value = text.rpartition("=")
    if equals:
        return _by_joint(arm, {name.strip(): value})
    values = text.split(",")
    if len(values) != arm.n_joints:
        raise _not_a_limit(repr(text), arm)
    return _by_joint(arm, dict(zip((joint.name for joint in arm.joints), values, strict=True)))


def _by_joint(arm: RobotArm, given: Mapping[str, object]) -> dict[str, dict[str, float]]:
    known = [joint.name for joint in arm.joints]
    found: dict[str, dict[str, float]] = {}
    for name, value in given.items():
        number = value_in(value)
        if number is None or not number > 0:
            raise _not_a_limit(f"{name}={value}", arm)
        if name != "all" and name not in known:
            expected = f"a joint of arm {arm.name}, or all: {', '.join(known)}"
            raise UsageError(f"there is no joint {name!r} to limit", where="--limits", expected=expected)
        for joint in known if name == "all" else (name,):
            found[joint] = {"acceleration_limit": number}
    return found


def _from_file(arm: RobotArm, path: Path) -> dict[str, dict[str, float]]:
    """Limits of the arm's joints in a file, which may have those of others, too."""
    table = _joint_limits(_document(path))
    if table is None:
        raise ArmError(
            "the file states no limits",
            where=Location(path),
            expected="a table joint_limits with one of each joint, as MoveIt's joint_limits.yaml has",
            next_step="add it: joint_limits: {elbow: {has_acceleration_limits: true, max_acceleration: 10}}",
        )
    found = {
        joint.name: limits
        for joint in arm.joints
        if joint.name in table and (limits := _limits(joint, table[joint.name], path))
    }
    if not found:
        raise ArmError(
            f"the file limits no joint of arm {arm.name}",
            where=Location(path),
            expected=f"limits of {', '.join(joint.name for joint in arm.joints)}",
            found=", ".join(str(name) for name in list(table)[:12]) or "no joint",
            next_step="name the joints as the robot's file does, and set has_acceleration_limits: true",
        )
    return found


def _limits(joint: Joint, table: object, path: Path) -> dict[str, float]:
    """Limits in a joint's table, by the arm's names."""
    stated = table if isinstance(table, Mapping) else {}
    found: dict[str, float] = {}
    for holds, keys in _KEYS:
        # MoveIt writes max_acceleration: 0 beside has_acceleration_limits: false.
        if not stated.get(holds, any(key in stated for key in keys)):
            continue
        for key, name in keys.items():
            value: Any = stated.get(key)
            is_number = isinstance(value, int | float) and not isinstance(value, bool)
            if not is_number or not math.isfinite(value) or not (value > 0 or "position" in key):
                raise ArmError(
                    f"{key} of joint {joint.name} is no limit",
                    where=Location(path),
                    expected="a number" if "position" in key else "a number above 0",
                    found=in_python(value),
                    next_step=f"fix it, or set {holds} to false",
                )
            found[name] = float(value)
    return found


def _joint_limits(document: Any, depth: int = 3) -> Mapping[Any, Any] | None:
    """Table joint_limits, at the top or below a few headings such as robot_description_planning."""
    if not isinstance(document, Mapping):
        return None
    table = document.get("joint_limits")
    if isinstance(table, Mapping):
        return table
    below = (_joint_limits(value, depth - 1) for value in document.values() if depth)
    return next((found for found in below if found is not None), None)


def _document(path: Path) -> Any:
    try:
        content = read_at_most(path, LARGEST_FILE)
        text = None if content is None else content.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        found = error.strerror if isinstance(error, OSError) else "bytes that are no text in UTF-8"
        raise ArmError("cannot read the file of limits", where=Location(path), found=found) from None
    if text is None:
        expected = f"up to {megabytes(LARGEST_FILE)}"
        raise ArmError("the file of limits is too large", where=Location(path), expected=expected)
    try:
        return tomllib.loads(text) if path.suffix.lower() == ".toml" else _yaml(text, path)
    except tomllib.TOMLDecodeError as error:
        raise invalid_toml("the file of limits", path, text, error) from None
    except (RecursionError, ValueError):
        what = "the file of limits nests too deep or holds no numbers"
        raise ArmError(what, where=Location(path)) from None


def invalid_toml(what: str, path: Path, text: str, error: tomllib.TOMLDecodeError) -> ArmError:
    """Refusal of a text that is not TOML, with line and column."""
    place = re.search(r"line (\d+), column (\d+)", str(error))
    line, column = (int(place[1]), int(place[2])) if place else (text.count("\n") + 1, None)
    found = re.sub(r" \(at .*\)$", "", str(error))
    where = Location(path, line, column)
    return ArmError(f"{what} is not valid TOML", where=where, found=found, next_step="fix the syntax there")


def _yaml(text: str, path: Path) -> Any:
    """YAML with the units that some robots' limits have: !degrees and !radians."""
    import yaml

    class Loader(yaml.SafeLoader):  # the one in C crashes where lists nest deep
        pass

    def scaled(factor: float) -> Any:
        return lambda loader, node: float(loader.construct_scalar(node)) * factor

    Loader.add_constructor("!degrees", scaled(math.pi / 180))
    Loader.add_constructor("!radians", scaled(1.0))
    try:
        return yaml.load(text, Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = Location(path, *((mark.line + 1, mark.column + 1) if mark else ()))
        found = str(getattr(error, "problem", None) or error)
        what = "the file of limits is not valid YAML"
        raise ArmError(what, where=where, found=found, next_step="fix the syntax there") from None


@dataclass(frozen=True, eq=False)
class BoxLimits:
    """Finite limits of every joint, shape (n,) each.

    Parameters
    ----------
    lower, upper
        Of the joint variables, rad (m).
    velocity, acceleration
        Largest magnitudes, per s and s^2.
    assumed
        Limits that the arm does not state, in words; "" where it states all.
    """

    lower: FloatArray
    upper: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    assumed: str

    @property
    def remark(self) -> str:
        """What to add where these limits are named."""
        return f" (assumed, as none are stated: {self.assumed})" if self.assumed else ""


def box_limits(arm: RobotArm) -> BoxLimits:
    """Limits of an arm, with ordinary ones in the place of those it does not state.

    Warns
    -----
    GdAnalyzeWarning
        Of limits that are assumed.
    """
    lower, upper = arm.limits("lower"), arm.limits("upper")
    velocity, acceleration = arm.limits("velocity_limit"), arm.limits("acceleration_limit")
    ranges = np.array([_RANGE[joint.kind] for joint in arm.joints])
    unknown = ~(np.isfinite(lower) & np.isfinite(upper))
    assumed = "; ".join(
        [
            *_assumed(arm, unknown, "a range of +-", ranges, ""),
            *_assumed(arm, np.isinf(velocity), "a velocity of ", np.full(arm.n_joints, _VELOCITY), "/s"),
            *_assumed(
                arm,
                np.isinf(acceleration),
                "an acceleration of ",
                np.full(arm.n_joints, _ACCELERATION),
                "/s^2",
            ),
        ]
    )
    if assumed:
        message = f"arm {arm.name} does not state all limits: for a box of states, {assumed} is assumed"
        warnings.warn(message, GdAnalyzeWarning, stacklevel=3)
    return BoxLimits(
        np.where(unknown, -ranges, lower),
        np.where(unknown, ranges, upper),
        np.where(np.isinf(velocity), _VELOCITY, velocity),
        np.where(np.isinf(acceleration), _ACCELERATION, acceleration),
        assumed,
    )


def _assumed(arm: RobotArm, unknown: NDArray[np.bool_], what: str, values: FloatArray, per: str) -> list[str]:
    """Values assumed for joints that state nothing, those of one unit together."""
    found = []
    for unit in ("rad", "m"):
        chosen = [i for i, joint in enumerate(arm.joints) if joint.unit == unit and unknown[i]]
        if chosen:
            names = ", ".join(arm.joints[i].name for i in chosen)
            names = "every joint" if len(chosen) == arm.n_joints else f"joint {names}"
            found.append(f"{what}{values[chosen[0]]:.4g} {unit}{per} of {names}")
    return found
