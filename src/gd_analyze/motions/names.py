"""What the name of a column says: quantity, joint, measured or target, unit; and the names alike."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from gd_analyze.motions.column_units import fits_some_joint, unit_taken_out
from gd_analyze.motions.joint_names import JointNames
from gd_analyze.motions.vocabulary import (
    LONGEST_PHRASE,
    MEANINGS,
    MOTION_QUANTITIES,
    VOCABULARY,
    Meaning,
    Phrase,
    Words,
    meanings_of,
    placed_words,
)

_TIME, _JOINT = VOCABULARY["time"], VOCABULARY["joint"]
EXTERNAL = tuple(_JOINT["external"])
_LETTERS = _JOINT["letters"] | _JOINT["external"]
_KNOWN = frozenset(word for phrase in MEANINGS for word in phrase)
# Rank of the bare name of a joint, behind those of `Meaning`.
_BARE = 3
# An axis by its letter, which is a capital where nothing else names a joint: A1, E1.
_AXIS = re.compile(r"(?<![A-Za-z])[AE](?=[0-9])")
TIMED = ("time", "sec", "nanosec", "index")
OTHER = "no quantity of the joints' motion"
_SET_POINT_COLUMN = re.compile(r"time|(qdd|qd|q)[1-9][0-9]{0,5}(_deg)?")


def are_of_set_points(names: Sequence[str]) -> bool:
    """Whether the names, but for empty ones, are those of a file of set points: time, q1, qd1_deg."""
    named = [name.strip().lower() for name in names if name]
    return bool(named) and all(map(_SET_POINT_COLUMN.fullmatch, named))


@dataclass(frozen=True)
class ColumnName:
    """What a column's name says."""

    text: str  # as written
    role: str = "other"  # a quantity of `MOTION_QUANTITIES`, one of `TIMED`, "names" of joints, or "other"
    kind: str = ""  # "measured", "target" or "" if it does not say
    rank: int = 0  # 0 for `q`, 1 for `position`, 2 for `theta`, 3 for the name of a joint alone
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
    segments = [_derived(words) for start, part in parts if (words := placed_words(part, start))]
    words = [word for segment in segments for word in segment]
    joint_words, joint = _joint_in(segments, joints)
    role = "" if joint is not None and joints.given else _role_of_time(segments)
    if role:
        return ColumnName(text, role, unit=unit, topic=tuple(word.text for word in words))
    tokens = [_tokens([word for word in segment if word not in joint_words]) for segment in segments]
    if _is_of_further_point(tokens) or _is_other(tokens):
        return ColumnName(text, unit=unit, fault=OTHER)
    every = [token for segment in tokens for token in segment]
    at, quantity = _quantity(tokens)
    rank = _BARE if quantity is None else quantity.rank
    kinds = {token.meaning.kind for token in every if token.meaning is not None}
    if words and words[0].text in VOCABULARY["kind"]["first_target"]:
        kinds.add("target")
    # "current position" is measured; a torque that follows from a current is second choice.
    if quantity is not None and quantity.of != "current" and any(t.means("current") for t in tokens[at]):
        kinds, rank = (kinds, 3) if quantity.of == "torque" else ({*kinds, "measured"}, rank)
    beside = _beside_joint(tokens) if joint is None else ()
    count = next((token for token in reversed(beside) if token.is_count), None)
    star = joint_words if count is None else [word for word in words if word.start == count.start]
    in_a_row = star and words.index(star[-1]) - words.index(star[0]) == len(star) - 1
    strange = [token for token in every if token.is_strange]
    name = ColumnName(
        text,
        role="other" if quantity is None else quantity.of,
        kind="target" if "target" in kinds else max(kinds, default=""),
        rank=rank,
        unit=unit or ("" if quantity is None else quantity.unit),
        joint=joint,
        number=None if count is None else int(count.text),
        label=tuple(token.text for token in strange if token in beside),
        topic=tuple(sorted(token.text for token in strange if token not in beside)),
        pattern=f"{text[: star[0].start]}*{text[star[-1].end :]}" if in_a_row else "",
        key=tuple("*" if word is star[0] else word.text for word in words if word not in star[1:])
        if star
        else (),
    )
    if any(token.means("names") for token in every):
        return replace(name, role="names")
    if quantity is None and _is_position(name, every, joints):
        name = replace(name, role="q")
    role = "torque" if name.role == "current" else name.role
    is_foreign = role != "other" and name.unit and not fits_some_joint(name.unit, role)
    return replace(name, fault=f"in {name.unit}, no unit of {role}") if is_foreign else name


