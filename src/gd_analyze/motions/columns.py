"""Roles of a log's columns: the family of each quantity that its names prefer, or what the user says."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from gd_analyze.motions.column_units import fitting_unit, units_of
from gd_analyze.motions.families import Family, Numbering, families_of
from gd_analyze.motions.instants import TimeColumns, time_columns
from gd_analyze.motions.mapping import ColumnMap, listed_names, map_option
from gd_analyze.motions.names import (
    OTHER,
    TIMED,
    ColumnName,
    JointNames,
    are_of_set_points,
    column_name,
)
from gd_analyze.motions.not_understood import (
    PLURAL,
    NamedLog,
    ambiguous,
    incomplete,
    lacking,
    no_currents,
    no_numbers,
    no_positions,
    said_of,
    unknown_torques,
)
from gd_analyze.motions.reading import ROLES, MotionRole, Reading, refusal
from gd_analyze.motions.table import Columns, LogTable
from gd_analyze.motions.text import TextTable
from gd_analyze.motions.vocabulary import words_in
from gd_analyze.progress import Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.units import TIME_UNITS, UNITS

_ZERO = "0 throughout"

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

    uses: tuple[tuple[int, ColumnUse], ...]  # with a role, by joint; without a unit where none is stated
    time: TimeColumns | None  # column or columns of time; None if rows are counted
    rate: float | None  # samples per second, where the user gives it
    unused: Mapping[int, str]  # reason for each unused column
    measured: bool  # whether these are readings
    set_points: bool  # whether the rows are set points, used unchanged
    remarks: tuple[str, ...]  # warnings

    @property
    def wanted(self) -> tuple[list[int], tuple[int, ...]]:
        """Columns to read as numbers, and as instants; instants of set points are plain numbers."""
        columns = {column for column, _ in self.uses}
        times = self.time.columns if self.time is not None else ()
        return (sorted({*columns, *times}), ()) if self.set_points else (sorted(columns), times)


def chosen_columns(
    table: LogTable, arm: RobotArm, reading: Reading, progress: Progress
) -> tuple[Choice, Columns]:
    """Choose columns and read them; choose again without families that are 0 throughout."""
    log = _named(table, arm, reading)
    zero: list[Family] = []
    while True:
        rivals = {role: families for role, families in _rivals(log, zero).items() if families}
        choice = _choice(log, {role: families[0] for role, families in rivals.items()}, zero)
        numbers, times = choice.wanted
        every = [family for families in rivals.values() for family in families]
        others = [family for families in rivals.values() for family in families[1:]]
        numbers = sorted({*numbers, *(column for family in others for column in family.all_columns)})
        columns = table.read(numbers, times, progress)
        moving = {k for i, k in enumerate(numbers) if np.nan_to_num(columns.numbers[:, i]).any()}
        resting = [family for family in every if family not in zero and not moving & {*family.all_columns}]
        # Where no row can be read, numbers say nothing of a family; `log_of` names the cell.
        if resting and not choice.set_points and len(columns.wrong) < len(columns.numbers):
            zero += resting
            continue
        for role, families in rivals.items():
            if len(families) > 1:
                raise ambiguous(role, families, log)
        _require_one_role_each(choice, table)
        return choice, columns


def _named(table: LogTable, arm: RobotArm, reading: Reading) -> NamedLog:
    """The names of the columns, read for the arm and as the user says, and their families."""
    given = ColumnMap.of(table, arm, reading)
    # In a file of set points q1 is the arm's first joint, whatever its name.
    in_order = are_of_set_points(table.names)
    arm_names = [str(k + 1) if in_order else joint.name for k, joint in enumerate(arm.joints)]
    joints = JointNames.as_given(given.joints) if given.joints else JointNames.of(arm_names)
    names = [_judged(column_name(text, joints), table, k, reading) for k, text in enumerate(table.names)]
    names = _with_joints_in_cells(names, table, joints)
    for column, unit in given.units.items():
        names[column] = replace(names[column], unit=unit, fault="")
    families = families_of(
        {k: name for k, name in enumerate(names) if name.role not in given.patterns}, arm_names
    )
    for role, starred in given.patterns.items():
        patterned = {k: _as_said(names[k], role, column_name(star, joints)) for k, star in starred.items()}
        families += families_of({k: name for k, name in patterned.items() if name.role == role}, arm_names)
    return NamedLog(table, arm, reading, given, names, families, arm_names)


def _judged(name: ColumnName, table: LogTable, column: int, reading: Reading) -> ColumnName:
    """No quantity where the cells are text; currents are torques where the user says what they give."""
    if name.role == "current" and reading.torque_constant is not None:
        name = replace(name, role="torque", rank=1, unit=name.unit or "A")
    elif name.role == "torque" and name.unit in UNITS["current"] and reading.torque_constant is None:
        name = replace(name, fault=f"in {name.unit}, no unit of torque")
    if name.role == "time" and name.unit not in ("", *TIME_UNITS):
        name = replace(name, role="other")
    has_text = name.role in (*ROLES, "time") and {type(cell) for cell in table.head(column)} == {str}
    return replace(name, fault="text") if has_text else name


def _with_joints_in_cells(names: list[ColumnName], table: LogTable, joints: JointNames) -> list[ColumnName]:
    """Joints of numbered columns, where columns name0, name1 and so on hold the joints' names."""
    naming = {
        k: name.number for k, name in enumerate(names) if name.role == "names" and name.number is not None
    }
    cells = {k: cell for k in naming for cell in reversed(table.head(k)) if isinstance(cell, str)}
    if not cells:
        return names
    if isinstance(table, TextTable):
        table.require_constant(cells, or_empty=True)
    called = {naming[k]: cell for k, cell in cells.items()}

    def named(name: ColumnName) -> ColumnName:
        if name.role not in ROLES or name.number not in called:
            return name
        words = words_in(called[name.number])
        joint = joints.phrases.get(words)
        return replace(name, joint=joint, number=None, label=words if joint is None else ())

    return [named(name) for name in names]


