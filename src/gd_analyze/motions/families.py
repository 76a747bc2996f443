"""Families of columns: names that differ in the joint alone, matched with an arm's joints."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.names import EXTERNAL, ColumnName
from gd_analyze.motions.reading import ROLES


@dataclass(frozen=True, eq=False)
class Family:
    """Columns of one quantity, one per joint."""

    name: ColumnName  # of its first column, which stands for all but for the joint
    columns: Mapping[int, tuple[int, ...]]  # columns of each joint of the arm, from 0, normally one
    extra: tuple[int, ...]  # columns of joints that the arm lacks
    pattern: str  # of its names, which `map` takes; "" if there are several
    why: str  # how the joints were matched
    unit: str = ""  # stated in all its names; "mixed" if they state several
    renamed: tuple[tuple[int, int], ...] = ()  # joints of the arm with a column of another name

    @property
    def all_columns(self) -> tuple[int, ...]:
        """All its columns."""
        return tuple(column for columns in self.columns.values() for column in columns)

    @property
    def is_si(self) -> bool:
        """Whether its names state no unit but that of SI."""
        return self.unit.partition("/")[0] in ("", "rad", "m", "N m", "N")


def families_of(names: Mapping[int, ColumnName], joints: JointNames) -> list[Family]:
    """Families of the columns that name a quantity."""
    groups: dict[tuple[object, ...], dict[int, ColumnName]] = {}
    for column, name in names.items():
        if name.role in ROLES and not name.fault:
            if name.says_joint:
                groups.setdefault((name.role, *name.key), {})[column] = name
            elif joints.n_joints == 1 and not name.label:
                groups.setdefault((name.role, name.kind, name.rank, name.topic), {})[column] = name
    # A log that numbers its joints may use other words for further quantities: TorqueSm1 beside Position1.
    has_bare_numbers = any(
        name.number is not None and not name.label for group in groups.values() for name in group.values()
    )
    families: list[Family] = []
    for group in groups.values():
        for part in _by_unit(group):
            family = _matched(part, joints, has_bare_numbers)
            if family is None:
                continue
            alike = next((k for k, other in enumerate(families) if _is_rest(family, other)), None)
            if alike is None:
                families.append(family)
            else:
                families[alike] = _joined(families[alike], family, joints)
    return [family for family in families if family.columns]


def _by_unit(columns: dict[int, ColumnName]) -> list[dict[int, ColumnName]]:
    """Columns by unit where they state each joint's quantity in the same few, such as q1_deg and q1_rad."""
    units: dict[object, list[str]] = {}
    for name in columns.values():
        units.setdefault((name.joint, name.number), []).append(name.unit)
    first = next(iter(units.values()))
    if len(first) < 2 or any(sorted(of_joint) != sorted({*first}) for of_joint in units.values()):
        return [columns]
    return [{c: name for c, name in columns.items() if name.unit == unit} for unit in first]


def _matched(columns: dict[int, ColumnName], joints: JointNames, has_bare_numbers: bool) -> Family | None:
    """Match with the joints that are named, or by number; None where words beside the numbers disagree."""
    first = next(iter(columns.values()))
    numbers = {column: name.number for column, name in columns.items() if name.number is not None}
    is_foreign, matched = False, dict[int, int | None]()
    if not first.says_joint:
        matched, why = dict.fromkeys(columns, 0), "the arm's only joint"
    elif any(name.joint is not None for name in columns.values()):
        matched, why = {column: name.joint for column, name in columns.items()}, "by name"
    elif first.label == EXTERNAL != joints.label:
        if not joints.partial:
            return None
        why = "an external axis"
    else:
        is_foreign = bool(first.label) and first.label != joints.label and not has_bare_numbers
        if is_foreign and (joints.label is None or joints.partial):
            return None
        matched, why = joints.numbered(numbers), f"by number, from {0 if 0 in numbers.values() else 1}"
    by_joint: dict[int, tuple[int, ...]] = {}
    for column, joint in matched.items():
        if joint is not None:
            by_joint[joint] = (*by_joint.get(joint, ()), column)
    by_joint = dict(sorted(by_joint.items()))
    patterns, units = {name.pattern for name in columns.values()}, {name.unit for name in columns.values()}
    return Family(
        first,
        by_joint,
        # Columns of other names are of another arm only where numbers are matched.
        tuple(column for column in columns if matched.get(column) is None) if why != "by name" else (),
        patterns.pop() if len(patterns) == 1 else "",
        why,
        units.pop() if len(units) == 1 else "mixed",
        tuple((joint, of_joint[0]) for joint, of_joint in by_joint.items()) if is_foreign else (),
    )


def _is_rest(family: Family, other: Family) -> bool:
    """Whether two families are one quantity of different joints."""
    a, b = family.name, other.name
    alike = (a.role, a.kind, a.rank, a.topic) == (b.role, b.kind, b.rank, b.topic)
    return alike and not {*family.columns} & {*other.columns}


def _joined(first: Family, second: Family, joints: JointNames) -> Family:
    """Join families of which each has some joints: a rail by its name and A1 to A6 by number.

    An external axis, KUKA's E1, is the only joint that has no number.
    """
    columns = {**first.columns, **second.columns}
    extra, renamed = first.extra + second.extra, first.renamed + second.renamed
    missing = sorted({*range(joints.n_joints)} - {*columns})
    for part in (first, second):
        if part.name.label == EXTERNAL and joints.partial and len(missing) == len(part.extra) == 1:
            columns[missing[0]] = part.extra
            renamed += ((missing[0], part.extra[0]),)
            extra = tuple(column for column in extra if column not in part.extra)
    return replace(
        first,
        name=replace(first.name, label=()),
        columns=dict(sorted(columns.items())),
        extra=extra,
        pattern="",
        why="by number of the joint's name",
        unit=first.unit if first.unit == second.unit else "mixed",
        renamed=renamed,
    )
