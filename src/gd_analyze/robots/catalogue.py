"""Arms by name (shipped with the package), by path (the user's own), or from a `pinocchio.Model`."""

from __future__ import annotations

import difflib
from collections.abc import Collection, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from gd_analyze.arrays import members
from gd_analyze.errors import ArmError, Location, UsageError, argument
from gd_analyze.files import shipped
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import read_arm, read_drives
from gd_analyze.robots.limits import GivenLimits, locks_of, with_limits
from gd_analyze.robots.other_formats import other_format
from gd_analyze.robots.parts import Drive
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.text import LARGEST, in_python
from gd_analyze.units import Quantity

if TYPE_CHECKING:
    import pinocchio

# Suffixes of logs and set points, which no robot file has, and of robot files in XML.
OF_LOGS = frozenset((".csv", ".tsv", ".db3", ".mcap", ".bag", ".parquet"))
_OF_YAML = (".yaml", ".yml")
# What files hold that are not the robot's, by their suffix.
_USUAL_CONTENT = {
    ".json": "models",
    **dict.fromkeys(OF_LOGS, "logs and set points"),
    **dict.fromkeys(_OF_YAML, "limits"),
}
_OF_XML = (".urdf", ".xml", ".mjcf", ".xacro", ".sdf")


def builtin_arms() -> dict[str, Path]:
    """Shipped arm files by name, in alphabetical order."""
    return shipped("robots", ".toml")


def arm_of(source: RobotArm | str | Path) -> RobotArm:
    """An arm itself, or the one given by a built-in name or a path; raises as `load_arm`."""
    return source if isinstance(source, RobotArm) else load_arm(source)


def arm_with_masses(source: RobotArm | str | Path) -> RobotArm:
    """As `arm_of`; ArmError if no link of the arm has mass or inertia, so that D, h and c are zero."""
    arm = arm_of(source)
    if not any(link.mass or link.inertia_com.any() for link in arm.links):
        message = f"no link of arm {arm.name} has mass or inertia, so that all torques would be 0"
        hint = "`gd-analyze identify ROBOT LOG` finds them from a log with measured torques"
        raise ArmError(message, where=arm.links[0].place, expected="links with mass", next_step=hint)
    return arm


def load_arm(
    name_or_path: str | Path | pinocchio.Model,
    *,
    tip: str | None = None,
    base: str | None = None,
    lock: Mapping[str, float] | Sequence[str] = (),
    limits: GivenLimits = None,
    gravity: Sequence[float] | str | None = None,
    drive_inertia: Sequence[float] | str | None = None,
) -> RobotArm:
    """Load a built-in arm by name, or an arm from a TOML, URDF or MJCF file or a `pinocchio.Model`.

    Parameters
    ----------
    name_or_path
        A name listed by `builtin_arms`, the path of a file, or a model in memory.
    tip, base
        For URDF, MJCF and models: last and first link of the arm. Joints that are not between them are held.
    lock
        Joints held at a value, rad or m: a mapping, or texts such as "elbow=90deg" and "slide=20mm". All
        other held joints are held at 0.
    limits
        Acceleration limits, which URDF and MJCF lack: a mapping by joint, texts such as "elbow=10",
        "all=600deg" or "10,10,20", or a file such as MoveIt's joint_limits.yaml, which may also state ranges
        and velocity limits.
    gravity
        g in the base frame, m/s^2, in place of the file's: three numbers, or their text "0,0,-1.62".
    drive_inertia
        Inertia of the drives at the joints, kg m^2 (kg), in place of the file's: a number per joint, or text;
        or a TOML file of [[drives]] tables as in arm files, friction and torque limits included.

    Returns
    -------
    RobotArm
        The arm.

    Raises
    ------
    ArmError
        If there is no such arm or file, or the file does not describe a valid arm.
    UsageError
        If `lock`, `limits`, `gravity` or `drive_inertia` cannot be read.

    Warns
    -----
    GdAnalyzeWarning
        If numbers in the file are implausible.

    Examples
    --------
    >>> load_arm("puma560").n_joints
    6
    """
    locked = locks_of(lock)
    of_pinocchio = type(name_or_path).__module__.partition(".")[0] == "pinocchio"
    is_model = of_pinocchio and hasattr(name_or_path, "jointPlacements")
    path = None if is_model else _path_of(name_or_path)
    if path is None or is_xml(path):
        from gd_analyze.robots.pinocchio_arm import arm_of_robot  # Pinocchio takes 0.2 s

        robot = arm_of_robot(name_or_path if path is None else path, tip, base, locked)
        arm = _supplemented(with_limits(robot, limits), gravity, drive_inertia)
        warn_of_implausible(arm)
        return arm
    if tip is not None or base is not None or locked:
        message = f"arm {name_or_path} is a single chain with all joints moving: there is nothing to choose"
        raise ArmError(message, where="`tip`, `base`, `lock`", next_step="leave them out")
    return _supplemented(with_limits(read_arm(path), limits), gravity, drive_inertia)


