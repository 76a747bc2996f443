"""Roles of a log's columns: chosen by their names and the user's options, or refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.motions.families import Family, TimeColumns, arms_numbers, families_of, time_columns
from gd_analyze.motions.mapping import (
    joint_named,
    listed_names,
    map_option,
    mapped_columns,
    no_column,
    patterns_given,
)
from gd_analyze.motions.missing import (
    ORDER,
    PLURAL,
    AmbiguityError,
    NamedLog,
    ambiguous,
    incomplete,
    lacking,
    no_currents,
    no_numbers,
    no_positions,
    unknown_torques,
)
from gd_analyze.motions.reading import ROLES, MotionRole, Reading, refusal
from gd_analyze.motions.table import Columns, LogTable
from gd_analyze.motions.text import TextTable
from gd_analyze.motions.words import (
    Meaning,
    fitting_unit,
    is_of_set_points,
    known_joints,
    meaning_by_pattern,
    meaning_of,
    units_of,
    words_of,
)
from gd_analyze.progress import Progress
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python
from gd_analyze.units import TIME_UNITS, UNITS

_TIMED = ("time", "sec", "nanosec", "index")
_ZERO = "0 throughout"
# Numbers of one quantity in two units agree to the digits with which logs are written.
_EQUAL_DIGITS = 1e-5
_SI = ("", "rad", "m", "N m", "N")

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

    uses: tuple[tuple[int, ColumnUse], ...]  # columns with a role, in the order of the joints
    time: TimeColumns | None  # column or columns of time; None if rows are counted
    unused: Mapping[int, str]  # reason for each unused column
    measured: bool  # whether these are readings
    set_points: bool = False  # whether the rows are set points, used unchanged
    remarks: tuple[str, ...] = ()  # warnings
    families: Mapping[str, Family] = field(default_factory=dict)  # the families chosen, by role

    @property
    def wanted(self) -> tuple[list[int], tuple[int, ...]]:
        """Columns to read as numbers, and as instants; instants of set points are plain numbers."""
        columns = {column for column, _ in self.uses}
        times = self.time.columns if self.time is not None else ()
        return (sorted({*columns, *times}), ()) if self.set_points else (sorted(columns), times)


def chosen_columns(
    table: LogTable, arm: RobotArm, reading: Reading, progress: Progress
) -> tuple[Choice, Columns]:
    """Choose columns and read them; choose again without families that are 0 throughout or given twice."""
    left_out: dict[object, str] = {}
    while True:
        try:
            outcome: Choice | AmbiguityError = _choose(table, arm, reading, left_out)
        except AmbiguityError as error:
            outcome = error
        if isinstance(outcome, Choice):
            families = () if outcome.set_points else tuple(outcome.families.values())
            numbers, times = outcome.wanted
        else:
            families, times = outcome.families, ()
            numbers = sorted({column for family in families for column in family.all_columns})
        columns = table.read(numbers, times, progress)
        moving = {k for i, k in enumerate(numbers) if np.nan_to_num(columns.numbers[:, i]).any()}
        # Where no row can be read, numbers say nothing of a family; `log_of` names the cell.
        judged = families if len(columns.wrong) < len(columns.numbers) else ()
        reasons: dict[object, str] = {f.key: _ZERO for f in judged if not moving & set(f.all_columns)}
        if not isinstance(outcome, Choice) and not reasons:
            reasons = _given_twice(families, arm, dict(zip(numbers, columns.numbers.T, strict=True)), table)
        if reasons.keys() <= left_out.keys():
            if isinstance(outcome, Choice):
                _require_one_role_each(outcome, table)
                return outcome, columns
            raise outcome
        left_out |= reasons


def _given_twice(
    families: Sequence[Family], arm: RobotArm, numbers: Mapping[int, FloatArray], table: LogTable
) -> dict[object, str]:
    """Families with the numbers of another, maybe in another unit, such as degrees beside radians.

    Of these the one in SI units stays, else the first.
    """

    def in_si(family: Family) -> FloatArray | None:
        """Numbers, (n, N); None where their units are not known."""
        sizes = []
        for joint in arm.joints:
            units = units_of(family.role, joint.kind == "revolute")
            unit = fitting_unit(family.unit or next(iter(units)), family.role, joint.kind == "revolute")
            sizes.append(np.nan if unit is None else units[unit])
        columns = [columns[0] for _, columns in sorted(family.columns.items())]
        return None if np.isnan(sizes).any() else np.array([numbers[c] for c in columns]) * np.c_[sizes]

    first, *others = sorted(families, key=lambda family: family.unit.partition("/")[0] not in _SI)
    values, same = in_si(first), f"the same as {table.names[first.all_columns[0]]} ..."
    if values is None:
        return {}
    tolerance = _EQUAL_DIGITS * float(np.nanmax(np.abs(values), initial=0.0))
    copies: dict[object, str] = {}
    for family in others:
        other = in_si(family)
        if other is not None and np.allclose(other, values, rtol=0.0, atol=tolerance, equal_nan=True):
            copies[family.key] = same
    return copies


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


def _choose(table: LogTable, arm: RobotArm, reading: Reading, left_out: Mapping[object, str]) -> Choice:
    """Choose columns, or refuse; `left_out` are the keys of families that their numbers leave out."""
    mapped, units = mapped_columns(table, arm, reading)
    meanings = _meanings(table, arm, reading)
    for column, unit in units.items():
        meanings[column] = replace(meanings[column], unit=unit)
    plain = [name.strip().lower().removesuffix("_deg") for name in table.names]
    first_of: dict[str, int] = {}
    for k, name in enumerate(plain if table.set_points and not reading.map else ()):
        if first_of.setdefault(name, k) < k:
            places = f"{table.names[k]} in column {k + 1}, {name} in column {first_of[name] + 1}"
            raise refusal(f"column {name} is given twice", table.where(None, k), "one column", places)
    # In a file of set points q1 is the arm's first joint, whatever its name, with or without a header line.
    named = any(table.names) and all(is_of_set_points(name) for name in table.names if name)
    complete = sum(meaning.role == "q" for meaning in meanings) == arm.n_joints
    in_order = table.set_points or (named and complete)
    names = [str(k + 1) if in_order else joint.name for k, joint in enumerate(arm.joints)]
    families = families_of(meanings, names, table.names)
    patterned = frozenset(pattern.role for pattern in patterns_given(table, reading))
    log = NamedLog(table, arm, reading, meanings, families, patterned, left_out)
    chosen: dict[str, Family] = {}
    uses: list[tuple[int, ColumnUse]] = []
    for role in ROLES:
        column_of_joint = {
            joint: column for (mapped_role, joint), column in mapped.items() if mapped_role == role
        }
        if -1 in column_of_joint:
            continue
        is_complete = len(column_of_joint) >= arm.n_joints
        family = None if is_complete else _family(log, role, chosen.get("q"), column_of_joint)
        if family is not None:
            chosen[role] = family
        if family is not None or column_of_joint:
            uses += _uses(log, role, family, column_of_joint)
    roles = {use.role for _, use in uses}
    if reading.torque_constant is not None and "torque" not in roles:
        raise no_currents(log)
    kinds = {role: family.kind for role, family in chosen.items()}
    planned = table.planned
    if planned is None:
        planned = named or kinds.get("qdd") == "plain" or kinds.get("q") == "target"
    measured = not planned if reading.measured is None else reading.measured
    time = _time(log, mapped)
    exact = table.set_points and not measured and reading.rate is None
    if exact and time is not None:
        why = "as in files of set points" if reading.time_unit is None else "as given"
        time = replace(time, unit=reading.time_unit or "s", why=why)
    unused = _unused(log, {column for column, _ in uses}, chosen)
    if exact and unused and not (reading.columns or reading.map or reading.family):
        column = min(unused)
        kind = plain[column].rstrip("0123456789")
        message = f"column {table.names[column]} does not fit arm {arm.name}"
        where = table.where(None, column)
        expected = f"{kind}1..{kind}{arm.n_joints}, or no {kind} at all"
        step = "choose the arm of this file, or complete the columns"
        raise refusal(message, where, expected, listed_names(table.names), step)
    remarks = _remarks(log, chosen)
    if measured and "torque" not in roles and ("torque", -1) not in mapped:
        remarks += unknown_torques(log, {column for column, _ in uses})
    return Choice(tuple(uses), time, unused, measured, exact, tuple(remarks), chosen)


def _meanings(table: LogTable, arm: RobotArm, reading: Reading) -> list[Meaning]:
    """Meanings of the columns' names; columns of text and those not asked for have none."""
    joints = known_joints([joint.name for joint in arm.joints])
    known = {word for joint in arm.joints for word in words_of(joint.name) if len(word) > 1}
    for role, log_name in reading.map:
        if role.startswith("joint:"):
            joint = joint_named(role.removeprefix("joint:"), arm)
            joints = {words: k for words, k in joints.items() if k != joint} | {words_of(log_name): joint}
    named = tuple(name or "-" for name in table.names) == reading.columns  # for a file without a header
    only = set() if named else set(reading.columns)
    for name in sorted(only - set(table.names)):
        raise no_column(name, table, "--columns")
    meanings = []
    for k, name in enumerate(table.names):
        asked = name and (not only or name in only)
        meaning = meaning_of(name, joints, known) if asked else Meaning("other")
        unit, role = meaning.unit, meaning.role
        if role in ROLES:
            currents = reading.torque_constant is not None
            fits = not unit or any(fitting_unit(unit, role, kind, currents) for kind in (True, False))
        else:
            fits = role != "time" or unit in ("", *TIME_UNITS)
        text = role in (*ROLES, "time") and {type(cell) for cell in table.head(k)} == {str}
        if not fits or text:
            meaning = Meaning("other", unit=unit, word=role, rejected="text" if text else "unit")
        meanings.append(meaning)
    # Columns name0, name1 and so on hold the joints' names of the numbered columns.
    naming = [
        k for k, meaning in enumerate(meanings) if meaning.role == "name" and meaning.number is not None
    ]
    cells = {k: cell for k in naming for cell in reversed(table.head(k)) if isinstance(cell, str)}
    if cells and isinstance(table, TextTable):
        table.require_constant(cells, or_empty=True)
    labels = {meanings[k].number: words_of(text) for k, text in cells.items()}
    for k, meaning in enumerate(meanings):
        label = labels.get(meaning.number)
        if meaning.role in ROLES and label is not None and meaning.joint is None:
            meanings[k] = replace(meaning, token=() if label in joints else label, joint=joints.get(label))
    patterns = [(pattern, pattern.columns(table)) for pattern in patterns_given(table, reading)]
    for pattern, stars in patterns:
        if not stars:
            raise no_column(pattern.text, table, "--map")
    replaced = {pattern.role for pattern, _ in patterns}
    meanings = [Meaning("other", unit=m.unit) if m.role in replaced else m for m in meanings]
    for pattern, stars in patterns:
        for k, star in stars.items():
            if meanings[k].role in _TIMED:
                continue
            unit = pattern.unit or meanings[k].unit
            meanings[k] = meaning_by_pattern(pattern.role, pattern.text, star, unit, joints)
    return meanings


