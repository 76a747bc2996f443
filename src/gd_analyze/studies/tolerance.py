"""Tracking error that counts as good: of joints that turn and of joints that slide."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST, UNSIGNED

_UNITS = {
    "deg": ("turning", math.pi / 180),
    "mrad": ("turning", 1e-3),
    "rad": ("turning", 1.0),
    "mm": ("sliding", 1e-3),
    "m": ("sliding", 1.0),
}


@dataclass(frozen=True)
class Tolerance:
    """Largest tracking error of joints that turn, rad, and that slide, m."""

    turning: float = math.radians(0.1)
    sliding: float = 1e-3

    def __post_init__(self) -> None:
        for value in (self.turning, self.sliding):
            if not 0.0 < value <= LARGEST:
                raise UsageError(
                    "no error is within this tolerance",
                    where="tolerance",
                    expected="a positive angle or length",
                    found=f"{value:g}",
                )

    @classmethod
    def parse(cls, text: str) -> Tolerance:
        """Read "0.1deg,1mm", or one of these; what is not named is as by default.

        Raises
        ------
        UsageError
            If an entry is not understood or is given twice.

        Examples
        --------
        >>> Tolerance.parse("2mrad").turning
        0.002
        """
        given: dict[str, float] = {}
        for place, entry in enumerate(text.split(","), start=1):
            match = re.fullmatch(rf"({UNSIGNED}) ?(deg|mrad|rad|mm|m)", entry.strip())
            name, worth = _UNITS[match[2]] if match else ("", 0.0)
            if match is None or name in given:
                raise UsageError(
                    "the tolerance is given twice" if match else "the tolerance is not understood",
                    where=f"--within, entry {place}",
                    expected="an angle such as 0.1deg or 2mrad, a length such as 1mm, or both with a comma",
                    found=repr(entry.strip()),
                )
            given[name] = float(match[1]) * worth
        return cls(**given)

    def of(self, arm: RobotArm) -> FloatArray:
        """Tolerance of every joint, rad (m), shape (n,)."""
        return np.where(np.array(arm.is_revolute), self.turning, self.sliding)

    def in_words(self, arm: RobotArm) -> str:
        """Say it of an arm's joints."""
        kinds = {
            "revolute": f"{math.degrees(self.turning):.4g}°",
            "prismatic": f"{1e3 * self.sliding:.4g} mm",
        }
        there = {joint.kind for joint in arm.joints}
        return " or ".join(words for kind, words in kinds.items() if kind in there)
