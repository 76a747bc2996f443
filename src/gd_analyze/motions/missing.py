"""What a log lacks: errors and warnings that list the columns in question, and the options that name them."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence, Set
from dataclasses import dataclass

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.families import Family, families_of
from gd_analyze.motions.mapping import listed_names, map_option
from gd_analyze.motions.reading import Reading, refusal
from gd_analyze.motions.table import LogTable
from gd_analyze.motions.words import (
    BLOCKED,
    CURRENTS,
    Meaning,
    as_written,
    known_joints,
    meaning_by_pattern,
    patterns_of,
    unit_in_words,
    units_of,
    words_of,
)
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python
from gd_analyze.units import UNITS

ORDER = {"measured": 0, "plain": 1, "target": 2}
PLURAL = {"q": "positions", "qd": "velocities", "qdd": "accelerations", "torque": "torques"}
_LACKED = {
    "q": "the log has no position of joint",
    "qd": "the log has no velocity of joint",
    "qdd": "the log has no acceleration of joint",
    "torque": "the log has no torque of joint",
}
# Most patterns of names listed in a message.
_MOST_CANDIDATES = 4


class AmbiguityError(TrajectoryError):
    """Several families fit equally; what their numbers say may leave one in a second try."""

    families: tuple[Family, ...] = ()


@dataclass(frozen=True)
class NamedLog:
    """A log with the meanings of its columns' names."""

    table: LogTable
    arm: RobotArm
    reading: Reading
    meanings: Sequence[Meaning]  # of its columns
    families: Sequence[Family]
    patterned: frozenset[str]  # roles that the user gives by a pattern
    left_out: Mapping[object, str]  # keys of families that their numbers leave out, with the reason

    def rejected(self, role: str, why: str) -> list[int]:
        """Columns with the name of a role that are rejected for their unit or their text."""
        return [
            k for k, meaning in enumerate(self.meanings) if (meaning.word, meaning.rejected) == (role, why)
        ]


def incomplete(log: NamedLog, role: str, column_of_joint: Mapping[int, int]) -> TrajectoryError:
    """Error for a role of which the user named the columns of some joints only."""
    names = [joint.name for joint in log.arm.joints]
    mapped_names = ", ".join(names[joint] for joint in sorted(column_of_joint))
    lacking = next(name for joint, name in enumerate(names) if joint not in column_of_joint)
    expected, step = f"a column for each joint, {lacking} too", f"add --map '{role}:{lacking}=COLUMN'"
    return refusal(f"{role} is given for some joints only", "--map", expected, mapped_names, step)


def _candidates(log: NamedLog, columns: Iterable[int]) -> list[str]:
    """Patterns that match a column of each of the arm's joints among these, at most a few."""
    arm, table = log.arm, log.table
    names = [joint.name for joint in arm.joints]
    joints = known_joints(names)
    stars_of: dict[str, dict[int, str]] = {}
    for k in columns:
        if any(isinstance(cell, str) for cell in table.head(k)):
            continue
        for pattern, star in patterns_of(table.names[k], joints):
            stars_of.setdefault(pattern, {})[k] = star
    patterns: dict[frozenset[int], str] = {}
    for pattern, stars in stars_of.items():
        if len(stars) >= arm.n_joints:
            meanings = [Meaning("other")] * len(table.names)
            for k, star in stars.items():
                meanings[k] = meaning_by_pattern("q", pattern, star, "", joints)
            families = families_of(meanings, names, table.names)
            if any(len(family.columns) == arm.n_joints for family in families):
                patterns.setdefault(frozenset(stars), pattern)
    return [*patterns.values()][:_MOST_CANDIDATES]


def _pattern_options(role: str, patterns: Sequence[str]) -> str:
    return " or ".join(map_option(f"{role}={pattern}") for pattern in patterns)


def _unknown_columns(log: NamedLog, known: Set[str]) -> list[int]:
    """Columns of no unit with unknown words beside the joint, and none of these that are known."""
    unknown = ((k, meaning.unknown) for k, meaning in enumerate(log.meanings) if not meaning.unit)
    return [k for k, words in unknown if words and not known & set(words)]


def unknown_torques(log: NamedLog, used: Collection[int]) -> list[str]:
    """A warning of unused columns that may be the torques that a recording lacks."""
    unknown = _unknown_columns(log, BLOCKED - CURRENTS)
    patterns = _candidates(log, [column for column in unknown if column not in used])
    listed, options = ", ".join(patterns), _pattern_options("torque", patterns)
    warning = f"no torques are read, and what {listed} is in the log is unknown; if torques: {options}"
    if any(CURRENTS & set(words_of(pattern)) for pattern in patterns):
        warning += ", of currents with --torque-constant LIST"
    if log.rejected("torque", "unit"):
        fault, step = _unit_not_read(log, "torque")
        warning, patterns = f"no torques are read: {fault}{f'; {step}' if step else ''}", ["any"]
    return [warning] if patterns else []


def _unit_not_read(log: NamedLog, role: str) -> tuple[str, str]:
    """Which column is in no unit of its role, and the option that states one where the unit is unknown."""
    columns = log.rejected(role, "unit")
    unit = log.meanings[columns[0]].unit
    units = [*units_of(role, log.arm.is_revolute[0])]
    fault = f"{log.table.names[columns[0]]} is in {unit}, no unit of {PLURAL[role]}"
    patterns = _candidates(log, columns) if unit_in_words(unit) in (None, "grad") else []
    options = _pattern_options(role, [f"{pattern}:{units[0]}" for pattern in patterns])
    if role == "torque" and unit in UNITS["current"]:
        return fault, f"--torque-constant LIST takes {log.arm.n_joints} joint torques per ampere"
    return fault, f"if this is {', '.join(units)}: {options}" if patterns else ""


