"""Roles of a log's columns: chosen by their names and the user's options, or refused."""

from __future__ import annotations

import difflib
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.families import Family, TimeColumns, arms_numbers, families_of, time_columns
from gd_analyze.motions.logged import ColumnUse
from gd_analyze.motions.reading import ROLES, TIME_UNITS, Quantity, Reading, refusal
from gd_analyze.motions.roles import (
    Meaning,
    as_written,
    fitting_unit,
    is_of_set_points,
    known_joints,
    meaning_of,
    units_of,
    words_of,
)
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.text import TextTable
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python

_NONE = "none"
_ORDER = {"measured": 0, "plain": 1, "target": 2}
_PLURAL = {"q": "positions", "qd": "velocities", "qdd": "accelerations", "torque": "torques"}
_TIMED = ("time", "sec", "nanosec", "index")
# Most names listed in a message.
_MOST = 12


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
class _Log:
    """A log with the meanings of its columns' names."""

    table: LogTable
    arm: RobotArm
    reading: Reading
    meanings: Sequence[Meaning]  # of its columns
    families: Sequence[Family]
    zero: frozenset[object]  # keys of families that are 0 throughout


def choose(table: LogTable, arm: RobotArm, reading: Reading, zero: frozenset[object]) -> Choice:
    """Choose columns, or refuse; `zero` are the keys of families that are 0 throughout."""
    meanings = _meanings(table, arm, reading)
    plain = [name.strip().lower().removesuffix("_deg") for name in table.names]
    for k, name in enumerate(plain if table.set_points and not reading.map else ()):
        if name in plain[:k]:
            found = f"{table.names[k]} in column {k + 1}, {name} in column {plain.index(name) + 1}"
            raise refusal(f"column {name} is given twice", table.where(None, k), "one column", found)
    # In a file of set points q1 is the arm's first joint, whatever its name, with or without a header line.
    named = any(table.names) and all(is_of_set_points(name) for name in table.names if name)
    complete = sum(meaning.role == "q" for meaning in meanings) == arm.n_joints
    in_order = table.set_points or (named and complete)
    names = [str(k + 1) if in_order else joint.name for k, joint in enumerate(arm.joints)]
    log = _Log(table, arm, reading, meanings, families_of(meanings, names, table.names), zero)
    said = _said(table, arm, reading)
    chosen: dict[str, Family] = {}
    uses: list[tuple[int, ColumnUse]] = []
    for role in ROLES:
        given = {joint: column for (of, joint), column in said.items() if of == role}
        if -1 in given:
            continue
        family = _family(log, role, chosen.get("q"), given) if len(given) < arm.n_joints else None
        if family is not None:
            chosen[role] = family
        if family is not None or given:
            uses += _uses(log, role, family, given)
    kinds = {role: family.kind for role, family in chosen.items()}
    planned = table.planned
    if planned is None:
        planned = named or kinds.get("qdd") == "plain" or kinds.get("q") == "target"
    measured = not planned if reading.measured is None else reading.measured
    time = _time(log, said)
    exact = table.set_points and not measured and reading.rate is None
    if exact and time is not None:
        why = "as in files of set points" if reading.time_unit is None else "as given"
        time = replace(time, unit=reading.time_unit or "s", why=why)
    unused = _unused(log, {column for column, _ in uses}, chosen)
    if exact and unused and not (reading.columns or reading.map or reading.family):
        column = min(unused)
        kind = plain[column].rstrip("0123456789")
        what, where = f"column {table.names[column]} does not fit arm {arm.name}", table.where(None, column)
        expected = f"{kind}1..{kind}{arm.n_joints}, or no {kind} at all"
        step = "choose the arm of this file, or complete the columns"
        raise refusal(what, where, expected, _listed(table.names), step)
    return Choice(tuple(uses), time, unused, measured, exact, tuple(_remarks(log, chosen)), chosen)


def _meanings(table: LogTable, arm: RobotArm, reading: Reading) -> list[Meaning]:
    """Meanings of the columns' names; columns of text and those not asked for have none."""
    known = known_joints([joint.name for joint in arm.joints])
    for role, other in reading.map:
        if role.startswith("joint:"):
            joint = _joint_named(role.removeprefix("joint:"), arm)
            known = {words: k for words, k in known.items() if k != joint} | {words_of(other): joint}
    named = tuple(name or "-" for name in table.names) == reading.columns  # for a file without a header
    only = set() if named else set(reading.columns)
    for name in sorted(only - set(table.names)):
        raise _no_column(name, table, "--columns")
    meanings = []
    for k, name in enumerate(table.names):
        meaning = meaning_of(name, known) if name and (not only or name in only) else Meaning("other")
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
            meanings[k] = replace(meaning, token=() if label in known else label, joint=known.get(label))
    return meanings


