"""Families of columns: one role, one column per joint, matched by name or number; and columns of time."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

from gd_analyze.errors import Location
from gd_analyze.motions.reading import ROLES, refusal
from gd_analyze.motions.words import (
    BARE,
    EXTERNAL,
    MEASURED,
    TARGET,
    Kind,
    Meaning,
    Words,
    as_written,
    is_bare,
    joint_of,
    without_fillers,
    words_of,
)

SAMPLE = "sample"
# Preferred are the time of the rows, then the stamp of the message, then anything called time.
_ROW_TIME, _STAMP, _ANY = 0, 1, 2


@dataclass(frozen=True)
class Family:
    """Columns of one role, one per joint."""

    # From the names, see `Meaning`
    role: str
    group: Words
    kind: Kind
    rank: int
    word: str
    label: Words  # words beside the number of the joint
    columns: Mapping[int, tuple[int, ...]]  # columns of each joint of the arm, from 0, normally one
    extra: tuple[int, ...]  # columns of joints that the arm lacks
    why: str  # how the joints were matched
    renamed: tuple[tuple[str, str], ...] = ()  # log's name and arm's name of joints whose names differ
    unit: str = ""  # stated in all its names; "mixed" if they state several

    @property
    def key(self) -> tuple[object, ...]:
        """Key that distinguishes it from other families."""
        return self.role, self.group, self.label, self.rank, self.word, self.unit

    @property
    def words(self) -> frozenset[str]:
        """Words that choose it."""
        return frozenset((*self.group, *self.label, self.kind, self.word, self.unit))

    @property
    def topic(self) -> Words:
        """Words of its origin, regardless of measured or commanded."""
        return tuple(sorted(set(self.group) - MEASURED - TARGET))

    @property
    def all_columns(self) -> tuple[int, ...]:
        """All its columns."""
        return tuple(column for columns in self.columns.values() for column in columns)


Make = Callable[..., Family]


def families_of(meanings: Sequence[Meaning], names: Sequence[str], written: Sequence[str]) -> list[Family]:
    """Sort columns, by meaning and name as written, into families and match each with the arm's joints."""
    groups: dict[tuple[str, Words, Kind, int, str], dict[int, Meaning]] = {}
    for column, meaning in enumerate(meanings):
        if meaning.role in ROLES:
            key = (meaning.role, meaning.group, meaning.kind, meaning.rank, meaning.word)
            groups.setdefault(key, {})[column] = meaning
    # A log that numbers its joints may use other words for further quantities: TorqueSm1 beside Position1.
    has_bare_numbers = any(
        m.number is not None and not m.label for columns in groups.values() for m in columns.values()
    )
    families: list[Family] = []
    for group, columns in ((group, part) for group, whole in groups.items() for part in _by_unit(whole)):
        units = {meaning.unit for meaning in columns.values()}
        make = partial(Family, *group, unit=units.pop() if len(units) == 1 else "mixed")
        named = _columns_by_joint({c: m.joint for c, m in columns.items()})
        unnamed = {c: m for c, m in columns.items() if m.joint is None}
        mixed = _by_name_or_number(make, columns, names, written)
        affixed = (
            None if named or mixed is not None else _by_affix(make, unnamed, names, bare=group[3] == BARE)
        )
        if mixed is not None:
            families.append(mixed)
        elif named:
            families.append(make((), named, tuple(unnamed), "by name"))
        elif affixed is not None:
            families.append(affixed)
        else:
            labelled: dict[Words, dict[int, Meaning]] = {}
            for column, meaning in unnamed.items():
                if meaning.number is not None and meaning.label != EXTERNAL:
                    labelled.setdefault(meaning.label, {})[column] = meaning
            numbered = (
                _by_number(make, label, members, names, None if has_bare_numbers else written)
                for label, members in labelled.items()
            )
            by_number = [family for family in numbered if family is not None]
            has_label = any(m.label for m in unnamed.values())
            if len(names) == len(unnamed) == 1 and not by_number and not has_label:
                by_number = [make((), {0: tuple(unnamed)}, (), "the arm's only joint")]
            families += by_number
    return families