def _supplemented(
    arm: RobotArm, gravity: Sequence[float] | str | None, drive_inertia: Sequence[float] | str | None
) -> RobotArm:
    """The arm with its gravity and drive inertia replaced."""
    if gravity is not None:
        hint = "give its direction, too: 0,0,-9.81"
        arm = replace(arm, gravity_vector=np.array(_numbers(gravity, 3, "gravity", "m/s^2", hint)))
    if isinstance(drive_inertia, str) and drive_inertia.endswith(".toml"):
        arm = replace(arm, drives=read_drives(drive_inertia))
    elif drive_inertia is not None:
        hint = f"give one for each of {', '.join(joint.name for joint in arm.joints)}; 0 where there is none"
        unit = "kg m^2 (kg), a number per joint"
        stated = _numbers(drive_inertia, arm.n_joints, "drive_inertia", unit, hint)
        drives = zip(arm.drives or (Drive(),) * arm.n_joints, stated, strict=True)
        arm = replace(arm, drives=tuple(replace(drive, inertia=value) for drive, value in drives))
    return arm


def _numbers(numbers: Sequence[float] | str, count: int, where: str, unit: str, hint: str) -> list[float]:
    """Numbers given as such or as text; UsageError unless there are `count`."""
    words = numbers.split(",") if isinstance(numbers, str) else members(numbers)
    values = [Quantity.si_of(word) for word in words]
    valid = [value for value in values if value is not None and abs(value) <= LARGEST]
    if len(valid) == len(values) == count:
        return valid
    message, expected = "the numbers are not as expected", f"{count} numbers with commas, {unit}"
    raise UsageError(message, where=where, expected=expected, found=in_python(numbers), next_step=hint)


def is_xml(path: Path) -> bool:
    """Whether a file is XML, by its suffix or its first character."""
    if path.suffix.lower() in _OF_XML:
        return True
    try:
        with path.open("rb") as file:
            start = file.read(512)
    except OSError:
        return False
    return start.removeprefix(b"\xef\xbb\xbf").lstrip().startswith(b"<")


def arguments_to_hold(arm: RobotArm, joints: Collection[int]) -> str:
    """Arguments that hold some joints, from 0, at 0: `tip` if they are the outermost; "" if none does.

    Only of URDF and MJCF a part can be selected.
    """
    source = arm.joints[0].source
    if source is None or not is_xml(Path(source.path)):
        return ""
    first = min(joints)
    if len(joints) == arm.n_joints - first and first > 0:
        return argument("tip", arm.links[first - 1].name)
    locks = [f"{arm.joints[joint].name}=0" for joint in sorted(joints)]
    return argument("lock", locks if len(locks) > 1 else locks[0])


def _path_of(name_or_path: object) -> Path:
    if not isinstance(name_or_path, str | PathLike):
        expected = "the name of a built-in one, the path of an arm's file, or a pinocchio.Model"
        value_text = in_python(name_or_path)
        raise ArmError("this is not an arm", where="arm", expected=expected, found=value_text)
    builtin = builtin_arms()
    name = str(name_or_path)
    if name in builtin:
        return builtin[name]
    path = Path(name_or_path)
    with suppress(OSError):  # a name too long for the file system is not a file
        suffix, is_folder = path.suffix.lower(), bool(name) and path.is_dir()
        usual_content, other = _USUAL_CONTENT.get(suffix, ""), other_format(suffix)
        if path.is_file() and other is not None:
            found, hint = other
            raise ArmError(
                "robots of this format are not read",
                where=Location(path),
                found=found,
                expected="URDF, MJCF or TOML",
                next_step=hint,
            )
        if path.is_file() and not usual_content:
            return path
        if name and path.exists():
            file_text, hint = f"a {suffix} file, as {usual_content} are", "name the robot's own file first"
            if suffix in _OF_YAML:
                hint = "name its URDF or MJCF; or write its Denavit-Hartenberg table and masses as TOML, as"
                hint += " `gd-analyze arms puma560 --to toml` prints them"
            if not path.is_file():
                file_text, hint = "a pipe or a device", "write it into a file first, and name that"
            if is_folder:
                file_text, hint = "a folder", "name the file in it"
            raise ArmError("this is not a robot file", where=Location(path), found=file_text, next_step=hint)
    near = difflib.get_close_matches(name, builtin, n=1)
    hint = f"did you mean {near[0]!r}?" if near else "`gd-analyze arms` lists the built-in arms"
    expected = f"a built-in arm ({', '.join(builtin)}) or the path of an arm's TOML, URDF or MJCF file"
    raise ArmError(f"there is no arm {name!r}", expected=expected, next_step=hint)
