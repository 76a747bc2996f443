"""Roles of a log's columns: chosen by their names and the user's options, or refused."""

from __future__ import annotations

import difflib
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.families import Family, TimeColumns, arms_numbers, families_of, time_columns
from gd_analyze.motions.reading import ROLES, MotionRole, Reading, refusal
from gd_analyze.motions.table import Columns, LogTable, Progress
from gd_analyze.motions.text import TextTable
from gd_analyze.motions.words import (
    Meaning,
    as_written,
    fitting_unit,
    is_of_set_points,
    known_joints,
    meaning_of,
    units_of,
    words_of,
)
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python
from gd_analyze.units import TIME_UNITS

_NONE = "none"
_ORDER = {"measured": 0, "plain": 1, "target": 2}
_PLURAL = {"q": "positions", "qd": "velocities", "qdd": "accelerations", "torque": "torques"}
_TIMED = ("time", "sec", "nanosec", "index")
# Most names listed in a message.
_MOST_LISTED_NAMES = 12

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


class AmbiguityError(TrajectoryError):
    """Several families fit equally; those that are 0 throughout may be left out in a second try."""

    families: tuple[Family, ...] = ()


@dataclass(frozen=True)
class _NamedLog:
    """A log with the meanings of its columns' names."""

    table: LogTable
    arm: RobotArm
    reading: Reading
    meanings: Sequence[Meaning]  # of its columns
    families: Sequence[Family]
    zero: frozenset[object]  # keys of families that are 0 throughout


def chosen_columns(
    table: LogTable, arm: RobotArm, reading: Reading, progress: Progress
) -> tuple[Choice, Columns]:
    """Choose columns and read them; choose again if those of a family are 0 throughout."""
    zero: frozenset[object] = frozenset()
    while True:
        try:
            outcome: Choice | AmbiguityError = _choose(table, arm, reading, zero)
        except AmbiguityError as error:
            outcome = error
        if isinstance(outcome, Choice):
            families = () if outcome.set_points else tuple(outcome.families.values())
            numbers, times = outcome.wanted
        else:
            families, times = outcome.families, ()
            numbers = sorted({column for family in families for column in family.all_columns})
        columns = table.read(numbers, times, progress)
        zero_keys: set[object] = set()
        if families:
            moving = {k for i, k in enumerate(numbers) if np.nan_to_num(columns.numbers[:, i]).any()}
            zero_keys = {family.key for family in families if not moving & set(family.all_columns)}
        if zero_keys <= zero:
            if isinstance(outcome, Choice):
                _require_one_role_each(outcome, table)
                return outcome, columns
            raise outcome
        zero |= zero_keys


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


def _choose(table: LogTable, arm: RobotArm, reading: Reading, zero: frozenset[object]) -> Choice:
    """Choose columns, or refuse; `zero` are the keys of families that are 0 throughout."""
    meanings = _meanings(table, arm, reading)
    plain = [name.strip().lower().removesuffix("_deg") for name in table.names]
    for k, name in enumerate(plain if table.set_points and not reading.map else ()):
        if name in plain[:k]:
            places = f"{table.names[k]} in column {k + 1}, {name} in column {plain.index(name) + 1}"
            raise refusal(f"column {name} is given twice", table.where(None, k), "one column", places)
    # In a file of set points q1 is the arm's first joint, whatever its name, with or without a header line.
    named = any(table.names) and all(is_of_set_points(name) for name in table.names if name)
    complete = sum(meaning.role == "q" for meaning in meanings) == arm.n_joints
    in_order = table.set_points or (named and complete)
    names = [str(k + 1) if in_order else joint.name for k, joint in enumerate(arm.joints)]
    log = _NamedLog(table, arm, reading, meanings, families_of(meanings, names, table.names), zero)
    mapped = _mapped(table, arm, reading)
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
        raise refusal(message, where, expected, _listed(table.names), step)
    return Choice(tuple(uses), time, unused, measured, exact, tuple(_remarks(log, chosen)), chosen)