def _by_unit(columns: dict[int, Meaning]) -> list[dict[int, Meaning]]:
    """Columns by unit where they state each joint's quantity in the same few, such as q1_deg and q1_rad."""
    units: dict[tuple[Words, int | None], list[str]] = {}
    for meaning in columns.values():
        units.setdefault((meaning.token, meaning.joint), []).append(meaning.unit)
    first = next(iter(units.values()))
    if len(first) < 2 or any(sorted(joint) != sorted({*first}) for joint in units.values()):
        return [columns]
    return [{c: m for c, m in columns.items() if m.unit == unit} for unit in first]


def _columns_by_joint(joints: Mapping[int, int | None]) -> dict[int, tuple[int, ...]]:
    """Columns of each joint, given the joint of each column."""
    columns: dict[int, tuple[int, ...]] = {}
    for column, joint in joints.items():
        if joint is not None:
            columns[joint] = (*columns.get(joint, ()), column)
    return columns


def arms_numbers(names: Sequence[str]) -> tuple[Words, tuple[int, ...]] | None:
    """Label and numbers of joints whose names differ only in a number; None for others."""
    split = [joint_of(words_of(name)) for name in names]
    numbers = tuple(number for _, number in split if number is not None)
    if len(set(numbers)) < len(names) or len({label for label, _ in split}) > 1:
        return None
    return split[0][0], numbers


def partly_numbered(names: Sequence[str]) -> tuple[Words, dict[int, int]] | None:
    """Label of an arm's numbered joints, if its other joints have no number; and joint, from 0, by number.

    None where the numbers agree with counting along the chain, as they do unless a rail comes first. None
    also where only some joints of a kind are numbered, such as wrist_1 to wrist_3 of six joints.
    """
    if arms_numbers(names) is not None:
        return None
    groups: dict[Words, dict[int, int]] = {}
    for joint, name in enumerate(names):
        label, number = joint_of(words_of(name))
        if number is not None:
            groups.setdefault(label, {})[number] = joint
    decisive = [
        (label, joints)
        for label, joints in groups.items()
        if (is_bare(label) or 2 * len(joints) > len(names))
        and any(number - (0 not in joints) != joint for number, joint in joints.items())
    ]
    return decisive[0] if len(decisive) == 1 else None


def _by_name_or_number(
    make: Make, columns: Mapping[int, Meaning], names: Sequence[str], written: Sequence[str]
) -> Family | None:
    """Match with a partly numbered arm, where counting along the chain would move every joint by one.

    The only other joint may be an external axis, KUKA's E1. None for other arms, and if no number fits.
    """
    numbered = partly_numbered(names)
    if numbered is None:
        return None
    label, joints = numbered
    numbers = {c: m.number for c, m in columns.items() if m.label in ((), label) and m.number is not None}
    base = int(0 in numbers.values() and 0 not in joints)
    matches = {c: joints.get(number + base) for c, number in numbers.items()}
    matches |= {c: m.joint for c, m in columns.items() if m.joint is not None}
    if all(joint is None for joint in matches.values()):
        return None
    unmatched = sorted({*range(len(names))} - {*matches.values()})
    external = [c for c, m in columns.items() if m.joint is None and m.label == EXTERNAL]
    renamed: tuple[tuple[str, str], ...] = ()
    if len(unmatched) == len(external) == 1:
        matches[external[0]] = unmatched[0]
        renamed = ((as_written(columns[external[0]].token, written[external[0]]), names[unmatched[0]]),)
    extra = tuple(c for c in columns if matches.get(c) is None)
    return make((), _columns_by_joint(matches), extra, "by number of the joint's name", renamed)


def _by_number(
    make: Make,
    label: Words,
    columns: Mapping[int, Meaning],
    names: Sequence[str],
    written: Sequence[str] | None,
) -> Family | None:
    """Match the columns of a label by number.

    Where words beside the numbers name joints, `written` are names as written; the arm's must be numbered.
    """
    counts = arms_numbers(names)
    if label and written is not None and counts is None:
        return None
    numbers = {c: m.number for c, m in columns.items() if m.number is not None}
    base = 0 if 0 in numbers.values() else 1
    if counts is None:
        numbers_of_joints: Sequence[int] = range(len(names))
    else:
        first = 0 if 0 in counts[1] else 1
        numbers_of_joints = [k - first for k in counts[1]]
    joints = {number + base: joint for joint, number in enumerate(numbers_of_joints)}
    matched = _columns_by_joint({column: joints.get(number) for column, number in numbers.items()})
    extra = tuple(column for column, number in numbers.items() if number not in joints)
    renamed: tuple[tuple[str, str], ...] = ()
    if label and written is not None and counts is not None and counts[0] != label:
        firsts = [(group[0], joint) for joint, group in sorted(matched.items())]
        renamed = tuple((as_written(columns[c].token, written[c]), names[joint]) for c, joint in firsts)
    return make(label, matched, extra, f"by number, from {base}", renamed)


