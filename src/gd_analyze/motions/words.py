"""Names of columns and joints, taken apart into words."""

from __future__ import annotations

import re

from gd_analyze.motions.units import unit_in_words

# TCP | Position, deg, wrist | 12 | words of other scripts
_WORD = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|[0-9]+|[^\W\d_A-Za-z]+")
_BRACKETED = re.compile(r"\[([^\[\]]{1,30})\]|\(([^()]{1,30})\)")
# Words that say no more than that a joint follows, or came before.
FILLERS = frozenset({"joint", "joints", "jnt", "axis", "axes", "j", "actuator", "motor"})

Words = tuple[str, ...]


def words_of(name: str) -> Words:
    """Take a name apart, in lower case.

    Examples
    --------
    >>> words_of("shoulder_pan_joint"), words_of("PositionCmptd1"), words_of("tau_J[0]")
    (('shoulder', 'pan', 'joint'), ('position', 'cmptd', '1'), ('tau', 'j', '0'))
    """
    return tuple(word.lower() for word in _WORD.findall(name))


def unit_taken_out(name: str) -> tuple[str, str]:
    """Take a unit in brackets or at the end out of a name; an empty one where there is none.

    Examples
    --------
    >>> unit_taken_out("q1 (rad/s)"), unit_taken_out("q1_deg"), unit_taken_out("q[0]")
    (('q1 ', 'rad/s'), ('q1', 'deg'), ('q[0]', ''))
    """
    for found in _BRACKETED.finditer(name):
        unit = unit_in_words(found[1] or found[2])
        if unit is not None:
            return name[: found.start()] + name[found.end() :], unit
    for separator in ("_", " ", "-"):
        front, between, last = name.rpartition(separator)
        # One letter may be anything: a joint s, a counter n.
        of_time = last == "s" and words_of(front)[-1:] in (("time",), ("t",), ("timestamp",), ("stamp",))
        if between and front and (len(last) > 1 or of_time):
            unit = unit_in_words(last)
            if unit is not None and not last[:1].isdigit():
                return front, unit
    return name, ""


def joint_of(words: Words) -> tuple[Words, int | None]:
    """Split the words of a joint's name into those that name it and the number by which it counts.

    Examples
    --------
    >>> joint_of(("fer", "joint", "1")), joint_of(("shoulder", "pan", "joint")), joint_of(("q", "3"))
    ((('fer',), 1), (('shoulder', 'pan'), None), (('q',), 3))
    """
    label = [word for word in words if word not in FILLERS]
    number = None
    for k in reversed(range(len(label))):
        if label[k].isascii() and label[k].isdigit() and len(label[k]) < 7:
            number = int(label.pop(k))
            break
    return tuple(label), number


def as_written(words: Words, name: str) -> str:
    """Words as they stand in a name that holds them, or with underscores between them.

    Examples
    --------
    >>> as_written(("fer", "joint", "1"), "/joint_states/fer_joint1/position")
    'fer_joint1'
    """
    found = re.search("[^A-Za-z0-9]?".join(map(re.escape, words)), name, re.IGNORECASE)
    return found[0] if found and words else "_".join(words)
