"""What the user says of a log's columns with --map: roles, columns by name, number or pattern, and units."""

from __future__ import annotations

import difflib
import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, field

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.column_units import fits_some_joint, unit_in_words, units_of
from gd_analyze.motions.reading import Reading, rate_in, refusal
from gd_analyze.motions.table import LogTable
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS

_NONE = "none"
# Most names listed in a message.
_MOST_LISTED_NAMES = 12
_RANGE = re.compile(r"(.*?)([0-9]{1,4})\.\.(.*?)([0-9]{1,4})")
# Columns that one range q1..qN names, at most.
_MOST_COLUMNS = 10_000


@dataclass
class ColumnMap:
    """What the user says, by the columns of a table and the arm's joints, both from 0."""

    table: LogTable
    arm: RobotArm
    time: int | None = None  # column of time
    time_unit: str = ""
    rate: float | None = None  # samples per second, of the rows or of what the column of time counts
    counts_rows: bool = False  # whether the rate is that of the rows, whatever the column of time
    columns: dict[tuple[str, int], int] = field(default_factory=dict)  # by role and joint
    patterns: dict[str, dict[int, str]] = field(default_factory=dict)  # by role: star by column
    units: dict[int, str] = field(default_factory=dict)  # by column
    role_units: dict[str, str] = field(default_factory=dict)  # by role, of columns not named
    left_out: set[str] = field(default_factory=set)  # roles
    joints: tuple[str, ...] = ()  # the joints' names in the log

    @classmethod
    def of(cls, table: LogTable, arm: RobotArm, reading: Reading) -> ColumnMap:
        """Find the columns that the user names.

        Raises
        ------
        TrajectoryError
            If there is no such column, joint or unit.
        """
        given = cls(table, arm)
        for role, value in reading.map:
            name, _, joint = role.partition(":")
            if name == "time":
                given._add_time(value)
            elif name == "joints":
                given._add_joints(value)
            elif value == _NONE:
                given.left_out.add(name)
            elif joint:
                given._add_column(name, joint_named(joint, arm), *without_unit(value, name, table))
            else:
                given._add_columns(name, value)
        return given

    def columns_of(self, role: str) -> dict[int, int]:
        """Column of each joint that the user names one for."""
        return {joint: column for (of_role, joint), column in self.columns.items() if of_role == role}

    def _add_time(self, value: str) -> None:
        rate = None if value in self.table.names else rate_in(value)
        self.counts_rows = rate is not None
        name, unit = ("", "") if self.counts_rows else without_unit(value, "time", self.table)
        self.time = _column_named(name, self.table) if name else None
        self.rate = rate_in(unit) if rate is None else rate
        self.time_unit = "" if self.rate else unit

    def _add_joints(self, value: str) -> None:
        names, arm = _listed(value), self.arm
        if len(names) != arm.n_joints:
            expected = f"{arm.n_joints}, in the order of {arm.name}'s joints"
            step = f"the arm's are {', '.join(joint.name for joint in arm.joints)}"
            raise refusal(f"joints: {len(names)} names", "--map", expected, value, step)
        self.joints = tuple(names)

    def _add_columns(self, role: str, value: str) -> None:
        """The columns of all joints: a pattern, a list, or the unit alone of those that are recognized."""
        text, unit = without_unit(value, role, self.table)
        if not text:
            self.role_units[role] = unit
            return
        if "*" in text and text not in self.table.names:
            starred = _starred(text, self.table)
            if not starred:
                raise no_column(text, self.table)
            self.patterns[role] = {**self.patterns.get(role, {}), **starred}
            self.units.update(dict.fromkeys(starred, unit) if unit else {})
            return
        names, n = [text] if text in self.table.names else _listed(text), self.arm.n_joints
        if len(names) != n:
            message, expected = f"{role} is given for some joints only", f"a column for each of {n} joints"
            step = f"list them as in {role}=#2..#{n + 1}; {role}:{self.arm.joints[0].name} is of one joint"
            raise refusal(message, "--map", expected, f"{role}={value}", step)
        for joint, name in enumerate(names):
            self._add_column(role, joint, name, unit)

    def _add_column(self, role: str, joint: int, name: str, unit: str) -> None:
        column = _column_named(name, self.table)
        self.columns[role, joint] = column
        self.units.update({column: unit} if unit else {})


def map_option(pair: str) -> str:
    """The option as it can be pasted into a shell."""
    return f"--map {shlex.quote(pair)}"


def without_unit(value: str, role: str, table: LogTable) -> tuple[str, str]:
    """Split `NAME:UNIT`; the unit is "" where the whole is a column's name or no unit is given."""
    name, colon, text = value.rpartition(":")
    if not colon or value in table.names:
        return value, ""
    unit = unit_in_words(text) or ""
    if role == "time" and (unit in TIME_UNITS or rate_in(text) is not None):
        return name, unit or text
    if role != "time" and unit and fits_some_joint(unit, role):
        return name, unit
    if not name or name in table.names or "*" in name or name.startswith("#"):
        units = (
            [*TIME_UNITS, "250Hz"]
            if role == "time"
            else {**units_of(role, True, True), **units_of(role, False)}
        )
        message, where = f"{text!r} is no unit of {role}", f"--map {role}={value}"
        raise refusal(
            message, where, f"{name or 'a column'} alone, or with one of {', '.join(units)}", repr(text)
        )
    return value, ""


def _starred(text: str, table: LogTable) -> dict[int, str]:
    """Columns that a pattern names, and what stands for the star."""
    front, _, end = text.partition("*")
    pattern = re.compile(f"{re.escape(front)}(.+){re.escape(end)}")
    matches = ((k, pattern.fullmatch(name)) for k, name in enumerate(table.names))
    return {k: match[1] for k, match in matches if match is not None}


def _listed(text: str) -> list[str]:
    """Names with commas, `q1..q6` among them."""
    names: list[str] = []
    for entry in (part.strip() for part in text.split(",")):
        match = _RANGE.fullmatch(entry)
        if match is None:
            names.append(entry)
            continue
        first, last = int(match[2]), int(match[4])
        if match[3] not in ("", match[1]) or not first <= last < first + _MOST_COLUMNS:
            expected = "q1..q6, with the same letters on both sides"
            step = "write the names one by one, with commas"
            raise refusal("this is not a range of names", "--map", expected, repr(entry), step)
        names += [f"{match[1]}{k}" for k in range(first, last + 1)]
    return names


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
    matches = [k for k, name in enumerate(table.names) if name == column and name]
    if not matches:
        raise no_column(column, table)
    if len(matches) > 1:
        numbers, step = ", ".join(f"#{k + 1}" for k in matches), f"give its number: #{matches[0] + 1}"
        raise refusal(f"{len(matches)} columns are named {column}", "--map", "one column", numbers, step)
    return matches[0]


def no_column(column: str, table: LogTable) -> TrajectoryError:
    """Error for a column that the log does not have, with names that are near."""
    near = difflib.get_close_matches(column, table.names, n=3)
    place, expected = f"--map; {table.where()}", f"a name, or a number from #1 to #{len(table.names)}"
    step = f"did you mean {' or '.join(near)}?" if near else "check the name"
    return refusal(f"the log has no column {column!r}", place, expected, listed_names(table.names), step)


def listed_names(names: Sequence[str]) -> str:
    """Names as one line of a message; only the first of many."""
    names = [name for name in names if name]
    first = ", ".join(names[:_MOST_LISTED_NAMES]) or "columns without names"
    return first if len(names) <= _MOST_LISTED_NAMES else f"{first}, ... ({len(names)})"
