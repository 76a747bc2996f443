"""Arms by name (shipped with the package) or by path (the user's own)."""

from __future__ import annotations

import difflib
from contextlib import suppress
from pathlib import Path

from gd_analyze.errors import ArmError
from gd_analyze.resources import shipped
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.arm_file import read_arm
from gd_analyze.visible import in_python


def builtin_arms() -> dict[str, Path]:
    """Shipped arm files by name, in alphabetical order."""
    return shipped("robots", ".toml")


def arm_of(given: RobotArm | str | Path) -> RobotArm:
    """Take an arm, or load the one that a built-in name or a path stands for.

    Raises
    ------
    ArmError
        As `load_arm`, or if it is none of these.
    """
    if isinstance(given, RobotArm):
        return given
    if isinstance(given, str | Path):
        return load_arm(given)
    raise ArmError(
        "this is no arm",
        where="arm",
        expected="a RobotArm, the name of a built-in one, or the path of an arm's TOML file",
        found=in_python(given),
    )


def load_arm(name_or_path: str | Path) -> RobotArm:
    """Load a built-in arm by name or any arm by its TOML file.

    Parameters
    ----------
    name_or_path
        A name that `builtin_arms` lists, or the path of a TOML file.

    Returns
    -------
    RobotArm
        The arm.

    Raises
    ------
    ArmError
        If there is neither such an arm nor such a file, or the file is not a possible arm.

    Examples
    --------
    >>> load_arm("puma560").n_joints
    6
    """
    builtin = builtin_arms()
    given = str(name_or_path)
    if given in builtin:
        return read_arm(builtin[given])
    path = Path(name_or_path)
    with suppress(OSError):  # a name too long for the file system is no file either
        if path.is_file():
            return read_arm(path)
    near = difflib.get_close_matches(given, builtin, n=1)
    raise ArmError(
        f"there is no arm {given!r}",
        expected=f"a built-in arm ({', '.join(builtin)}) or the path of an arm's TOML file",
        found="neither a known name nor an existing file",
        next_step=f"did you mean {near[0]!r}?" if near else "`gd-analyze arms` lists the built-in arms",
    )