def _said(table: LogTable, arm: RobotArm, reading: Reading) -> dict[tuple[str, int], int]:
    """Columns named by the user, by role and joint; joint -1 for a role to leave out."""
    said: dict[tuple[str, int], int] = {}
    for role, column in reading.map:
        of, colon, joint = role.partition(":")
        if of == "joint" and colon:
            continue
        if of not in (*ROLES, "time") or ((of == "time") == bool(colon) and column != _NONE):
            expected = "time, joint:JOINT, or q:JOINT, qd:JOINT, qdd:JOINT, torque:JOINT; or qd=none"
            what = f"{of} of which joint?" if of in ROLES else f"unknown role {role!r}"
            raise refusal(what, "--map", expected, f"{role}={column}")
        if column == _NONE and of != "q":
            said[of, -1] = -1
        else:
            said[of, _joint_named(joint, arm) if colon else 0] = column_named(column, table)
    return said


def _joint_named(name: str, arm: RobotArm) -> int:
    """Number, from 0, of the arm's joint given by name or by number from 1."""
    names = [joint.name for joint in arm.joints]
    if name in names:
        return names.index(name)
    if name.isascii() and name.isdigit() and 1 <= int(name[:9]) <= arm.n_joints:
        return int(name) - 1
    near = difflib.get_close_matches(name, names, n=1)
    expected = f"{', '.join(names)}, or a number from 1 to {arm.n_joints}"
    step = f"did you mean {near[0]}?" if near else "`gd-analyze arms ROBOT` lists the joints"
    raise refusal(f"arm {arm.name} has no joint {name!r}", "--map", expected, repr(name), step)


def column_named(column: str, table: LogTable, where: str = "--map") -> int:
    """Column given by name, or by #NUMBER from 1; TrajectoryError if there is none or several."""
    if column.startswith("#") and column[1:].isascii() and column[1:].isdigit() and len(column) < 8:
        number = int(column[1:])
        if 1 <= number <= len(table.names):
            return number - 1
    found = [k for k, name in enumerate(table.names) if name == column]
    if not found:
        raise _no_column(column, table, where)
    if len(found) > 1:
        numbers, step = ", ".join(f"#{k + 1}" for k in found), f"give its number: #{found[0] + 1}"
        raise refusal(f"{len(found)} columns are named {column}", where, "one column", numbers, step)
    return found[0]


def _no_column(column: str, table: LogTable, where: str) -> TrajectoryError:
    near = difflib.get_close_matches(column, table.names, n=3)
    place, expected = f"{where}; {table.where()}", f"a name, or a number from #1 to #{len(table.names)}"
    step = f"did you mean {' or '.join(near)}?" if near else "check the name"
    return refusal(f"the log has no column {column!r}", place, expected, _listed(table.names), step)


def _listed(names: Sequence[str]) -> str:
    """Names as one line of a message; only the first of many."""
    names = [name for name in names if name]
    first = ", ".join(names[:_MOST]) or "columns without names"
    return first if len(names) <= _MOST else f"{first}, ... ({len(names)})"


def _family(log: _Log, role: str, q: Family | None, given: Mapping[int, int]) -> Family | None:
    """Choose the family of a role; positions are required."""
    words = [word for asked in log.reading.words_for(role) for word in words_of(asked)]
    of_role = [f for f in log.families if f.role == role and all(word in f.words for word in words)]
    if role != "q" and q is not None and not words:
        # Quantities of the positions' topic, measured or commanded like them, are preferred.
        commanded = q.kind == "target"
        of_role = [f for f in of_role if f.topic == q.topic and (f.kind == "target") == commanded]
    complete = [f for f in of_role if all(j in f.columns or j in given for j in range(log.arm.n_joints))]
    alive = [family for family in complete if family.key not in log.zero]
    if not complete and role == "q":
        raise _incomplete(log, role, given) if given else _no_positions(log, of_role, words)
    if not complete or (not alive and role != "q"):
        return None

    def preference(family: Family) -> tuple[int, ...]:
        beside = 0 if q is None else int(family.group != q.group)
        return beside, _ORDER[family.kind], family.rank, int(bool(family.label))

    best = min(map(preference, alive or complete))
    choices = [family for family in alive or complete if preference(family) == best]
    if len(choices) > 1:
        raise _ambiguous(role, choices, log.table)
    return choices[0]


