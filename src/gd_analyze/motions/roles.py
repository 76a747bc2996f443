"""What the name of a column says: role, joint, whose value it is, unit."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from gd_analyze.motions.role_words import (
    BLOCKED,
    COMPOSED,
    CONTAINERS,
    DERIVED,
    INDEX,
    MEASURED,
    ROLE_WORDS,
    SECOND_CHOICE,
    SET_POINT_COLUMN,
    SINGLE,
    TARGET,
    TIME_CORE,
    TIME_MORE,
    Kind,
    Said,
)
from gd_analyze.motions.words import FILLERS, Words, joint_of, unit_taken_out, words_of


@dataclass(frozen=True)
class Meaning:
    """What one name says.

    Parameters
    ----------
    role
        What the column seems to hold.
    token
        Words of the joint as they stand; `label` and `number` are what names it, and by what it counts.
    joint
        The arm's joint of exactly this name, from 0.
    group
        Words that tell it from columns of the same role and joint: topic, actual, target.
    kind
        Whether these say measured or target.
    unit
        Unit that the name states.
    rank
        How plain the role is: 0 of `q` and `position`, 1 of `theta`, 2 of the bare name of a joint.
    word
        The word that says the role.
    """

    role: Said
    token: Words = ()
    joint: int | None = None
    group: Words = ()
    kind: Kind = "plain"
    unit: str = ""
    rank: int = 0
    word: str = ""

    @property
    def label(self) -> Words:
        """Words that name the joint."""
        return joint_of(self.token)[0]

    @property
    def number(self) -> int | None:
        """Number by which the joint counts."""
        return joint_of(self.token)[1]


def meaning_of(name: str, joints: Mapping[Words, int]) -> Meaning:
    """Read a column's name.

    Parameters
    ----------
    name
        As it stands in the log.
    joints
        Words of the arm's joints' names, and their numbers from 0.
    """
    text, unit = unit_taken_out(name.strip().lstrip("%#"))
    segments = [_merged(words_of(part)) for part in re.split(r"[/.]", text)]
    segments = [segment for segment in segments if segment]
    timed = _time_said(segments)
    if timed is not None:
        return Meaning(timed, group=tuple(w for s in segments for w in s), unit=unit)
    if any(k and "points" in segment for segment in segments for k in [_joined_number(segment)]):
        return Meaning("other")  # a further point of a message
    if _is_blocked(segments):
        return Meaning("other", unit=unit)
    at, joint, segments = _known_joint(segments, joints)
    return _of_joint(segments, at, joint, unit)


def _joined_number(segment: Words) -> int:
    return next((int(word) for word in segment if word.isascii() and word.isdigit() and len(word) < 7), 0)


def _merged(words: Words) -> Words:
    """Words with `q dot` and `qdes` made plain."""
    out: list[str] = []
    for word in words:
        composed = COMPOSED.fullmatch(word)
        for part in composed.groups() if composed and word not in ROLE_WORDS else (word,):
            while out and (out[-1], part) in DERIVED:
                part = DERIVED[out.pop(), part]
            out.append(part)
    return tuple(out)


def _time_said(segments: Sequence[Words]) -> Said | None:
    if not segments:
        return None
    last = segments[-1]
    before = {word for segment in segments[:-1] for word in segment}
    end = last[-1] if last else ""
    stamped = before | set(last[:-1])
    if end in ("sec", "secs", "nanosec", "nanosecs", "nsec", "nsecs") and (
        len(segments) == len(last) == 1 or stamped & {"stamp", "time", "start"}
    ):
        return "nanosec" if end.startswith("n") else "sec"
    if set(last) & TIME_CORE and set(last) <= TIME_CORE | TIME_MORE:
        return "time"
    if len(segments) <= 3 and set(last) <= INDEX | {"number", "no"} and set(last) & INDEX:
        return "index"
    return None


def _is_blocked(segments: Sequence[Words]) -> bool:
    words = {word for segment in segments for word in segment}
    if "error" in words or "err" in words:
        return True
    last = set(segments[-1]) if segments else set()
    torque = any(ROLE_WORDS.get(word) == "torque" for word in last)
    blocked = last & BLOCKED
    if torque:  # TorqueCur: torque that follows from current
        blocked -= {"cur", "currents"}
    moving = any(word in ROLE_WORDS for segment in segments for word in segment)
    return bool(blocked) or ("current" in last and not moving)


def _known_joint(segments: list[Words], joints: Mapping[Words, int]) -> tuple[int, int | None, list[Words]]:
    """Segment and number of the arm's joint that is named, and the segments without its words."""
    for words in sorted(joints, key=len, reverse=True):
        for k, segment in enumerate(segments):
            for first in range(len(segment) - len(words) + 1):
                if segment[first : first + len(words)] == words:
                    rest = segment[:first] + segment[first + len(words) :]
                    return k, joints[words], [*segments[:k], rest, *segments[k + 1 :]]
    return -1, None, segments


