"""Columns that the user names, with `--map` and in mapping files."""

from __future__ import annotations

import difflib
from collections.abc import Sequence

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.reading import NONE, ROLES, Reading
from gd_analyze.motions.table import LogTable
from gd_analyze.robots.arm import RobotArm

# Names that a message lists.
_MOST = 12


def columns_said(table: LogTable, arm: RobotArm, reading: Reading) -> dict[tuple[str, int], int]:
    """Columns by role and joint that the user names; joint -1 of a role that shall be left out."""
    said: dict[tuple[str, int], int] = {}
    for role, column in reading.map:
        of, colon, joint = role.partition(":")
        if of == "joint" and colon:
            continue
        if of not in (*ROLES, "time") or ((of == "time") == bool(colon) and column != NONE):
            raise TrajectoryError(
                f"there is no role {role!r}",
                where="--map",
                expected="time, joint:JOINT, or q:JOINT, qd:JOINT, qdd:JOINT, torque:JOINT; qd=none and such",
                found=f"{role}={column}",
            )
        if column == NONE and of != "q":
            said[of, -1] = -1
        else:
            said[of, joint_named(joint, arm) if colon else 0] = column_named(column, table)
    return said


def joint_named(name: str, arm: RobotArm) -> int:
    """Number, from 0, of the arm's joint of a name, or of a number from 1.

    Raises
    ------
    TrajectoryError
        If there is none.
    """
    names = [joint.name for joint in arm.joints]
    if name in names:
        return names.index(name)
    if name.isascii() and name.isdigit() and 1 <= int(name[:9]) <= arm.n_joints:
        return int(name) - 1
    near = difflib.get_close_matches(name, names, n=1)
    raise TrajectoryError(
        f"arm {arm.name} has no joint {name!r}",
        where="--map",
        expected=f"{', '.join(names)}, or a number from 1 to {arm.n_joints}",
        found=repr(name),
        next_step=f"did you mean {near[0]}?" if near else "`gd-analyze arms ROBOT` lists the joints",
    )


def column_named(column: str, table: LogTable, where: str = "--map") -> int:
    """Column of a name, or of #NUMBER from 1.

    Raises
    ------
    TrajectoryError
        If there is none, or there are several.
    """
    if column.startswith("#") and column[1:].isascii() and column[1:].isdigit() and len(column) < 8:
        number = int(column[1:])
        if 1 <= number <= len(table.names):
            return number - 1
    found = [k for k, name in enumerate(table.names) if name == column]
    if len(found) == 1:
        return found[0]
    if found:
        raise TrajectoryError(
            f"{len(found)} columns are named {column}",
            where=where,
            expected="one column",
            found=", ".join(f"#{k + 1}" for k in found),
            next_step=f"give its number: #{found[0] + 1}",
        )
    raise no_column(column, table, where)


def no_column(column: str, table: LogTable, where: str) -> TrajectoryError:
    """Error of a name that no column has."""
    near = difflib.get_close_matches(column, table.names, n=3)
    return TrajectoryError(
        f"the log has no column {column!r}",
        where=f"{where}; {table.where()}",
        expected=f"a name, or a number from #1 to #{len(table.names)}",
        found=listed([name for name in table.names if name]) or "columns without names",
        next_step=f"did you mean {' or '.join(near)}?" if near else "check the name",
    )


def listed(names: Sequence[str]) -> str:
    """Names as one line of a message, of many the first."""
    first = ", ".join(names[:_MOST])
    return first if len(names) <= _MOST else f"{first}, ... ({len(names)})"
