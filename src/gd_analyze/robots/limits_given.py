"""Limits that a user adds to an arm's: joint=value, a list in the joints' order, or a file such as MoveIt's.

Neither URDF nor MJCF has a place for limits of acceleration. MoveIt keeps them in joint_limits.yaml.
"""

from __future__ import annotations

import dataclasses
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from os import PathLike
from pathlib import Path
from typing import Any

from gd_analyze.errors import ArmError, Location, UsageError
from gd_analyze.files import megabytes, read_at_most
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.joint_values import value_in
from gd_analyze.robots.parts import Joint
from gd_analyze.text import in_python, visible

# MoveIt writes 0.2 kB per joint.
LARGEST_FILE = 200_000
_SUFFIXES = (".yaml", ".yml", ".toml")
_EVERY = "all"
# MoveIt's keys: what says that a limit holds, the keys of its values, and the arm's name of each.
_KEYS = (
    ("has_acceleration_limits", {"max_acceleration": "acceleration_limit"}),
    ("has_velocity_limits", {"max_velocity": "rate_limit"}),
    ("has_position_limits", {"min_position": "lower", "max_position": "upper"}),
)

Given = Mapping[str, float] | Sequence[str] | str | Path | None


def with_limits(arm: RobotArm, given: Given) -> RobotArm:
    """Add limits to an arm's.

    Parameters
    ----------
    arm
        The arm.
    given
        Accelerations by joint, rad/s^2 or m/s^2, or texts, each "joint=value", "all=value", values of all
        joints in order with commas between, or the path of a YAML or TOML file with `joint_limits`.

    Raises
    ------
    UsageError
        If one of them is none of these, or names a joint that the arm has not.
    ArmError
        If a file cannot be read or holds what is no limit.
    """
    if given is None or not given:
        return arm
    told: list[str] = []
    if isinstance(given, Mapping):
        arm = _replaced(arm, _by_joint(arm, dict(given)))
        told.append(_accelerations_told(arm))
    for word in [] if isinstance(given, Mapping) else _words(given):
        if isinstance(word, PathLike) or str(word).lower().endswith(_SUFFIXES):
            path = Path(word)
            found = _from_file(arm, path)
            arm = _replaced(arm, found)
            told.append(f"Limits of {', '.join(found)} from {visible(path.name)}.")
        else:
            arm = _replaced(arm, _from_text(arm, word))
            told.append(f"Limits of acceleration as given: {visible(str(word))}.")
    return dataclasses.replace(arm, assumptions=(*arm.assumptions, *told))


def _words(given: Sequence[str] | str | Path) -> Sequence[str | Path]:
    return [given] if isinstance(given, str | Path) else given


def _accelerations_told(arm: RobotArm) -> str:
    known = [
        f"{joint.name} {joint.acceleration_limit:g} {joint.unit}/s^2"
        for joint in arm.joints
        if joint.acceleration_limit is not None
    ]
    return f"Limits of acceleration as given: {', '.join(known)}."


def _replaced(arm: RobotArm, limits: Mapping[str, Mapping[str, float]]) -> RobotArm:
    joints = []
    for joint in arm.joints:
        changed: dict[str, Any] = dict(limits.get(joint.name, {}))
        joints.append(dataclasses.replace(joint, **changed))
    return dataclasses.replace(arm, joints=tuple(joints))


def _no_limit(found: str, arm: RobotArm) -> UsageError:
    return UsageError(
        "this is no limit of acceleration",
        where="--limits",
        expected=f"joint=value, all=value, {arm.n_joints} values with commas between, or a .yaml or .toml "
        "file; values above 0 in rad/s^2 or m/s^2, or with a unit: 600deg, 500mm",
        found=found,
    )


def _from_text(arm: RobotArm, text: object) -> dict[str, dict[str, float]]:
    if not isinstance(text, str):
        raise _no_limit(in_python(text), arm)
    name, equals, value = text.rpartition("=")
    if equals:
        return _by_joint(arm, {name.strip(): value})
    values = text.split(",")
    if len(values) != arm.n_joints:
        raise _no_limit(f"{len(values)} values in {text!r}" if len(values) > 1 else repr(text), arm)
    return _by_joint(arm, dict(zip((joint.name for joint in arm.joints), values, strict=True)))