def _meanings(table: LogTable, arm: RobotArm, reading: Reading) -> list[Meaning]:
    """Meanings of the columns' names; columns of text and those not asked for have none."""
    joints = known_joints([joint.name for joint in arm.joints])
    for role, log_name in reading.map:
        if role.startswith("joint:"):
            joint = _joint_named(role.removeprefix("joint:"), arm)
            joints = {words: k for words, k in joints.items() if k != joint} | {words_of(log_name): joint}
    named = tuple(name or "-" for name in table.names) == reading.columns  # for a file without a header
    only = set() if named else set(reading.columns)
    for name in sorted(only - set(table.names)):
        raise _no_column(name, table, "--columns")
    meanings = []
    for k, name in enumerate(table.names):
        meaning = meaning_of(name, joints) if name and (not only or name in only) else Meaning("other")
        unit, role = meaning.unit, meaning.role
        if role in ROLES:
            fits = not unit or any(fitting_unit(unit, role, revolute) for revolute in (True, False))
        else:
            fits = role != "time" or unit in ("", *TIME_UNITS)
        text = role in (*ROLES, "time") and {type(cell) for cell in table.head(k)} == {str}
        meanings.append(meaning if fits and not text else Meaning("other", unit=unit))
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
    return meanings


def _mapped(table: LogTable, arm: RobotArm, reading: Reading) -> dict[tuple[str, int], int]:
    """Columns named by the user, by role and joint; joint -1 for a role to leave out."""
    mapped: dict[tuple[str, int], int] = {}
    for role, column in reading.map:
        quantity, colon, joint = role.partition(":")
        if quantity == "joint" and colon:
            continue
        if quantity not in (*ROLES, "time") or ((quantity == "time") == bool(colon) and column != _NONE):
            expected = "time, joint:JOINT, or q:JOINT, qd:JOINT, qdd:JOINT, torque:JOINT; or qd=none"
            message = f"{quantity} of which joint?" if quantity in ROLES else f"unknown role {role!r}"
            raise refusal(message, "--map", expected, f"{role}={column}")
        if column == _NONE and quantity != "q":
            mapped[quantity, -1] = -1
        else:
            mapped[quantity, _joint_named(joint, arm) if colon else 0] = _column_named(column, table)
    return mapped


def _joint_named(name: str, arm: RobotArm) -> int:
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
        raise _no_column(column, table, "--map")
    if len(matches) > 1:
        numbers, step = ", ".join(f"#{k + 1}" for k in matches), f"give its number: #{matches[0] + 1}"
        raise refusal(f"{len(matches)} columns are named {column}", "--map", "one column", numbers, step)
    return matches[0]


def _no_column(column: str, table: LogTable, where: str) -> TrajectoryError:
    near = difflib.get_close_matches(column, table.names, n=3)
    place, expected = f"{where}; {table.where()}", f"a name, or a number from #1 to #{len(table.names)}"
    step = f"did you mean {' or '.join(near)}?" if near else "check the name"
    return refusal(f"the log has no column {column!r}", place, expected, _listed(table.names), step)


def _listed(names: Sequence[str]) -> str:
    """Names as one line of a message; only the first of many."""
    names = [name for name in names if name]
    first = ", ".join(names[:_MOST_LISTED_NAMES]) or "columns without names"
    return first if len(names) <= _MOST_LISTED_NAMES else f"{first}, ... ({len(names)})"


def _family(log: _NamedLog, role: str, q: Family | None, column_of_joint: Mapping[int, int]) -> Family | None:
    """Choose the family of a role; positions are required."""
    words = [word for phrase in log.reading.words_for(role) for word in words_of(phrase)]
    of_role = [f for f in log.families if f.role == role and all(word in f.words for word in words)]
    if role != "q" and q is not None and not words:
        # Quantities of the positions' topic, measured or commanded like them, are preferred.
        commanded = q.kind == "target"
        of_role = [f for f in of_role if f.topic == q.topic and (f.kind == "target") == commanded]
    complete = [
        f for f in of_role if all(j in f.columns or j in column_of_joint for j in range(log.arm.n_joints))
    ]
    alive = [family for family in complete if family.key not in log.zero]
    if not complete and role == "q":
        if column_of_joint:
            raise _incomplete(log, role, column_of_joint)
        raise _no_positions(log, of_role, words)
    if not complete or (not alive and role != "q"):
        return None

    def preference(family: Family) -> tuple[int, ...]:
        other_group = 0 if q is None else int(family.group != q.group)
        return other_group, _ORDER[family.kind], family.rank, int(bool(family.label))

    best = min(map(preference, alive or complete))
    choices = [family for family in alive or complete if preference(family) == best]
    if len(choices) > 1:
        raise _ambiguous(role, choices, log.table)
    return choices[0]


