"""Families of columns: names that differ in the joint alone, matched with an arm's joints."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

from gd_analyze.motions.names import EXTERNAL, ColumnName
from gd_analyze.motions.reading import ROLES
from gd_analyze.motions.vocabulary import MEANINGS, MOTION_QUANTITIES, VOCABULARY, Words, words_in

_FILLERS = VOCABULARY["joint"]["plain"]


@dataclass(frozen=True)
class Numbering:
    """Numbers of an arm's joints: those in their names, or else along the chain."""

    joints: Mapping[int, int]  # joint, from 0, by number
    label: Words | None = None  # what stands beside the numbers; None if they are not in the names
    partial: bool = False  # whether other joints, such as a rail, have no number

    @classmethod
    def of(cls, names: Sequence[str]) -> Numbering:
        """Those of an arm.

        Numbers of some joints count only where counting along the chain would differ, as above a rail, and
        not where they count joints of a kind, such as wrist_1 to wrist_3 of six.
        """
        groups: dict[Words, dict[int, int]] = {}
        for joint, name in enumerate(names):
            label, number = _label_and_number(name)
            if number is not None:
                groups.setdefault(label, {})[number] = joint
        if len(groups) == 1 and len(next(iter(groups.values()))) == len(names):
            ((label, joints),) = groups.items()
            return cls(joints, label)
        decisive = [
            (label, joints)
            for label, joints in groups.items()
            if (_says_nothing(label) or 2 * len(joints) > len(names))
            and any(number - (0 not in joints) != joint for number, joint in joints.items())
        ]
        if len(decisive) == 1:
            return cls(decisive[0][1], decisive[0][0], partial=True)
        return cls({joint + 1: joint for joint in range(len(names))})

    @cached_property
    def first(self) -> int:
        """Where the numbers begin."""
        return 0 if 0 in self.joints else 1

    def joints_of(self, numbers: Mapping[int, int]) -> dict[int, int | None]:
        """Joint of each column, given its number in the log, which may begin elsewhere."""
        shift = self.first - (0 if 0 in numbers.values() else 1)
        return {column: self.joints.get(number + shift) for column, number in numbers.items()}


def _label_and_number(name: str) -> tuple[Words, int | None]:
    words = [word for word in words_in(name) if word not in _FILLERS]
    counts = [k for k, word in enumerate(words) if word.isascii() and word.isdigit() and len(word) < 7]
    if not counts:
        return tuple(words), None
    return tuple(words[: counts[-1]] + words[counts[-1] + 1 :]), int(words[counts[-1]])


def _says_nothing(label: Words) -> bool:
    """Whether the label of a numbered joint says nothing beside the number: a, q."""
    return all(len(word) == 1 or MEANINGS.get((word,)) in _QUANTITIES for word in label)


_QUANTITIES = [meaning for meaning in MEANINGS.values() if meaning.of in MOTION_QUANTITIES]


@dataclass(frozen=True, eq=False)
class Family:
    """Columns of one quantity, one per joint."""

    role: str
    kind: str  # "measured", "target" or ""
    rank: int  # of the quantity's word, see `ColumnName`
    topic: Words
    label: Words  # words beside the number of the joint
    key: Words  # of names that differ in the joint, and in the unit, only
    columns: Mapping[int, tuple[int, ...]]  # columns of each joint of the arm, from 0, normally one
    extra: tuple[int, ...]  # columns of joints that the arm lacks
    patterns: tuple[str, ...]  # patterns of the names, normally one
    why: str  # how the joints were matched
    unit: str = ""  # stated in all its names; "mixed" if they state several
    renamed: tuple[tuple[int, int], ...] = ()  # joints of the arm with a column of another name

    @property
    def all_columns(self) -> tuple[int, ...]:
        """All its columns."""
        return tuple(column for columns in self.columns.values() for column in columns)

    @property
    def pattern(self) -> str:
        """The pattern that --map takes; "" if its names have several."""
        return self.patterns[0] if len(self.patterns) == 1 and "*" in self.patterns[0] else ""

    @property
    def preference(self) -> tuple[int, int, bool]:
        """Order of a role's families: measured before what is not said; usual words; bare numbers."""
        return ("measured", "", "target").index(self.kind), self.rank, bool(self.label)

    @property
    def is_si(self) -> bool:
        """Whether its names state no unit but that of SI."""
        return self.unit.partition("/")[0] in ("", "rad", "m", "N m", "N")


