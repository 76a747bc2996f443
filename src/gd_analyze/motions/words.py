"""Meaning of a column's name: role, joint, measured or target, unit; and units in logs."""

from __future__ import annotations

import math
import re
from collections.abc import Container, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Literal

from gd_analyze.units import KINDS, UNITS, unit_named


def word_set(words: str) -> frozenset[str]:
    """Set of words separated by blanks."""
    return frozenset(words.split())


_PER = {"q": "", "qd": "/s", "qdd": "/s^2"}
_TIMES = dict.fromkeys(("s", "sec"), "/s") | dict.fromkeys(("s^2", "s2", "sec^2", "(s^2)", "s/s"), "/s^2")
# Units of drives, counts of unknown size, and units that no motion uses.
_FOREIGN = word_set(
    "v mv w °c degc celsius k % ‰ permille hz inc incs increments count counts tick ticks "
    "pulse pulses cdeg mdeg gon grad inch ft lbf lbfft lbfin ftlb inlb kgcm kgfcm percent pct"
)


def unit_in_words(text: str) -> str | None:
    """Read a unit in any known spelling; None if it is unknown."""
    bare = re.sub(r"\s+", "", text).replace("²", "^2").replace("**2", "^2")
    if bare.lower() == "rpm":
        return "rpm"
    base, slash, per = bare.partition("/")
    per = per.lower()
    if re.sub(r"[-.*·]", "", base.lower()) in _FOREIGN and (not slash or per in _TIMES):
        return bare.lower()
    unit = unit_named(base)
    kind = "" if unit is None else KINDS[unit]
    if not slash:
        return unit if kind in ("time", "angle", "length", "torque", "force", "current") else None
    return f"{unit}{_TIMES[per]}" if kind in ("angle", "length") and per in _TIMES else None


def units_of(role: str, revolute: bool, currents: bool = False) -> dict[str, float]:
    """Units of a joint's q, qd, qdd or torque, the SI unit first, and their size in SI.

    With `currents` torque may be in amperes, too.
    """
    if role == "torque":
        return UNITS["torque" if revolute else "force"] | (UNITS["current"] if currents else {})
    sizes = UNITS["angle" if revolute else "length"]
    units = {f"{unit}{_PER[role]}": size for unit, size in sizes.items()}
    return units | ({"rpm": 2 * math.pi / 60.0} if revolute and role == "qd" else {})


def fitting_unit(stated: str, role: str, revolute: bool, currents: bool = False) -> str | None:
    """Unit of a role for the unit `stated` in a name; None if that belongs to another quantity."""
    units = units_of(role, revolute, currents)
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
    "torque": "tau torque torques trq tq effort efforts moment moments",
}
_ROLE_WORDS = {word: role for role, words in _WORDS_OF.items() for word in words.split()}
# In a log with q, theta means something else, such as motor angles in libfranka.
_SECOND_CHOICE = word_set("theta th phi dtheta thetadot thetad omega")
MEASURED = word_set("actual act measured meas msr feedback fbk fb real current present")
TARGET = word_set(
    "target tgt command commanded cmd cmptd desired des reference ref setpoint setpoints planned plan "
    "goal nominal demand demanded interpolated"
)
# The command in records of demonstrations: action.elbow.pos. In topics it is a kind of interface.
_ACTION = "action"
# Words of currents.
CURRENTS = word_set("current currents cur amp amps ampere amperes")
# Words beside a joint in a log that are not quantities of its motion.
BLOCKED = word_set(
    "temp temps temperature temperatures cur currents amps voltage voltages pose tcp cartesian ext "
    "external contact collision tool scaling fraction mode error errors err deviation force forces wrench "
    "imu status power jerk covariance variance std limit limits max min offset dtau stiffness window "
    "model modelled predicted ff feedforward coriolis inertia residual bias delta init initial damping "
    "gravity friction quaternion orientation tf success digital analog gain gains ratio valid enabled "
    "enable flag"
)
# Words that only say that a joint is named.
_FILLERS = word_set("joint joints jnt axis axes j actuator motor")
_CONTAINERS = word_set(
    "states state msg message field data points point header robot values value interface rtde log record "
    "joint joints dynamic multi dof"
)
_TIME_CORE = word_set(
    "time uptime timestamp timestamps datetime stamp t ts clock elapsed epoch duration millis"
)
_TIME_MORE = word_set(
    "date from start since rel relative abs absolute unix system ros robot recv recording log header field "
    "of sample utc controller receive received in"
)
_FIELDS_OF_STAMPS = word_set("sec secs nanosec nanosecs nsec nsecs")
_INDEX = word_set("index idx sample samples tick ticks cycle counter seq n")
_COMPOSED = re.compile(
    r"(q|dq|qd|ddq|qdd|tau|pos|vel|acc|torque|position|velocity)"
    r"(act|actual|meas|des|desired|ref|cmd|target|tgt)"
)
# Axis positions in KUKA's telegrams: actual and commanded, of the arm and of external axes.
_AXES_OF_KUKA = re.compile(r"(?<![A-Za-z])A[IS]Pos(?![a-z])")  # in degrees; external axes may be in mm
_OF_KUKA = {"ai": "actual", "ei": "actual", "as": "setpoint", "es": "setpoint"}
_DERIVED = {
    **{("q", "dot"): "qd", ("qd", "dot"): "qdd", ("q", "ddot"): "qdd", ("d", "q"): "dq", ("dd", "q"): "ddq"},
    **{("theta", "dot"): "thetadot", ("thetadot", "dot"): "thetaddot"},
}
# KUKA's A1 to A6 are joints; its external axes E1 to E6 and the S, L, U of others do not tell which.
_SINGLE, EXTERNAL = ("a",), ("e",)
BARE = 2  # rank of the bare name of a joint
_SET_POINT_COLUMN = re.compile(r"time|(qdd|qd|q)[1-9][0-9]{0,5}(_deg)?")