def _incomplete(log: _NamedLog, role: str, column_of_joint: Mapping[int, int]) -> TrajectoryError:
    """Error for a role of which the user named the columns of some joints only."""
    names = [joint.name for joint in log.arm.joints]
    mapped_names = ", ".join(names[joint] for joint in sorted(column_of_joint))
    lacking = next(name for joint, name in enumerate(names) if joint not in column_of_joint)
    expected, step = f"a column for each joint, {lacking} too", f"add --map '{role}:{lacking}=COLUMN'"
    return refusal(f"{role} is given for some joints only", "--map", expected, mapped_names, step)


def _uses(
    log: _NamedLog, role: MotionRole, family: Family | None, column_of_joint: Mapping[int, int]
) -> list[tuple[int, ColumnUse]]:
    table, uses = log.table, []
    for index, joint in enumerate(log.arm.joints):
        columns = family.columns.get(index, ()) if family is not None else ()
        if index in column_of_joint:
            column, why = column_of_joint[index], "as given"
        elif not columns or family is None:
            raise _incomplete(log, role, column_of_joint)
        elif len(columns) > 1:
            message = f"{len(columns)} columns hold {role} of {joint.name}"
            where = table.where(None, columns[1])
            candidates = _listed([f"{table.names[c]} (column {c + 1})" for c in columns])
            pairs = (_map_option(f"{role}:{joint.name}=#{c + 1}") for c in columns[:4])
            step = f"choose: {' or '.join(pairs)}"
            raise refusal(message, where, "one", candidates, step)
        else:
            column, why = columns[0], family.why
        stated_unit, is_revolute = log.meanings[column].unit, joint.kind == "revolute"
        if not stated_unit:
            degrees = log.reading.degrees and is_revolute and role != "torque"
            stated_unit = "deg" if degrees else next(iter(units_of(role, is_revolute)))
        unit = fitting_unit(stated_unit, role, is_revolute)
        if unit is None:
            message = f"column {table.names[column]} is in {stated_unit}"
            expected = ", ".join(units_of(role, is_revolute))
            another = f"--map '{role}:{joint.name}=COLUMN' names another"
            step = f"check its joint, as {joint.name} is {joint.kind}; {another}"
            raise refusal(message, table.where(None, column), expected, stated_unit, step)
        uses.append((column, ColumnUse(table.shown(column), role, joint.name, unit, why)))
    return uses


def _time(log: _NamedLog, mapped: Mapping[tuple[str, int], int]) -> TimeColumns | None:
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
                message = f"the time in column {name} is text, which is not read as instants"
                raise refusal(message, table.where(None, k), expected, in_python(cells[0]), step)
        message = "no column is recognized as time"
        raise refusal(message, table.where(), expected, _listed(table.names), step)
    return time


def _unused(log: _NamedLog, used: set[int], chosen: Mapping[str, Family]) -> dict[int, str]:
    """Why each of the other columns is left out."""
    why = {}
    for column, meaning in enumerate(log.meanings):
        if column not in used and meaning.role not in _TIMED:
            why[column] = "names of joints" if meaning.role == "name" else "no quantity of the joints' motion"
    for family in log.families:
        reason = "0 throughout" if family.key in log.zero else "of another family"
        if family.kind == "target" and "q" in chosen and chosen["q"].kind != "target":
            reason = "target; measured is used"
        why |= dict.fromkeys(set(family.all_columns) - used, reason)
        if family.why != "by name":
            why |= dict.fromkeys(set(family.extra) - used, "of a joint that the arm lacks")
    return why


def _map_option(pair: str) -> str:
    """Option that can be pasted into a shell."""
    return f"--map {shlex.quote(pair)}"


