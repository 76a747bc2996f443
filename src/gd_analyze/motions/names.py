"""What the name of a column says: quantity, joint, measured or target, unit; and the names alike."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from gd_analyze.motions.column_units import fits_some_joint, unit_taken_out
from gd_analyze.motions.vocabulary import (
    LONGEST_PHRASE,
    MEANINGS,
    MOTION_QUANTITIES,
    VOCABULARY,
    Meaning,
    NameWord,
    Words,
    placed_words,
    split_in_two,
    words_in,
)

_TIME, _JOINT = VOCABULARY["time"], VOCABULARY["joint"]
EXTERNAL = tuple(_JOINT["external"])
_LETTERS = _JOINT["letters"] | _JOINT["external"]
_KNOWN = VOCABULARY["unit"]["treatment"] | {word for phrase in MEANINGS for word in phrase}
# Rank of the bare name of a joint; 0 and 1 are those of a quantity's usual words and of second choice.
_BARE = 2
TIMED = ("time", "sec", "nanosec", "index")
OTHER = "no quantity of the joints' motion"
_SET_POINT_COLUMN = re.compile(r"time|(qdd|qd|q)[1-9][0-9]{0,5}(_deg)?")


def are_of_set_points(names: Sequence[str]) -> bool:
    """Whether the names, but for empty ones, are those of a file of set points: time, q1, qd1_deg."""
    named = [name.strip().lower() for name in names if name]
    return bool(named) and all(map(_SET_POINT_COLUMN.fullmatch, named))


@dataclass(frozen=True)
class JointNames:
    """Names of an arm's joints in a log, each as the words that name it in a column."""

    phrases: Mapping[Words, int]  # joint, from 0
    known: frozenset[str] = frozenset()  # words of these names, which say nothing else
    given: bool = False  # whether the user gives them: then a letter may be a name

    @classmethod
    def of(cls, names: Sequence[str]) -> JointNames:
        """Those of an arm's joints, also without "joint" and without words with which all of them begin.

        Names that only count, joint_1 or A1, are left to numbers.
        """
        split = [words_in(name) for name in names]
        shared = next((k for k, words in enumerate(zip(*split, strict=False)) if len({*words}) > 1), 0)
        phrases: dict[Words, int | None] = {}
        for joint, words in enumerate(split):
            for part in (words, words[shared:]):
                bare = tuple(word for word in part if word not in _JOINT["plain"])
                if any(
                    not (word.isdigit() or word in _JOINT["letters"] or _is_quantity(word)) for word in bare
                ):
                    phrases |= {p: joint if phrases.get(p, joint) == joint else None for p in (part, bare)}
        known = frozenset(word for words in split for word in words if len(word) > 1)
        return cls({words: joint for words, joint in phrases.items() if joint is not None}, known)

    @classmethod
    def as_given(cls, names: Sequence[str]) -> JointNames:
        """Those that the user lists in the order of the arm's joints."""
        return cls({words_in(name): joint for joint, name in enumerate(names)}, given=True)


def _is_quantity(word: str) -> bool:
    meaning = MEANINGS.get((word,))
    return meaning is not None and meaning.of in MOTION_QUANTITIES


@dataclass(frozen=True)
class ColumnName:
    """What a column's name says."""

    text: str  # as written
    role: str = "other"  # a quantity of `MOTION_QUANTITIES`, one of `TIMED`, "names" of joints, or "other"
    kind: str = ""  # "measured", "target" or "" if it does not say
    rank: int = 0  # 0 for `q` and `position`, 1 for `theta`, 2 for the name of a joint alone
    unit: str = ""  # stated in the name
    joint: int | None = None  # the arm's joint that it names, from 0
    number: int | None = None  # of the joint, in a name without the arm's
    label: Words = ()  # unknown words beside the number, which may name the joint: fer of fer_joint1
    topic: Words = ()  # the other unknown words, which say where it comes from
    pattern: str = ""  # with a star in place of the joint
    key: Words = ()  # of the names that differ from this in the joint only
    fault: str = ""  # why it is none of the quantities

    @property
    def says_joint(self) -> bool:
        """Whether a joint of the arm or a number is named."""
        return self.joint is not None or self.number is not None

    @property
    def is_unclear(self) -> bool:
        """Whether it may be any quantity of a joint, by words that are not known."""
        is_quantity = self.role != "other" and not (self.role == "current" and (self.label or self.topic))
        return self.says_joint and not is_quantity and not self.fault