def is_of_set_points(name: str) -> bool:
    """Whether a column's name belongs to a file of set points: time, q1, qd1_deg."""
    return _SET_POINT_COLUMN.fullmatch(name.strip().lower()) is not None


def words_of(name: str) -> Words:
    """Split a name into words, in lower case."""
    return tuple(word.lower() for word in _WORD.findall(name))


# Units that a name may hold anywhere: q_deg_1, posDeg2, tau_mNm_3, vel_rad_s_4.
_RATE = re.compile(
    r"(?i)(?<![a-z])(deg|rad|mrad|mm)(?:[_ /]per[_ /]|[_ /]|p)s(?:ec)?(\^?2)?(?=[_ .\[(/-]|[0-9]*$)"
)
_COUNT = re.compile(r"(?<![0-9])[0-9]{1,6}(?![0-9])")
_LETTERS = re.compile(r"[^\W\d_]+")
_ANGLES = word_set("deg degs degree degrees rad rads radian radians")
_ANYWHERE = _ANGLES | {word for word in _FOREIGN if len(word) > 2}
_ANYWHERE |= word_set("mrad rpm mm cm nm mnm knm ncm ma")
# What may stand in brackets beside units.
_TREATMENTS = word_set("raw filtered unfiltered filt smoothed estimated")


def unit_taken_out(name: str) -> tuple[str, str]:
    """Split a unit off a name: in brackets, at the end, or a word of it; "" if there is none."""
    for match in _BRACKETED.finditer(name):
        unit = unit_in_words(match[1] or match[2])
        if unit is not None:
            return name[: match.start()] + name[match.end() :], unit
    for separator in ("_", " ", "-", "/"):
        front, between, last = name.rpartition(separator)
        if separator == "/" and ("/" in front or last.lower() in _FIELDS_OF_STAMPS):
            continue  # a topic, not t/ms
        # A single letter is ambiguous: a joint s, a counter n.
        of_time = last == "s" and words_of(front)[-1:] in (("time",), ("t",), ("timestamp",), ("stamp",))
        if between and front and (len(last) > 1 or of_time):
            unit = unit_in_words(last)
            if unit is not None and not last[:1].isdigit():
                return front, unit
    rate = _RATE.search(name)
    if rate is not None:
        per = "s^2" if rate[2] else "s"
        return f"{name[: rate.start()]}_{name[rate.end() :]}", f"{unit_named(rate[1])}/{per}"
    for pattern, words in ((_LETTERS, _ANYWHERE), (_WORD, _ANGLES)):
        for match in pattern.finditer(name):
            unit = unit_in_words(match[0]) if match[0].lower() in words else None
            if unit is not None:
                return f"{name[: match.start()]}_{name[match.end() :]}", unit
    return name, ""


