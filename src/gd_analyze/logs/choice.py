"""Which columns of a log are used for what: chosen by their names, by what the user says, or refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from gd_analyze.errors import TrajectoryError
from gd_analyze.logs.joints import Family, arms_numbers, families_of
from gd_analyze.logs.reading import ROLES, Reading
from gd_analyze.logs.refusals import PLURAL, ambiguous, no_positions
from gd_analyze.logs.roles import Meaning, is_of_set_points, known_joints, meaning_of
from gd_analyze.logs.said import columns_said, joint_named, listed, no_column
from gd_analyze.logs.table import LogTable
from gd_analyze.logs.text_table import TextTable, is_text
from gd_analyze.logs.time_axis import TimeColumns, time_columns
from gd_analyze.logs.units import TIME_UNITS, fitting_unit, units_of
from gd_analyze.logs.words import words_of
from gd_analyze.robots import RobotArm
from gd_analyze.visible import in_python

_ORDER = {"measured": 0, "plain": 1, "target": 2}


@dataclass(frozen=True)
class Use:
    """A column that is used: its role, the joint from 0, the unit of its numbers, and why."""

    column: int
    role: str
    joint: int
    unit: str
    why: str


@dataclass(frozen=True)
class Choice:
    """What is used of a log.

    Parameters
    ----------
    uses
        Columns of joints.
    time
        Column or columns of time; None where rows are counted.
    unused
        Per column that is left out, why.
    measured
        Whether these are readings.
    told
        Sentences to warn with.
    families
        The families chosen, by role.
    """

    uses: tuple[Use, ...]
    time: TimeColumns | None
    unused: Mapping[int, str]
    measured: bool
    told: tuple[str, ...] = ()
    families: Mapping[str, Family] | None = None

    def of(self, role: str) -> tuple[Use, ...]:
        """Columns of a role, in the order of the joints."""
        return tuple(sorted((use for use in self.uses if use.role == role), key=lambda use: use.joint))


def choose(table: LogTable, arm: RobotArm, reading: Reading, zero: frozenset[object] = frozenset()) -> Choice:
    """Choose columns.

    Parameters
    ----------
    table
        The log.
    arm
        Whose joints these are.
    reading
        What the user says.
    zero
        Keys of families that are 0 throughout.

    Raises
    ------
    TrajectoryError
        If the names do not tell, or tell of other joints than the arm's; the message lists the choices.
    """
    names = [joint.name for joint in arm.joints]
    meanings = _meanings(table, arm, reading)
    families = families_of(meanings, names, table.names)
    said = columns_said(table, arm, reading)
    chosen: dict[str, Family] = {}
    uses: list[Use] = []
    for role in ROLES:
        given = {joint: column for (of, joint), column in said.items() if of == role and joint >= 0}
        if (role, -1) in said:
            continue
        family = _family(role, families, chosen.get("q"), given, table, arm, reading, zero, meanings)
        if family is not None:
            chosen[role] = family
        if family is not None or given:
            uses += _uses(role, family, given, table, arm, reading, meanings)
    target = "q" in chosen and chosen["q"].kind == "target"
    accelerated = "qdd" in chosen and chosen["qdd"].kind == "plain"
    set_points = any(table.names) and all(is_of_set_points(name) for name in table.names if name)
    planned = target or accelerated or set_points if table.planned is None else table.planned
    told = [sentence for role in ("q",) if role in chosen for sentence in _renaming(chosen[role])]
    told += _left_over(chosen, arm, table)
    told += _standing_in(families, chosen, zero, table)
    used = {use.column for use in uses}
    time = _time(table, meanings, said, reading)
    if set_points and not reading.asked and time is not None and isinstance(table, TextTable):
        time = replace(time, unit="s", why="as files of set points have it")
    return Choice(
        uses=tuple(uses),
        time=time,
        unused=_unused(used, meanings, families, chosen, zero),
        measured=not planned if reading.measured is None else reading.measured,
        told=tuple(told),
        families=chosen,
    )


def _meanings(table: LogTable, arm: RobotArm, reading: Reading) -> list[Meaning]:
    """What the columns' names say; text and columns not asked for say nothing."""
    known = known_joints([joint.name for joint in arm.joints])
    for role, other in reading.map:
        if role.startswith("joint:"):
            joint = joint_named(role.removeprefix("joint:"), arm)
            known = {words: k for words, k in known.items() if k != joint} | {words_of(other): joint}
    named = tuple(name or "-" for name in table.names) == reading.columns  # those of a file without a header
    only = set() if named else set(reading.columns)
    missing = only - set(table.names)
    if missing:
        raise no_column(sorted(missing)[0], table, "--columns")
    meanings = []
    for name in table.names:
        meaning = meaning_of(name, known) if name and (not only or name in only) else Meaning("other")
        if meaning.unit and meaning.role in ROLES:
            fits = any(fitting_unit(meaning.unit, meaning.role, turns) for turns in (True, False))
            meaning = meaning if fits else Meaning("other", unit=meaning.unit)
        if meaning.role == "time" and meaning.unit and meaning.unit not in TIME_UNITS:
            meaning = Meaning("other", unit=meaning.unit)
        meanings.append(meaning)
    return _without_text(_named_in_rows(meanings, table, known), table)


