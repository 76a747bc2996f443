"""Arms by name (shipped with the package) or by path (the user's own)."""

from __future__ import annotations

import difflib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING

from gd_analyze.errors import ArmError, Location
from gd_analyze.files import shipped
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.robots.chain import Pick
from gd_analyze.robots.limits import Given, locks_of, with_limits
from gd_analyze.robots.plausibility import warn_of_implausible
from gd_analyze.robots.reduced import arm_of_tree
from gd_analyze.robots.robot_file import is_pinocchio_model, is_xml, read_tree, tree_of_model
from gd_analyze.text import in_python

if TYPE_CHECKING:
    import pinocchio

# Suffixes of logs and set points, which no robot's file has.
_OF_LOGS = frozenset((".csv", ".tsv", ".db3", ".mcap", ".bag", ".parquet"))


def builtin_arms() -> dict[str, Path]:
    """Shipped arm files by name, in alphabetical order."""
    return shipped("robots", ".toml")


def arm_of(given: RobotArm | str | Path) -> RobotArm:
    """Take an arm, or load the one that a built-in name or a path stands for.

    Raises
    ------
    ArmError
        As `load_arm`.
    """
    return given if isinstance(given, RobotArm) else load_arm(given)


def load_arm(
    name_or_path: str | Path | pinocchio.Model,
    *,
    tip: str | None = None,
    base: str | None = None,
    lock: Mapping[str, float] | Sequence[str] = (),
    limits: Given = None,
) -> RobotArm:
    """Load a built-in arm by name, any arm by its TOML, URDF or MJCF file, or that of a `pinocchio.Model`.

    Parameters
    ----------
    name_or_path
        A name that `builtin_arms` lists, the path of a file, or a model in memory.
    tip, base
        Of URDF, MJCF and models: the links that the arm ends and begins with. Joints that are not between
        them are held.
    lock
        Joints held at a value, rad or m: a mapping, or texts such as "elbow=90deg" and "slide=20mm". All
        other held joints are held at 0.
    limits
        Limits of acceleration, which URDF and MJCF do not have: a mapping by joint, texts such as
        "elbow=10", "all=600deg" or "10,10,20", or a file such as MoveIt's joint_limits.yaml, which may state
        ranges and rates as well.

    Returns
    -------
    RobotArm
        The arm.

    Raises
    ------
    ArmError
        If there is neither such an arm nor such a file, or the file is not a possible arm.
    UsageError
        If `lock` or `limits` cannot be read.

    Warns
    -----
    GdAnalyzeWarning
        Of what looks like a slip in the file.

    Examples
    --------
    >>> load_arm("puma560").n_joints
    6
    """
    pick = Pick(tip, base, locks_of(lock))
    if is_pinocchio_model(name_or_path):
        return _checked(arm_of_tree(tree_of_model(name_or_path), pick), limits)
    path = _path_of(name_or_path)
    if is_xml(path):
        return _checked(arm_of_tree(read_tree(path), pick), limits)
    if pick:
        raise ArmError(
            f"arm {name_or_path} has no other links or joints to choose from",
            where="--tip, --base, --lock",
            expected="none of them: its file describes one chain, all of which moves",
            next_step="leave them out",
        )
    return with_limits(read_arm(path), limits)


def _checked(arm: RobotArm, limits: Given) -> RobotArm:
    """Add limits to an arm that was read, and warn of what looks like a slip in it."""
    limited = with_limits(arm, limits)
    warn_of_implausible(limited, stacklevel=3)
    return limited


def _path_of(name_or_path: object) -> Path:
    if not isinstance(name_or_path, str | PathLike):
        raise ArmError(
            "this is no arm",
            where="arm",
            expected="the name of a built-in one, the path of an arm's file, or a pinocchio.Model",
            found=in_python(name_or_path),
        )
    builtin = builtin_arms()
    given = str(name_or_path)
    if given in builtin:
        return builtin[given]
    path = Path(name_or_path)
    with suppress(OSError):  # a name too long for the file system is no file either
        is_file = path.is_file()
        if (given and path.is_dir()) or (is_file and path.suffix.lower() in _OF_LOGS):
            raise _no_robot(path)
        if is_file:
            return path
    near = difflib.get_close_matches(given, builtin, n=1)
    raise ArmError(
        f"there is no arm {given!r}",
        expected=f"a built-in arm ({', '.join(builtin)}) or the path of an arm's TOML, URDF or MJCF file",
        found="neither a known name nor an existing file",
        next_step=f"did you mean {near[0]!r}?" if near else "`gd-analyze arms` lists the built-in arms",
    )


def _no_robot(path: Path) -> ArmError:
    """Refuse what exists but is no robot's file: a folder, or a log that was named first."""
    is_folder = path.is_dir()
    return ArmError(
        "this is no robot's file",
        where=Location(path),
        expected="the path of an arm's URDF, MJCF or TOML file, or a built-in arm's name",
        found="a folder" if is_folder else f"a {path.suffix} file, as logs and set points are",
        next_step="name the file in it" if is_folder else "name the robot first, then the log",
    )
