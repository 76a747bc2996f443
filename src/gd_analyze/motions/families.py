"""Columns of one role that belong together, and which joint of the arm each is of: by name, or by number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gd_analyze.motions.reading import ROLES
from gd_analyze.motions.roles import (
    Kind,
    Meaning,
    Words,
    as_written,
    joint_of,
    topic_of,
    without_fillers,
    words_of,
)


@dataclass(frozen=True)
class Family:
    """Columns of one role, one per joint."""

    # As the names say, see `Meaning`
    role: str
    group: Words
    kind: Kind
    rank: int
    word: str
    label: Words  # words beside the number of the joint
    columns: Mapping[int, tuple[int, ...]]  # columns of each joint of the arm, from 0; there should be one
    extra: tuple[int, ...]  # columns of joints that the arm lacks
    why: str  # how the joints were matched
    renamed: tuple[tuple[str, str], ...] = ()  # log's name and arm's name of joints whose names differ

    @property
    def key(self) -> tuple[object, ...]:
        """What tells it from others."""
        return self.role, self.group, self.label, self.rank, self.word

    @property
    def words(self) -> frozenset[str]:
        """Words that choose it."""
        return frozenset((*self.group, *self.label, self.kind, self.word))

    @property
    def topic(self) -> Words:
        """Words of where it comes from, be it measured or commanded."""
        return topic_of(self.group)

    @property
    def all_columns(self) -> tuple[int, ...]:
        """Every column of it."""
        return tuple(column for columns in self.columns.values() for column in columns)


# A match: label, columns by joint, columns of other joints, reason, pairs of names.
_Match = tuple[Words, Mapping[int, tuple[int, ...]], Sequence[int], str, tuple[tuple[str, str], ...]]


def families_of(meanings: Sequence[Meaning], names: Sequence[str], written: Sequence[str]) -> list[Family]:
    """Sort columns, by meaning and name as written, into families and match each with the arm's joints."""
    groups: dict[tuple[str, Words, Kind, int, str], list[int]] = {}
    # A log that numbers its joints tells by other words what else it has of each: TorqueSm1 beside Position1.
    counts = any(m.role in ROLES and m.number is not None and not m.label for m in meanings)
    for column, meaning in enumerate(meanings):
        if meaning.role in ROLES:
            key = (meaning.role, meaning.group, meaning.kind, meaning.rank, meaning.word)
            groups.setdefault(key, []).append(column)
    return [
        Family(*key, label, columns, tuple(extra), why, renamed)
        for key, of in groups.items()
        for label, columns, extra, why, renamed in _matched(of, meanings, names, written, counts)
    ]


def _matched(
    columns: Sequence[int],
    meanings: Sequence[Meaning],
    names: Sequence[str],
    written: Sequence[str],
    beside: bool,
) -> list[_Match]:
    """Matches among columns whose names differ in the joint alone."""
    rest = [c for c in columns if meanings[c].joint is None]
    by_joint: dict[int, tuple[int, ...]] = {}
    for column in columns:
        joint = meanings[column].joint
        if joint is not None:
            by_joint[joint] = (*by_joint.get(joint, ()), column)
    if by_joint:
        return [((), by_joint, rest, "by name", ())]
    affixed = _by_affix(rest, meanings, names)
    if affixed is not None:
        return [affixed]
    counted: dict[Words, list[int]] = {}
    for column in rest:
        if meanings[column].number is not None:
            counted.setdefault(meanings[column].label, []).append(column)
    tried = (_by_number(label, of, meanings, names, written, beside) for label, of in counted.items())
    found = [match for match in tried if match is not None]
    if len(names) == 1 and len(rest) == 1 and not found and not meanings[rest[0]].label:
        return [((), {0: (rest[0],)}, (), "the arm's only joint", ())]
    return found


def arms_numbers(names: Sequence[str]) -> tuple[Words, tuple[int, ...]] | None:
    """Label and numbers of joints whose names differ in a number alone; None of others."""
    split = [joint_of(words_of(name)) for name in names]
    numbers = tuple(number for _, number in split if number is not None)
    if len(set(numbers)) < len(names) or len({label for label, _ in split}) > 1:
        return None
    return split[0][0], numbers


def _by_number(
    label: Words,
    columns: Sequence[int],
    meanings: Sequence[Meaning],
    names: Sequence[str],
    written: Sequence[str],
    beside: bool,
) -> _Match | None:
    """Match numbered columns; with words beside the numbers, only with an arm that numbers its joints too."""
    counts = arms_numbers(names)
    if label and not beside and counts is None:
        return None
    numbers = {c: meanings[c].number or 0 for c in columns}
    base = 0 if 0 in numbers.values() else 1
    own = range(len(names)) if counts is None else [k - (0 if 0 in counts[1] else 1) for k in counts[1]]
    joints = {number: joint for joint, number in enumerate(own)}
    matched: dict[int, tuple[int, ...]] = {}
    for column, number in numbers.items():
        joint = joints.get(number - base)
        if joint is not None:
            matched[joint] = (*matched.get(joint, ()), column)
    extra = [column for column, number in numbers.items() if number - base not in joints]
    renamed: tuple[tuple[str, str], ...] = ()
    if label and not beside and counts is not None and counts[0] != label:
        renamed = tuple(
            (as_written(meanings[of[0]].token, written[of[0]]), names[joint])
            for joint, of in sorted(matched.items())
        )
    return label, matched, extra, f"by number, from {base}", renamed


def _by_affix(columns: Sequence[int], meanings: Sequence[Meaning], names: Sequence[str]) -> _Match | None:
    """Match names that differ in the same words before all of them, such as a prefix of the robot."""
    own = [without_fillers(words_of(name)) for name in names]
    logged = {c: without_fillers(meanings[c].token) for c in columns}
    if not all(any(not word.isdigit() for word in words) for words in own):
        return None
    # Words that the log has before a joint's; after "", words that it lacks.
    prefixes: dict[Words, None] = {}
    for words in logged.values():
        for joint in own:
            if words[-len(joint) :] == joint:
                prefixes.setdefault(words[: -len(joint)])
            if joint[-len(words) :] == words and words:
                prefixes.setdefault(("", *joint[: -len(words)]))
    for prefix in sorted(prefixes, key=len):
        lacks = prefix[:1] == ("",)
        if lacks and any(("", *joint[: len(prefix) - 1]) != prefix for joint in own):
            continue
        wanted = [joint[len(prefix) - 1 :] if lacks else prefix + joint for joint in own]
        matched = {j: tuple(c for c in columns if logged[c] == words) for j, words in enumerate(wanted)}
        if all(matched.values()):
            used = {c for of in matched.values() for c in of}
            beside = " ".join(prefix).strip()
            why = f"by name, but for {beside!r}" if beside else "by name"
            return (), matched, [c for c in columns if c not in used], why, ()
    return None
