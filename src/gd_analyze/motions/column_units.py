"""Units of logs: in any spelling, anywhere in a column's name, and those that fit a quantity."""

from __future__ import annotations

import math
import re
from collections.abc import Container

from gd_analyze.motions.vocabulary import VOCABULARY, words_in
from gd_analyze.units import KINDS, UNITS, unit_named

_PER = {"q": "", "qd": "/s", "qdd": "/s^2"}
_PER_TIME = dict.fromkeys(("s", "sec"), "/s") | dict.fromkeys(("s^2", "s2", "sec^2", "(s^2)", "s/s"), "/s^2")
_FOREIGN = VOCABULARY["unit"]["foreign"]
_BRACKETED = re.compile(r"\[([^\[\]]{1,30})\]|\(([^()]{1,30})\)")
# vel_rad_s_4, velocity_degps_1, acc_deg_per_s2_1
_RATE = re.compile(
    r"(?i)(?<![a-z])(deg|rad|mrad|mm)(?:[_ /]per[_ /]|[_ /]|p)s(?:ec)?(\^?2)?(?=[_ .\[(/-]|[0-9]*$)"
)
_LETTERS = re.compile(r"[^\W\d_]+")
_PIECES = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+")
# Units that a name may hold anywhere as a word of its own, and those told by a capital as well: posDeg2.
_ANGLES = frozenset(["deg", "degs", "degree", "degrees", "rad", "rads", "radian", "radians"])
_ANYWHERE = _ANGLES | {word for word in _FOREIGN if len(word) > 2}
_ANYWHERE |= frozenset(["mrad", "rpm", "mm", "cm", "nm", "mnm", "knm", "ncm", "ma"])


def unit_in_words(text: str) -> str | None:
    """Read a unit in any known spelling; None if it is unknown."""
    bare = re.sub(r"\s+", "", text).replace("²", "^2").replace("**2", "^2")
    if bare.lower() == "rpm":
        return "rpm"
    base, slash, per = bare.partition("/")
    per = per.lower()
    if re.sub(r"[-.*·]", "", base.lower()) in _FOREIGN and (not slash or per in _PER_TIME):
        return bare.lower()
    unit = unit_named(base)
    kind = "" if unit is None else KINDS[unit]
    if not slash:
        return unit if kind in ("time", "angle", "length", "torque", "force", "current") else None
    return f"{unit}{_PER_TIME[per]}" if kind in ("angle", "length") and per in _PER_TIME else None


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
    """Unit of a role for the unit `stated`; None if that belongs to another quantity."""
    units = units_of(role, revolute, currents)
    return next((unit for unit in (stated, stated + _PER.get(role, "")) if unit in units), None)


def fits_some_joint(unit: str, role: str) -> bool:
    """Whether a unit is one of a role, of a joint that turns or slides."""
    return any(fitting_unit(unit, role, revolute, currents=True) is not None for revolute in (True, False))


def unit_taken_out(name: str, known: Container[str]) -> tuple[str, str]:
    """A name with blanks in place of its unit, which stands anywhere, and the unit; "" if there is none.

    Words in brackets that are not `known` are taken for a unit, too.
    """
    for match in _BRACKETED.finditer(name):
        unit = unit_in_words(match[1] or match[2])
        if unit is not None:
            return _blanked(name, *match.span()), unit
    for separator in ("_", " ", "-", "/"):
        front, between, last = name.rpartition(separator)
        if separator == "/" and ("/" in front or last.lower() in _FIELDS_OF_STAMPS):
            continue  # a topic, not t/ms
        # A single letter is ambiguous: a joint s, a counter n.
        of_time = last == "s" and bool(words_in(front)[-1:]) and words_in(front)[-1] in _OF_SECONDS
        if between and front and (len(last) > 1 or of_time) and not last[:1].isdigit():
            unit = unit_in_words(last)
            if unit is not None:
                return _blanked(name, len(front), len(name)), unit
    rate = _RATE.search(name)
    if rate is not None:
        return _blanked(name, *rate.span()), f"{unit_named(rate[1])}/{'s^2' if rate[2] else 's'}"
    for pattern, words in ((_LETTERS, _ANYWHERE), (_PIECES, _ANGLES)):
        for match in pattern.finditer(name):
            unit = unit_in_words(match[0]) if match[0].lower() in words else None
            if unit is not None:
                return _blanked(name, *match.span()), unit
    for match in _BRACKETED.finditer(name):
        text = match[1] or match[2]
        if any(not (word.isdigit() or word in known) for word in words_in(text)):
            return _blanked(name, *match.span()), text.strip()
    return name, ""


_FIELDS_OF_STAMPS = VOCABULARY["time"]["seconds"] | VOCABULARY["time"]["nanoseconds"]
_OF_SECONDS = frozenset({"time", "t", "timestamp", "stamp"})


def _blanked(name: str, start: int, end: int) -> str:
    return f"{name[:start]}{' ' * (end - start)}{name[end:]}"
