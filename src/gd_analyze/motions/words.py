"""Meaning of a column's name: role, joint, measured or target, unit; and units in logs."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from gd_analyze.units import KINDS, UNITS, unit_named


def word_set(words: str) -> frozenset[str]:
    """Set of words separated by blanks."""
    return frozenset(words.split())


_PER = {"q": "", "qd": "/s", "qdd": "/s^2"}
_TIMES = dict.fromkeys(("s", "sec"), "/s") | dict.fromkeys(("s^2", "s2", "sec^2", "(s^2)", "s/s"), "/s^2")
# Units of drives, counts of unknown size, and units that no motion uses.
_FOREIGN = word_set(
    "a ma amp amps v mv w °c degc celsius k % ‰ permille hz inc incs increments count counts tick ticks "
    "pulse pulses cdeg mdeg gon grad inch ft lbf lbfft lbfin ftlb inlb kgcm kgfcm"
)


def unit_in_words(text: str) -> str | None:
    """Read a unit in any known spelling; None if it is unknown."""
    bare = re.sub(r"\s+", "", text).lower().replace("²", "^2").replace("**2", "^2")
    if bare == "rpm":
        return "rpm"
    base, slash, per = bare.partition("/")
    if re.sub(r"[-.*·]", "", base) in _FOREIGN and (not slash or per in _TIMES):
        return bare
    unit = unit_named(base)
    kind = "" if unit is None else KINDS[unit]
    if not slash:
        return unit if kind in ("time", "angle", "length", "torque", "force") else None
    return f"{unit}{_TIMES[per]}" if kind in ("angle", "length") and per in _TIMES else None


def units_of(role: str, revolute: bool) -> dict[str, float]:
    """Units of a joint's q, qd, qdd or torque, the SI unit first, and their size in SI."""
    if role == "torque":
        return UNITS["torque" if revolute else "force"]
    sizes = UNITS["angle" if revolute else "length"]
    units = {f"{unit}{_PER[role]}": size for unit, size in sizes.items()}
    return units | ({"rpm": 2 * math.pi / 60.0} if revolute and role == "qd" else {})


def fitting_unit(stated: str, role: str, revolute: bool) -> str | None:
    """Unit of a role for the unit `stated` in a name; None if that belongs to another quantity."""
    units = units_of(role, revolute)
    return next((unit for unit in (stated, stated + _PER.get(role, "")) if unit in units), None)


NameRole = Literal["time", "sec", "nanosec", "index", "q", "qd", "qdd", "torque", "name", "other"]
Kind = Literal["measured", "plain", "target"]
Words = tuple[str, ...]

# TCP | Position, deg, wrist | 12 | words of other scripts
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[^\W\d_A-Za-z]+")
_BRACKETED = re.compile(r"\[([^\[\]]{1,30})\]|\(([^()]{1,30})\)")


