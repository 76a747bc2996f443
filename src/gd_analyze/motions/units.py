"""Units as logs write them, and their size in SI units."""

from __future__ import annotations

import math
import re

from gd_analyze.motions.reading import TIME_UNITS


def word_set(words: str) -> frozenset[str]:
    """Words between blanks."""
    return frozenset(words.split())


_ANGLES = {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0, "rev": 2 * math.pi}
_LENGTHS = {"m": 1.0, "cm": 1e-2, "mm": 1e-3}
_PER = {"q": "", "qd": "/s", "qdd": "/s^2"}
_TORQUES = {"N m": 1.0, "cN m": 1e-2, "mN m": 1e-3, "kN m": 1e3}
_FORCES = {"N": 1.0, "kN": 1e3}

# Other spellings.
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
# Of drives, of counts of unknown size, and of no use in a motion.
_FOREIGN = word_set(
    "a ma amp amps v mv w °c degc celsius k % ‰ permille hz inc incs increments count counts tick ticks "
    "pulse pulses cdeg mdeg gon grad inch ft lbf lbfft lbfin ftlb inlb kgcm kgfcm"
)


def unit_in_words(text: str) -> str | None:
    """Read a unit as somebody wrote it; None where it is no known one.

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
        return shown if shown in {*TIME_UNITS, *_ANGLES, *_LENGTHS, *_TORQUES, *_FORCES} else None
    return shown + _TIMES[per] if shown in {*_ANGLES, *_LENGTHS} and per in _TIMES else None


def units_of(role: str, revolute: bool) -> dict[str, float]:
    """Units that a joint's q, qd, qdd or torque may be in, the SI unit first, and their size in it."""
    if role == "torque":
        return _TORQUES if revolute else _FORCES
    units = {f"{unit}{_PER[role]}": size for unit, size in (_ANGLES if revolute else _LENGTHS).items()}
    return units | ({"rpm": 2 * math.pi / 60.0} if revolute and role == "qd" else {})


def fitting_unit(said: str, role: str, revolute: bool) -> str | None:
    """Unit of a role that a name means by `said`; None where that is of another quantity.

    Examples
    --------
    >>> fitting_unit("deg", "qd", True), fitting_unit("a", "torque", True)
    ('deg/s', None)
    """
    known = units_of(role, revolute)
    return next((unit for unit in (said, said + _PER.get(role, "")) if unit in known), None)