@dataclass(frozen=True)
class _Token:
    """A phrase of a name."""

    text: str
    start: int
    end: int
    meaning: Meaning | None  # None for a number, and for a word that is not known

    @property
    def is_count(self) -> bool:
        return self.meaning is None and self.text.isascii() and self.text.isdigit() and len(self.text) < 7

    @property
    def is_strange(self) -> bool:
        """Whether it is a word that is not known."""
        return self.meaning is None and not self.is_count

    def means(self, *tables: str) -> bool:
        return self.meaning is not None and self.meaning.of in tables


def column_name(text: str, joints: JointNames) -> ColumnName:
    """Read a column's name.

    Examples
    --------
    >>> name = column_name("actual_q_0 [deg]", JointNames.of(["elbow", "wrist"]))
    >>> name.role, name.kind, name.number, name.unit, name.pattern
    ('q', 'measured', 0, 'deg', 'actual_q_* [deg]')
    >>> column_name("elbow.vel", JointNames.of(["elbow", "wrist"])).joint
    0
    """
    bare, unit = unit_taken_out(text, _KNOWN | joints.known)
    parts = ((match.start(), match[0]) for match in re.finditer(r"[^/.]+", bare))
    segments = [words for start, part in parts if (words := placed_words(part, start))]
    joint_words, joint = _joint_in(segments, joints)
    texts = [[word.text for word in segment] for segment in segments]
    role = "" if joint is not None and joints.given else _role_of_time(texts)
    if role:
        return ColumnName(text, role, unit=unit, topic=tuple(word for words in texts for word in words))
    tokens = [_tokens([word for word in segment if word not in joint_words]) for segment in segments]
    if _is_of_further_point(tokens) or _is_other(tokens):
        return ColumnName(text, unit=unit, fault=OTHER)
    at, quantity = _quantity(tokens)
    kinds = {token.meaning.kind for segment in tokens for token in segment if token.meaning is not None}
    if segments and segments[0][0].text in VOCABULARY["kind"]["first_target"]:
        kinds.add("target")
    rank = _BARE if quantity is None else int(quantity.second)
    # "current position" is measured; a torque that follows from a current is second choice.
    if quantity is not None and quantity.of != "current" and any(t.means("current") for t in tokens[at]):
        kinds, rank = (kinds, 1) if quantity.of == "torque" else ({*kinds, "measured"}, rank)
    name = ColumnName(
        text,
        role="other" if quantity is None else quantity.of,
        kind="target" if "target" in kinds else max(kinds, default=""),
        rank=rank,
        unit=unit or ("" if quantity is None else quantity.unit),
        joint=joint,
    )
    return _judged(_with_joint(name, segments, tokens, at, joint_words), tokens, joints)


def _joint_in(segments: list[list[NameWord]], joints: JointNames) -> tuple[list[NameWord], int | None]:
    """Words of the joint that is named, the longest name first, and its number.

    Words of the kind may stand among them: axis_a_1 is named by AXIS_ACT_A1.
    """
    present = {word.text for segment in segments for word in segment}
    for phrase in sorted(joints.phrases, key=len, reverse=True):
        for skipped in ((), ("kind", *MOTION_QUANTITIES)) if present >= {*phrase} else ():
            for segment in segments:
                words = [w for w in segment if not (m := MEANINGS.get((w.text,))) or m.of not in skipped]
                for first in range(len(words) - len(phrase) + 1):
                    matched = words[first : first + len(phrase)]
                    if tuple(word.text for word in matched) == phrase:
                        return matched, joints.phrases[phrase]
    return [], None


def _tokens(words: Sequence[NameWord]) -> list[_Token]:
    """Phrases of a segment, each as long as possible; the letter of A1 says no more than "axis"."""
    tokens: list[_Token] = []
    k = 0
    while k < len(words):
        lengths = range(min(LONGEST_PHRASE, len(words) - k), 0, -1)
        length = next((n for n in lengths if tuple(w.text for w in words[k : k + n]) in MEANINGS), 1)
        phrase = words[k : k + length]
        k += length
        texts = tuple(word.text for word in phrase)
        meanings = (MEANINGS.get(texts),) if texts in MEANINGS else split_in_two(texts[0]) or (None,)
        tokens += [_Token(" ".join(texts), phrase[0].start, phrase[-1].end, meaning) for meaning in meanings]
    # In joint_a1 and tau_a_1 it may be a name.
    if not any(token.text in ("joint", "jnt") or token.means(*MOTION_QUANTITIES) for token in tokens):
        for k, (token, following) in enumerate(pairwise(tokens)):
            if token.text in _JOINT["letters"] and following.is_count:
                tokens[k] = replace(token, meaning=MEANINGS["axis",])
    return tokens