_WORDS_OF: dict[NameRole, str] = {
    "q": "q pos position positions angle angles theta th phi",
    "qd": "qd dq qdot vel vels velocity velocities speed speeds rate rates omega dtheta thetadot thetad",
    "qdd": "qdd ddq qddot acc accel acceleration accelerations ddtheta thetaddot thetadd",
    "torque": "tau torque torques trq effort efforts moment moments",
}
_ROLE_WORDS = {word: role for role, words in _WORDS_OF.items() for word in words.split()}
# In a log with q, theta means something else, such as motor angles in libfranka.
_SECOND_CHOICE = word_set("theta th phi dtheta thetadot thetad omega")
MEASURED = word_set("actual act measured meas msr feedback fbk fb real current present")
TARGET = word_set(
    "target tgt command commanded cmd cmptd desired des reference ref setpoint setpoints planned plan "
    "goal nominal demand demanded interpolated"
)
# Words beside a joint in a log that are not quantities of its motion.
_BLOCKED = word_set(
    "temp temps temperature temperatures cur currents amps voltage voltages pose tcp cartesian ext "
    "external contact collision tool scaling fraction mode error errors err deviation force forces wrench "
    "imu status power jerk covariance variance std limit limits max min offset dtau stiffness window "
    "model modelled predicted ff feedforward coriolis inertia residual bias delta init initial damping "
    "gravity friction quaternion orientation tf success digital analog"
)
# Words that only say that a joint is named.
_FILLERS = word_set("joint joints jnt axis axes j actuator motor")
_CONTAINERS = word_set(
    "states state msg message field data points point header robot values value interface rtde log record "
    "joint joints dynamic multi dof"
)
_TIME_CORE = word_set("time timestamp timestamps stamp t ts clock elapsed epoch duration millis")
_TIME_MORE = word_set(
    "from start since rel relative abs absolute unix system ros robot recv recording log header field of "
    "sample utc controller receive received in"
)
_INDEX = word_set("index idx sample samples tick ticks cycle counter seq n")
_COMPOSED = re.compile(
    r"(q|dq|qd|ddq|qdd|tau|pos|vel|acc|torque|position|velocity)"
    r"(act|actual|meas|des|desired|ref|cmd|target|tgt)"
)
_DERIVED = {
    **{("q", "dot"): "qd", ("qd", "dot"): "qdd", ("q", "ddot"): "qdd", ("d", "q"): "dq", ("dd", "q"): "ddq"},
    **{("theta", "dot"): "thetadot", ("thetadot", "dot"): "thetaddot"},
}
# KUKA's A1 to A6 are joints; its external axes E1 to E6 and the S, L, U of others do not tell which.
_SINGLE, EXTERNAL = ("a",), ("e",)
_SET_POINT_COLUMN = re.compile(r"time|(qdd|qd|q)[1-9][0-9]{0,5}(_deg)?")


def is_of_set_points(name: str) -> bool:
    """Whether a column's name belongs to a file of set points: time, q1, qd1_deg."""
    return _SET_POINT_COLUMN.fullmatch(name.strip().lower()) is not None


def words_of(name: str) -> Words:
    """Split a name into words, in lower case."""
    return tuple(word.lower() for word in _WORD.findall(name))


def unit_taken_out(name: str) -> tuple[str, str]:
    """Split a unit in brackets or at the end off a name; "" if there is none."""
    for match in _BRACKETED.finditer(name):
        unit = unit_in_words(match[1] or match[2])
        if unit is not None:
            return name[: match.start()] + name[match.end() :], unit
    for separator in ("_", " ", "-"):
        front, between, last = name.rpartition(separator)
        # A single letter is ambiguous: a joint s, a counter n.
        of_time = last == "s" and words_of(front)[-1:] in (("time",), ("t",), ("timestamp",), ("stamp",))
        if between and front and (len(last) > 1 or of_time):
            unit = unit_in_words(last)
            if unit is not None and not last[:1].isdigit():
                return front, unit
    return name, ""


def joint_of(words: Words) -> tuple[Words, int | None]:
    """Split the words of a joint's name into label and number."""
    label = without_fillers(words)
    for k in reversed(range(len(label))):
        if _is_count(label[k]):
            return label[:k] + label[k + 1 :], int(label[k])
    return label, None


def is_bare(label: Words) -> bool:
    """Whether the label of a numbered joint says nothing beside the number: j, a, q, axis."""
    return all(len(word) == 1 or word in _ROLE_WORDS or word in _FILLERS for word in label)


def without_fillers(words: Words) -> Words:
    """Words without fillers, which only say that a joint is named."""
    return tuple(word for word in words if word not in _FILLERS)


def as_written(words: Words, name: str) -> str:
    """Words as written in a name that contains them, or joined by underscores."""
    for candidate in filter(None, (words, without_fillers(words))):
        match = re.search("[^A-Za-z0-9]?".join(map(re.escape, candidate)), name, re.IGNORECASE)
        if match:
            return match[0]
    return "_".join(words)