def _without_text(meanings: list[Meaning], table: LogTable) -> list[Meaning]:
    return [
        Meaning("other")
        if meaning.role in (*ROLES, "time") and is_text(table.head(k)) and not _some_numbers(table, k)
        else meaning
        for k, meaning in enumerate(meanings)
    ]


def _some_numbers(table: LogTable, column: int) -> bool:
    return any(isinstance(cell, float) for cell in table.head(column))


def _named_in_rows(
    meanings: list[Meaning], table: LogTable, known: Mapping[tuple[str, ...], int]
) -> list[Meaning]:
    """Give counted columns the joints' names where the log has columns name0, name1 and so on."""
    labels, cells = {}, {}
    for k, meaning in enumerate(meanings):
        if meaning.role == "name" and meaning.number is not None:
            text = next((cell for cell in table.head(k) if isinstance(cell, str)), None)
            if text is not None:
                labels[meaning.number], cells[k] = words_of(text), text
    if not labels:
        return meanings
    if isinstance(table, TextTable):  # of other tables in which text may change none is read
        table.require_constant(cells, or_empty=True)
    return [
        replace(
            meaning, token=() if labels[number] in known else labels[number], joint=known.get(labels[number])
        )
        if meaning.role in ROLES and (number := meaning.number) in labels and meaning.joint is None
        else meaning
        for meaning in meanings
    ]


def _family(
    role: str,
    families: Sequence[Family],
    q: Family | None,
    given: Mapping[int, int],
    table: LogTable,
    arm: RobotArm,
    reading: Reading,
    zero: frozenset[object],
    meanings: Sequence[Meaning],
) -> Family | None:
    """Choose the family of a role; of the positions one must be found, unless all are given."""
    if len(given) == arm.n_joints:
        return None
    words = [word for asked in reading.words_for(role) for word in words_of(asked)]
    of_role = [
        family for family in families if family.role == role and all(word in family.words for word in words)
    ]
    if role != "q" and q is not None:
        # Beside positions belong what is of the same source: of the same topic, and commanded as they are.
        of_role = [f for f in of_role if words or _are_of_one_source(f, q)]
    complete = [f for f in of_role if all(j in f.columns or j in given for j in range(arm.n_joints))]
    alive = [family for family in complete if family.key not in zero]
    if not complete or (not alive and role != "q"):
        if role == "q":
            raise no_positions(of_role, families, table, arm, meanings, words)
        return None
    ranked = alive or complete
    best = min(_preference(family, q) for family in ranked)
    choices = [family for family in ranked if _preference(family, q) == best]
    if len(choices) > 1:
        raise ambiguous(role, choices, table)
    return choices[0]


def _are_of_one_source(family: Family, q: Family) -> bool:
    return family.topic == q.topic and (family.kind == "target") == (q.kind == "target")


def _preference(family: Family, q: Family | None) -> tuple[int, ...]:
    beside = 0 if q is None else int(family.group != q.group)
    return beside, _ORDER[family.kind], family.rank, int(bool(family.label))


def _uses(
    role: str,
    family: Family | None,
    given: Mapping[int, int],
    table: LogTable,
    arm: RobotArm,
    reading: Reading,
    meanings: Sequence[Meaning],
) -> list[Use]:
    uses = []
    for joint, of in enumerate(arm.joints):
        if joint in given:
            column, why = given[joint], "as given"
        elif family is None:
            raise TrajectoryError(
                f"{role} is given of some joints only",
                where="--map",
                expected=f"a column for each joint, {role}:{of.name} too",
                found=", ".join(arm.joints[j].name for j in sorted(given)),
                next_step=f"add --map '{role}:{of.name}=COLUMN'",
            )
        else:
            columns, why = family.columns[joint], family.why
            if len(columns) > 1:
                twice = [f"{table.names[c]} (column {c + 1})" for c in columns]
                raise TrajectoryError(
                    f"{len(columns)} columns hold {role} of joint {of.name}",
                    where=table.where(None, columns[1]),
                    expected="one",
                    found=listed(twice),
                    next_step=f"choose: --map '{role}:{of.name}=#{columns[0] + 1}' or #{columns[1] + 1}",
                )
            column = columns[0]
        uses.append(
            Use(column, role, joint, _unit(role, meanings[column], of.kind, table, column, reading), why)
        )
    return uses