def _as_said(name: ColumnName, role: str, star: ColumnName) -> ColumnName:
    """A column by the user's pattern, whose star stands for the joint; the time stays the time."""
    if name.role in TIMED:
        return name
    name = replace(name, joint=star.joint, number=star.number, label=star.label)
    return replace(name, role=role, rank=0, topic=(), key=(role, *star.label), fault="")


def _rivals(log: NamedLog, zero: Sequence[Family]) -> dict[str, list[Family]]:
    """Families of each role that its names prefer equally; none where the user names all columns, or none."""
    rivals: dict[str, list[Family]] = {}
    for role in ROLES:
        if role not in log.given.left_out and len(log.given.columns_of(role)) < log.arm.n_joints:
            rivals[role] = _preferred(log, role, next(iter(rivals.get("q", ())), None), zero)
    return rivals


def _preferred(log: NamedLog, role: MotionRole, q: Family | None, zero: Sequence[Family]) -> list[Family]:
    """The preferred families of a role that have all joints; positions, and what the user names, must."""
    patterned, mapped = role in log.given.patterns, log.given.columns_of(role)
    of_role = [family for family in log.families if family.role == role]
    if role != "q" and q is not None and not patterned:
        # Quantities of the positions' topic, measured or commanded like them.
        of_role = [
            family
            for family in of_role
            if ("q" in log.given.patterns or family.topic == q.topic)
            and (family.kind == "target") == (q.kind == "target")
        ]
    complete = [f for f in of_role if all(j in f.columns or j in mapped for j in range(log.arm.n_joints))]
    alive = [family for family in complete if family not in zero]
    if not complete and (role == "q" or patterned or mapped):
        raise _absent(log, role, of_role)
    if role == "q" or patterned:
        alive = alive or complete

    def preference(family: Family) -> tuple[object, ...]:
        return (q is not None and family.kind != q.kind, *family.preference)

    best = min(map(preference, alive), default=())
    preferred = [family for family in alive if preference(family) == best]
    # The same names in two units, such as q0_deg and q0_rad, are the same angle.
    in_si = {family.key for family in preferred if family.is_si}
    return [family for family in preferred if family.is_si or family.key not in in_si]


def _absent(log: NamedLog, role: MotionRole, of_role: Sequence[Family]) -> Exception:
    if log.given.columns_of(role):
        return incomplete(log, role)
    text = [k for k, name in enumerate(log.names) if name.role == role and name.fault == "text"]
    if text:
        return no_numbers(log.table, text[0])
    return lacking(log, role, of_role) if of_role else no_positions(log)


