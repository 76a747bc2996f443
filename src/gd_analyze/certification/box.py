"""A box of states, as the region of a bound."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

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
        lowest = np.full(shape, -np.inf)
        for name in ("lower", "upper", "velocity", "acceleration"):
            array = array_of(getattr(self, name), name, UsageError).copy()
            if array.ndim != 1 or array.shape != shape or not array.size:
                expected = f"{shape[0]} numbers" if len(shape) == 1 and shape[0] else "numbers in a row"
                message = "a box needs one limit of each kind per joint"
                raise UsageError(message, where=name, expected=expected, found=f"shape {array.shape}")
            wrong = np.flatnonzero(~(np.isfinite(array) & (array >= lowest)))
            if wrong.size:
                joint, message = wrong[0], "the box is empty"
                where, value = f"{name}, joint {joint + 1}", f"{array[joint]:g}"
                expected = "a finite number"
                if name != "lower":
                    expected += f", {lowest[joint]:g} or more"
                raise UsageError(message, where=where, expected=expected, found=value)
            array.flags.writeable = False
            object.__setattr__(self, name, array)
            lowest = array if name == "lower" else np.zeros(shape)

    @property
    def n_joints(self) -> int:
        """Number of joints n."""
        return len(self.lower)

    def pieces(self, count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Limits of q, qd, qdd (3, count, n) to draw states from; weights of errors there (count, n)."""
        upper = np.stack([self.upper, self.velocity, self.acceleration])
        lower = np.stack([self.lower, -self.velocity, -self.acceleration])
        lower, upper = (side[:, None].repeat(count, axis=1) for side in (lower, upper))
        return lower, upper, np.ones((count, self.n_joints))

    def counts_at(self, states: FloatArray) -> FloatArray:
        """Weights of errors at states (3, M, n), shape (M, n): all equal."""
        return np.ones(states.shape[1:])

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
        """Box of the arm's limits, and of assumed ones if it states none.

        Warns
        -----
        GdAnalyzeWarning
            If limits are assumed; `where` names them, too.
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
        arrays = {"q": q, "qd": qd, "qdd": qdd}
        q, qd, qdd = (array_of(values, name, UsageError) for name, values in arrays.items())
        if q.ndim != 2 or not q.size or not q.shape == qd.shape == qdd.shape:
            message, shapes = "a box needs at least one state", f"{q.shape}, {qd.shape}, {qdd.shape}"
            expected = "three arrays of equal shape (N, n)"
            raise UsageError(message, where="q, qd, qdd", expected=expected, found=shapes)
        return cls(q.min(axis=0), q.max(axis=0), np.abs(qd).max(axis=0), np.abs(qdd).max(axis=0))