def _incomplete(log: _Log, role: str, given: Mapping[int, int]) -> TrajectoryError:
    """Error for a role of which the user named the columns of some joints only."""
    names = [joint.name for joint in log.arm.joints]
    found = ", ".join(names[joint] for joint in sorted(given))
    lacking = next(name for joint, name in enumerate(names) if joint not in given)
    expected, step = f"a column for each joint, {lacking} too", f"add --map '{role}:{lacking}=COLUMN'"
    return refusal(f"{role} is given for some joints only", "--map", expected, found, step)


def _uses(
    log: _Log, role: Quantity, family: Family | None, given: Mapping[int, int]
) -> list[tuple[int, ColumnUse]]:
    table, uses = log.table, []
    for joint, of in enumerate(log.arm.joints):
        columns = family.columns.get(joint, ()) if family is not None else ()
        if joint in given:
            column, why = given[joint], "as given"
        elif not columns or family is None:
            raise _incomplete(log, role, given)
        elif len(columns) > 1:
            what, where = f"{len(columns)} columns hold {role} of {of.name}", table.where(None, columns[1])
            found = _listed([f"{table.names[c]} (column {c + 1})" for c in columns])
            pairs = (_map(f"{role}:{of.name}=#{c + 1}") for c in columns[:4])
            step = f"choose: {' or '.join(pairs)}"
            raise refusal(what, where, "one", found, step)
        else:
            column, why = columns[0], family.why
        said, revolute = log.meanings[column].unit, of.kind == "revolute"
        if not said:
            degrees = log.reading.degrees and revolute and role != "torque"
            said = "deg" if degrees else next(iter(units_of(role, revolute)))
        unit = fitting_unit(said, role, revolute)
        if unit is None:
            what, expected = f"column {table.names[column]} is in {said}", ", ".join(units_of(role, revolute))
            another = f"--map '{role}:{of.name}=COLUMN' names another"
            step = f"check its joint, as {of.name} is {of.kind}; {another}"
            raise refusal(what, table.where(None, column), expected, said, step)
        uses.append((column, ColumnUse(table.shown(column), role, of.name, unit, why)))
    return uses


def _time(log: _Log, said: Mapping[tuple[str, int], int]) -> TimeColumns | None:
    """Column of time; None where rows are counted."""
    table = log.table
    if ("time", 0) in said:
        unit = log.meanings[said["time", 0]].unit
        return TimeColumns((said["time", 0],), unit if unit in TIME_UNITS else "", "as given")
    found, stand = None, [False] * len(table.names)
    if ("time", -1) not in said:
        stand = [meaning.role in _TIMED and table.stands(k) for k, meaning in enumerate(log.meanings)]
        found = time_columns(table.names, log.meanings, stand, table.where())
    if found is None and log.reading.rate is None:
        if any(stand):
            column = stand.index(True)
            cell = table.head(column)[0]
            stamp = f"{cell:.10g}" if isinstance(cell, float) else str(cell)
            what = f"all rows at one instant: {table.names[column]} does not change"
            expected = "stamps that increase"
            step = "write its stamps with all digits, or give the samples per second with --rate HZ"
            raise refusal(what, table.where(None, column), expected, stamp, step)
        step = "name it with --map time=COLUMN, or give the samples per second with --rate HZ"
        expected = "a column such as time, timestamp or header.stamp, in numbers"
        for k, name in enumerate(table.names):
            cells = table.head(k)
            if meaning_of(name, {}).role == "time" and any(isinstance(cell, str) for cell in cells):
                what = f"the time in column {name} is text, which is not read as instants"
                raise refusal(what, table.where(None, k), expected, in_python(cells[0]), step)
        what = "no column is recognized as time"
        raise refusal(what, table.where(), expected, _listed(table.names), step)
    return found


def _unused(log: _Log, used: set[int], chosen: Mapping[str, Family]) -> dict[int, str]:
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


def _map(pair: str) -> str:
    """Option that can be pasted into a shell."""
    return f"--map {shlex.quote(pair)}"


