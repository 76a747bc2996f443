"""Names of an arm's joints as logs write them: in words and by number."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from gd_analyze.motions.vocabulary import (
    MEANINGS,
    MOTION_QUANTITIES,
    VOCABULARY,
    Words,
    placed_words,
    words_in,
)

_FILLERS, _LETTERS = VOCABULARY["joint"]["plain"], VOCABULARY["joint"]["letters"]


@dataclass(frozen=True)
class JointNames:
    """What names an arm's joints, which count from 0, in the columns of a log."""

    phrases: Mapping[Words, int]  # joint by the words that name it
    known: frozenset[str] = frozenset()  # words of these names, which say nothing else
    given: bool = False  # whether the user gives them: then a letter may be a name
    n_joints: int = 0
    numbers: Mapping[int, int] = field(default_factory=dict)  # joint by number
    label: Words | None = None  # what stands beside the numbers; None if these count along the chain
    partial: bool = False  # whether other joints, such as a rail, have no number

    @classmethod
    def of(cls, names: Sequence[str], given: Sequence[str] = ()) -> JointNames:
        """Those of an arm's joints, or what the user gives in their place; numbers are always the arm's."""
        phrases = {words_in(name): joint for joint, name in enumerate(given)} or _phrases(names)
        words = {word for name in names for word in words_in(name) if len(word) > 1}
        known = frozenset() if given else frozenset(words)
        return cls(phrases, known, bool(given), len(names), *_numbering(names))

    def numbered(self, numbers: Mapping[int, int]) -> dict[int, int | None]:
        """Joint of each column, given its number in the log, which may begin elsewhere."""
        shift = int(0 not in self.numbers) - int(0 not in numbers.values())
        return {column: self.numbers.get(number + shift) for column, number in numbers.items()}


def _phrases(names: Sequence[str]) -> dict[Words, int]:
    """Words of each joint, also without "joint" and without words with which all names begin.

    Names that only count, joint_1 or A1, are left to numbers.
    """
    split = [words_in(name) for name in names]
    shared = next((k for k, words in enumerate(zip(*split, strict=False)) if len({*words}) > 1), 0)
    phrases: dict[Words, int | None] = {}
    for joint, words in enumerate(split):
        for part in (words, words[shared:]):
            bare = tuple(word for word in part if word not in _FILLERS)
            if not all(word.isdigit() or word in _LETTERS or _is_quantity(word) for word in bare):
                phrases |= {p: joint if phrases.get(p, joint) == joint else None for p in (part, bare)}
    return {words: joint for words, joint in phrases.items() if joint is not None}


def _numbering(names: Sequence[str]) -> tuple[dict[int, int], Words | None, bool]:
    """Joints by the numbers in their names, or else along the chain: `numbers`, `label` and `partial`.

    Numbers of some joints count only where counting along the chain would differ, as above a rail, and not
    where they count joints of a kind, such as wrist_1 to wrist_3 of six.
    """
    groups: dict[Words, dict[int, int]] = {}
    for joint, name in enumerate(names):
        words = [word for word in placed_words(name) if word.text not in _FILLERS]
        counts = [word for word in words if word.is_count]
        if counts:
            label = tuple(word.text for word in words if word is not counts[-1])
            groups.setdefault(label, {})[int(counts[-1].text)] = joint
    if len(groups) == 1 and len(next(iter(groups.values()))) == len(names):
        ((label, joints),) = groups.items()
        return joints, label, False
    decisive = [
        (label, joints)
        for label, joints in groups.items()
        # A label such as a or q says nothing.
        if (all(len(word) == 1 or _is_quantity(word) for word in label) or 2 * len(joints) > len(names))
        and any(number - (0 not in joints) != joint for number, joint in joints.items())
    ]
    if len(decisive) == 1:
        return decisive[0][1], decisive[0][0], True
    return {joint + 1: joint for joint in range(len(names))}, None, False


def _is_quantity(word: str) -> bool:
    meaning = MEANINGS.get((word,))
    return meaning is not None and meaning.of in MOTION_QUANTITIES