def _family(log: NamedLog, role: str, q: Family | None, column_of_joint: Mapping[int, int]) -> Family | None:
    """Choose the family of a role; positions are required."""
    words = [word for phrase in log.reading.words_for(role) for word in words_of(phrase)]
    of_role = [f for f in log.families if f.role == role and all(word in f.words for word in words)]
    if role != "q" and q is not None and not words and role not in log.patterned:
        # Quantities of the positions' topic, measured or commanded like them, are preferred.
        commanded = q.kind == "target"
        any_topic = "q" in log.patterned
        of_role = [
            f for f in of_role if (any_topic or f.topic == q.topic) and (f.kind == "target") == commanded
        ]
    complete = [
        f for f in of_role if all(j in f.columns or j in column_of_joint for j in range(log.arm.n_joints))
    ]
    alive = [family for family in complete if family.key not in log.left_out]
    if not complete and (role == "q" or role in log.patterned):
        if column_of_joint:
            raise incomplete(log, role, column_of_joint)
        texts = log.rejected(role, "text")
        if texts:
            raise no_numbers(log.table, texts[0])
        raise lacking(log, role, of_role) if of_role else no_positions(log, words)
    if not complete or (not alive and role != "q" and role not in log.patterned):
        return None

    def preference(family: Family) -> tuple[int, ...]:
        other_group = 0 if q is None else int(family.group != q.group)
        return other_group, ORDER[family.kind], family.rank, int(bool(family.label))

    best = min(map(preference, alive or complete))
    choices = [family for family in alive or complete if preference(family) == best]
    if len(choices) > 1:
        raise ambiguous(role, choices, log.table)
    return choices[0]


