"""What is not understood in a log: messages that list it, and one option that settles all joints."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace

from gd_analyze.errors import TrajectoryError
from gd_analyze.motions.column_units import unit_in_words, units_of
from gd_analyze.motions.families import Family, families_of
from gd_analyze.motions.mapping import ColumnMap, listed_names, map_option
from gd_analyze.motions.names import TIMED, ColumnName
from gd_analyze.motions.reading import Reading, refusal
from gd_analyze.motions.table import LogTable
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import in_python
from gd_analyze.units import UNITS

PLURAL = {"q": "positions", "qd": "velocities", "qdd": "accelerations", "torque": "torques"}
_LACKED = {
    "q": "the log has no position of joint",
    "qd": "the log has no velocity of joint",
    "qdd": "the log has no acceleration of joint",
    "torque": "the log has no torque of joint",
}
# Most families listed in a message.
_MOST_CANDIDATES = 4


@dataclass(frozen=True)
class NamedLog:
    """A log with what its columns' names and the user say."""

    table: LogTable
    arm: RobotArm
    reading: Reading
    given: ColumnMap
    names: Sequence[ColumnName]  # of its columns
    families: Sequence[Family]
    arm_names: Sequence[str]  # of the arm's joints; numbers in a file of set points


def said_of(role: str, family: Family, log: NamedLog) -> str:
    """What --map takes for a family: its pattern, or its columns."""
    if family.pattern:
        return f"{role}={family.pattern}"
    names = [log.table.names[columns[0]] for _, columns in sorted(family.columns.items())]
    listed = all(name and "," not in name and log.table.names.count(name) == 1 for name in names)
    columns = [f"#{columns[0] + 1}" for _, columns in sorted(family.columns.items())]
    return f"{role}={','.join(names if listed else columns)}"


def _options(said: Iterable[str]) -> str:
    return " or ".join(map_option(text) for text in said)


def _candidates(log: NamedLog, role: str, columns: Iterable[int]) -> list[str]:
    """What --map takes for the columns of each of the arm's joints among these, at most a few."""
    numeric = [k for k in columns if not any(isinstance(cell, str) for cell in log.table.head(k))]
    as_role = {k: replace(log.names[k], role="q", kind="", rank=0, label=(), fault="") for k in numeric}
    families = families_of(as_role, log.arm_names)
    complete = [family for family in families if len(family.columns) == log.arm.n_joints]
    single = [f for f in complete if all(len(of_joint) == 1 for of_joint in f.columns.values())]
    return [said_of(role, family, log) for family in single[:_MOST_CANDIDATES]]


def _strangers(log: NamedLog) -> dict[str, int]:
    """Joints of the log that are none of the arm's, as --map takes their names, and a column of each."""
    strangers: dict[str, int] = {}
    for k, name in enumerate(log.names):
        if name.role == "q" and name.joint is None and (name.label or name.number is None):
            number = () if name.number is None else (str(name.number),)
            strangers.setdefault("_".join((*name.label, *number)), k)
    return strangers


def _unknown(log: NamedLog) -> list[int]:
    """Columns of a joint beside a word that is not known."""
    return [k for k, name in enumerate(log.names) if name.is_unclear]


def unknown_torques(log: NamedLog, used: Collection[int]) -> list[str]:
    """A warning of unused columns that may be the torques that a recording lacks."""
    of_unit = _in_foreign_unit(log, "torque")
    if of_unit:
        return [f"no torques are read: {of_unit}"]
    unknown = [k for k in _unknown(log) if k not in used]
    said = _candidates(log, "torque", unknown)
    if not said:
        return []
    listed = ", ".join(text.removeprefix("torque=") for text in said)
    warning = f"no torques are read, and what {listed} is in the log is unknown"
    warning += f"; if torques: {_options(said)}"
    has_currents = any(log.names[k].role == "current" for k in unknown)
    return [f"{warning}, of currents with --torque-constant LIST" if has_currents else warning]


def _in_foreign_unit(log: NamedLog, role: str) -> str:
    """Which column is in no unit of its role, and the option that states one where the unit is unknown."""
    columns = [k for k, name in enumerate(log.names) if name.role == role and name.fault not in ("", "text")]
    if not columns:
        return ""
    unit, units = log.names[columns[0]].unit, [*units_of(role, log.arm.is_revolute[0])]
    fault = f"{log.table.names[columns[0]]} is in {unit}, no unit of {PLURAL[role]}"
    if role == "torque" and unit in UNITS["current"]:
        return f"{fault}; --torque-constant LIST takes {log.arm.n_joints} joint torques per ampere"
    said = _candidates(log, role, columns) if unit_in_words(unit) in (None, "grad") else []
    options = _options([f"{text}:{units[0]}" for text in said])
    return f"{fault}; if this is {', '.join(units)}: {options}" if said else fault


