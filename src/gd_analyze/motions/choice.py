"""Which columns of a log are used for what: chosen by their names, by what the user says, or refused."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.joints import Family, families_of
from gd_analyze.motions.logged import Quantity
from gd_analyze.motions.meanings import meanings_of
from gd_analyze.motions.reading import ROLES, Reading
from gd_analyze.motions.refusals import ambiguous, no_positions
from gd_analyze.motions.remarks import left_over, renaming, standing_in, unused
from gd_analyze.motions.roles import Meaning, is_of_set_points, meaning_of
from gd_analyze.motions.said import columns_said, listed
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.text_table import TextTable, is_text
from gd_analyze.motions.time_axis import TimeColumns, time_columns
from gd_analyze.motions.units import TIME_UNITS, fitting_unit, units_of
from gd_analyze.motions.words import words_of
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python

_ORDER = {"measured": 0, "plain": 1, "target": 2}


@dataclass(frozen=True)
class Use:
    """A column that is used: its role, the joint from 0, the unit of its numbers, and why."""

    column: int
    role: Quantity
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
    meanings = meanings_of(table, arm, reading)
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
    told = [sentence for role in ("q",) if role in chosen for sentence in renaming(chosen[role])]
    told += left_over(chosen, arm, table)
    told += standing_in(families, chosen, zero, table)
    used = {use.column for use in uses}
    time = _time(table, meanings, said, reading)
    if set_points and not reading.asked and time is not None and isinstance(table, TextTable):
        time = replace(time, unit="s", why="as files of set points have it")
    return Choice(
        uses=tuple(uses),
        time=time,
        unused=unused(used, meanings, families, chosen, zero),
        measured=not planned if reading.measured is None else reading.measured,
        told=tuple(told),
        families=chosen,
    )


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
    role: Quantity,
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
        stand = [
            meaning.role in ("time", "sec", "nanosec", "index") and table.stands(k)
            for k, meaning in enumerate(meanings)
        ]
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
