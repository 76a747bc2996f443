"""What is not understood in a log: messages that list it, and one argument that settles all joints."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import replace

from gd_analyze.errors import TrajectoryError, argument, in_options
from gd_analyze.motions.column_units import unit_in_words, units_of
from gd_analyze.motions.families import Family, families_of
from gd_analyze.motions.fewer_joints import ways_to_hold
from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.mapping import NamedLog, listed_names, typed_columns
from gd_analyze.motions.names import TIMED, ColumnName
from gd_analyze.motions.reading import MotionRole, refusal
from gd_analyze.robots.catalogue import arguments_to_hold
from gd_analyze.text import in_python
from gd_analyze.units import UNITS

ZERO = "0 throughout"
_QUANTITY = {"q": "position", "qd": "velocity", "qdd": "acceleration", "torque": "torque"}
_PLURAL = {"q": "positions", "qd": "velocities", "qdd": "accelerations", "torque": "torques"}
# Most families listed in a message.
_MOST_CANDIDATES = 4


def _said_of(role: str, family: Family, log: NamedLog) -> str:
    """What `map` takes for a family: its pattern, or its columns."""
    if family.pattern:
        return f"{role}={family.pattern}"
    columns = typed_columns([columns[0] for columns in family.columns.values()], log.table)
    return f"{role}={','.join(columns)}"


def _mapped(said: Iterable[str]) -> str:
    return " or ".join(argument("map", text) for text in said)


def _single(log: NamedLog, columns: Iterable[int]) -> list[Family]:
    """Families that these columns would be as positions, with one column of each joint."""
    as_positions = {
        k: replace(log.names[k], role="q", kind="", rank=0, label=(), fault="")
        for k in columns
        if _is_numeric(log, k)
    }
    families = families_of(as_positions, log.joints)
    return [family for family in families if {len(columns) for columns in family.columns.values()} == {1}]


def _candidates(log: NamedLog, role: str, columns: Iterable[int]) -> list[str]:
    """What `map` takes for the columns of each of the arm's joints among these, at most a few."""
    complete = [family for family in _single(log, columns) if len(family.columns) == log.arm.n_joints]
    return [_said_of(role, family, log) for family in complete[:_MOST_CANDIDATES]]


def _of_fewer_joints(log: NamedLog) -> str:
    """What to do if unknown columns are the positions of most joints, but not of all; "" if they are not."""
    for family in _single(log, _unknown(log)):
        if 2 * len(family.columns) > log.arm.n_joints > len(family.columns):
            for way in ways_to_hold(log, family.columns):
                return f"if these are positions, and {way} {_mapped([_said_of('q', family, log)])}"
    return ""


def _is_numeric(log: NamedLog, column: int) -> bool:
    return not any(isinstance(cell, str) for cell in log.table.head(column))


def _unknown(log: NamedLog) -> list[int]:
    """Columns of a joint beside a word that is not known."""
    return [k for k, name in enumerate(log.names) if name.is_unclear]


def unknown_torques(log: NamedLog, used: Collection[int]) -> list[str]:
    """A warning of unused columns that are, or may be, the torques that a recording lacks."""
    unknown = [k for k in _unknown(log) if k not in used]
    said = _candidates(log, "torque", unknown)
    reasons = [_in_foreign_unit(log, "torque"), _torques_of_some_joints(log)]
    if not said:
        reasons.append(_only_currents(log))
    for fault, step in reasons:
        if fault:
            text = f"no torques are read: {fault}; {step}" if step else f"no torques are read: {fault}"
            return [in_options(text)]
    if not said:
        return []
    listed = ", ".join(text.removeprefix("torque=") for text in said)
    has_currents = any(log.names[k].role == "current" for k in unknown)
    constants = f", of currents with {argument('torque_constant', 'LIST')}" if has_currents else ""
    warning = f"no torques are read, and what {listed} is in the log is unknown"
    return [in_options(f"{warning}; if torques: {_mapped(said)}{constants}")]