def no_currents(log: NamedLog) -> TrajectoryError:
    """Error for torque constants of a log without columns of torque."""
    named = [k for k, name in enumerate(log.names) if name.role == "torque"]
    said = _candidates(log, "torque", named) or _candidates(log, "torque", _unknown(log))
    step = _options(said) or "--map 'torque=NAME*', whose star stands for a joint's name or number"
    message, expected = "no columns for the torque constants", "columns of torque or currents, one per joint"
    where = f"--torque-constant; {log.table.where()}"
    return refusal(message, where, expected, listed_names(log.table.names), f"name the currents: {step}")


def no_numbers(table: LogTable, column: int) -> TrajectoryError:
    """Error for a column with the name of a role whose cells are text."""
    message, cell = f"{table.label(column)} is not a number", in_python(table.head(column)[0])
    step = "correct the cells, or choose the columns with --map"
    return refusal(message, table.where(0, column), "numbers", cell, step)


def incomplete(log: NamedLog, role: str) -> TrajectoryError:
    """Error for a role of which the user named the columns of some joints only."""
    names, mapped = [joint.name for joint in log.arm.joints], log.given.columns_of(role)
    listed = ", ".join(names[joint] for joint in sorted(mapped))
    missing = next(name for joint, name in enumerate(names) if joint not in mapped)
    expected, step = f"a column for each joint, {missing} too", f"add --map '{role}:{missing}=COLUMN'"
    return refusal(f"{role} is given for some joints only", "--map", expected, listed, step)


def ambiguous(role: str, choices: Sequence[Family], log: NamedLog) -> TrajectoryError:
    """Error for several families that fit a role equally well."""
    message, table = f"several columns may be the {PLURAL[role]}", log.table
    said = list(dict.fromkeys(said_of(role, family, log) for family in choices[:6]))
    candidates = "; ".join(f"{table.names[min(family.all_columns)]} and so on" for family in choices[:6])
    return refusal(message, table.where(), "one column per joint", candidates, f"choose: {_options(said)}")


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
    every = sorted((*nearest.all_columns, *nearest.extra))
    if len(every) == arm.n_joints and all(len(columns) == 1 for columns in nearest.columns.values()):
        in_order = map_option(f"{role}={','.join(table.names[column] for column in every)}")
        step = f"if the columns are the joints in this order: {in_order}"
    return refusal(message, table.where(), f"{PLURAL[role]} of all joints: {expected}", listed, step)


def no_positions(log: NamedLog) -> TrajectoryError:
    """Error for a log without positions."""
    table, arm = log.table, log.arm
    names = [joint.name for joint in arm.joints]
    strangers = _strangers(log)
    if strangers:
        message, listed = (
            f"the log's joints are not those of arm {arm.name}",
            listed_names([table.names[k] for k in strangers.values()]),
        )
        said = _candidates(log, "q", [k for k, name in enumerate(log.names) if name.role == "q"])
        if said:
            step = f"if these are the arm's joints in order of number: {_options(said)}"
        elif len(strangers) == arm.n_joints and "" not in strangers:
            step = (
                f"if these are the same joints in this order: {map_option('joints=' + ','.join(strangers))}"
            )
        else:
            step = f"--map joints=LIST, the log's names of {', '.join(names)} in this order"
        return refusal(message, table.where(), ", ".join(names), listed, step)
    message = "no column is recognized as a joint position"
    expected = f"names such as q1, joint_1, actual_q_0, or those of the arm's joints: {', '.join(names)}"
    said = _candidates(log, "q", _unknown(log)) or _all_that_is_left(log)
    if said:
        step = f"if these are positions: {_options(said)}, with :deg behind it for degrees"
    elif foreign := _in_foreign_unit(log, "q"):
        message, _, step = f"{message}: {foreign}".partition("; ")
    else:
        step = (
            f"name the columns: --map q=LIST, {arm.n_joints} names or numbers such as #2 in the joints' order"
        )
    return refusal(
        message, table.where(), expected, listed_names(table.names), step or "name others with --map q=LIST"
    )


def _all_that_is_left(log: NamedLog) -> list[str]:
    """The columns of which nothing is known, where there are as many as joints."""
    columns = [
        k
        for k, name in enumerate(log.names)
        if name.role == "other"
        and name.text
        and not (name.unit or name.fault)
        and not any(isinstance(cell, str) for cell in log.table.head(k))
    ]
    unread = all(name.role in ("other", *TIMED) for name in log.names)
    return (
        [f"q={','.join(log.names[k].text for k in columns)}"]
        if unread and len(columns) == log.arm.n_joints
        else []
    )
