"""Units and quantities: one table of units, and one parser for options, files and Python."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass

from gd_analyze.text import LARGEST, UNSIGNED

# Size of each unit in SI, by kind; the SI unit comes first.
UNITS: dict[str, dict[str, float]] = {
    "angle": {"rad": 1.0, "mrad": 1e-3, "deg": math.pi / 180.0, "rev": 2 * math.pi},
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "frequency": {"Hz": 1.0, "kHz": 1e3},
    "torque": {"N m": 1.0, "cN m": 1e-2, "mN m": 1e-3, "kN m": 1e3},
    "force": {"N": 1.0, "kN": 1e3},
    "mass": {"kg": 1.0, "g": 1e-3},
    "inertia": {"kg m^2": 1.0},
    "current": {"A": 1.0, "mA": 1e-3},
    "share": {"%": 0.01},
}
TIME_UNITS = UNITS["time"]
# Beyond these, rad and m, and per s^2, a number without a unit is probably in degrees or mm.
MOST_WITHOUT_UNIT: Mapping[str, float] = {"angle": 2 * math.pi, "length": 10.0}
MOST_ACCELERATION_WITHOUT_UNIT: Mapping[str, float] = {"angle": 300.0, "length": 300.0}
KINDS = {unit: kind for kind, sizes in UNITS.items() for unit in sizes}
# Unit by its spellings, in lower case without blanks.
_SPELLINGS = {re.sub(r"\s", "", unit).lower(): unit for unit in KINDS} | {
    spelling: unit
    for unit, spellings in {
        "deg": "degree degrees degs °",
        "rad": "radian radians rads",
        "m": "meter meters metre metres",
        "s": "sec secs second seconds",
        "ms": "msec msecs millis milliseconds",
        "us": "µs μs usec usecs micros microseconds",
        "ns": "nsec nsecs nanosec nanosecs nanos nanoseconds",
        "rev": "turn turns revs revolutions",
        "cN m": "ncm cnm",
        "mN m": "nmm mnm",
        "N m": "nm",
        "kN m": "knm",
        "N": "newton",
        "A": "amp amps ampere amperes",
    }.items()
    for spelling in spellings.split()
}
_SUPERSCRIPTS = str.maketrans({"²": "^2"})
_TIMES_SIGN = re.compile(r"(?<=[A-Za-z])[-.*·](?=[A-Za-z])")
# Spellings whose first letter means something else as a capital: M is mega, N is newton.
_SMALL_FIRST = {"mrad", "mm", "ms", "msec", "msecs", "ma", "mnm", "ns"}
_QUANTITY = re.compile(rf"(?P<number>[-+]?{UNSIGNED})\s*(?P<rest>.*)", re.DOTALL)
_SHARE = re.compile(r"%\s*(?:of\s+)?(?P<whole>[a-z]*)", re.IGNORECASE)


def unit_named(text: str) -> str | None:
    """A unit of `UNITS` by any of its spellings; None if it is unknown.

    Examples
    --------
    >>> unit_named("Nm"), unit_named("degrees"), unit_named("furlong")
    ('N m', 'deg', None)
    >>> unit_named("mN m"), unit_named("MN m")
    ('mN m', None)
    """
    bare = _TIMES_SIGN.sub("", re.sub(r"\s+", "", text)).translate(_SUPERSCRIPTS).replace("**2", "^2")
    spelling = bare.lower()
    # Text in capitals throughout tells no prefix, but before N m, where mega is as likely as milli.
    shouted = bare.isupper() and spelling != "mnm"
    if spelling in _SMALL_FIRST and bare[0].isupper() and not shouted:
        return None
    return _SPELLINGS.get(spelling)


@dataclass(frozen=True)
class Quantity:
    """A number with its unit, in SI."""

    si: float  # in the SI unit of its kind; 1 % is 0.01; infinite where the text overflows
    kind: str = ""  # a key of `UNITS`; "" for a number without a unit
    of: str = ""  # what a share is of, in lower case: "friction"; "" if it is not said

    @classmethod
    def parse(cls, text: str) -> Quantity | None:
        """Read "1%", "0.1deg", "2 mm", "5 N m", "10% of friction" or "0.5"; None for any other text.

        Examples
        --------
        >>> Quantity.parse("2 mm")
        Quantity(si=0.002, kind='length', of='')
        >>> Quantity.parse("10% friction")
        Quantity(si=0.1, kind='share', of='friction')
        >>> Quantity.parse("two") is None
        True
        """
        match = _QUANTITY.fullmatch(text.strip())
        if match is None:
            return None
        number, unit_text = float(match["number"]), match["rest"]
        if not unit_text:
            return cls(number)
        share = _SHARE.fullmatch(unit_text)
        if share is not None:
            # Divided, as 7 / 100 is the number nearest to 0.07.
            return cls(number / 100, "share", share["whole"].lower())
        unit = unit_named(unit_text)
        return None if unit is None else cls(number * UNITS[KINDS[unit]][unit], KINDS[unit])

    def __str__(self) -> str:
        """Text that `parse` reads, to six digits."""
        unit = next(iter(UNITS[self.kind])) if self.kind else ""
        number = self.si if not unit else self.si / UNITS[self.kind][unit]
        return f"{number:g}{unit} {self.of}".rstrip()

    @classmethod
    def read(cls, value: object) -> Quantity | None:
        """Read a text, or take a number without a unit; None for anything else."""
        if isinstance(value, str):
            return cls.parse(value)
        return cls(float(value)) if isinstance(value, int | float) and not isinstance(value, bool) else None

    def of_joint(self, revolute: bool, most: Mapping[str, float] = MOST_WITHOUT_UNIT) -> float | None:
        """SI value for a joint that turns (slides).

        None if the unit is of another kind, or if there is none and the value is beyond `most`, by kind.

        Examples
        --------
        >>> Quantity.parse("10mm").of_joint(revolute=True), Quantity.parse("90").of_joint(revolute=True)
        (None, None)
        >>> Quantity.parse("90rad").of_joint(revolute=True)
        90.0
        """
        kind = "angle" if revolute else "length"
        largest = LARGEST if self.kind else most[kind]
        return self.si if self.kind in ("", kind) and abs(self.si) <= largest else None

    @classmethod
    def si_of(cls, value: object, *kinds: str) -> float | None:
        """SI value of a number, or of a text without a unit or in one of these kinds; None if neither.

        Examples
        --------
        >>> Quantity.si_of("20mm", "angle", "length"), Quantity.si_of(1.5, "angle")
        (0.02, 1.5)
        >>> Quantity.si_of("20mm", "angle") is None
        True
        """
        quantity = cls.read(value)
        return quantity.si if quantity is not None and quantity.kind in ("", *kinds) else None


def joint_units(revolute: bool, per: str = "") -> str:
    """How to write a joint's value, for messages."""
    kind = "angle" if revolute else "length"
    unit, *_ = UNITS[kind]
    most = MOST_WITHOUT_UNIT[kind] if not per else MOST_ACCELERATION_WITHOUT_UNIT[kind]
    example = ("90deg", "1.57rad") if revolute else ("20mm", "0.02m")
    return f"up to {most:.3g} {unit}{per}, or with a unit: {example[0]}, {example[1]}"
