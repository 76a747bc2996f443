"""Columns that the user names: by name, number or pattern, with units; and names in messages."""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.reading import ROLES, MotionRole, Reading, refusal
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.words import fitting_unit, unit_in_words, units_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS

_NONE = "none"
# Most names listed in a message.
_MOST_LISTED_NAMES = 12


@dataclass(frozen=True)
class Pattern:
    """Columns of a role whose names differ where the star stands, as the user gives them."""

    role: MotionRole
    text: str
    unit: str  # "" if it is not said

    def columns(self, table: LogTable) -> dict[int, str]:
        """Columns that it names, and what stands for the star."""
        front, _, end = self.text.partition("*")
        starred = re.compile(f"{re.escape(front)}(.+){re.escape(end)}")
        matches = ((k, starred.fullmatch(name)) for k, name in enumerate(table.names))
        return {k: match[1] for k, match in matches if match is not None}


def patterns_given(table: LogTable, reading: Reading) -> list[Pattern]:
    """Patterns among the columns that the user names."""
    patterns = []
    for role in ROLES:
        for mapped_role, column in reading.map:
            if mapped_role == role and "*" in column and column not in table.names:
                patterns.append(Pattern(role, *without_unit(column, role, table)))
    return patterns


def without_unit(column: str, role: str, table: LogTable) -> tuple[str, str]:
    """Split `NAME:UNIT`; the unit is "" where the whole is a column's name or no unit is given."""
    name, colon, text = column.rpartition(":")
    if not colon or column in table.names:
        return column, ""
    units = TIME_UNITS if role == "time" else {**units_of(role, True, True), **units_of(role, False)}
    unit = unit_in_words(text) or ""
    kinds = (True, False)
    fits = (
        unit in TIME_UNITS if role == "time" else any(fitting_unit(unit, role, kind, True) for kind in kinds)
    )
    if fits:
        return name, unit
    if name in table.names or "*" in name or name.startswith("#"):
        message, where = f"{text!r} is no unit of {role}", f"--map {role}={column}"
        raise refusal(message, where, f"{name} alone, or with one of {', '.join(units)}", repr(text))
    return column, ""


def mapped_columns(
    table: LogTable, arm: RobotArm, reading: Reading
) -> tuple[dict[tuple[str, int], int], dict[int, str]]:
    """Columns named by the user, by role and joint, -1 for a role to leave out; and the units given."""
    mapped: dict[tuple[str, int], int] = {}
    units: dict[int, str] = {}
    for role, column in reading.map:
        quantity, colon, joint = role.partition(":")
        if (quantity == "joint" and colon) or (role in ROLES and "*" in column and column not in table.names):
            continue
        if quantity not in (*ROLES, "time") or ((quantity == "time") == bool(colon) and column != _NONE):
            expected = (
                "time, joint:JOINT, or q:JOINT, qd:JOINT, qdd:JOINT, torque:JOINT; 'q=NAME*'; or qd=none"
            )
            message = f"{quantity} of which joint?" if quantity in ROLES else f"unknown role {role!r}"
            raise refusal(message, "--map", expected, f"{role}={column}")
        if column == _NONE and quantity != "q":
            mapped[quantity, -1] = -1
        else:
            name, unit = without_unit(column, quantity, table)
            number = _column_named(name, table)
            mapped[quantity, joint_named(joint, arm) if colon else 0] = number
            units |= {number: unit} if unit else {}
    return mapped, units


def joint_named(name: str, arm: RobotArm) -> int:
    """Number, from 0, of the arm's joint given by name or by number from 1."""
    number = arm.joint_number(name)
    if number is not None:
        return number
    names = [joint.name for joint in arm.joints]
    near = difflib.get_close_matches(name, names, n=1)
    expected = f"{', '.join(names)}, or a number from 1 to {arm.n_joints}"
    step = f"did you mean {near[0]}?" if near else "`gd-analyze arms ROBOT` lists the joints"
    raise refusal(f"arm {arm.name} has no joint {name!r}", "--map", expected, repr(name), step)


def _column_named(column: str, table: LogTable) -> int:
    """Column given by name, or by #NUMBER from 1; TrajectoryError if there is none or several."""
    if column.startswith("#") and column[1:].isascii() and column[1:].isdigit() and len(column) < 8:
        number = int(column[1:])
        if 1 <= number <= len(table.names):
            return number - 1
    matches = [k for k, name in enumerate(table.names) if name == column]
    if not matches:
        raise no_column(column, table, "--map")
    if len(matches) > 1:
        numbers, step = ", ".join(f"#{k + 1}" for k in matches), f"give its number: #{matches[0] + 1}"
        raise refusal(f"{len(matches)} columns are named {column}", "--map", "one column", numbers, step)
    return matches[0]


def no_column(column: str, table: LogTable, where: str) -> TrajectoryError:
    """Error for a column that the log does not have, with names that are near."""
    near = difflib.get_close_matches(column, table.names, n=3)
    place, expected = f"{where}; {table.where()}", f"a name, or a number from #1 to #{len(table.names)}"
    step = f"did you mean {' or '.join(near)}?" if near else "check the name"
    return refusal(f"the log has no column {column!r}", place, expected, listed_names(table.names), step)


def listed_names(names: Sequence[str]) -> str:
    """Names as one line of a message; only the first of many."""
    names = [name for name in names if name]
    first = ", ".join(names[:_MOST_LISTED_NAMES]) or "columns without names"
    return first if len(names) <= _MOST_LISTED_NAMES else f"{first}, ... ({len(names)})"


def map_option(pair: str) -> str:
    """Option that can be pasted into a shell."""
    return f"--map {shlex.quote(pair)}"