def _uses(
    log: NamedLog, role: MotionRole, family: Family | None, column_of_joint: Mapping[int, int]
) -> list[tuple[int, ColumnUse]]:
    table, uses = log.table, []
    for index, joint in enumerate(log.arm.joints):
        columns = family.columns.get(index, ()) if family is not None else ()
        if index in column_of_joint:
            column, why = column_of_joint[index], "as given"
        elif not columns or family is None:
            raise incomplete(log, role, column_of_joint)
        elif len(columns) > 1:
            message = f"{len(columns)} columns hold {role} of {joint.name}"
            where = table.where(None, columns[1])
            candidates = listed_names([f"{table.names[c]} (column {c + 1})" for c in columns])
            pairs = (map_option(f"{role}:{joint.name}=#{c + 1}") for c in columns[:4])
            step = f"choose: {' or '.join(pairs)}"
            raise refusal(message, where, "one", candidates, step)
        else:
            column, why = columns[0], "as given" if role in log.patterned else family.why
        stated_unit, is_revolute = log.meanings[column].unit, joint.kind == "revolute"
        if not stated_unit:
            degrees = log.reading.degrees and is_revolute and role != "torque"
            stated_unit = "deg" if degrees else next(iter(units_of(role, is_revolute)))
        currents = log.reading.torque_constant is not None
        unit = fitting_unit(stated_unit, role, is_revolute, currents)
        if unit is None and role == "torque" and stated_unit in UNITS["current"]:
            message, expected = (
                f"column {table.names[column]} is in {stated_unit}",
                "the joint's torque per ampere",
            )
            step = f"--torque-constant LIST, {log.arm.n_joints} numbers with commas, or --map torque=none"
            raise refusal(message, table.where(None, column), expected, stated_unit, step)
        if unit is None:
            message = f"column {table.names[column]} is in {stated_unit}"
            expected = ", ".join(units_of(role, is_revolute))
            another = f"--map '{role}:{joint.name}=COLUMN' names another"
            step = f"check its joint, as {joint.name} is {joint.kind}; {another}"
            raise refusal(message, table.where(None, column), expected, stated_unit, step)
        uses.append((column, ColumnUse(table.shown(column), role, joint.name, unit, why)))
    return uses