def known_joints(names: Sequence[str]) -> dict[Words, int]:
    """Words of the joints whose names say more than a number, and their numbers from 0."""
    joints = {_merged(words_of(name)): number for number, name in enumerate(names)}
    return {
        words: k for words, k in joints.items() if set(joint_of(words)[0]).difference(_ROLE_WORDS, _SINGLE)
    }


@dataclass(frozen=True)
class Meaning:
    """Meaning of one name."""

    role: NameRole  # apparent role
    token: Words = ()  # words of the joint; `label` and `number` are its name and its count
    joint: int | None = None  # the arm's joint of exactly this name, from 0
    group: Words = ()  # words that distinguish columns of the same role and joint: topic, actual, target
    kind: Kind = "plain"  # whether these say measured or target
    unit: str = ""  # unit in the name
    # Clarity of the role: 0 for `q` and `position`, 1 for `theta`, 2 for the bare name of a joint
    rank: int = 0
    word: str = ""  # the word of the role

    @property
    def label(self) -> Words:
        """Words that name the joint."""
        return joint_of(self.token)[0]

    @property
    def number(self) -> int | None:
        """Number of the joint in the log."""
        return joint_of(self.token)[1]


def meaning_of(name: str, joints: Mapping[Words, int]) -> Meaning:
    """Read a column's name; `joints` are the words of the arm's joints and their numbers from 0."""
    text, unit = unit_taken_out(name.strip().lstrip("%#"))
    parts = (_merged(words_of(part)) for part in re.split(r"[/.]", text))
    segments = [segment for segment in parts if segment]
    role_of_time = _role_of_time(segments)
    if role_of_time is not None:
        return Meaning(role_of_time, group=tuple(w for s in segments for w in s), unit=unit)
    points = (segment for segment in segments if "points" in segment)
    if any(next((int(word) for word in segment if _is_count(word)), 0) for segment in points):
        return Meaning("other")  # a further point of a message
    words = {word for segment in segments for word in segment}
    last = set(segments[-1]) if segments else set()
    blocked = last & _BLOCKED
    if any(_ROLE_WORDS.get(word) == "torque" for word in last):  # TorqueCur: torque that follows from current
        blocked -= {"cur", "currents"}
    if blocked or words & {"error", "err"} or ("current" in last and not words & set(_ROLE_WORDS)):
        return Meaning("other", unit=unit)
    return _of_joint(*_known_joint(segments, joints), unit)


def _is_count(word: str) -> bool:
    return word.isascii() and word.isdigit() and len(word) < 7


def _merged(words: Words) -> Words:
    """Words with `q dot` as qd and `qdes` as q des."""
    out: list[str] = []
    for word in words:
        composed = _COMPOSED.fullmatch(word)
        for part in composed.groups() if composed and word not in _ROLE_WORDS else (word,):
            while out and (out[-1], part) in _DERIVED:
                part = _DERIVED[out.pop(), part]
            out.append(part)
    return tuple(out)


def _role_of_time(segments: Sequence[Words]) -> NameRole | None:
    if not segments:
        return None
    last = segments[-1]
    *before, end = (word for segment in segments for word in segment)
    seconds = end in ("sec", "secs", "nanosec", "nanosecs", "nsec", "nsecs")
    if seconds and (not before or {"stamp", "time", "start"} & set(before)):
        return "nanosec" if end.startswith("n") else "sec"
    if set(last) & _TIME_CORE and set(last) <= _TIME_CORE | _TIME_MORE:
        return "time"
    if len(segments) <= 3 and set(last) <= _INDEX | {"number", "no"} and set(last) & _INDEX:
        return "index"
    return None


