"""How far the states of a tube may be from the motion."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, fields

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, UNSIGNED

# What is read: which margin an entry is, and what its unit is worth.
_UNITS = {
    "deg": ("turning", math.pi / 180),
    "rad": ("turning", 1.0),
    "mm": ("sliding", 1e-3),
    "m": ("sliding", 1.0),
    "% rate": ("rate", 1e-2),
    "% acceleration": ("acceleration", 1e-2),
}
_KINDS = {"qd": "rate", "qdd": "acceleration"}


@dataclass(frozen=True)
class Margin:
    """How far states may be from the motion; what a drive that follows it well stays within by default.

    A joint that is held still has a margin of position only: a share of no rate is none.

    Parameters
    ----------
    turning, sliding
        Of the positions of joints that turn, rad, and that slide, m.
    rate, acceleration
        Of rates and accelerations, as a share of each joint's largest along the motion.

    Raises
    ------
    UsageError
        If one is negative, not finite or above 1e12.
    """

    turning: float = math.radians(1.0)
    sliding: float = 1e-3
    rate: float = 0.02
    acceleration: float = 0.05

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not 0.0 <= value <= LARGEST:
                raise UsageError(
                    "a margin cannot be that",
                    where=f"Margin, {entry.name}",
                    expected=f"0 or more, up to {LARGEST:g}",
                    found=f"{value:g}",
                )

    @classmethod
    def of(cls, given: Margin | str | None) -> Margin:
        """Take a margin, its text, or the default."""
        return cls.parse(given) if isinstance(given, str) else given or cls()

    @classmethod
    def parse(cls, text: str) -> Margin:
        """Read "1deg,1mm,qd=2%,qdd=5%", or some of these: what is not named is as by default.

        Raises
        ------
        UsageError
            If an entry is not understood, or a margin is given twice.

        Examples
        --------
        >>> Margin.parse("0.5deg,qd=1%").rate
        0.01
        """
        given: dict[str, float] = {}
        for column, entry in enumerate(text.split(","), start=1):
            match = re.fullmatch(rf"(?:(qdd?)=)?({UNSIGNED}) ?(deg|rad|mm|m|%)", entry.strip())
            unit = match and (f"% {_KINDS[match[1]]}" if match[1] in _KINDS else match[3])
            if match is None or unit not in _UNITS or (match[3] == "%") != bool(match[1]):
                raise UsageError(
                    "the margin is not understood",
                    where=f"--margin, entry {column}",
                    expected="entries such as 1deg or 1mm for positions, qd=2% for rates and qdd=5% for "
                    "accelerations, comma-separated",
                    found=repr(entry.strip()),
                )
            name, worth = _UNITS[unit]
            if name in given:
                raise UsageError(
                    "a margin is given twice",
                    where=f"--margin, entry {column}",
                    expected="one entry each",
                    found=repr(text),
                )
            given[name] = float(match[2]) * worth
        return cls(**given)

    def __str__(self) -> str:
        """As `parse` reads it."""
        return (
            f"{math.degrees(self.turning):.12g}deg,{1e3 * self.sliding:.12g}mm,"
            f"qd={100 * self.rate:.12g}%,qdd={100 * self.acceleration:.12g}%"
        )

    def in_words(self, arm: RobotArm) -> str:
        """Say it of an arm's joints.

        Examples
        --------
        >>> from gd_analyze.robots.catalogue import load_arm
        >>> Margin().in_words(load_arm("puma560"))
        '1 degree, 2 % of peak rate and 5 % of peak acceleration'
        """
        degrees = f"{math.degrees(self.turning):.6g}"
        kinds = {
            "revolute": f"{degrees} degree{'' if degrees == '1' else 's'}",
            "prismatic": f"{1e3 * self.sliding:.6g} mm",
        }
        positions = " or ".join(
            words for kind, words in kinds.items() if kind in {j.kind for j in arm.joints}
        )
        rate, acceleration = 100 * self.rate, 100 * self.acceleration
        return f"{positions}, {rate:.6g} % of peak rate and {acceleration:.6g} % of peak acceleration"

    def along(self, arm: RobotArm, motion: Trajectory) -> FloatArray:
        """Margins of q, qd and qdd of every joint along a motion, SI, shape (3, n)."""
        position = np.where(np.array(arm.is_revolute), self.turning, self.sliding)
        peaks = [np.abs(values).max(axis=0) for values in (motion.qd, motion.qdd)]
        return np.stack([position, self.rate * peaks[0], self.acceleration * peaks[1]])