def _by_affix(
    make: Make, columns: Mapping[int, Meaning], names: Sequence[str], *, bare: bool
) -> Family | None:
    """Match names that differ only by the same leading words, such as the robot's prefix.

    Leading words of bare names in the log may say another quantity: volt_elbow_axis.
    """
    joint_words = [without_fillers(words_of(name)) for name in names]
    logged = {c: without_fillers(meaning.token) for c, meaning in columns.items()}
    if not all(any(not word.isdigit() for word in words) for words in joint_words):
        return None
    by_words: dict[Words, tuple[int, ...]] = {}
    # Leading words that the log adds; after "", leading words that it lacks.
    prefixes: dict[Words, None] = {}
    for column, words in logged.items():
        by_words[words] = (*by_words.get(words, ()), column)
        for joint in joint_words:
            if words[-len(joint) :] == joint and not (bare and len(words) > len(joint)):
                prefixes.setdefault(words[: -len(joint)])
            if joint[-len(words) :] == words and words:
                prefixes.setdefault(("", *joint[: -len(words)]))
    for prefix in sorted(prefixes, key=len):
        lacks = prefix[:1] == ("",)
        if lacks and any(("", *joint[: len(prefix) - 1]) != prefix for joint in joint_words):
            continue
        wanted_words = [joint[len(prefix) - 1 :] if lacks else prefix + joint for joint in joint_words]
        matched = {joint: by_words.get(words, ()) for joint, words in enumerate(wanted_words)}
        if all(matched.values()):
            used = {c for group in matched.values() for c in group}
            added = " ".join(prefix).strip()
            why = f"by name, but for {added!r}" if added else "by name"
            return make((), matched, tuple(c for c in columns if c not in used), why)
    return None


@dataclass(frozen=True)
class TimeColumns:
    """The column of time, or the pair of seconds and nanoseconds."""

    columns: tuple[int, ...]
    unit: str  # "" if unknown
    why: str


def time_columns(
    names: Sequence[str], meanings: Sequence[Meaning], stand: Sequence[bool], where: Location
) -> TimeColumns | None:
    """Find the time of the rows; `stand` tells whether all first cells of a column are equal."""
    candidates = []
    nanoseconds: dict[Words, int] = {}  # the first column of each topic
    for k, meaning in enumerate(meanings):
        if meaning.role == "nanosec":
            nanoseconds.setdefault(meaning.group[:-1], k)
    for k, meaning in enumerate(meanings):
        name = names[k].strip()
        rank = _ROW_TIME if name.startswith("__") else _ANY + ("duration" in meaning.group)
        if rank and "stamp" in meaning.group and name != "stamp":
            rank = _STAMP
        if meaning.role == "time" and not stand[k]:
            candidates.append((rank, TimeColumns((k,), meaning.unit, "name")))
        pair = nanoseconds.get(meaning.group[:-1]) if meaning.role == "sec" else None
        if pair is not None and not (stand[k] and stand[pair]):
            candidates.append((min(rank, _STAMP), TimeColumns((k, pair), "s", "seconds and nanoseconds")))
    if not candidates:
        counts = [k for k, meaning in enumerate(meanings) if meaning.role == "index" and not stand[k]]
        return TimeColumns((counts[0],), SAMPLE, "name") if len(counts) == 1 else None
    best = min(rank for rank, _ in candidates)
    choices = [columns for rank, columns in candidates if rank == best]
    if len(choices) > 1:
        listed = [names[columns.columns[0]] for columns in choices]
        if len({*listed}) < len(listed):
            listed = [f"#{columns.columns[0] + 1}" for columns in choices]
        step = "choose one: " + " or ".join(f"--map {shlex.quote(f'time={name}')}" for name in listed[:4])
        raise refusal("several columns may be the time", where, "one column of time", ", ".join(listed), step)
    return choices[0]
