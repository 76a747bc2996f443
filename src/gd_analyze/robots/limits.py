"""Joint values with units, limits added to an arm by the user, and finite limits for a box of states."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from os import PathLike
from pathlib import Path
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray, members
from gd_analyze.errors import ArmError, Location, UsageError, argument, warn_caller
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.text_file import parsed_toml, read_text
from gd_analyze.text import LARGEST, in_python, visible
from gd_analyze.units import MOST_ACCELERATION_WITHOUT_UNIT, UNITS, Quantity, joint_units

# Limits as a user gives them.
GivenLimits = Mapping[str, float] | Sequence[str] | str | Path | None

# MoveIt writes 0.2 kB per joint.
_LARGEST_FILE_BYTES = 200_000
# MoveIt's keys: the arm's name of each limit, and the key that enables it.
_KEYS = {
    "max_acceleration": ("acceleration_limit", "has_acceleration_limits"),
    "max_velocity": ("velocity_limit", "has_velocity_limits"),
    "min_position": ("lower", "has_position_limits"),
    "max_position": ("upper", "has_position_limits"),
}
# Limits of a box if an arm states none: half a turn or half a metre each way, per s and per s^2.
_ORDINARY = (
    ("a range of +-", {"revolute": np.pi, "prismatic": 0.5}, ""),
    ("a velocity of ", {"revolute": 2.0, "prismatic": 2.0}, "/s"),
    ("an acceleration of ", {"revolute": 5.0, "prismatic": 5.0}, "/s^2"),
)


def locks_of(locks: Mapping[str, float] | Sequence[str] | None) -> dict[str, Quantity]:
    """Values of joints to lock, from a mapping or texts such as elbow=90deg; or UsageError."""
    texts = [] if locks is None else [locks] if isinstance(locks, str) else members(locks)
    pairs = locks.items() if isinstance(locks, Mapping) else map(_pair, texts)
    values: dict[str, Quantity] = {}
    for joint, value in pairs:
        number = Quantity.read(value)
        if not joint or number is None or number.kind not in ("", "angle", "length"):
            expected = "joint=value in rad or m, or with a unit: elbow=1.57, elbow=90deg, slide=20mm"
            pair_text = f"{joint}={value}" if joint else str(value)
            hint = "name the joint and the value it is held at"
            message = "no joint with a value"
            raise UsageError(message, where="lock", expected=expected, found=pair_text, next_step=hint)
        if joint in values:
            raise UsageError(f"joint {joint} is locked twice", where="lock", next_step="give one value")
        values[joint] = number
    return values


def _pair(text: object) -> tuple[str, str]:
    name, _, value = str(text).rpartition("=")
    return name.strip(), value


def with_limits(arm: RobotArm, limits: GivenLimits) -> RobotArm:
    """Add acceleration limits: by joint, as texts ("joint=value", "all=value", all values), or from a file.

    Raises UsageError for any other word, and ArmError for a file.
    """
    if limits is None or (isinstance(limits, str) and not limits):
        return arm
    for word in [limits] if isinstance(limits, str | Path | Mapping) else members(limits):
        if isinstance(word, PathLike) or str(word).lower().endswith((".yaml", ".yml", ".toml")):
            by_joint: dict[str, dict[str, Any]] = _from_file(arm, Path(str(word)))
            note = f"Limits of {', '.join(by_joint)} from {visible(Path(str(word)).name)}."
        else:
            accelerations = _accelerations(arm, word)
            by_joint = {name: {"acceleration_limit": value} for name, value in accelerations.items()}
            stated = ", ".join(f"{name} {value:g}" for name, value in accelerations.items())
            note = f"Acceleration limits as given, per s^2: {stated}."
        joints = tuple(dataclasses.replace(joint, **by_joint.get(joint.name, {})) for joint in arm.joints)
        arm = dataclasses.replace(arm, joints=joints, assumptions=(*arm.assumptions, note))
    return arm


def _accelerations(arm: RobotArm, statement: object) -> dict[str, float]:
    """Acceleration limits by joint, from a mapping or a text."""
    names = [joint.name for joint in arm.joints]
    turns = dict(zip(names, arm.is_revolute, strict=True))
    if isinstance(statement, Mapping):
        stated = dict(statement)
    elif "=" in str(statement):
        stated = dict([_pair(statement)])
    else:
        values = str(statement).split(",")
        stated = dict(zip(names, values, strict=False)) if len(values) == len(names) else {"": statement}
    limits: dict[str, float] = {}
    for name, value in stated.items():
        quantity = Quantity.read(value)
        if quantity is None or not quantity.si > 0 or not name:
            message = "this is not an acceleration limit"
            value_text = f"{name}={value}" if name else in_python(statement)
            expected = f"joint=value, all=value, {len(names)} values with commas, or a .yaml or .toml file"
            hint = "give values above 0, in rad/s^2 or m/s^2, or with a unit: 600deg, 500mm"
            raise UsageError(message, where="limits", expected=expected, found=value_text, next_step=hint)
        number = None if name == "all" else arm.joint_number(str(name))
        if name != "all" and number is None:
            message, hint = f"there is no joint {name!r} to limit", "name one of them, or all"
            expected = f"a joint of arm {arm.name} by name or number, or all: {', '.join(names)}"
            raise UsageError(message, where="limits", expected=expected, next_step=hint)
        for joint in names if number is None else [names[number]]:
            limit = quantity.of_joint(turns[joint], MOST_ACCELERATION_WITHOUT_UNIT)
            if limit is None:
                kind, unit = ("turns", "deg") if turns[joint] else ("slides", "mm")
                message = f"this is no acceleration of joint {joint}, which {kind}"
                expected, hint = (
                    joint_units(turns[joint], "/s^2"),
                    f"{argument('limits', f'{joint}=600{unit}')} states the unit",
                )
                fault = f"{name}={value}"
                raise UsageError(message, where="limits", expected=expected, found=fault, next_step=hint)
            limits[joint] = limit
    return limits


def _from_file(arm: RobotArm, path: Path) -> dict[str, dict[str, float]]:
    """Limits of the arm's joints in a file, which may hold other joints, too."""
    kind = "file of limits"
    text = read_text(path, kind, _LARGEST_FILE_BYTES)
    is_toml = path.suffix.lower() == ".toml"
    table = _joint_limits(parsed_toml(path, text, kind) if is_toml else parsed_yaml(path, text, kind))
    names = [joint.name for joint in arm.joints]
    by_joint = {name: _limits(name, (table or {}).get(name), path) for name in names}
    by_joint = {name: limits for name, limits in by_joint.items() if limits}
    if by_joint:
        return by_joint
    listed = "no table joint_limits" if table is None else ", ".join(str(name) for name in list(table)[:12])
    message = f"the file limits no joint of arm {arm.name}"
    expected = f"a table joint_limits, as in MoveIt's joint_limits.yaml, of {', '.join(names)}"
    raise ArmError(message, where=Location(path), expected=expected, found=listed or "no joint")