def _torques_of_some_joints(log: NamedLog) -> tuple[str, str]:
    """Which joints lack a column of torque where others have one, "" if none does, and what names it."""
    families = [family for family in log.families if family.name.role == "torque"]
    family = max(families, key=lambda family: len(family.columns), default=None)
    if family is None or len(family.columns) == log.arm.n_joints:
        return "", ""
    names = [joint.name for j, joint in enumerate(log.arm.joints) if j not in family.columns]
    every = sorted((*family.all_columns, *family.extra))
    if len(every) == log.arm.n_joints:
        in_order = f"torque={','.join(typed_columns(every, log.table))}"
        way = f"if they are the joints' in this order: {argument('map', in_order)}"
    else:
        way = f"{argument('map', f'torque:{names[0]}=COLUMN')} names a column"
    first = log.table.names[every[0]]
    return f"{first} ... are torques, but none is of {listed_names(names)}", way


def _only_currents(log: NamedLog) -> tuple[str, str]:
    """That columns are currents, "" if there are fewer than joints, and what makes torques of them."""
    columns, n = [k for k, name in enumerate(log.names) if name.role == "current"], log.arm.n_joints
    if len(columns) < n:
        return "", ""
    fault = f"{log.table.names[columns[0]]} ... are currents"
    return fault, f"{argument('torque_constant', 'LIST')} takes {n} joint torques per ampere"


def _in_foreign_unit(log: NamedLog, role: str) -> tuple[str, str]:
    """Which column is in no unit of its role, "" if none is, and the option that states one, if any does."""
    columns = [k for k, name in enumerate(log.names) if name.role == role and name.fault not in ("", "text")]
    if not columns:
        return "", ""
    unit, units = log.names[columns[0]].unit, [*units_of(role, log.arm.is_revolute[0])]
    fault = f"{log.table.names[columns[0]]} is in {unit}, no unit of {_PLURAL[role]}"
    if role == "torque" and unit in UNITS["current"]:
        return (
            fault,
            f"{argument('torque_constant', 'LIST')} takes {log.arm.n_joints} joint torques per ampere",
        )
    said = _candidates(log, role, columns) if unit_in_words(unit) in (None, "grad") else []
    options = _mapped([f"{text}:{units[0]}" for text in said])
    return fault, f"if this is {', '.join(units)}: {options}" if said else ""


def no_currents(log: NamedLog) -> TrajectoryError:
    """Error for torque constants of a log without columns of torque."""
    named = [k for k, name in enumerate(log.names) if name.role == "torque"]
    said = _candidates(log, "torque", named) or _candidates(log, "torque", _unknown(log))
    step = (
        _mapped(said) or f"{argument('map', 'torque=NAME*')}, whose star stands for a joint's name or number"
    )
    message, expected = "no columns for the torque constants", "columns of torque or currents, one per joint"
    where = f"torque_constant; {log.table.where()}"
    return refusal(message, where, expected, listed_names(log.table.names), f"name the currents: {step}")


def ambiguous(role: str, choices: Sequence[Family], log: NamedLog) -> TrajectoryError:
    """Error for several families that fit a role equally well."""
    message, table = f"several columns may be the {_PLURAL[role]}", log.table
    said = dict.fromkeys(_said_of(role, family, log) for family in choices[:6])
    candidates = "; ".join(f"{table.names[min(family.all_columns)]} and so on" for family in choices[:6])
    return refusal(message, table.where(), "one column per joint", candidates, f"choose: {_mapped(said)}")