def families_of(names: Mapping[int, ColumnName], arm_names: Sequence[str]) -> list[Family]:
    """Families of the columns that name a quantity."""
    groups: dict[tuple[object, ...], dict[int, ColumnName]] = {}
    alone: dict[tuple[object, ...], dict[int, ColumnName]] = {}
    for column, name in names.items():
        if name.role not in ROLES or name.fault:
            continue
        if name.says_joint:
            groups.setdefault((name.role, *name.key), {})[column] = name
        elif len(arm_names) == 1 and not name.label:
            alone.setdefault((name.role, name.kind, name.rank, name.topic), {})[column] = name
    # A log that numbers its joints may use other words for further quantities: TorqueSm1 beside Position1.
    has_bare_numbers = any(
        name.number is not None and not name.label for group in groups.values() for name in group.values()
    )
    numbering = Numbering.of(arm_names)
    matched = [
        _matched(part, arm_names, numbering, has_bare_numbers)
        for group in groups.values()
        for part in _by_unit(group)
    ]
    families = _completed([family for family in matched if family is not None], names, arm_names, numbering)
    families += [_family(group, {0: tuple(group)}, "the arm's only joint") for group in alone.values()]
    return families


def _family(columns: Mapping[int, ColumnName], joints: Mapping[int, tuple[int, ...]], why: str) -> Family:
    first = next(iter(columns.values()))
    units = {name.unit for name in columns.values()}
    used = {column for of_joint in joints.values() for column in of_joint}
    return Family(
        first.role,
        first.kind,
        first.rank,
        first.topic,
        first.label if first.joint is None else (),
        first.key,
        dict(sorted(joints.items())),
        tuple(column for column in columns if column not in used),
        tuple(dict.fromkeys(name.pattern or name.text for name in columns.values())),
        why,
        units.pop() if len(units) == 1 else "mixed",
    )


def _by_unit(columns: dict[int, ColumnName]) -> list[dict[int, ColumnName]]:
    """Columns by unit where they state each joint's quantity in the same few, such as q1_deg and q1_rad."""
    units: dict[object, list[str]] = {}
    for name in columns.values():
        units.setdefault((name.joint, name.number), []).append(name.unit)
    first = next(iter(units.values()))
    if len(first) < 2 or any(sorted(of_joint) != sorted({*first}) for of_joint in units.values()):
        return [columns]
    return [{c: name for c, name in columns.items() if name.unit == unit} for unit in first]


def _matched(
    columns: dict[int, ColumnName], arm_names: Sequence[str], numbering: Numbering, has_bare_numbers: bool
) -> Family | None:
    """Match with the joints that are named, or by number; None where words beside the numbers disagree."""
    if any(name.joint is not None for name in columns.values()):
        return _family(columns, _by_joint({c: name.joint for c, name in columns.items()}), "by name")
    numbers = {c: name.number for c, name in columns.items() if name.number is not None}
    label = next(iter(columns.values())).label
    foreign = bool(label) and label != numbering.label and not has_bare_numbers
    if label == EXTERNAL != numbering.label:
        return _family(columns, {}, "an external axis") if numbering.partial else None
    if foreign and (numbering.label is None or numbering.partial):
        return None
    joints = _by_joint(numbering.joints_of(numbers))
    family = _family(columns, joints, f"by number, from {0 if 0 in numbers.values() else 1}")
    if not foreign:
        return family
    return replace(family, renamed=tuple((joint, of_joint[0]) for joint, of_joint in sorted(joints.items())))


def _by_joint(joints: Mapping[int, int | None]) -> dict[int, tuple[int, ...]]:
    """Columns of each joint, given the joint of each column."""
    columns: dict[int, tuple[int, ...]] = {}
    for column, joint in joints.items():
        if joint is not None:
            columns[joint] = (*columns.get(joint, ()), column)
    return columns


def _completed(
    families: list[Family],
    names: Mapping[int, ColumnName],
    arm_names: Sequence[str],
    numbering: Numbering,
) -> list[Family]:
    """Join families of one quantity of which each has some joints: a rail by its name and A1 to A6 by number.

    An external axis, KUKA's E1, is the only joint that has no number.
    """
    out: list[Family] = []
    for family in families:
        alike = next((k for k, other in enumerate(out) if _complement(other, family)), None)
        if alike is None:
            out.append(family)
            continue
        first = out[alike]
        columns, renamed = {**first.columns, **family.columns}, first.renamed + family.renamed
        extra = first.extra + family.extra
        missing = sorted({*range(len(arm_names))} - {*columns})
        for part in (first, family):
            if part.why == "an external axis" and numbering.partial and len(missing) == len(part.extra) == 1:
                columns[missing[0]] = part.extra
                renamed += ((missing[0], part.extra[0]),)
                extra = tuple(column for column in extra if column not in part.extra)
        why = "by number of the joint's name"
        unit = first.unit if first.unit == family.unit else "mixed"
        out[alike] = replace(
            first,
            label=(),
            columns=dict(sorted(columns.items())),
            extra=extra,
            patterns=first.patterns + family.patterns,
            why=why,
            unit=unit,
            renamed=renamed,
        )
    return [family for family in out if family.columns]


def _complement(a: Family, b: Family) -> bool:
    """Whether two families are one quantity of different joints."""
    alike = (a.role, a.kind, a.rank, a.topic) == (b.role, b.kind, b.rank, b.topic)
    return alike and not {*a.columns} & {*b.columns}