def _limits(name: str, table: object, path: Path) -> dict[str, float]:
    """Limits in a joint's table, under the arm's names."""
    stated = table if isinstance(table, Mapping) else {}
    limits: dict[str, float] = {}
    for key, (limit, switch) in _KEYS.items():
        # MoveIt writes max_acceleration: 0 beside has_acceleration_limits: false. A range has two ends.
        is_stated = any(end in stated for end, (_, end_switch) in _KEYS.items() if end_switch == switch)
        if not stated.get(switch, is_stated):
            continue
        value = None if isinstance(stated.get(key), str) else Quantity.si_of(stated.get(key))
        if value is None or not abs(value) <= LARGEST or not (value > 0 or "position" in key):
            message, value_text = f"{key} of joint {name} is not a limit", in_python(stated.get(key))
            hint = f"give a number{'' if 'position' in key else ' above 0'}, or set {switch} to false"
            raise ArmError(message, where=Location(path), found=value_text, next_step=hint)
        limits[limit] = value
    return limits


def _joint_limits(document: Any, depth: int = 3) -> Mapping[Any, Any] | None:
    """Table joint_limits, at the top or below a few headings such as robot_description_planning."""
    if not isinstance(document, Mapping):
        return None
    table = document.get("joint_limits")
    if isinstance(table, Mapping):
        return table
    below = (_joint_limits(value, depth - 1) for value in document.values() if depth)
    return next((inner for inner in below if inner is not None), None)