def absent(log: NamedLog, role: MotionRole, of_role: Sequence[Family]) -> TrajectoryError:
    """Error for a role that no family has for all of the arm's joints."""
    table, arm = log.table, log.arm
    names = [joint.name for joint in arm.joints]
    text = [k for k, name in enumerate(log.names) if name.role == role and name.fault == "text"]
    if text and role not in log.mapped:
        message, cell = f"{table.label(text[0])} is not a number", in_python(table.head(text[0])[0])
        step = "correct the cells, or choose the columns with `map`"
        return refusal(message, table.where(0, text[0]), "numbers", cell, step)
    nearest = max(of_role, key=lambda family: len(family.columns), default=None)
    columns = {} if nearest is None else {**nearest.columns}
    columns |= {joint: (column,) for joint, column in log.mapped.get(role, {}).items()}
    if not columns:
        return _no_positions(log)
    lacking = [name for j, name in enumerate(names) if j not in columns]
    used = [column for of_joint in columns.values() for column in of_joint]
    used_names = [table.names[column] for column in used]
    remaining_names = [name for name in table.names if name and name not in used_names]
    message = f"the log has no {_QUANTITY[role]} of joint {', '.join(lacking)}"
    expected = f"{_PLURAL[role]} of all joints: {', '.join(names)}"
    listed = listed_names(used_names) + (f"; also {listed_names(remaining_names)}" if remaining_names else "")
    step = f"{argument('map', f'{role}:{lacking[0]}=COLUMN')} names a column, or choose the log's arm"
    ways = ways_to_hold(log, columns) if role == "q" else []
    step = "; ".join([*(f"if {way}" for way in ways), step])
    column_names = [name for name in log.names if name.role == role]
    labels = _labels(column_names)
    has_own_names = any(name.joint is not None or name.label == log.joints.label for name in column_names)
    if role == "q" and len(labels) == arm.n_joints and not has_own_names:
        step = f"if these are the joints in this order: {argument('map', 'joints=' + ','.join(labels))}"
    every = sorted((*used, *(() if nearest is None else nearest.extra)))
    if len(every) == arm.n_joints and len(used) == len(columns):
        in_order = f"{role}={','.join(typed_columns(every, table))}"
        step = f"if the columns are the joints in this order: {argument('map', in_order)}"
    return refusal(message, table.where(), expected, listed, step)


def _no_positions(log: NamedLog) -> TrajectoryError:
    """Error for a log without positions."""
    table, arm = log.table, log.arm
    names = ", ".join(joint.name for joint in arm.joints)
    # Joints of the log that are none of the arm's, as `map` takes their names, and a column of each.
    unmatched = [name for name in log.names if name.role == "q" and name.joint is None]
    strangers = _labels([name for name in unmatched if name.label or name.number is None])
    if strangers:
        said = _candidates(log, "q", [k for k, name in enumerate(log.names) if name.role == "q"])
        step = f"{argument('map', 'joints=LIST')}, the log's names of {names} in this order"
        if said:
            step = f"if these are the arm's joints in order of number: {_mapped(said)}"
        elif len(strangers) == arm.n_joints and "" not in strangers:
            step = f"if these are the same joints in this order: {_mapped(['joints=' + ','.join(strangers)])}"
        elif len(strangers) < arm.n_joints and "" not in strangers:
            outer = arguments_to_hold(arm, range(len(strangers), arm.n_joints))
            listed = _mapped(["joints=" + ",".join(strangers)])
            step = f"if these are the first joints in this order: {outer} {listed}" if outer else step
        message = f"the log's joints are not those of arm {arm.name}"
        return refusal(message, table.where(), names, listed_names([*strangers.values()]), step)
    message = "no column is recognized as a joint position"
    expected = f"names such as q1, joint_1, actual_q_0, or those of the arm's joints: {names}"
    fault, step = _in_foreign_unit(log, "q")
    said = _candidates(log, "q", _unknown(log)) or _all_that_is_left(log)
    if said:
        step = f"if these are positions: {_mapped(said)}, with :deg behind it for degrees"
    elif of_fewer := _of_fewer_joints(log):
        step = of_fewer
    elif fault:
        message, step = f"{message}: {fault}", step or f"name others with {argument('map', 'q=LIST')}"
    else:
        listed = f"{arm.n_joints} names or numbers such as #2 in the joints' order"
        step = f"name the columns: {argument('map', 'q=LIST')}, {listed}"
    return refusal(message, table.where(), expected, listed_names(table.names), step)


def _labels(columns: Iterable[ColumnName]) -> dict[str, str]:
    """The log's own names of joints, as `map` takes them, and a column of each."""
    labels: dict[str, str] = {}
    for name in columns:
        number = () if name.number is None else (str(name.number),)
        labels.setdefault("_".join((*name.label, *number)), name.text)
    return labels


