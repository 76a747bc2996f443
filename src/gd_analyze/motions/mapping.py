"""What the user says of a log's columns with `map`: roles, columns by name, number or pattern, and units."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from gd_analyze.errors import TrajectoryError, argument
from gd_analyze.motions.column_units import fitting_unit, unit_in_words, units_of
from gd_analyze.motions.families import Family
from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.names import ColumnName
from gd_analyze.motions.reading import Reading, rate_in, refusal
from gd_analyze.motions.table import LogTable
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS, UNITS

_NONE = "none"
# Most names listed in a message.
_MOST_LISTED_NAMES = 12
_RANGE = re.compile(r"(.*?)([0-9]{1,4})\.\.(.*?)([0-9]{1,4})")
# Columns that one range q1..qN names, at most.
_MOST_COLUMNS = 10_000


@dataclass
class NamedLog:
    """A log with what the user and its columns' names say; columns and the arm's joints count from 0."""

    table: LogTable
    arm: RobotArm
    reading: Reading
    # What the user says
    time: int | None = None  # column of time
    time_unit: str = ""
    rate: float | None = None  # samples per second, of the rows or of what the column of time counts
    counts_rows: bool = False  # whether the rate is that of the rows, whatever the column of time
    mapped: dict[str, dict[int, int]] = field(default_factory=dict)  # column by role and joint
    patterns: dict[str, dict[int, str]] = field(default_factory=dict)  # by role: star by column
    units: dict[int, str] = field(default_factory=dict)  # by column
    role_units: dict[str, str] = field(default_factory=dict)  # by role, of columns not named
    left_out: set[str] = field(default_factory=set)  # roles
    given_joints: tuple[str, ...] = ()  # the joints' names in the log
    # What the names say
    joints: JointNames = field(default_factory=lambda: JointNames({}))
    names: Sequence[ColumnName] = ()  # of the columns
    families: list[Family] = field(default_factory=list)

    @classmethod
    def of(cls, table: LogTable, arm: RobotArm, reading: Reading) -> NamedLog:
        """Find the columns that the user names.

        Raises
        ------
        TrajectoryError
            If there is no such column, joint or unit.
        """
        log = cls(table, arm, reading)
        for role, value in reading.map:
            name, _, joint = role.partition(":")
            if name == "time":
                log._map_time(value)
            elif name == "joints":
                log._map_joints(value)
            elif value == _NONE:
                log.left_out.add(name)
                log.patterns.pop(name, None)
                log.mapped.pop(name, None)
            else:
                log.left_out.discard(name)
                text, unit = _without_unit(value, name, log)
                if joint:
                    log._map_column(name, _joint_named(joint, arm), text, unit)
                else:
                    log._map_role(name, text, unit)
        return log

    @property
    def has_currents(self) -> bool:
        """Whether the user says what torques currents give."""
        return self.reading.torque_constant is not None

    def _map_time(self, value: str) -> None:
        rate = None if value in self.table.names else rate_in(value)
        self.counts_rows = rate is not None
        name, unit = ("", "") if self.counts_rows else _without_unit(value, "time", self)
        self.time = _column_named(name, self.table) if name else None
        self.rate = rate_in(unit) if rate is None else rate
        self.time_unit = "" if self.rate else unit

    def _map_joints(self, value: str) -> None:
        names, arm = _listed(value), self.arm
        if len(names) != arm.n_joints:
            expected = f"{arm.n_joints}, in the order of {arm.name}'s joints"
            step = f"the arm's are {', '.join(joint.name for joint in arm.joints)}"
            raise refusal(f"joints: {len(names)} names", "map", expected, value, step)
        self.given_joints = tuple(names)

    def _map_role(self, role: str, text: str, unit: str) -> None:
        """The columns of all joints: a pattern, a list, or the unit alone of those that are recognized."""
        if not text:
            self.role_units[role] = unit
            return
        if "*" in text and text not in self.table.names:
            starred = _starred(text, self.table)
            if not starred:
                raise _no_column(text, self.table)
            self.patterns[role] = {**self.patterns.get(role, {}), **starred}
            self.units.update(dict.fromkeys(starred, unit) if unit else {})
            return
        names, n = [text] if text in self.table.names else _listed(text), self.arm.n_joints
        if len(names) != n:
            message, expected = f"{role} is given for some joints only", f"a column for each of {n} joints"
            step = f"list them as in {role}=#2..#{n + 1}; {role}:{self.arm.joints[0].name} is of one joint"
            raise refusal(message, "map", expected, f"{role}={text}", step)
        for joint, name in enumerate(names):
            self._map_column(role, joint, name, unit)

    def _map_column(self, role: str, joint: int, name: str, unit: str) -> None:
        if not name:
            expected = f"{role}:{joint + 1}=COLUMN:{unit}, or {role}=:{unit} for all joints"
            raise refusal("no column is named", "map", expected, f"{role}:{joint + 1}=:{unit}")
        column = _column_named(name, self.table)
        self.mapped.setdefault(role, {})[joint] = column
        self.units.update({column: unit} if unit else {})


def _without_unit(value: str, role: str, log: NamedLog) -> tuple[str, str]:
    """Split `NAME:UNIT`; the unit is "" where the whole is a column's name or no unit is given."""
    name, colon, text = value.rpartition(":")
    if not colon or value in log.table.names:
        return value, ""
    unit, step = unit_in_words(text) or "", None
    if role == "time":
        if unit in TIME_UNITS or rate_in(text) is not None:
            return name, unit or text
        message, units = f"{text!r} is no unit of time", [*TIME_UNITS, "250Hz"]
    else:
        kinds = dict.fromkeys(log.arm.is_revolute)
        if any(fitting_unit(unit, role, kind, log.has_currents) for kind in kinds):
            return name, unit
        message = f"no joint of {log.arm.name} has {role} in {text}"
        units = [*dict.fromkeys(unit for kind in kinds for unit in units_of(role, kind, log.has_currents))]
        step = "give `torque_constant`, too" if unit in UNITS["current"] and role == "torque" else None
    if name and not unit and name not in log.table.names and "*" not in name and not name.startswith("#"):
        return value, ""
    expected = f"{name or 'a column'} alone, or with one of {', '.join(units)}"
    raise refusal(message, argument("map", f"{role}={value}"), expected, repr(text), step)


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
            raise refusal("this is not a range of names", "map", expected, repr(entry), step)
        names += [f"{match[1]}{k}" for k in range(first, last + 1)]
    return names