# Most references to other parts of a file of limits.
_MOST_ALIASES = 20


def parsed_yaml(path: Path, text: str, kind: str) -> Any:
    """Parsed YAML, with the tags !degrees and !radians of some robots' limits; ArmError if it is not YAML."""
    import yaml  # 0.02 s at every start

    class Loader(yaml.SafeLoader):  # the C loader crashes on deeply nested lists
        aliases = 0

        def compose_node(self, parent: Any, index: Any) -> Any:
            # Nested in each other, a few lines of aliases fill any memory.
            self.aliases += self.check_event(yaml.AliasEvent)
            if self.aliases > _MOST_ALIASES:
                raise yaml.MarkedYAMLError(problem=f"more than {_MOST_ALIASES} aliases")
            return super().compose_node(parent, index)

        def construct_mapping(self, node: Any, deep: bool = False) -> Any:
            # Of two entries YAML keeps the last, so that the first limit would be lost.
            keys: set[object] = set()
            for key, _ in node.value if isinstance(node, yaml.MappingNode) else ():
                name = (key.tag, str(key.value))
                if name in keys:
                    problem = f"a second key {in_python(key.value)}"
                    raise yaml.MarkedYAMLError(problem=problem, problem_mark=key.start_mark)
                keys.add(name)
            return super().construct_mapping(node, deep)

    def scaled(factor: float) -> Any:
        return lambda loader, node: factor * float(loader.construct_scalar(node))

    Loader.add_constructor("!degrees", scaled(UNITS["angle"]["deg"]))
    Loader.add_constructor("!radians", scaled(1.0))
    try:
        return yaml.load(text, Loader)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        where = Location(path, *((mark.line + 1, mark.column + 1) if mark else ()))
        fault = str(getattr(error, "problem", None) or error)
    except (RecursionError, ValueError):
        where, fault = Location(path), "lists nested too deep, or an invalid number"
    raise ArmError(f"the {kind} is not valid YAML", where=where, found=fault, next_step="fix it there")


@dataclass(frozen=True, eq=False)
class BoxLimits:
    """Finite limits of every joint, shape (n,) each."""

    lower: FloatArray  # rad (m)
    upper: FloatArray
    velocity: FloatArray  # largest magnitude, per s
    acceleration: FloatArray  # per s^2
    remark: str  # limits that the arm does not state, as a suffix to the limits' name, or ""


def box_limits(arm: RobotArm) -> BoxLimits:
    """Limits of an arm; those it does not state are assumed, with a warning."""
    lower, upper = arm.limits("lower"), arm.limits("upper")
    velocity, acceleration = arm.limits("velocity_limit"), arm.limits("acceleration_limit")
    stated = (np.isfinite(lower) & np.isfinite(upper), np.isfinite(velocity), np.isfinite(acceleration))
    assumed = []
    for (text, values, per), is_stated in zip(_ORDINARY, stated, strict=True):
        for kind, unit in (("revolute", "rad"), ("prismatic", "m")):
            joints = zip(arm.joints, is_stated, strict=True)
            names = [joint.name for joint, is_known in joints if joint.kind == kind and not is_known]
            if names:
                subject = "every joint" if len(names) == arm.n_joints else f"joint {', '.join(names)}"
                assumed.append(f"{text}{values[kind]:.4g} {unit}{per} of {subject}")
    if assumed:
        listed = "; ".join(assumed)
        message = f"arm {arm.name} does not state all limits: for a box of states, {listed} is assumed"
        warn_caller(message)
    span, fast, jerky = (np.array([values[joint.kind] for joint in arm.joints]) for _, values, _ in _ORDINARY)
    return BoxLimits(
        np.where(stated[0], lower, -span),
        np.where(stated[0], upper, span),
        np.where(stated[1], velocity, fast),
        np.where(stated[2], acceleration, jerky),
        f" (assumed, as none are stated: {'; '.join(assumed)})" if assumed else "",
    )