def _time(log: NamedLog, mapped: Mapping[tuple[str, int], int]) -> TimeColumns | None:
    """Column of time; None where rows are counted."""
    table = log.table
    if ("time", 0) in mapped:
        unit = log.meanings[mapped["time", 0]].unit
        return TimeColumns((mapped["time", 0],), unit if unit in TIME_UNITS else "", "as given")
    time, stand = None, [False] * len(table.names)
    if ("time", -1) not in mapped:
        stand = [meaning.role in _TIMED and table.stands(k) for k, meaning in enumerate(log.meanings)]
        time = time_columns(table.names, log.meanings, stand, table.where())
    if time is None and log.reading.rate is None:
        if any(stand):
            column = stand.index(True)
            cell = table.head(column)[0]
            stamp = f"{cell:.10g}" if isinstance(cell, float) else str(cell)
            message = f"all rows at one instant: {table.names[column]} does not change"
            expected = "stamps that increase"
            step = "write its stamps with all digits, or give the samples per second with --rate HZ"
            raise refusal(message, table.where(None, column), expected, stamp, step)
        step = "name it with --map time=COLUMN, or give the samples per second with --rate HZ"
        expected = "a column such as time, timestamp or header.stamp, in numbers"
        for k, name in enumerate(table.names):
            cells = table.head(k)
            if meaning_of(name, {}).role == "time" and any(isinstance(cell, str) for cell in cells):
                message = f"the time in column {name} is text that is not read as instants"
                expected = "numbers, or dates and times such as 2025-03-04T10:20:30.016Z or 10:20:30.016"
                raise refusal(message, table.where(None, k), expected, in_python(cells[0]), step)
        message = "no column is recognized as time"
        raise refusal(message, table.where(), expected, listed_names(table.names), step)
    return time


