"""Roles of a log's columns: the family of each quantity that its names prefer, or what the user says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from gd_analyze.errors import argument
from gd_analyze.motions.column_units import fitting_unit, units_of
from gd_analyze.motions.families import Family, families_of
from gd_analyze.motions.instants import TimeColumns, time_columns
from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.mapping import NamedLog, listed_names
from gd_analyze.motions.names import OTHER, TIMED, ColumnName, are_of_set_points, column_name
from gd_analyze.motions.not_understood import (
    ZERO,
    absent,
    ambiguous,
    no_currents,
    remarks_on,
    unknown_torques,
)
from gd_analyze.motions.reading import ROLES, MotionRole, Reading, refusal
from gd_analyze.motions.table import Columns, LogTable
from gd_analyze.motions.text import TextTable
from gd_analyze.motions.vocabulary import words_in
from gd_analyze.progress import Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS, UNITS

Role = Literal["time", "unused"] | MotionRole


@dataclass(frozen=True)
class ColumnUse:
    """How one column of a log was understood."""

    column: str  # its name, or its number from 1 if it has none
    role: Role  # "time", "q", "qd", "qdd", "torque" or "unused"
    joint: str = ""  # name of the arm's joint; "" for time and unused columns
    unit: str = ""  # unit of its numbers in the log
    why: str = ""  # the reason for the role


@dataclass(frozen=True)
class Choice:
    """Columns used from a log."""

    columns: Mapping[MotionRole, Sequence[int]]  # of each role, by joint
    uses: tuple[ColumnUse, ...]  # of every column; without a unit where none is stated
    time: TimeColumns | None  # column or columns of time; None if rows are counted
    rate: float | None  # samples per second, where the user gives it
    measured: bool  # whether these are readings
    set_points: bool  # whether the rows are set points, used unchanged
    remarks: Sequence[str]  # warnings

    @property
    def wanted(self) -> tuple[list[int], tuple[int, ...]]:
        """Columns to read as numbers, and as instants; instants of set points are plain numbers."""
        columns = {column for of_role in self.columns.values() for column in of_role}
        times = self.time.columns if self.time is not None else ()
        return (sorted({*columns, *times}), ()) if self.set_points else (sorted(columns), times)


def chosen_columns(
    table: LogTable, arm: RobotArm, reading: Reading, progress: Progress
) -> tuple[Choice, Columns]:
    """Choose columns and read them; choose again without families that are 0 throughout."""
    log = _named(table, arm, reading)
    zero: list[Family] = []
    while True:
        rivals = _rivals(log, zero)
        choice = _choice(log, {role: families[0] for role, families in rivals.items()}, zero)
        numbers, times = choice.wanted
        others = [family for families in rivals.values() for family in families[1:]]
        numbers = sorted({*numbers, *(column for family in others for column in family.all_columns)})
        columns = table.read(numbers, times, progress)
        moving = {k for i, k in enumerate(numbers) if np.nan_to_num(columns.numbers[:, i]).any()}
        every = [family for families in rivals.values() for family in families]
        resting = [family for family in every if family not in zero and not moving & {*family.all_columns}]
        # Where no row can be read, numbers say nothing of a family; `log_of` names the cell.
        if resting and not choice.set_points and len(columns.wrong) < len(columns.numbers):
            zero += resting
            continue
        for role, families in rivals.items():
            if len(families) > 1:
                raise ambiguous(role, families, log)
        _require_one_role_each(choice, log)
        return choice, columns


def _named(table: LogTable, arm: RobotArm, reading: Reading) -> NamedLog:
    """The names of the columns, read for the arm and as the user says, and their families."""
    log = NamedLog.of(table, arm, reading)
    # In a file of set points q1 is the arm's first joint, whatever its name.
    in_order = are_of_set_points(table.names)
    arm_names = [str(k + 1) if in_order else joint.name for k, joint in enumerate(arm.joints)]
    log.joints = JointNames.of(arm_names, log.given_joints)
    names = [_judged(column_name(text, log.joints), log, column) for column, text in enumerate(table.names)]
    if log.given_joints and not any(name.joint is not None for name in names):
        message, listed = "no column names one of these joints", listed_names(table.names)
        where = argument("map", f"joints={','.join(log.given_joints)}")
        step = "give the joints' names as they stand in the names of the columns"
        raise refusal(message, where, "joints of the log", listed, step)
    _take_joints_from_cells(names, log)
    for column, unit in log.units.items():
        names[column] = replace(names[column], unit=unit, fault="")
    log.names = names
    log.families = families_of(
        {k: name for k, name in enumerate(names) if name.role not in log.patterns}, log.joints
    )
    for role, stars in log.patterns.items():
        starred = {
            k: column_name(star, log.joints) for k, star in stars.items() if names[k].role not in TIMED
        }
        log.families += families_of(
            {k: _as_said(names[k], role, star) for k, star in starred.items()}, log.joints
        )
    return log


def _judged(name: ColumnName, log: NamedLog, column: int) -> ColumnName:
    """No quantity where the cells are text; currents are torques where the user says what they give."""
    if name.role == "current" and log.has_currents:
        name = replace(name, role="torque", rank=3, unit=name.unit or "A")
    elif name.role == "torque" and name.unit in UNITS["current"] and not log.has_currents:
        name = replace(name, fault=f"in {name.unit}, no unit of torque")
    if name.role == "time" and name.unit not in ("", *TIME_UNITS):
        name = replace(name, role="other")
    has_text = name.role in (*ROLES, "time") and {type(cell) for cell in log.table.head(column)} == {str}
    return replace(name, fault="text") if has_text else name


def _take_joints_from_cells(names: list[ColumnName], log: NamedLog) -> None:
    """Name the joints of numbered columns, where columns name0, name1 and so on hold the joints' names."""
    naming = {k: n.number for k, n in enumerate(names) if n.role == "names" and n.number is not None}
    cells = {k: cell for k in naming for cell in reversed(log.table.head(k)) if isinstance(cell, str)}
    if cells and isinstance(log.table, TextTable):
        log.table.require_constant(cells, or_empty=True)
    called = {naming[k]: words_in(cell) for k, cell in cells.items()}
    for k, name in enumerate(names):
        if name.role in ROLES and name.number in called:
            words = called[name.number]
            joint = log.joints.phrases.get(words)
            names[k] = replace(name, joint=joint, number=None, label=words if joint is None else ())