def _of_joint(segments: list[Words], at: int, joint: int | None, unit: str) -> Meaning:
    """Meaning of a name that is not of time: role, joint and group from what its words are."""
    with_role = [k for k, segment in enumerate(segments) if any(word in ROLE_WORDS for word in segment)]
    role_at = with_role[-1] if with_role else -1
    role: Said = "other"
    rank, spelt = 0, ""
    words: list[tuple[int, str]] = []
    group: list[str] = []
    for k, segment in enumerate(segments):
        for i, word in enumerate(segment):
            if k == role_at and word in ROLE_WORDS and role == "other":
                role, rank, spelt = ROLE_WORDS[word], int(word in SECOND_CHOICE), word
            elif k == role_at and word == "d" and i and segment[i - 1] in (*ROLE_WORDS, "j"):
                group.append("desired")
            elif word in MEASURED or word in TARGET:
                group.append(word)
            else:
                words.append((k, word))
    token_at = _token_segment(segments, words, role_at, at)
    token = tuple(word for k, word in words if k == token_at) if joint is None else ()
    # What stands beside the joint tells families apart, containers do not.
    group += [w for k, w in words if (k != token_at or joint is not None) and not _says_nothing(w)]
    if role == "other":
        label, number = joint_of(token)
        if "name" in label or "names" in label:
            return Meaning("name", token)
        # A3 counts, joint_a3 is a name; of other words only those beside "joint" are joints' for certain.
        beside = bool(set(token) & {"joint", "jnt", "axis"})
        counts = number is not None and (not label or (not beside and len(label) == 1 and label[0] in SINGLE))
        # elbow is a position; elbow_enabled and elbow_x are something else of it.
        more = joint is not None and any(k == at and not _says_nothing(word) for k, word in words)
        if more or (joint is None and not counts and not beside):
            return Meaning("other", token, unit=unit)
        if counts:
            token = (str(number),)
        role, rank = "q", 2
    kind: Kind = "target" if set(group) & (TARGET) else "measured" if set(group) & MEASURED else "plain"
    return Meaning(role, token, joint, tuple(group), kind, unit, rank, spelt)


def _says_nothing(word: str) -> bool:
    return word in CONTAINERS or word in FILLERS or (word.isascii() and word.isdigit())


def _token_segment(segments: list[Words], words: list[tuple[int, str]], role_at: int, at: int) -> int:
    """Segment that names the joint: the role's own, the one behind it, or the one before."""
    if at >= 0:
        return at
    if role_at < 0:
        return words[-1][0] if words else -1
    for k in (role_at, *range(len(segments) - 1, role_at, -1), *range(role_at - 1, -1, -1)):
        own = [word for of, word in words if of == k]
        if any(not _says_nothing(word) or word.isdigit() for word in own):
            return k
    return role_at


def is_of_set_points(name: str) -> bool:
    """Whether a column's name is one of a file of set points: time, q1, qd1_deg."""
    lowered = name.strip().lower()
    return lowered == "time" or SET_POINT_COLUMN.fullmatch(lowered) is not None


def topic_of(group: Words) -> Words:
    """Words of a group that say neither measured nor target."""
    return tuple(sorted(set(group) - MEASURED - TARGET))


def says_target(words: Words) -> bool:
    """Whether words tell of something commanded or planned."""
    return bool(set(words) & TARGET)


def known_joints(names: Sequence[str]) -> dict[Words, int]:
    """Words of the joints whose names say more than a number, and their numbers from 0."""
    known = {}
    for number, name in enumerate(names):
        words = _merged(words_of(name))
        label, _ = joint_of(words)
        if set(label) - set(ROLE_WORDS) - SINGLE:
            known[words] = number
    return known