def _by_joint(arm: RobotArm, given: Mapping[str, object]) -> dict[str, dict[str, float]]:
    known = {joint.name for joint in arm.joints}
    found: dict[str, dict[str, float]] = {}
    for name, value in given.items():
        number = value_in(value)
        if number is None or not number > 0:
            raise _no_limit(f"{name}={value}", arm)
        if name != _EVERY and name not in known:
            raise UsageError(
                f"there is no joint {name!r} to limit",
                where="--limits",
                expected=f"a joint of arm {arm.name}, or {_EVERY}",
                found=", ".join(joint.name for joint in arm.joints),
                next_step="take one of these names",
            )
        for joint in known if name == _EVERY else (name,):
            found.setdefault(joint, {})["acceleration_limit"] = number
    return found


def _from_file(arm: RobotArm, path: Path) -> dict[str, dict[str, float]]:
    """Limits of the arm's joints that a file has; it may have those of others, too."""
    table = _joint_limits(_document(path))
    if table is None:
        raise ArmError(
            "the file states no limits",
            where=Location(path),
            expected="a table joint_limits with one of each joint, as MoveIt's joint_limits.yaml has",
            next_step="add it: joint_limits: {elbow: {has_acceleration_limits: true, max_acceleration: 10}}",
        )
    found = {
        joint.name: _limits(joint, table[joint.name], path) for joint in arm.joints if joint.name in table
    }
    found = {name: limits for name, limits in found.items() if limits}
    if not found:
        raise ArmError(
            f"the file limits no joint of arm {arm.name}",
            where=Location(path),
            expected=f"limits of {', '.join(joint.name for joint in arm.joints)}",
            found=", ".join(str(name) for name in list(table)[:12]) or "no joint",
            next_step="name the joints as the robot's file does, and set has_acceleration_limits where "
            "max_acceleration holds",
        )
    return found


def _limits(joint: Joint, table: object, path: Path) -> dict[str, float]:
    """What a joint's table states, by the arm's names."""
    found: dict[str, float] = {}
    for holds, keys in _KEYS:
        stated = table if isinstance(table, Mapping) else {}
        # MoveIt writes max_acceleration: 0 beside has_acceleration_limits: false.
        if not stated.get(holds, any(key in stated for key in keys)):
            continue
        for key, name in keys.items():
            value = stated.get(key)
            if not isinstance(value, int | float) or isinstance(value, bool) or not math.isfinite(value):
                raise ArmError(
                    f"{key} of joint {joint.name} is no limit",
                    where=Location(path),
                    expected=f"a number, as {holds} says",
                    found=in_python(value),
                    next_step=f"state it, or set {holds} to false",
                )
            if "position" not in key and not value > 0:
                raise ArmError(
                    f"{key} of joint {joint.name} is not positive",
                    where=Location(path),
                    expected="a number above 0",
                    found=f"{value:g}",
                    next_step=f"mend it, or set {holds} to false",
                )
            found[name] = float(value)
    return found


def _document(path: Path) -> Any:
    try:
        content = read_at_most(path, LARGEST_FILE)
        text = None if content is None else content.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        found = error.strerror if isinstance(error, OSError) else "bytes that are no text in UTF-8"
        raise ArmError("cannot read the file of limits", where=Location(path), found=found) from None
    if text is None:
        most = megabytes(LARGEST_FILE)
        raise ArmError("the file of limits is too large", where=Location(path), expected=f"up to {most}")
    try:
        return tomllib.loads(text) if path.suffix.lower() == ".toml" else _yaml(text, path)
    except tomllib.TOMLDecodeError as error:
        place = re.search(r"line (\d+), column (\d+)", str(error))
        line, column = (int(place[1]), int(place[2])) if place else (None, None)
        raise ArmError(
            "the file of limits is not valid TOML",
            where=Location(path, line, column),
            found=str(error),
            next_step="mend the syntax there",
        ) from None
    except (RecursionError, ValueError):
        raise ArmError(
            "the file of limits nests too deep or holds no numbers", where=Location(path)
        ) from None


def _yaml(text: str, path: Path) -> Any:
    """Read YAML with the units that some robots' limits have: !degrees and !radians."""
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
        raise ArmError(
            "the file of limits is not valid YAML",
            where=Location(path, *((mark.line + 1, mark.column + 1) if mark else ())),
            found=str(getattr(error, "problem", None) or error),
            next_step="mend the syntax there",
        ) from None


def _joint_limits(document: Any, depth: int = 3) -> Mapping[Any, Any] | None:
    """Table of joint_limits, at the top or below a few headings such as robot_description_planning."""
    if not isinstance(document, Mapping):
        return None
    table = document.get("joint_limits")
    if isinstance(table, Mapping):
        return table
    below = (_joint_limits(value, depth - 1) for value in document.values() if depth)
    return next((found for found in below if found is not None), None)