def _choice(log: NamedLog, chosen: Mapping[str, Family], zero: Sequence[Family]) -> Choice:
    """The columns of the chosen families and of the user, and what is said of the others."""
    table, reading, given = log.table, log.reading, log.given
    named = table.set_points and not reading.map
    uses = [use for role in ROLES for use in _uses(log, role, chosen.get(role))]
    roles = {use.role for _, use in uses}
    if reading.torque_constant is not None and "torque" not in roles:
        raise no_currents(log)
    planned = table.planned
    if planned is None:
        kinds = {role: family.kind for role, family in chosen.items()}
        has_plans_qdd = "qdd" in roles and kinds.get("qdd") != "measured"
        planned = are_of_set_points(table.names) or kinds.get("q") == "target" or has_plans_qdd
    measured = not planned if reading.measured is None else reading.measured
    time = time_columns(table, log.names, given)
    exact = table.set_points and not measured and given.rate is None
    if exact and time is not None:
        why = "as in files of set points" if not given.time_unit else "as given"
        time = replace(time, unit=given.time_unit or "s", why=why)
    unused = _unused(log, {column for column, _ in uses}, chosen, zero)
    if exact and named and unused:
        column = min(unused)
        kind = log.names[column].role
        message = f"column {table.names[column]} does not fit arm {log.arm.name}"
        expected = f"{kind}1..{kind}{log.arm.n_joints}, or no {kind} at all"
        step = "choose the arm of this file, or complete the columns"
        raise refusal(message, table.where(None, column), expected, listed_names(table.names), step)
    remarks = _remarks(log, chosen, zero)
    if measured and "torque" not in roles and "torque" not in given.left_out:
        remarks += unknown_torques(log, {column for column, _ in uses})
    return Choice(tuple(uses), time, given.rate, unused, measured, exact, tuple(remarks))


def _uses(log: NamedLog, role: MotionRole, family: Family | None) -> list[tuple[int, ColumnUse]]:
    """The columns of a role, in the order of the joints."""
    table, mapped, uses = log.table, log.given.columns_of(role), []
    if family is None and not mapped:
        return []
    for index, joint in enumerate(log.arm.joints):
        columns = family.columns.get(index, ()) if family is not None else ()
        if index in mapped:
            column, why = mapped[index], "as given"
        elif family is None or not columns:
            raise incomplete(log, role)
        elif len(columns) > 1:
            message = f"{len(columns)} columns hold {role} of {joint.name}"
            candidates = listed_names([f"{table.names[c]} (column {c + 1})" for c in columns])
            pairs = (map_option(f"{role}:{joint.name}=#{c + 1}") for c in columns[:4])
            step = f"choose: {' or '.join(pairs)}"
            raise refusal(message, table.where(None, columns[1]), "one", candidates, step)
        else:
            column, why = columns[0], "as given" if role in log.given.patterns else family.why
        unit = _unit_of(log, role, index, column)
        uses.append((column, ColumnUse(table.shown(column), role, joint.name, unit, why)))
    return uses


def _unit_of(log: NamedLog, role: MotionRole, index: int, column: int) -> str:
    """Unit that name or user state for a column of a joint; "" where neither does."""
    table, joint = log.table, log.arm.joints[index]
    revolute, currents = joint.kind == "revolute", log.reading.torque_constant is not None
    stated = log.names[column].unit
    if role in log.given.role_units and column not in log.given.units:
        # A unit given for all joints is that of those it fits, such as degrees of those that turn.
        return fitting_unit(log.given.role_units[role], role, revolute, currents) or ""
    unit = fitting_unit(stated, role, revolute, currents) if stated else ""
    if unit is not None:
        return unit
    message = f"column {table.names[column]} is in {stated}"
    if role == "torque" and stated in UNITS["current"]:
        step = f"--torque-constant LIST, {log.arm.n_joints} numbers with commas, or --map torque=none"
        raise refusal(message, table.where(None, column), "the joint's torque per ampere", stated, step)
    another = f"--map '{role}:{joint.name}=COLUMN' names another"
    step = f"check its joint, as {joint.name} is {joint.kind}; {another}"
    raise refusal(message, table.where(None, column), ", ".join(units_of(role, revolute)), stated, step)