def _remarks(log: _NamedLog, chosen: Mapping[str, Family]) -> list[str]:
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
        remarks.append(f"{matched}; {_map_option(f'joint:{arm_name}={log_name}')} {changes}")
    counts = arms_numbers([joint.name for joint in log.arm.joints])
    if q is not None and not q.label and q.why.startswith("by number") and counts is not None:
        astray = next((k for k, number in enumerate(counts[1]) if number != sorted(counts[1])[k]), None)
        if astray is not None:
            column, joint = log.table.names[q.columns[astray][0]], log.arm.joints[astray].name
            remarks.append(f"{column} is used for {joint}, joint {astray + 1} of the chain; check the order")
    # An arm selected from a longer chain may count like the log.
    is_picked = counts is not None and max(counts[1]) - min(counts[1]) >= log.arm.n_joints
    if q is not None and q.extra and q.why.startswith("by number") and not is_picked:
        left_out = _listed([log.table.names[k] for k in q.extra])
        logged = f"{len(q.columns) + len(q.extra)} joints logged"
        check = f"left out: {left_out}; check that the log belongs to this arm"
        remarks.append(f"{logged}, {log.arm.n_joints} in arm {log.arm.name}; {check}")
    for role, family in chosen.items():
        zero_families = [
            f for f in log.families if f.role == role and f.key in log.zero and f.key != family.key
        ]
        if zero_families:
            first = ", ".join(log.table.names[min(f.all_columns)] for f in zero_families)
            source = log.table.names[min(family.all_columns)]
            remarks.append(f"{first} ... are 0 throughout; {_PLURAL[role]} taken from {source} ...")
    return remarks


def _ambiguous(role: str, choices: Sequence[Family], table: LogTable) -> AmbiguityError:
    shared = frozenset.intersection(*(family.words for family in choices))
    words = []
    for family in choices[:6]:
        distinct_words = sorted(family.words - shared, key=lambda word: (word in (*_ORDER, ""), word))
        words += distinct_words[:1] if distinct_words and distinct_words[0] else []
    for_role = "" if role == "q" else f"{role}="
    options = [f"--family {for_role}{word}" for word in words]
    choose_by = " or ".join(options) or "--columns with the names to use"
    message, step = f"several columns may be the {_PLURAL[role]}", f"choose: {choose_by}"
    candidates = "; ".join(f"{table.names[min(family.all_columns)]} and so on" for family in choices[:6])
    expected = "one column per joint"
    error = AmbiguityError(message, where=table.where(), expected=expected, found=candidates, next_step=step)
    error.families = tuple(choices)
    return error


def _no_positions(log: _NamedLog, of_role: Sequence[Family], words: Sequence[str]) -> TrajectoryError:
    """Error for a log whose positions are not those of all the arm's joints."""
    table, arm = log.table, log.arm
    names = [joint.name for joint in arm.joints]
    if words and not of_role and any(family.role == "q" for family in log.families):
        family_words = sorted({word for f in log.families if f.role == "q" for word in f.words if word})
        message = f"no positions are of family {' '.join(words)}"
        step = "give one of these words with --family"
        return refusal(message, table.where(), ", ".join(family_words), " ".join(words), step)
    if of_role:
        nearest = max(of_role, key=lambda family: len(family.columns))
        missing = [name for j, name in enumerate(names) if j not in nearest.columns]
        used_names = [table.names[c] for c in nearest.all_columns]
        remaining_names = [name for name in table.names if name and name not in used_names]
        message, expected = f"the log has no position of joint {', '.join(missing)}", ", ".join(names)
        listed = _listed(used_names) + (f"; also {_listed(remaining_names)}" if remaining_names else "")
        step = f"--map 'q:{missing[0]}=COLUMN' names a column, or choose the log's arm"
        return refusal(message, table.where(), f"positions of all joints: {expected}", listed, step)
    strangers = {
        as_written(meaning.token, name) if meaning.label else name: None
        for meaning, name in zip(log.meanings, table.names, strict=True)
        if meaning.role == "q" and meaning.token and meaning.joint is None
    }
    if strangers:
        message, listed = f"the log's joints are not those of arm {arm.name}", _listed(list(strangers))
        if len(strangers) == arm.n_joints:
            pairs = (
                _map_option(f"joint:{arm_name}={log_name}")
                for arm_name, log_name in zip(names, strangers, strict=True)
            )
            step = f"if these are the same joints in this order: {' '.join(pairs)}"
        else:
            step = f"--map 'joint:{names[0]}=NAME' for every joint, with its name in the log"
        return refusal(message, table.where(), ", ".join(names), listed, step)
    message, step = "no column is recognized as a joint position", f"--map 'q:{names[0]}=COLUMN' and so on"
    expected = f"names such as q1, joint_1, actual_q_0, or those of the arm's joints: {', '.join(names)}"
    return refusal(message, table.where(), expected, _listed(table.names), f"name the columns: {step}")