def _unit(role: str, meaning: Meaning, kind: str, table: LogTable, column: int, reading: Reading) -> str:
    turns = kind == "revolute"
    if meaning.unit:
        unit = fitting_unit(meaning.unit, role, turns)
        if unit is None:
            raise TrajectoryError(
                f"column {table.names[column]} is in {meaning.unit}, but its joint "
                + ("turns" if turns else "slides"),
                where=table.where(None, column),
                expected=", ".join(units_of(role, turns)),
                found=meaning.unit,
                next_step="check which joint it is of; --map names another column",
            )
        return unit
    if reading.degrees and turns and role != "torque":
        return {"q": "deg", "qd": "deg/s", "qdd": "deg/s^2"}[role]
    return next(iter(units_of(role, turns)))


def _time(
    table: LogTable, meanings: Sequence[Meaning], said: Mapping[tuple[str, int], int], reading: Reading
) -> TimeColumns | None:
    if ("time", -1) in said:
        found = None
    elif ("time", 0) in said:
        column = said["time", 0]
        unit = meanings[column].unit if meanings[column].unit in TIME_UNITS else ""
        found = TimeColumns((column,), unit, "as given")
    else:
        stand = [meaning.role in ("time", "sec", "nanosec", "index") and table.stands(k)
                 for k, meaning in enumerate(meanings)]  # fmt: skip
        found = time_columns(table.names, meanings, stand, table.where())
    if found is None and reading.rate is None:
        text = next((k for k, name in enumerate(table.names) if _is_time_of_text(name, table.head(k))), None)
        raise TrajectoryError(
            "no column is known to be the time"
            if text is None
            else f"the time in column {table.names[text]} is text, of which no instants are read",
            where=table.where(None, text),
            expected="a column such as time, timestamp or header.stamp, in numbers",
            found=listed([name for name in table.names if name]) or "columns without names"
            if text is None
            else in_python(table.head(text)[0]),
            next_step="name it with --map time=COLUMN, or give the samples per second with --rate HZ",
        )
    return found


def _is_time_of_text(name: str, cells: Sequence[str | float]) -> bool:
    return meaning_of(name, {}).role == "time" and is_text(cells)


def _renaming(family: Family) -> list[str]:
    if not family.renamed:
        return []
    log, own = family.renamed[0]
    pairs = f"{log} is {own}"
    if len(family.renamed) > 1:
        pairs += " and so on to " + " is ".join(family.renamed[-1])
    return [
        f"the log's joints are not called like the arm's and were matched by number: {pairs}; "
        f"--map joint:{own}={log} and so on matches them otherwise"
    ]


def _left_over(chosen: Mapping[str, Family], arm: RobotArm, table: LogTable) -> list[str]:
    """Say that a log counts more joints than the arm has: it may be of another arm."""
    family = chosen.get("q")
    if family is None or not family.extra or not family.why.startswith("by number"):
        return []
    counts = arms_numbers([joint.name for joint in arm.joints])
    if counts is not None and max(counts[1]) - min(counts[1]) >= arm.n_joints:
        return []  # an arm picked out of a longer chain counts as the log does
    return [
        f"it counts {len(family.columns) + len(family.extra)} joints, arm {arm.name} has {arm.n_joints}: "
        f"{listed([table.names[column] for column in family.extra])} left out; check that the log is of this arm"
    ]


def _standing_in(
    families: Sequence[Family], chosen: Mapping[str, Family], zero: frozenset[object], table: LogTable
) -> list[str]:
    """Say which columns are taken in the place of such that are 0 throughout."""
    told = []
    for role, family in chosen.items():
        dead = [of for of in families if of.role == role and of.key in zero and of.key != family.key]
        if dead:
            first = [table.names[min(of.all_columns)] for of in dead]
            told.append(
                f"{' and '.join(first)} and so on are 0 throughout; {PLURAL[role]} are taken from "
                f"{table.names[min(family.all_columns)]} and so on"
            )
    return told


def _unused(
    used: set[int],
    meanings: Sequence[Meaning],
    families: Sequence[Family],
    chosen: Mapping[str, Family],
    zero: frozenset[object],
) -> dict[int, str]:
    """Why each of the other columns is left out."""
    why = {}
    for column, meaning in enumerate(meanings):
        if column not in used and meaning.role not in ("time", "sec", "nanosec", "index"):
            why[column] = "names of joints" if meaning.role == "name" else "no quantity of the joints' motion"
    for family in families:
        reason = "0 throughout" if family.key in zero else "of another family"
        if family.kind == "target" and "q" in chosen and chosen["q"].kind != "target":
            reason = "target beside measured"
        for column in family.all_columns:
            if column not in used:
                why[column] = reason
        for column in family.extra:
            if column not in used:
                why[column] = (
                    "of a joint that the arm lacks" if family.why != "by name" else why.get(column, "")
                )
    return why