def foreign_unit(name: str, known: Container[str]) -> str:
    """What stands in brackets in a name and is no unit, index or word that a name may have; "" if nothing.

    `known` are the words of the arm's joints.
    """
    for match in _BRACKETED.finditer(name):
        text = match[1] or match[2]
        words = words_of(text)
        if unit_in_words(text) is None and any(
            not (_names_nothing(word) or _names_role_or_kind(word) or word in _TREATMENTS or word in known)
            for word in words
        ):
            return text.strip()
    return ""


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
    rank: int = 0  # clarity of the role: 0 for `q` and `position`, 1 for `theta`, or `BARE`
    word: str = ""  # the word of the role
    unknown: Words = ()  # words beside a joint without a role, which make it no position
    # Why a column with the name of a role, its word, is none: "text" in its cells, "unit" in its name
    rejected: Literal["", "text", "unit"] = ""

    @cached_property
    def label(self) -> Words:
        """Words that name the joint."""
        return joint_of(self.token)[0]

    @cached_property
    def number(self) -> int | None:
        """Number of the joint in the log."""
        return joint_of(self.token)[1]


def meaning_of(name: str, joints: Mapping[Words, int], known: Container[str] = ()) -> Meaning:
    """Read a column's name.

    `joints` are the words of the arm's joints and their numbers from 0, `known` all words in their names.
    """
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
    blocked = last & BLOCKED
    if any(_ROLE_WORDS.get(word) == "torque" for word in last):  # TorqueCur: torque that follows from current
        blocked -= {"cur", "currents"}
    if blocked or words & {"error", "err"} or ("current" in last and not words & set(_ROLE_WORDS)):
        return Meaning("other", unit=unit)
    meaning = _of_joint(*_known_joint(segments, joints, words), unit, known)
    if not unit and meaning.role == "q" and _AXES_OF_KUKA.search(text):
        return replace(meaning, unit="deg")
    foreign = "" if unit or meaning.role not in _WORDS_OF else foreign_unit(text, known)
    return Meaning("other", unit=foreign, word=meaning.role, rejected="unit") if foreign else meaning


def _is_count(word: str) -> bool:
    return word.isascii() and word.isdigit() and len(word) < 7


def _merged(words: Words) -> Words:
    """Words with `q dot` as qd and `qdes` as q des."""
    out: list[str] = []
    for word in words:
        composed = _COMPOSED.fullmatch(word)
        for part in composed.groups() if composed and word not in _ROLE_WORDS else (word,):
            if part == "pos" and out and out[-1] in _OF_KUKA:
                out[-1] = _OF_KUKA[out[-1]]
            while out and (out[-1], part) in _DERIVED:
                part = _DERIVED[out.pop(), part]
            out.append(part)
    return tuple(out)


def _role_of_time(segments: Sequence[Words]) -> NameRole | None:
    if not segments:
        return None
    last = segments[-1]
    *before, end = (word for segment in segments for word in segment)
    seconds = end in _FIELDS_OF_STAMPS
    if seconds and (not before or {"stamp", "time", "start"} & set(before)):
        return "nanosec" if end.startswith("n") else "sec"
    if set(last) & _TIME_CORE and set(last) <= _TIME_CORE | _TIME_MORE:
        return "time"
    if len(segments) <= 3 and set(last) <= _INDEX | {"number", "no"} and set(last) & _INDEX:
        return "index"
    return None


def _known_joint(
    segments: list[Words], joints: Mapping[Words, int], all_words: Set[str]
) -> tuple[list[Words], int, int | None]:
    """The segments without the words of the named joint, its segment and its number.

    Words of role and kind may stand among those of the joint: axis_a_1 is named by AXIS_ACT_A1.
    """
    likely = [words for words in sorted(joints, key=len, reverse=True) if all_words >= {*words}]
    if not likely:
        return segments, -1, None
    all_places = [range(len(segment)) for segment in segments]
    bare = [
        [i for i in at if not _names_role_or_kind(segment[i])]
        for at, segment in zip(all_places, segments, strict=True)
    ]
    for words in likely:
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