def _as_said(name: ColumnName, role: str, star: ColumnName) -> ColumnName:
    """A column by the user's pattern, whose star stands for the joint."""
    name = replace(name, joint=star.joint, number=star.number, label=star.label)
    return replace(name, role=role, rank=0, topic=(), key=(role, *star.label), fault="")


def _rivals(log: NamedLog, zero: Sequence[Family]) -> dict[MotionRole, list[Family]]:
    """Families of each role that its names prefer equally; none where the user names all columns, or none."""
    rivals: dict[MotionRole, list[Family]] = {}
    for role in ROLES:
        if role not in log.left_out and len(log.mapped.get(role, ())) < log.arm.n_joints:
            families = _preferred(log, role, rivals["q"][0] if "q" in rivals else None, zero)
            rivals |= {role: families} if families else {}
    return rivals


def _preferred(log: NamedLog, role: MotionRole, q: Family | None, zero: Sequence[Family]) -> list[Family]:
    """The preferred families of a role that have all joints; positions, and what the user names, must."""
    mapped = log.mapped.get(role, {})
    of_role = [family for family in log.families if family.name.role == role]
    if role != "q" and q is not None and role not in log.patterns:
        # Quantities of the positions' topic, measured or commanded like them.
        of_role = [
            family
            for family in of_role
            if ("q" in log.patterns or family.name.topic == q.name.topic)
            and (family.name.kind == "target") == (q.name.kind == "target")
        ]
    complete = [f for f in of_role if all(j in f.columns or j in mapped for j in range(log.arm.n_joints))]
    alive = [family for family in complete if family not in zero]
    if role == "q" or role in log.patterns or mapped:
        if not complete:
            raise absent(log, role, of_role)
        alive = alive or complete

    # Beside q, theta is something else; beside position it may be the angle.
    has_symbol = any(family.name.rank == 0 for family in alive)

    def preference(family: Family) -> tuple[object, ...]:
        """Kind of the positions; measured before what is not said; usual words; bare numbers."""
        name = family.name
        rank = 1 if name.rank < 2 or (name.rank == 2 and not has_symbol) else name.rank
        kind = ("measured", "", "target").index(name.kind)
        return q is not None and name.kind != q.name.kind, kind, rank, bool(name.label)

    best = min(map(preference, alive), default=())
    preferred = [family for family in alive if preference(family) == best]
    # The same names in two units, such as q0_deg and q0_rad, are the same angle.
    in_si = {family.name.key for family in preferred if family.is_si}
    return [family for family in preferred if family.is_si or family.name.key not in in_si]


