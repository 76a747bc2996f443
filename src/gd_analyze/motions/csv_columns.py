"""The header of a trajectory file: which column holds which quantity, and in which unit.

`time, q1..qn[, qd1..qdn][, qdd1..qdn]` in any order, SI and radians; a `_deg` suffix means degrees.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from gd_analyze.errors import Location, TrajectoryError
from gd_analyze.motions.role_words import SET_POINT_COLUMN
from gd_analyze.motions.text_layout import LONGEST_NAME
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python

KINDS = ("q", "qd", "qdd")

# Names that a message lists.
_MOST_LISTED = 40


@dataclass(frozen=True)
class Columns:
    """Where a file keeps what; columns count from 0.

    Parameters
    ----------
    time
        Column of the time.
    by_kind
        For "q" and, where given, "qd" and "qdd": the columns of joints 1..n.
    degrees
        Columns whose numbers are degrees.
    names
        All column names as written.
    """

    time: int
    by_kind: dict[str, tuple[int, ...]]
    degrees: frozenset[int]
    names: tuple[str, ...]


def read_columns(cells: Sequence[str], arm: RobotArm, header: Location) -> Columns:
    """Understand a header line.

    Parameters
    ----------
    cells
        The header's cells.
    arm
        The arm the trajectory is for.
    header
        Where the header stands, for messages.

    Raises
    ------
    TrajectoryError
        If a column is unknown, given twice or missing, or the columns are those of an arm with another
        number of joints.
    """
    names = tuple(cell.strip() for cell in cells)
    _refuse_long_names(names, header)
    found: dict[tuple[str, int], int] = {}
    degrees = set()
    for column, name in enumerate(names):
        where = replace(header, column=column + 1)
        match = SET_POINT_COLUMN.fullmatch(name.lower())
        if name.lower() == "time":
            key = ("time", 0)
        elif match:
            key = (match[1], int(match[2]))
        else:
            raise TrajectoryError(
                f"column {name!r} is unknown",
                where=where,
                expected=f"time, q1..q{arm.n_joints}, qd1.., qdd1..; _deg appended for degrees",
                found=repr(name),
            )
        if key in found:
            raise TrajectoryError(
                f"column {name} is given twice",
                where=where,
                expected="each quantity of each joint once",
                found=f"{names[found[key]]} in column {found[key] + 1} as well",
                next_step="remove one of the two",
            )
        found[key] = column
        if match and match[3]:
            _refuse_degrees_of_length(arm, int(match[2]), name, where)
            degrees.add(column)
    if ("time", 0) not in found:
        raise TrajectoryError(
            "column time is missing",
            where=header,
            expected="a column named time, in s",
            found=_listed(names),
            next_step="add the instants of the set points",
        )
    return Columns(
        time=found["time", 0],
        by_kind=_complete_kinds(found, arm, header),
        degrees=frozenset(degrees),
        names=names,
    )


def header_for(n_joints: int, kinds: Sequence[str] = KINDS) -> str:
    """Write the header line for n joints."""
    return ",".join(["time", *(f"{kind}{i}" for kind in kinds for i in range(1, n_joints + 1))])


def _complete_kinds(
    found: dict[tuple[str, int], int], arm: RobotArm, where: Location
) -> dict[str, tuple[int, ...]]:
    n = arm.n_joints
    by_kind = {}
    for kind in KINDS:
        given = sorted(joint for k, joint in found if k == kind)
        if not given and kind != "q":
            continue
        if given == list(range(1, len(given) + 1)) and given and len(given) != n:
            raise TrajectoryError(
                f"the file's {kind} columns do not fit arm {arm.name}",
                where=where,
                expected=f"{n} joints: {kind}1..{kind}{n}",
                found=f"{len(given)} {'joint' if len(given) == 1 else 'joints'}",
                next_step=f"choose the arm the file was made for, or give {kind} of every joint",
            )
        missing = [f"{kind}{joint}" for joint in range(1, n + 1) if joint not in given]
        surplus = [f"{kind}{joint}" for joint in given if joint > n]
        if missing or surplus:
            raise TrajectoryError(
                f"column {missing[0]} is missing"
                if missing
                else f"column {surplus[0]} is one too many for arm {arm.name}",
                where=where,
                expected=f"{kind}1..{kind}{n}",
                found=_listed([f"{kind}{joint}" for joint in given]) or f"no {kind} column",
                next_step=f"the whole header: {header_for(n, ('q',))}, then qd1.. and qdd1.. if known",
            )
        by_kind[kind] = tuple(found[kind, joint] for joint in range(1, n + 1))
    return by_kind


def _listed(names: Sequence[str]) -> str:
    """Names as one line of a message, of many the first."""
    first = ", ".join(names[:_MOST_LISTED])
    return first if len(names) <= _MOST_LISTED else f"{first}, ... ({len(names)} columns)"


def _refuse_long_names(names: Sequence[str], where: Location) -> None:
    for column, name in enumerate(names, start=1):
        if len(name) > LONGEST_NAME:
            raise TrajectoryError(
                f"the name of column {column} is far too long",
                where=replace(where, column=column),
                expected=f"a name such as time or q1, up to {LONGEST_NAME} characters",
                found=in_python(name),
                next_step="check that the file is a trajectory",
            )


def _refuse_degrees_of_length(arm: RobotArm, number: int, name: str, where: Location) -> None:
    if number <= arm.n_joints and arm.joints[number - 1].kind == "prismatic":
        raise TrajectoryError(
            f"column {name} is in degrees, but joint {number} slides",
            where=where,
            expected=f"{name.lower().removesuffix('_deg')}, in metres and seconds",
            found=name,
            next_step="rename the column and give metres",
        )