def _unused(log: NamedLog, used: set[int], chosen: Mapping[str, Family]) -> dict[int, str]:
    """Why each of the other columns is left out."""
    why: dict[int, str] = {}
    for column, meaning in enumerate(log.meanings):
        if column not in used and meaning.role not in _TIMED:
            why[column] = _why_unused(meaning)
    for family in log.families:
        reason = log.left_out.get(family.key, "of another family")
        if family.kind == "target" and "q" in chosen and chosen["q"].kind != "target":
            reason = "target; measured is used"
        why |= dict.fromkeys(set(family.all_columns) - used, reason)
        if family.why != "by name":
            why |= dict.fromkeys(set(family.extra) - used, "of a joint that the arm lacks")
    return why


def _why_unused(meaning: Meaning) -> str:
    """Why a column is no quantity of the joints' motion, by its name."""
    if meaning.role == "name":
        return "names of joints"
    if meaning.rejected == "text":
        return "text, not numbers"
    if meaning.rejected == "unit":
        return f"in {meaning.unit}, no unit of {meaning.word}"
    if meaning.unknown and (meaning.joint is not None or meaning.number is not None):
        return f"beside the joint, what {' '.join(meaning.unknown)} means is unknown"
    return "no quantity of the joints' motion"


def _remarks(log: NamedLog, chosen: Mapping[str, Family]) -> list[str]:
    """Warnings of joints under other names or of another arm, and of columns that are 0 throughout."""
    remarks = []
    q = chosen.get("q")
    if q is not None and q.renamed:
        (log_name, arm_name), *_ = q.renamed
        if len(q.renamed) == 1:
            matched, changes = f"{log_name} is taken for {arm_name}, the only other joint", "confirms it"
        else:
            matched = f"joints matched by number, as their names differ: {log_name} is {arm_name}"
            matched, changes = f"{matched} ... {' is '.join(q.renamed[-1])}", "and so on changes this"
        remarks.append(f"{matched}; {map_option(f'joint:{arm_name}={log_name}')} {changes}")
    counts = arms_numbers([joint.name for joint in log.arm.joints])
    if q is not None and not q.label and q.why.startswith("by number") and counts is not None:
        astray = next((k for k, number in enumerate(counts[1]) if number != sorted(counts[1])[k]), None)
        if astray is not None:
            column, joint = log.table.names[q.columns[astray][0]], log.arm.joints[astray].name
            remarks.append(f"{column} is used for {joint}, joint {astray + 1} of the chain; check the order")
    # An arm selected from a longer chain may count like the log.
    is_picked = counts is not None and max(counts[1]) - min(counts[1]) >= log.arm.n_joints
    if q is not None and q.extra and q.why.startswith("by number") and not is_picked:
        left_out = listed_names([log.table.names[k] for k in q.extra])
        logged = f"{len(q.columns) + len(q.extra)} joints logged"
        check = f"left out: {left_out}; check that the log belongs to this arm"
        remarks.append(f"{logged}, {log.arm.n_joints} in arm {log.arm.name}; {check}")
    for role, family in chosen.items():
        for reason in dict.fromkeys(log.left_out.values()):
            keys = {key for key in log.left_out if log.left_out[key] == reason} - {family.key}
            others = [f for f in log.families if f.role == role and f.key in keys]
            if others:
                first = ", ".join(log.table.names[min(f.all_columns)] for f in others)
                source = log.table.names[min(family.all_columns)]
                remarks.append(f"{first} ... are {reason}; {PLURAL[role]} taken from {source} ...")
    return remarks