def _all_that_is_left(log: NamedLog) -> list[str]:
    """The columns of which nothing is known, where there are as many as joints."""
    others = [k for k, name in enumerate(log.names) if name.role not in TIMED]
    columns = [
        k
        for k in others
        if log.names[k].text and not (log.names[k].unit or log.names[k].fault) and _is_numeric(log, k)
    ]
    unread = all(log.names[k].role == "other" for k in others)
    is_all = unread and len(columns) == log.arm.n_joints
    return [f"q={','.join(typed_columns(columns, log.table))}"] if is_all else []


def remarks_on(log: NamedLog, chosen: Mapping[MotionRole, Family], zero: Sequence[Family]) -> list[str]:
    """Warnings of joints under other names or of another arm, and of columns that are 0 throughout."""
    q, names = chosen.get("q"), log.table.names
    remarks = _remarks_on_joints(log, q) if q is not None else []
    for role, family in chosen.items():
        first, pattern = f"{names[min(family.all_columns)]} ...", role in log.patterns
        label = " ".join(family.name.label)
        # Words of the positions' own columns, which the user may have named, name the joints.
        positions = "" if q is None else q.name.text.lower()
        has_word = any(len(word) > 1 and word not in positions for word in family.name.label)
        if q is not None and has_word and not q.name.label and not pattern:
            confirms, omits = _mapped([_said_of(role, family, log)]), argument("map", f"{role}=none")
            remark = f"{_PLURAL[role]}: what {label} means in {first} is unknown"
            remarks.append(f"{remark}; {confirms} confirms it, {omits} leaves them out")
        others = [other for other in zero if other.name.role == role and other is not family]
        if others:
            listed = ", ".join(names[min(other.all_columns)] for other in others)
            remarks.append(f"{listed} ... are {ZERO}; {_PLURAL[role]} taken from {first}")
        same = [f for f in log.families if f.name.key == family.name.key and f.unit != family.unit]
        if same:
            other = f"{names[min(same[0].all_columns)]} ..."
            remarks.append(f"{other} are the same as {first} in another unit, and are not read")
    if "torque" not in chosen:
        idle = [names[min(family.all_columns)] for family in zero if family.name.role == "torque"]
        remarks += [f"{', '.join(idle)} ... are {ZERO}; no torques are read"] if idle else []
    return [in_options(remark) for remark in remarks]


def _remarks_on_joints(log: NamedLog, q: Family) -> list[str]:
    """Warnings of positions that are matched by number."""
    remarks, names, arm = [], log.table.names, log.arm
    joints = JointNames.of([joint.name for joint in arm.joints])
    renamed = [(joint, column) for joint, column in q.renamed if joint not in log.mapped.get("q", ())]
    pairs = [f"{names[column]} is {arm.joints[joint].name}" for joint, column in renamed]
    if len(renamed) == 1:
        ((rail, only),) = renamed
        option = argument("map", f"q:{arm.joints[rail].name}={names[only]}")
        remarks.append(f"{pairs[0]}, the only other joint; {option} confirms it")
    elif renamed:
        matched = f"joints matched by number, as their names differ: {pairs[0]} ... {pairs[-1]}"
        remarks.append(f"{matched}; {_mapped([_said_of('q', q, log)])} confirms it")
    is_counted = joints.label is not None and not joints.partial
    if is_counted and not q.name.label and q.why.startswith("by number"):
        numbers = {joint: number for number, joint in joints.numbers.items()}
        counts = [numbers[joint] for joint in range(arm.n_joints)]
        astray = [k for k in q.columns if numbers[k] != sorted(counts)[k]]
        for k in astray[:1]:
            column, joint = names[q.columns[k][0]], arm.joints[k].name
            remarks.append(f"{column} is used for {joint}, joint {k + 1} of the chain; check the order")
    # An arm selected from a longer chain may count like the log.
    is_picked = is_counted and max(joints.numbers) - min(joints.numbers) >= arm.n_joints
    if q.extra and not is_picked:
        logged = f"{len(q.columns) + len(q.extra)} joints logged, {arm.n_joints} in arm {arm.name}"
        listed = listed_names([names[k] for k in q.extra])
        remarks.append(f"{logged}; left out: {listed}; check that the log belongs to this arm")
    return remarks
