"""A box of states, over which a bound holds."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from gd_analyze.arrays import FloatArray, array_of
from gd_analyze.errors import UsageError
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.limits import box_limits


@dataclass(frozen=True, eq=False)
class Box:
    """All states between limits.

    Parameters
    ----------
    lower, upper
        Limits of the positions, rad (m), shape (n,).
    velocity, acceleration
        Largest magnitudes, per s and s^2, shape (n,).
    where
        Name of these states.

    Raises
    ------
    UsageError
        If lengths disagree, a limit is not finite, a magnitude is negative or `lower` exceeds `upper`.
    """

    lower: FloatArray
    upper: FloatArray
    velocity: FloatArray
    acceleration: FloatArray
    where: str = "the box"

    def __post_init__(self) -> None:
        shape = array_of(self.lower, "lower", UsageError).shape
        for what in ("lower", "upper", "velocity", "acceleration"):
            array = array_of(getattr(self, what), what, UsageError).copy()
            if array.ndim != 1 or array.shape != shape or not array.size:
                raise UsageError(
                    "a box needs one limit of each kind per joint",
                    where=what,
                    expected=f"{shape[0]} numbers" if len(shape) == 1 and shape[0] else "numbers in a row",
                    found=f"shape {array.shape}",
                )
            array.flags.writeable = False
            object.__setattr__(self, what, array)
            self._require(np.isfinite(array), what, "finite numbers")
        self._require(self.lower <= self.upper, "lower", "at most the upper limit")
        self._require(self.velocity >= 0.0, "velocity", "a magnitude, at least 0")
        self._require(self.acceleration >= 0.0, "acceleration", "a magnitude, at least 0")

    def _require(self, holds: NDArray[np.bool_], what: str, expected: str) -> None:
        if not holds.all():
            joint = int(np.flatnonzero(~holds)[0])
            raise UsageError(
                "no state lies within the box",
                where=f"{what}, joint {joint + 1}",
                expected=expected,
                found=f"{getattr(self, what)[joint]:g}",
            )

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return len(self.lower)

    @property
    def centre(self) -> FloatArray:
        """Middle of the positions, shape (n,)."""
        return (self.lower + self.upper) / 2

    @property
    def farthest(self) -> FloatArray:
        """Largest magnitude of every position, shape (n,)."""
        return np.maximum(np.abs(self.lower), np.abs(self.upper))

    @classmethod
    def of(cls, arm: RobotArm) -> Box:
        """Box of the arm's own limits, and of assumed ones where it states none.

        Warns
        -----
        GdAnalyzeWarning
            Names the limits that are assumed, as `where` does.
        """
        limits = box_limits(arm)
        where = f"the arm's limits{limits.remark}"
        return cls(limits.lower, limits.upper, limits.velocity, limits.acceleration, where)

    @classmethod
    def around(cls, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> Box:
        """Smallest box around given states.

        Parameters
        ----------
        q, qd, qdd
            Positions, velocities and accelerations, rad (m) and per s, s^2, shape (N, n) each.

        Raises
        ------
        UsageError
            If shapes disagree, there is no state or a number is not finite.
        """
        given = {"q": q, "qd": qd, "qdd": qdd}
        arrays = [array_of(values, name, UsageError) for name, values in given.items()]
        if arrays[0].ndim != 2 or 0 in arrays[0].shape or any(a.shape != arrays[0].shape for a in arrays):
            raise UsageError(
                "a box is drawn around at least one state",
                where="q, qd, qdd",
                expected="three arrays of one shape (N, n)",
                found=", ".join(str(a.shape) for a in arrays),
            )
        position, velocity, acceleration = arrays
        return cls(
            position.min(axis=0),
            position.max(axis=0),
            np.abs(velocity).max(axis=0),
            np.abs(acceleration).max(axis=0),
        )
