"""Which joint of the arm is which of the log: by name, or by number where the log itself counts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

from gd_analyze.motions.reading import ROLES
from gd_analyze.motions.role_words import Kind
from gd_analyze.motions.roles import Meaning, topic_of
from gd_analyze.motions.words import FILLERS, Words, as_written, joint_of, words_of


@dataclass(frozen=True)
class Family:
    """Columns of one role that belong together, one per joint.

    Parameters
    ----------
    role, group, kind, rank, word
        As the names say, see `Meaning`.
    label
        Words beside the number by which the log counts.
    columns
        Per joint of the arm, from 0: its columns, of which there should be one.
    extra
        Columns of joints that the arm lacks.
    why
        By what the joints were matched.
    renamed
        Log's name and arm's name of joints that are not called alike.
    """

    role: str
    group: Words
    kind: Kind
    rank: int
    label: Words
    columns: Mapping[int, tuple[int, ...]]
    extra: tuple[int, ...]
    why: str
    renamed: tuple[tuple[str, str], ...] = ()
    word: str = ""

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


def families_of(meanings: Sequence[Meaning], names: Sequence[str], columns: Sequence[str]) -> list[Family]:
    """Sort columns into families, each matched with the arm's joints.

    Parameters
    ----------
    meanings
        Of every column of the log.
    names
        Names of the arm's joints.
    columns
        Names of the log's columns.
    """
    groups: dict[tuple[str, Words, Kind, int, str], list[int]] = {}
    # A log that counts its joints tells by other words what else it has of each: TorqueSm1 beside Position1.
    counts = any(
        meaning.role in ROLES and meaning.number is not None and not meaning.label for meaning in meanings
    )
    for column, meaning in enumerate(meanings):
        if meaning.role in ROLES:
            key = (meaning.role, meaning.group, meaning.kind, meaning.rank, meaning.word)
            groups.setdefault(key, []).append(column)
    found = []
    for (role, group, kind, rank, word), of in groups.items():
        for family in _matched(of, meanings, names, columns, counts):
            found.append(replace(family, role=role, group=group, kind=kind, rank=rank, word=word))
    return found


def _matched(
    columns: Sequence[int],
    meanings: Sequence[Meaning],
    names: Sequence[str],
    written: Sequence[str],
    beside: bool,
) -> list[Family]:
    """Families among columns whose names differ in the joint alone."""
    named = [c for c in columns if meanings[c].joint is not None]
    rest = [c for c in columns if meanings[c].joint is None]
    families = []
    if named:
        by_joint: dict[int, tuple[int, ...]] = {}
        for column in named:
            joint = meanings[column].joint or 0
            by_joint[joint] = (*by_joint.get(joint, ()), column)
        families.append(_family((), by_joint, rest, "by name"))
        return families
    by_label: dict[Words, list[int]] = {}
    for column in rest:
        by_label.setdefault(meanings[column].label, []).append(column)
    with_numbers = {
        label: [c for c in of if meanings[c].number is not None] for label, of in by_label.items()
    }
    counted = {label: of for label, of in with_numbers.items() if of}
    affixed = _by_affix(rest, meanings, names)
    if affixed is not None:
        return [affixed]
    for label, of in counted.items():
        matched = _by_number(label, of, meanings, names, written, beside)
        if matched is not None:
            families.append(matched)
    if len(names) == 1 and len(rest) == 1 and not families and not meanings[rest[0]].label:
        families.append(_family((), {0: (rest[0],)}, (), "the arm's only joint"))
    return families


def _family(label: Words, columns: Mapping[int, tuple[int, ...]], extra: Sequence[int], why: str) -> Family:
    return Family("", (), "plain", 0, label, columns, tuple(extra), why)


def arms_numbers(names: Sequence[str]) -> tuple[Words, tuple[int, ...]] | None:
    """Label and numbers of joints that are called alike but for a number; None of others."""
    split = [joint_of(words_of(name)) for name in names]
    numbers = tuple(number for _, number in split if number is not None)
    if len(numbers) < len(names) or len(set(numbers)) < len(names) or len({label for label, _ in split}) > 1:
        return None
    return split[0][0], numbers


def _by_number(
    label: Words,
    columns: Sequence[int],
    meanings: Sequence[Meaning],
    names: Sequence[str],
    written: Sequence[str],
    beside: bool,
) -> Family | None:
    """Match columns that count; with words beside the numbers, only with an arm that counts as well."""
    counts = arms_numbers(names)
    if label and not beside and counts is None:
        return None
    numbers = {c: meanings[c].number or 0 for c in columns}
    base = 0 if 0 in numbers.values() else 1
    joints = dict(enumerate(range(len(names))))
    if counts is not None:
        first = 0 if 0 in counts[1] else 1
        joints = {number - first: joint for joint, number in enumerate(counts[1])}
    matched: dict[int, tuple[int, ...]] = {}
    extra = []
    for column, number in numbers.items():
        joint = joints.get(number - base)
        if joint is None:
            extra.append(column)
        else:
            matched[joint] = (*matched.get(joint, ()), column)
    renamed: tuple[tuple[str, str], ...] = ()
    if label and not beside and counts is not None and counts[0] != label:
        renamed = tuple(
            (as_written(meanings[of[0]].token, written[of[0]]), names[joint])
            for joint, of in sorted(matched.items())
        )
    return replace(_family(label, matched, extra, f"by number, from {base}"), renamed=renamed)


def _by_affix(columns: Sequence[int], meanings: Sequence[Meaning], names: Sequence[str]) -> Family | None:
    """Match names that are alike but for the same words before, such as a prefix of the robot."""
    own = [_bare(words_of(name)) for name in names]
    logged = {c: _bare(meanings[c].token) for c in columns}
    if not all(any(not word.isdigit() for word in words) for words in own):
        return None
    shortest: dict[Words, None] = {}
    for words in logged.values():
        for joint in own:
            if words[-len(joint) :] == joint:
                shortest.setdefault(words[: -len(joint)])
            if joint[-len(words) :] == words and words:
                shortest.setdefault(("", *joint[: -len(words)]))
    for prefix in sorted(shortest, key=len):
        wanted = [joint[len(prefix) - 1 :] if prefix[:1] == ("",) else prefix + joint for joint in own]
        if prefix[:1] == ("",) and any(("", *joint[: len(prefix) - 1]) != prefix for joint in own):
            continue
        matched = {j: tuple(c for c in columns if logged[c] == words) for j, words in enumerate(wanted)}
        if all(matched.values()):
            used = {c for of in matched.values() for c in of}
            beside = " ".join(prefix).strip()
            why = f"by name, but for {beside!r}" if beside else "by name"
            return _family((), matched, [c for c in columns if c not in used], why)
    return None


def _bare(words: Words) -> Words:
    return tuple(word for word in words if word not in FILLERS)