def _choice(log: NamedLog, chosen: Mapping[MotionRole, Family], zero: Sequence[Family]) -> Choice:
    """The columns of the chosen families and of the user, and what is said of the others."""
    table, reading, arm = log.table, log.reading, log.arm
    time = time_columns(log)
    times = time.columns if time is not None else ()
    reasons = _why_unused(log, chosen, zero, times)
    uses = [
        ColumnUse(table.shown(k), "time" if k in times else "unused", why=w) for k, w in enumerate(reasons)
    ]
    columns: dict[MotionRole, list[int]] = {}
    for role in ROLES:
        if role not in chosen and role not in log.mapped:
            continue
        columns[role] = [_column(log, role, joint, chosen.get(role)) for joint in range(arm.n_joints)]
        for joint, column in enumerate(columns[role]):
            is_given = joint in log.mapped.get(role, ()) or role in log.patterns
            why, unit = "as given" if is_given else chosen[role].why, _unit_of(log, role, joint, column)
            uses[column] = ColumnUse(table.shown(column), role, arm.joints[joint].name, unit, why)
    if log.has_currents and "torque" not in columns:
        raise no_currents(log)
    planned = table.planned
    if planned is None:
        kinds = {role: family.name.kind for role, family in chosen.items()}
        has_plans_qdd = "qdd" in columns and kinds.get("qdd") != "measured"
        planned = are_of_set_points(table.names) or kinds.get("q") == "target" or has_plans_qdd
    measured = not planned if reading.measured is None else reading.measured
    exact = table.set_points and not measured and log.rate is None
    if exact and time is not None:
        why = "as in files of set points" if not log.time_unit else "as given"
        time = replace(time, unit=log.time_unit or "s", why=why)
    misfits = [k for k, use in enumerate(uses) if use.role == "unused" and log.names[k].role not in TIMED]
    if exact and not reading.map and misfits:
        kind = log.names[misfits[0]].role
        message = f"column {table.names[misfits[0]]} does not fit arm {arm.name}"
        expected = f"{kind}1..{kind}{arm.n_joints}, or no {kind} at all"
        step = "choose the arm of this file, or complete the columns"
        raise refusal(message, table.where(None, misfits[0]), expected, listed_names(table.names), step)
    remarks = remarks_on(log, chosen, zero)
    if measured and "torque" not in columns and "torque" not in log.left_out:
        remarks += unknown_torques(log, [k for k, use in enumerate(uses) if use.role != "unused"])
    return Choice(columns, tuple(uses), time, log.rate, measured, exact, remarks)


def _column(log: NamedLog, role: MotionRole, joint: int, family: Family | None) -> int:
    """The column of a joint, as the user or the chosen family says."""
    if joint in log.mapped.get(role, ()) or family is None:
        return log.mapped[role][joint]
    columns, table, name = family.columns[joint], log.table, log.arm.joints[joint].name
    if len(columns) == 1:
        return columns[0]
    candidates = listed_names([f"{table.names[c]} (column {c + 1})" for c in columns])
    step = f"choose: {' or '.join(argument('map', f'{role}:{name}=#{c + 1}') for c in columns[:4])}"
    message = f"{len(columns)} columns hold {role} of {name}"
    raise refusal(message, table.where(None, columns[1]), "one", candidates, step)


def _unit_of(log: NamedLog, role: str, index: int, column: int) -> str:
    """Unit that name or user state for a column of a joint; "" where neither does."""
    table, joint = log.table, log.arm.joints[index]
    revolute, stated = joint.kind == "revolute", log.names[column].unit
    if role in log.role_units and column not in log.units:
        # A unit given for all joints is that of those it fits, such as degrees of those that turn.
        return fitting_unit(log.role_units[role], role, revolute, log.has_currents) or ""
    unit = fitting_unit(stated, role, revolute, log.has_currents) if stated else ""
    if unit is not None:
        return unit
    message = f"column {table.names[column]} is in {stated}"
    units = units_of(role, revolute)
    another = argument("map", f"{role}:{joint.name}={table.names[column]}:{next(reversed(units))}")
    step = f"check its joint, as {joint.name} is {joint.kind}; {another} states another unit"
    if role == "torque" and stated in UNITS["current"]:
        step = "give `torque_constant`, too"
    raise refusal(message, table.where(None, column), ", ".join(units), stated, step)


def _require_one_role_each(choice: Choice, log: NamedLog) -> None:
    """Refuse a column of two roles."""
    roles = {column: ["time"] for column in (choice.time.columns if choice.time is not None else ())}
    for role, columns in choice.columns.items():
        for joint, column in zip(log.arm.joints, columns, strict=True):
            roles.setdefault(column, []).append(f"{role} {joint.name}")
    for column, claims in roles.items():
        if len(claims) > 1:
            message = f"column {log.table.shown(column)} is given two roles"
            where, step = f"map; {log.table.where(None, column)}", "`gd-analyze columns` shows the columns"
            raise refusal(message, where, "a column for each", " and ".join(claims), step)


def _why_unused(
    log: NamedLog, chosen: Mapping[MotionRole, Family], zero: Sequence[Family], times: Sequence[int]
) -> list[str]:
    """Why each column would be left out."""
    why = [_why_unclear(name, "another time" if times else "no time is needed") for name in log.names]
    for family in log.families:
        is_target = family.name.kind == "target" and "q" in chosen and chosen["q"].name.kind != "target"
        for column in family.all_columns:
            why[column] = "target; measured is used" if is_target else "of another family"
            why[column] = ZERO if family in zero and not is_target else why[column]
        for column in family.extra:
            why[column] = "of a joint that the arm lacks"
    return why


def _why_unclear(name: ColumnName, of_time: str) -> str:
    """Why a column is no quantity of the joints' motion, by its name."""
    if name.role in TIMED:
        return of_time
    if name.role == "names":
        return "names of joints"
    if name.fault:
        return "text, not numbers" if name.fault == "text" else name.fault
    if name.role == "current":
        way = "--map names them" if name.is_unclear else "--torque-constant makes torques of them"
        return f"{'perhaps ' if name.is_unclear else ''}currents; {way}"
    if name.is_unclear:
        return f"beside the joint, what {' '.join((*name.label, *name.topic)) or 'the rest'} means is unknown"
    return OTHER