def _known_joint(segments: list[Words], joints: Mapping[Words, int]) -> tuple[list[Words], int, int | None]:
    """The segments without the words of the named joint, its segment and its number.

    Words of role and kind may stand among those of the joint: axis_a_1 is named by AXIS_ACT_A1.
    """
    all_places = [range(len(segment)) for segment in segments]
    bare = [
        [i for i in at if not _names_role_or_kind(segment[i])]
        for at, segment in zip(all_places, segments, strict=True)
    ]
    for words in sorted(joints, key=len, reverse=True):
        for places in (all_places, bare):
            for k, (segment, at) in enumerate(zip(segments, places, strict=True)):
                for first in range(len(at) - len(words) + 1):
                    matched = at[first : first + len(words)]
                    if tuple(segment[i] for i in matched) == words:
                        remainder = tuple(word for i, word in enumerate(segment) if i not in matched)
                        return [*segments[:k], remainder, *segments[k + 1 :]], k, joints[words]
    return segments, -1, None


def _names_role_or_kind(word: str) -> bool:
    return word in _ROLE_WORDS or word in MEASURED or word in TARGET


def _of_joint(segments: list[Words], at: int, joint: int | None, unit: str) -> Meaning:
    """Role, joint and group of a name other than time."""
    with_role = [k for k, segment in enumerate(segments) if any(word in _ROLE_WORDS for word in segment)]
    role_at = with_role[-1] if with_role else -1
    role: NameRole = "other"
    rank, role_word = 0, ""
    words: list[tuple[int, str]] = []
    group: list[str] = []
    for k, segment in enumerate(segments):
        for i, word in enumerate(segment):
            if k == role_at and word in _ROLE_WORDS and role == "other":
                role, rank, role_word = _ROLE_WORDS[word], int(word in _SECOND_CHOICE), word
            elif k == role_at and word == "d" and i and segment[i - 1] in (*_ROLE_WORDS, "j"):
                group.append("desired")
            elif word in MEASURED or word in TARGET:
                group.append(word)
            else:
                words.append((k, word))
    token_at = _token_segment(segments, words, role_at, at)
    token = tuple(word for k, word in words if k == token_at) if joint is None else ()
    # Words beside the joint distinguish families, containers do not.
    group += [w for k, w in words if (k != token_at or joint is not None) and not _names_nothing(w)]
    if role == "other":
        label, number = joint_of(token)
        if "name" in label or "names" in label:
            return Meaning("name", token)
        # A3 and KUKA's AXIS_ACT_A3 are numbered, joint_a3 is a name; other words certainly name a joint only
        # beside "joint".
        names_joint = bool(set(token) & {"joint", "jnt", "axis"})
        counts = number is not None and (
            not label or (not set(token) & {"joint", "jnt"} and label == _SINGLE)
        )
        is_external = number is not None and label == EXTERNAL
        # elbow is a position; elbow_enabled and elbow_x are other quantities.
        has_more_words = joint is not None and any(k == at and not _names_nothing(word) for k, word in words)
        if has_more_words or (joint is None and not counts and not names_joint and not is_external):
            return Meaning("other", token, unit=unit)
        token = (str(number),) if counts else token
        role, rank = "q", 2
    kind: Kind = "target" if set(group) & TARGET else "measured" if set(group) & MEASURED else "plain"
    return Meaning(role, token, joint, tuple(group), kind, unit, rank, role_word)


def _names_nothing(word: str) -> bool:
    return word in _CONTAINERS or word in _FILLERS or (word.isascii() and word.isdigit())


def _token_segment(segments: list[Words], words: list[tuple[int, str]], role_at: int, at: int) -> int:
    """Segment that names the joint: that of the role, or the one after or before it."""
    if at >= 0:
        return at
    if role_at < 0:
        return words[-1][0] if words else -1
    for k in (role_at, *range(len(segments) - 1, role_at, -1), *range(role_at - 1, -1, -1)):
        if any(not _names_nothing(word) or word.isdigit() for index, word in words if index == k):
            return k
    return role_at
