"""Units as logs write them, and what one of each is in SI units."""

from __future__ import annotations

import math
import re

DEGREE = math.pi / 180.0

# Per quantity: unit as it is shown, and what one of it is in rad, m, s or N m.
TIME_UNITS = {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": DEGREE, "rev": 2 * math.pi}
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_PER = {"q": "", "qd": "/s", "qdd": "/s^2"}
_TORQUES = {"N m": 1.0, "cN m": 1e-2, "mN m": 1e-3, "kN m": 1e3}
_FORCES = {"N": 1.0, "kN": 1e3}

# How units are spelt, beside the way they are shown.
_SPELT = {
    spelt: unit
    for unit, all_spelt in {
        "deg": "degree degrees degs °",
        "rad": "radian radians rads",
        "m": "meter meters metre metres",
        "s": "sec secs second seconds",
        "ms": "msec msecs millis milliseconds",
        "us": "µs μs usec usecs micros microseconds",
        "ns": "nsec nsecs nanosec nanosecs nanos nanoseconds",
        "rev": "turn turns revs revolutions",
        "cN m": "ncm n*cm cnm",
        "mN m": "nmm n*mm mnm",
        "N m": "nm n*m n.m n·m n-m",
        "kN m": "knm",
        "N": "n newton",
        "kN": "kn",
    }.items()
    for spelt in all_spelt.split()
}
_TIMES = dict.fromkeys(("s", "sec"), "/s") | dict.fromkeys(("s^2", "s2", "sec^2", "(s^2)", "s/s"), "/s^2")
# Of quantities that are none of an arm's motion, of counts whose size is not known, and others.
_DRIVES = {"a", "ma", "amp", "amps", "v", "mv", "w", "°c", "degc", "celsius", "k", "%", "‰", "permille", "hz"}
_COUNTS = {"inc", "incs", "increments", "count", "counts", "tick", "ticks", "pulse", "pulses"}
_OTHERS = {
    "cdeg",
    "mdeg",
    "gon",
    "grad",
    "inch",
    "ft",
    "lbf",
    "lbfft",
    "lbfin",
    "ftlb",
    "inlb",
    "kgcm",
    "kgfcm",
}
_FOREIGN = _DRIVES | _COUNTS | _OTHERS


def unit_in_words(text: str) -> str | None:
    """Read a unit as somebody wrote it; None where it is none that is known.

    Examples
    --------
    >>> unit_in_words("Degrees/s"), unit_in_words("rad/s²"), unit_in_words("Nm"), unit_in_words("elbow")
    ('deg/s', 'rad/s^2', 'N m', None)
    """
    bare = re.sub(r"\s+", "", text).lower().replace("²", "^2").replace("**2", "^2")
    if bare == "rpm":
        return "rpm"
    base, slash, per = bare.partition("/")
    if re.sub(r"[-.*·]", "", base) in _FOREIGN and (not slash or per in _TIMES):
        return bare
    shown = _SPELT.get(base, base)
    if not slash:
        known = {*TIME_UNITS, *_ANGLES, *_LENGTHS, *_TORQUES, *_FORCES}
        return shown if shown in known else None
    if shown in {*_ANGLES, *_LENGTHS} and per in _TIMES:
        return shown + _TIMES[per]
    return None


def units_of(role: str, turns: bool) -> dict[str, float]:
    """Units that numbers of a role may be in, the SI unit first, and what one of each is in it.

    Parameters
    ----------
    role
        "time", "q", "qd", "qdd" or "torque".
    turns
        Whether the joint turns; it slides otherwise.
    """
    if role == "time":
        return TIME_UNITS
    if role == "torque":
        return _TORQUES if turns else _FORCES
    per = _PER[role]
    units = {f"{unit}{per}": factor for unit, factor in (_ANGLES if turns else _LENGTHS).items()}
    if turns and role == "qd":
        units["rpm"] = 2 * math.pi / 60.0
    return units


def fitting_unit(said: str, role: str, turns: bool) -> str | None:
    """Unit of a role that is meant where a name says `said`: q̇ named with `_deg` is in deg/s.

    Returns
    -------
    str or None
        None where the unit is of another quantity.

    Examples
    --------
    >>> fitting_unit("deg", "qd", True), fitting_unit("a", "torque", True)
    ('deg/s', None)
    """
    known = units_of(role, turns)
    if said in known:
        return said
    meant = said + _PER.get(role, "")
    if meant in known:
        return meant
    return None