def _derived(words: list[Phrase]) -> list[Phrase]:
    """Words of a segment, the dot of q1_dot before the number."""
    for k in range(1, len(words)):
        if words[k].text in ("dot", "ddot") and words[k - 1].is_count:
            words[k - 1], words[k] = words[k], words[k - 1]
    return words


def _joint_in(segments: list[list[Phrase]], joints: JointNames) -> tuple[list[Phrase], int | None]:
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


def _tokens(words: Sequence[Phrase]) -> list[Phrase]:
    """Phrases of a segment, each as long as possible; the letter of A1 says no more than "axis"."""
    tokens: list[Phrase] = []
    k = 0
    while k < len(words):
        lengths = range(min(LONGEST_PHRASE, len(words) - k), 0, -1)
        length = next((n for n in lengths if tuple(w.text for w in words[k : k + n]) in MEANINGS), 1)
        phrase = words[k : k + length]
        k += length
        texts = tuple(word.text for word in phrase)
        for meaning in meanings_of(texts) or (None,):
            tokens.append(Phrase(" ".join(texts), phrase[0].start, phrase[-1].end, meaning))
    # In joint_a1 and tau_a_1 it may be a name.
    if not any(token.text in ("joint", "jnt") or token.means(*MOTION_QUANTITIES) for token in tokens):
        for k, (token, following) in enumerate(pairwise(tokens)):
            if token.text in _JOINT["letters"] and following.is_count:
                tokens[k] = replace(token, meaning=MEANINGS["axis",])
    return tokens


def _role_of_time(segments: Sequence[Sequence[Phrase]]) -> str:
    if not segments:
        return ""
    last = {word.text for word in segments[-1]}
    *before, end = (word.text for segment in segments for word in segment)
    of_stamp = not before or bool({"stamp", "time", "start"} & {*before})
    for role, fields in (("sec", _TIME["seconds"]), ("nanosec", _TIME["nanoseconds"])):
        if of_stamp and end in fields:
            return role
    if last & _TIME["plain"] and last <= _TIME["plain"] | _TIME["beside"]:
        return "time"
    counts = last & _TIME["samples"] and last <= _TIME["samples"] | {"number", "no"}
    return "index" if counts else ""


def _is_of_further_point(tokens: Sequence[Sequence[Phrase]]) -> bool:
    """Whether it is of another than the first point of a message: points[1].positions[0]."""
    points = next((segment for segment in tokens if any(t.text == "points" for t in segment)), ())
    return any(token.is_count and int(token.text) > 0 for token in points)


def _is_other(tokens: Sequence[Sequence[Phrase]]) -> bool:
    """Whether a word says another quantity than one of the joint's motion."""
    last = next((segment for segment in reversed(tokens) if segment), [])
    anywhere = VOCABULARY["other"]["anywhere"]
    return any(t.means("other") for t in last) or any(t.text in anywhere for s in tokens for t in s)


def _quantity(tokens: Sequence[Sequence[Phrase]]) -> tuple[int, Meaning | None]:
    """Segment and meaning of the quantity: of the last segment that names one, its first."""
    for tables in (MOTION_QUANTITIES[:-1], MOTION_QUANTITIES[-1:]):
        for at in reversed(range(len(tokens))):
            for token in tokens[at]:
                if token.means(*tables):
                    return at, token.meaning
    return -1, None


def _beside_joint(tokens: Sequence[Sequence[Phrase]]) -> Sequence[Phrase]:
    """The last segment with the joint's number, or else with a word that is not known."""
    numbered = [segment for segment in tokens if any(token.is_count for token in segment)]
    strange = [segment for segment in tokens if any(token.is_strange for token in segment)]
    return next(reversed(numbered or strange), ())


def _is_position(name: ColumnName, tokens: Sequence[Phrase], joints: JointNames) -> bool:
    """Whether a name without a quantity is that of a joint, and so of its position."""
    # The letter of joint_a1 and E1, but not of J1_A.
    has_letter = any((letter, "*") in pairwise(name.key) for letter in _LETTERS)
    says_joint = bool(_AXIS.search(name.text)) or any(
        token.means("joint") and token.text not in _LETTERS for token in tokens
    )
    strange = {*name.label, *name.topic} - joints.known - ({*name.label} & _LETTERS if has_letter else set())
    counts = name.number is not None and (says_joint or all(token.is_count for token in tokens))
    is_strangers = not name.says_joint and says_joint
    return is_strangers or ((name.joint is not None or counts) and not strange)