def no_currents(log: NamedLog) -> TrajectoryError:
    """Error for torque constants of a log without columns of torque."""
    currents = [k for k, name in enumerate(log.table.names) if set(words_of(name)) & CURRENTS]
    patterns = _candidates(log, currents) or _candidates(log, _unknown_columns(log, BLOCKED - CURRENTS))
    step = _pattern_options("torque", patterns) or "--map torque:JOINT=COLUMN for every joint"
    message, expected = "no columns for the torque constants", "columns of torque or currents, one per joint"
    where = f"--torque-constant; {log.table.where()}"
    return refusal(message, where, expected, listed_names(log.table.names), f"name the currents: {step}")


def no_numbers(table: LogTable, column: int) -> TrajectoryError:
    """Error for a column with the name of a role whose cells are text."""
    message, cell = f"{table.label(column)} is not a number", in_python(table.head(column)[0])
    step = "correct the cells, or choose the columns with --map"
    return refusal(message, table.where(0, column), "numbers", cell, step)


def ambiguous(role: str, choices: Sequence[Family], table: LogTable) -> AmbiguityError:
    """Error for several families that fit a role equally well."""
    shared = frozenset.intersection(*(family.words for family in choices))
    words = []
    for family in choices[:6]:
        distinct_words = sorted(family.words - shared, key=lambda word: (word in (*ORDER, ""), word))
        words += distinct_words[:1] if distinct_words and distinct_words[0] else []
    for_role = "" if role == "q" else f"{role}="
    options = [f"--family {for_role}{word}" for word in words]
    choose_by = " or ".join(options) or "--columns with the names to use"
    message, step = f"several columns may be the {PLURAL[role]}", f"choose: {choose_by}"
    candidates = "; ".join(f"{table.names[min(family.all_columns)]} and so on" for family in choices[:6])
    expected = "one column per joint"
    error = AmbiguityError(message, where=table.where(), expected=expected, found=candidates, next_step=step)
    error.families = tuple(choices)
    return error


def lacking(log: NamedLog, role: str, of_role: Sequence[Family]) -> TrajectoryError:
    """Error for a quantity that is not given for all of the arm's joints."""
    table, arm = log.table, log.arm
    names = [joint.name for joint in arm.joints]
    nearest = max(of_role, key=lambda family: len(family.columns))
    missing = [name for j, name in enumerate(names) if j not in nearest.columns]
    used_names = [table.names[c] for c in nearest.all_columns]
    remaining_names = [name for name in table.names if name and name not in {*used_names}]
    message, expected = f"{_LACKED[role]} {', '.join(missing)}", ", ".join(names)
    listed = listed_names(used_names) + (f"; also {listed_names(remaining_names)}" if remaining_names else "")
    step = f"--map '{role}:{missing[0]}=COLUMN' names a column, or choose the log's arm"
    return refusal(message, table.where(), f"{PLURAL[role]} of all joints: {expected}", listed, step)


def no_positions(log: NamedLog, words: Sequence[str]) -> TrajectoryError:
    """Error for a log without positions."""
    table, arm = log.table, log.arm
    names = [joint.name for joint in arm.joints]
    if words and any(family.role == "q" for family in log.families):
        family_words = sorted({word for f in log.families if f.role == "q" for word in f.words if word})
        message = f"no positions are of family {' '.join(words)}"
        step = "give one of these words with --family"
        return refusal(message, table.where(), ", ".join(family_words), " ".join(words), step)
    strangers = {
        as_written(meaning.token, name) if meaning.label else name: None
        for meaning, name in zip(log.meanings, table.names, strict=True)
        if meaning.role == "q" and meaning.token and meaning.joint is None
    }
    if strangers:
        message, listed = f"the log's joints are not those of arm {arm.name}", listed_names(list(strangers))
        patterns = _candidates(log, [k for k, meaning in enumerate(log.meanings) if meaning.role == "q"])
        if patterns:
            step = f"if these are the arm's joints in order of number: {_pattern_options('q', patterns)}"
        elif len(strangers) == arm.n_joints:
            pairs = (
                map_option(f"joint:{arm_name}={log_name}")
                for arm_name, log_name in zip(names, strangers, strict=True)
            )
            step = f"if these are the same joints in this order: {' '.join(pairs)}"
        else:
            step = f"--map 'joint:{names[0]}=NAME' for every joint, with its name in the log"
        return refusal(message, table.where(), ", ".join(names), listed, step)
    message = "no column is recognized as a joint position"
    expected = f"names such as q1, joint_1, actual_q_0, or those of the arm's joints: {', '.join(names)}"
    patterns = _candidates(log, _unknown_columns(log, BLOCKED))
    step = f"name the columns: --map 'q:{names[0]}=COLUMN' and so on"
    if not patterns and log.rejected("q", "unit"):
        fault, option = _unit_not_read(log, "q")
        message, step = f"{message}: {fault}", option or step
    if patterns:
        step = f"if these are positions: {_pattern_options('q', patterns)}; in degrees 'q={patterns[0]}:deg'"
    return refusal(message, table.where(), expected, listed_names(table.names), step)