def _of_joint(segments: list[Words], at: int, joint: int | None, unit: str, known: Container[str]) -> Meaning:
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
            elif word in MEASURED or word in TARGET or (k == i == 0 and word == _ACTION):
                group.append(word)
            else:
                words.append((k, word))
    token_at = _token_segment(segments, words, role_at, at)
    token = tuple(word for k, word in words if k == token_at) if joint is None else ()
    # Words beside the joint distinguish families, containers do not.
    group += [w for k, w in words if (k != token_at or joint is not None) and not _names_nothing(w)]
    label, number = joint_of(token)
    # A3 and KUKA's AXIS_ACT_A3 are numbered, joint_a3 is a name.
    counts = number is not None and (not label or (not set(token) & {"joint", "jnt"} and label == _SINGLE))
    if role == "other":
        if "name" in label or "names" in label:
            return Meaning("name", token)
        # Other words certainly name a joint only beside "joint".
        names_joint = bool(set(token) & {"joint", "jnt", "axis"})
        is_external = number is not None and label == EXTERNAL
        # elbow and joint_2 are positions; elbow_enabled, temp_joint_2 and MACur.A2 are other quantities.
        unknown = _unknown_words(segments, known)
        says_joint = bool(set(token) & _FILLERS)
        is_named = names_joint or is_external or (counts and (bool(label) or says_joint or not group))
        if joint is None and not (is_named or unknown):
            # target_2 and state_2 name no quantity.
            all_words = [word for segment in segments for word in segment if not word.isdigit()]
            return Meaning("other", token, unit=unit, unknown=tuple(all_words) if number is not None else ())
        if (joint is not None or number is not None or not is_named) and unknown:
            return Meaning("other", token, joint, unit=unit, unknown=unknown)
        role, rank = "q", BARE
    # Of AIPos.A1 the segment A1 names the joint, in tau_a_1 the letter may be anything.
    token = (str(number),) if counts and (rank == BARE or token == segments[token_at]) else token
    return Meaning(role, token, joint, tuple(group), _kind_of(group), unit, rank, role_word)


def _kind_of(words: Sequence[str]) -> Kind:
    """Whether words say measured or target."""
    if words[:1] in ([_ACTION], (_ACTION,)) or set(words) & TARGET:
        return "target"
    return "measured" if set(words) & MEASURED else "plain"


def meaning_by_pattern(
    role: NameRole, pattern: str, star: str, unit: str, joints: Mapping[Words, int]
) -> Meaning:
    """Meaning of a column by the user's pattern, whose star stands for the words of the joint."""
    words = _merged(words_of(star))
    label, number = joint_of(words)
    token = (str(number),) if number is not None and label in ((), _SINGLE) else words
    kind = _kind_of(_merged(words_of(pattern.replace("*", " "))))
    joint = joints.get(words)
    return Meaning(role, () if joint is not None else token, joint, kind=kind, unit=unit)


def patterns_of(name: str, joints: Mapping[Words, int]) -> Iterator[tuple[str, str]]:
    """A name with a star in place of a joint's words or a number, and what stood there; in every way."""
    bare = {without_fillers(words) for words in joints} - {()}
    spans = [
        match.span()
        for words in {*joints, *bare}
        for match in re.finditer("[^A-Za-z0-9]?".join(map(re.escape, words)), name, re.IGNORECASE)
    ]
    longest = [max(spans, key=lambda span: span[1] - span[0])] if spans else []
    for start, end in [*longest, *(match.span() for match in _COUNT.finditer(name))]:
        yield f"{name[:start]}*{name[end:]}", name[start:end]


def _unknown_words(segments: list[Words], known: Container[str]) -> Words:
    """Words of a name that say neither a role nor measured or target, nor which joint."""
    out: list[str] = []
    for segment in segments:
        for word, following in pairwise((*segment, "")):
            # The letter of A1 and E1 belongs to its number.
            is_letter = word in (*_SINGLE, *EXTERNAL) and following.isdigit()
            if not (_names_nothing(word) or _names_role_or_kind(word) or word in known or is_letter):
                out.append(word)
    return tuple(out)


def _names_nothing(word: str) -> bool:
    return word in _CONTAINERS or word in _FILLERS or (word.isascii() and word.isdigit())


def _token_segment(segments: list[Words], words: list[tuple[int, str]], role_at: int, at: int) -> int:
    """Segment that names the joint: that of the role, or the one after or before it."""
    if at >= 0:
        return at
    if role_at < 0:
        numbered = [k for k, word in words if word.isdigit()]
        return numbered[-1] if numbered else words[-1][0] if words else -1
    for k in (role_at, *range(len(segments) - 1, role_at, -1), *range(role_at - 1, -1, -1)):
        if any(not _names_nothing(word) or word.isdigit() for index, word in words if index == k):
            return k
    return role_at