def _role_of_time(segments: Sequence[Sequence[str]]) -> str:
    if not segments:
        return ""
    last, (*before, end) = {*segments[-1]}, (word for segment in segments for word in segment)
    of_stamp = not before or bool({"stamp", "time", "start"} & {*before})
    for role, fields in (("sec", _TIME["seconds"]), ("nanosec", _TIME["nanoseconds"])):
        if of_stamp and end in fields:
            return role
    if last & _TIME["plain"] and last <= _TIME["plain"] | _TIME["beside"]:
        return "time"
    counts = last & _TIME["samples"] and last <= _TIME["samples"] | {"number", "no"}
    return "index" if counts and len(segments) <= 3 else ""


def _is_of_further_point(tokens: Sequence[Sequence[_Token]]) -> bool:
    """Whether it is of another than the first point of a message: points[1].positions[0]."""
    points = next((segment for segment in tokens if any(t.text == "points" for t in segment)), ())
    return any(token.is_count and int(token.text) > 0 for token in points)


def _is_other(tokens: Sequence[Sequence[_Token]]) -> bool:
    """Whether a word says another quantity than one of the joint's motion."""
    last = next((segment for segment in reversed(tokens) if segment), [])
    anywhere = VOCABULARY["other"]["anywhere"]
    return any(t.means("other") for t in last) or any(t.text in anywhere for s in tokens for t in s)


def _quantity(tokens: Sequence[Sequence[_Token]]) -> tuple[int, Meaning | None]:
    """Segment and meaning of the quantity: of the last segment that names one, its first."""
    for tables in (MOTION_QUANTITIES[:-1], MOTION_QUANTITIES[-1:]):
        for at in reversed(range(len(tokens))):
            for token in tokens[at]:
                if token.means(*tables):
                    return at, token.meaning
    return -1, None


def _with_joint(
    name: ColumnName,
    segments: Sequence[Sequence[NameWord]],
    tokens: Sequence[Sequence[_Token]],
    at: int,
    joint_words: Sequence[NameWord],
) -> ColumnName:
    """Add the joint's place: its number, the words beside it, and what is left of the name without it."""
    # Looked for in the segment of the quantity, those behind it from the last one on, and those before it.
    behind, before = tokens[:at:-1] if at >= 0 else tokens[::-1], tokens[:at][::-1] if at > 0 else ()
    nearest = [*tokens[at : at + 1], *behind, *before]
    beside: Sequence[_Token] = ()
    if name.joint is None:
        beside = next((segment for segment in nearest if any(t.is_count for t in segment)), ())
        beside = beside or next((segment for segment in nearest if any(t.is_strange for t in segment)), ())
    count = next((token for token in reversed(beside) if token.is_count), None)
    words = [word for segment in segments for word in segment]
    star = [*joint_words] if count is None else [word for word in words if word.start == count.start]
    in_a_row = star and words.index(star[-1]) - words.index(star[0]) == len(star) - 1
    strange = [token for segment in tokens for token in segment if token.is_strange]
    return replace(
        name,
        number=None if count is None else int(count.text),
        label=tuple(token.text for token in strange if token in beside),
        topic=tuple(sorted(token.text for token in strange if token not in beside)),
        pattern=f"{name.text[: star[0].start]}*{name.text[star[-1].end :]}" if in_a_row else "",
        key=tuple("*" if word is star[0] else word.text for word in words if word not in star[1:])
        if star
        else (),
    )


def _judged(name: ColumnName, tokens: Sequence[Sequence[_Token]], joints: JointNames) -> ColumnName:
    """Decide whether a name without a quantity is a position, and refuse units that fit none."""
    every = [token for segment in tokens for token in segment]
    if any(token.means("names") for token in every):
        return replace(name, role="names")
    if name.role == "other":
        # The letter of joint_a1 and E1, but not of J1_A.
        has_letter = any((letter, "*") in pairwise(name.key) for letter in _LETTERS)
        says_joint = has_letter or any(token.means("joint") for token in every)
        strange = (
            {*name.label, *name.topic} - joints.known - ({*name.label} & _LETTERS if has_letter else set())
        )
        counts = name.number is not None and (says_joint or all(token.is_count for token in every))
        is_strangers = not name.says_joint and says_joint and not any(t.means("container") for t in every)
        if is_strangers or ((name.joint is not None or counts) and not strange):
            name = replace(name, role="q")
    role = "torque" if name.role == "current" else name.role
    if name.role != "other" and name.unit and not fits_some_joint(name.unit, role):
        return replace(name, fault=f"in {name.unit}, no unit of {role}")
    return name