def _require_one_role_each(choice: Choice, table: LogTable) -> None:
    """Refuse a column of two roles."""
    times = choice.time.columns if choice.time else ()
    used = dict.fromkeys(times, ColumnUse("", "time"))
    for column, use in choice.uses:
        if column in used:
            roles = " and ".join(f"{claim.role} {claim.joint}".strip() for claim in (used[column], use))
            where, step = f"--map; {table.where(None, column)}", "`gd-analyze columns` shows the columns"
            raise refusal(f"column {use.column} is given two roles", where, "a column for each", roles, step)
        used[column] = use


def _unused(
    log: NamedLog, used: set[int], chosen: Mapping[str, Family], zero: Sequence[Family]
) -> dict[int, str]:
    """Why each of the other columns is left out."""
    why = {
        column: _why_unused(name)
        for column, name in enumerate(log.names)
        if column not in used and name.role not in TIMED
    }
    for family in log.families:
        reason = _ZERO if family in zero else "of another family"
        if family.kind == "target" and "q" in chosen and chosen["q"].kind != "target":
            reason = "target; measured is used"
        why |= dict.fromkeys({*family.all_columns} - used, reason)
        if family.why != "by name":
            why |= dict.fromkeys({*family.extra} - used, "of a joint that the arm lacks")
    return why


def _why_unused(name: ColumnName) -> str:
    """Why a column is no quantity of the joints' motion, by its name."""
    if name.role == "names":
        return "names of joints"
    if name.fault:
        return "text, not numbers" if name.fault == "text" else name.fault
    if name.role == "current":
        return "currents; --torque-constant makes torques of them"
    if name.is_unclear:
        return f"beside the joint, what {' '.join((*name.label, *name.topic)) or 'the rest'} means is unknown"
    return OTHER


def _remarks(log: NamedLog, chosen: Mapping[str, Family], zero: Sequence[Family]) -> list[str]:
    """Warnings of joints under other names or of another arm, and of columns that are 0 throughout."""
    remarks = []
    q, names, arm = chosen.get("q"), log.table.names, log.arm
    renamed = [] if q is None else [pair for pair in q.renamed if pair[0] not in log.given.columns_of("q")]
    if q is not None and renamed:
        pairs = [f"{names[column]} is {arm.joints[joint].name}" for joint, column in renamed]
        if len(renamed) == 1:
            ((rail, only),) = renamed
            option = map_option(f"q:{arm.joints[rail].name}={names[only]}")
            remarks.append(f"{pairs[0]}, the only other joint; {option} confirms it")
        else:
            matched = f"joints matched by number, as their names differ: {pairs[0]} ... {pairs[-1]}"
            remarks.append(f"{matched}; {map_option(said_of('q', q, log))} confirms it")
    numbering = Numbering.of([joint.name for joint in arm.joints])
    if q is not None and not q.label and q.why.startswith("by number") and numbering.label is not None:
        numbers = {joint: number for number, joint in numbering.joints.items()}
        counts = [numbers[k] for k in range(arm.n_joints)] if not numbering.partial else []
        astray = next((k for k, number in enumerate(counts) if number != sorted(counts)[k]), None)
        if astray is not None:
            column, joint = names[q.columns[astray][0]], arm.joints[astray].name
            remarks.append(f"{column} is used for {joint}, joint {astray + 1} of the chain; check the order")
    # An arm selected from a longer chain may count like the log.
    counts = [*numbering.joints] if numbering.label is not None and not numbering.partial else [0]
    is_picked = max(counts) - min(counts) >= arm.n_joints
    if q is not None and q.extra and q.why.startswith("by number") and not is_picked:
        logged = f"{len(q.columns) + len(q.extra)} joints logged"
        check = (
            f"left out: {listed_names([names[k] for k in q.extra])}; check that the log belongs to this arm"
        )
        remarks.append(f"{logged}, {arm.n_joints} in arm {arm.name}; {check}")
    for role, family in chosen.items():
        others = [other for other in zero if other.role == role and other is not family]
        if others:
            first = ", ".join(names[min(other.all_columns)] for other in others)
            source = names[min(family.all_columns)]
            remarks.append(f"{first} ... are {_ZERO}; {PLURAL[role]} taken from {source} ...")
        same = [other for other in log.families if other.key == family.key and other.unit != family.unit]
        if same:
            first, source = names[min(same[0].all_columns)], names[min(family.all_columns)]
            remarks.append(f"{first} ... are the same as {source} ... in another unit, and are not read")
    return remarks