def _joint_named(name: str, arm: RobotArm) -> int:
    """Number, from 0, of the arm's joint given by name or by number from 1."""
    number = arm.joint_number(name)
    if number is not None:
        return number
    names = [joint.name for joint in arm.joints]
    near = difflib.get_close_matches(name, names, n=1)
    expected = f"{', '.join(names)}, or a number from 1 to {arm.n_joints}"
    step = f"did you mean {near[0]}?" if near else "`gd-analyze arms ROBOT` lists the joints"
    raise refusal(f"arm {arm.name} has no joint {name!r}", "map", expected, repr(name), step)


def _column_named(column: str, table: LogTable) -> int:
    """Column given by name, or by #NUMBER from 1; TrajectoryError if there is none or several."""
    if column not in table.names and re.fullmatch("#[0-9]{1,6}", column):
        number = int(column[1:])
        if 1 <= number <= len(table.names):
            return number - 1
    matches = [k for k, name in enumerate(table.names) if name == column and name]
    if not matches:
        raise _no_column(column, table)
    if len(matches) > 1:
        numbers, step = ", ".join(f"#{k + 1}" for k in matches), f"give its number: #{matches[0] + 1}"
        raise refusal(f"{len(matches)} columns are named {column}", "map", "one column", numbers, step)
    return matches[0]


def _no_column(column: str, table: LogTable) -> TrajectoryError:
    """Error for a column that the log does not have, with names that are near."""
    near = difflib.get_close_matches(column, table.names, n=3)
    place, expected = f"map; {table.where()}", f"a name, or a number from #1 to #{len(table.names)}"
    step = f"did you mean {' or '.join(near)}?" if near else "check the name"
    return refusal(f"the log has no column {column!r}", place, expected, listed_names(table.names), step)


def typed_columns(columns: Sequence[int], table: LogTable) -> list[str]:
    """What `map` takes for columns: their names, or numbers where these are not their own."""
    names = [table.names[column] for column in columns]
    if all(name and "," not in name and table.names.count(name) == 1 for name in names):
        return names
    return [f"#{column + 1}" for column in columns]


def listed_names(names: Sequence[str]) -> str:
    """Names as one line of a message; only the first of many."""
    names = [name for name in names if name]
    first = ", ".join(names[:_MOST_LISTED_NAMES]) or "columns without names"
    return first if len(names) <= _MOST_LISTED_NAMES else f"{first}, ... ({len(names)})"
