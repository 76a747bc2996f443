"""Largest distance of states from a motion: a margin of position, velocity and acceleration."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from types import NoneType

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import UsageError, require_type
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.robots.arm import RobotArm
from gd_analyze.text import LARGEST
from gd_analyze.units import Quantity

# Field of a margin, by what stands before "=" and the kind of quantity.
_FIELDS = {
    ("", "angle"): "revolute",
    ("", "length"): "prismatic",
    ("qd", "share"): "velocity",
    ("qdd", "share"): "acceleration",
}


@dataclass(frozen=True)
class Margin:
    """Largest distance of states from the motion; the default is what a well-tuned drive keeps.

    A joint at rest has a margin of position only, as its peak velocity is zero.

    Parameters
    ----------
    revolute, prismatic
        Positions of revolute joints, rad, and of prismatic joints, m.
    velocity, acceleration
        Velocities and accelerations, as shares of each joint's peak along the motion.

    Raises
    ------
    UsageError
        If one is negative, not finite or above 1e12.
    """

    revolute: float = math.radians(1.0)
    prismatic: float = 1e-3
    velocity: float = 0.02
    acceleration: float = 0.05

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if not 0.0 <= value <= LARGEST:
                where, expected = f"Margin, {entry.name}", f"0 or more, up to {LARGEST:g}"
                raise UsageError(
                    "a margin is out of range", where=where, expected=expected, found=f"{value:g}"
                )

    @classmethod
    def of(cls, margin: Margin | str | None) -> Margin:
        """Margin from its text, itself, or the default."""
        require_type(margin, (cls, str, NoneType), "margin", "a Margin, its text such as 1deg,1mm, or None")
        return cls.parse(margin) if isinstance(margin, str) else margin or cls()

    @classmethod
    def parse(cls, text: str) -> Margin:
        """Read "1deg,1mm,qd=2%,qdd=5%", or some of these entries; the others keep their defaults.

        Raises
        ------
        UsageError
            If an entry is not understood, or a margin is given twice.

        Examples
        --------
        >>> Margin.parse("0.5deg,qd=1%").velocity
        0.01
        """
        margins: dict[str, float] = {}
        for column, entry in enumerate(text.split(","), start=1):
            derivative, _, amount = entry.strip().rpartition("=")
            quantity = Quantity.parse(amount)
            name = None if quantity is None or quantity.of else _FIELDS.get((derivative, quantity.kind))
            where = f"margin, entry {column}"
            if quantity is None or name is None or quantity.si < 0.0:
                message, quoted = "the margin is not understood", repr(entry.strip())
                expected = "comma-separated: 1deg or 1mm of q, qd=2% of velocities, qdd=5% of accelerations"
                raise UsageError(message, where=where, expected=expected, found=quoted)
            if name in margins:
                message, quoted = "a margin is given twice", repr(text)
                raise UsageError(message, where=where, expected="one each", found=quoted)
            margins[name] = quantity.si
        return cls(**margins)

    def __str__(self) -> str:
        """Text that `parse` reads."""
        return (
            f"{math.degrees(self.revolute):.12g}deg,{1e3 * self.prismatic:.12g}mm,"
            f"qd={100 * self.velocity:.12g}%,qdd={100 * self.acceleration:.12g}%"
        )

    def in_words(self, arm: RobotArm) -> str:
        """Text for the kinds of joints that an arm has.

        Examples
        --------
        >>> from gd_analyze.robots.catalogue import load_arm
        >>> Margin().in_words(load_arm("puma560"))
        '1°, 2 % of peak velocity and 5 % of peak acceleration'
        """
        revolute = [f"{math.degrees(self.revolute):.6g}°"] if any(arm.is_revolute) else []
        prismatic = [] if all(arm.is_revolute) else [f"{1e3 * self.prismatic:.6g} mm"]
        return (
            f"{' or '.join(revolute + prismatic)}, {100 * self.velocity:.6g} % of peak velocity and "
            f"{100 * self.acceleration:.6g} % of peak acceleration"
        )

    def along(self, arm: RobotArm, motion: Trajectory) -> FloatArray:
        """Margins of q, qd and qdd of every joint along a motion, SI, shape (3, n)."""
        position = np.where(np.array(arm.is_revolute), self.revolute, self.prismatic)
        velocity, acceleration = np.abs(motion.extremes[1:]).max(axis=1)
        return np.stack([position, self.velocity * velocity, self.acceleration * acceleration])