def _remarks(log: _Log, chosen: Mapping[str, Family]) -> list[str]:
    """Warnings of joints under other names or of another arm, and of columns that are 0 throughout."""
    remarks = []
    q = chosen.get("q")
    if q is not None and q.renamed:
        (other, own), *_ = q.renamed
        if len(q.renamed) == 1:
            matched, changes = f"{other} is taken for {own}, the only other joint", "confirms it"
        else:
            matched = f"joints matched by number, as their names differ: {other} is {own}"
            matched, changes = f"{matched} ... {' is '.join(q.renamed[-1])}", "and so on changes this"
        remarks.append(f"{matched}; {_map(f'joint:{own}={other}')} {changes}")
    counts = arms_numbers([joint.name for joint in log.arm.joints])
    if q is not None and not q.label and q.why.startswith("by number") and counts is not None:
        astray = next((k for k, number in enumerate(counts[1]) if number != sorted(counts[1])[k]), None)
        if astray is not None:
            column, joint = log.table.names[q.columns[astray][0]], log.arm.joints[astray].name
            remarks.append(f"{column} is used for {joint}, joint {astray + 1} of the chain; check the order")
    # An arm selected from a longer chain may count like the log.
    is_picked = counts is not None and max(counts[1]) - min(counts[1]) >= log.arm.n_joints
    if q is not None and q.extra and q.why.startswith("by number") and not is_picked:
        left = _listed([log.table.names[k] for k in q.extra])
        logged = f"{len(q.columns) + len(q.extra)} joints logged"
        check = f"left out: {left}; check that the log belongs to this arm"
        remarks.append(f"{logged}, {log.arm.n_joints} in arm {log.arm.name}; {check}")
    for role, family in chosen.items():
        dead = [of for of in log.families if of.role == role and of.key in log.zero and of.key != family.key]
        if dead:
            first = ", ".join(log.table.names[min(of.all_columns)] for of in dead)
            taken = log.table.names[min(family.all_columns)]
            remarks.append(f"{first} ... are 0 throughout; {_PLURAL[role]} taken from {taken} ...")
    return remarks


def _ambiguous(role: str, choices: Sequence[Family], table: LogTable) -> AmbiguityError:
    shared = frozenset.intersection(*(family.words for family in choices))
    words = []
    for family in choices[:6]:
        own = sorted(family.words - shared, key=lambda word: (word in (*_ORDER, ""), word))
        words += own[:1] if own and own[0] else []
    for_role = "" if role == "q" else f"{role}="
    options = [f"--family {for_role}{word}" for word in words]
    choose_by = " or ".join(options) or "--columns with the names to use"
    what, step = f"several columns may be the {_PLURAL[role]}", f"choose: {choose_by}"
    found = "; ".join(f"{table.names[min(family.all_columns)]} and so on" for family in choices[:6])
    expected = "one column per joint"
    error = AmbiguityError(what, where=table.where(), expected=expected, found=found, next_step=step)
    error.families = tuple(choices)
    return error


def _no_positions(log: _Log, of_role: Sequence[Family], words: Sequence[str]) -> TrajectoryError:
    """Error for a log whose positions are not those of all the arm's joints."""
    table, arm = log.table, log.arm
    names = [joint.name for joint in arm.joints]
    if words and not of_role and any(family.role == "q" for family in log.families):
        known = sorted({word for f in log.families if f.role == "q" for word in f.words if word})
        what, step = f"no positions are of family {' '.join(words)}", "give one of these words with --family"
        return refusal(what, table.where(), ", ".join(known), " ".join(words), step)
    if of_role:
        nearest = max(of_role, key=lambda family: len(family.columns))
        missing = [name for j, name in enumerate(names) if j not in nearest.columns]
        having = [table.names[c] for c in nearest.all_columns]
        others = [name for name in table.names if name and name not in having]
        what, expected = f"the log has no position of joint {', '.join(missing)}", ", ".join(names)
        found = f"{_listed(having)}; also {_listed(others)}" if others else _listed(having)
        step = f"--map 'q:{missing[0]}=COLUMN' names a column, or choose the log's arm"
        return refusal(what, table.where(), f"positions of all joints: {expected}", found, step)
    strangers = {
        as_written(meaning.token, name) if meaning.label else name: None
        for meaning, name in zip(log.meanings, table.names, strict=True)
        if meaning.role == "q" and meaning.token and meaning.joint is None
    }
    if strangers:
        what, found = f"the log's joints are not those of arm {arm.name}", _listed(list(strangers))
        if len(strangers) == arm.n_joints:
            pairs = (_map(f"joint:{own}={other}") for own, other in zip(names, strangers, strict=True))
            step = f"if these are the same joints in this order: {' '.join(pairs)}"
        else:
            step = f"--map 'joint:{names[0]}=NAME' for every joint, with its name in the log"
        return refusal(what, table.where(), ", ".join(names), found, step)
    what, step = "no column is recognized as a joint position", f"--map 'q:{names[0]}=COLUMN' and so on"
    expected = f"names such as q1, joint_1, actual_q_0, or those of the arm's joints: {', '.join(names)}"
    return refusal(what, table.where(), expected, _listed(table.names), f"name the columns: {step}")
