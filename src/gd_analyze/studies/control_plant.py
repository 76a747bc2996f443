"""What is controlled: the exact arm's D and h + c, and the motion that it is to follow."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.between import Between
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.velocities import FEWEST_SET_POINTS, completed
from gd_analyze.operations.program import Batch, Program

# The polynomials' accelerations go with those given where they are at most so many times as large, and where
# they are below so many rad/s^2 (m/s^2).
_LARGER, _SMALL = 3.0, 1e-2
INSTANTS = 500  # at which a whole motion is looked at


class Dynamics:
    """D and h + c of m states from a program of the torque D qdd + h + c of n joints.

    Torque without acceleration is h + c, and what one of each joint adds is a column of D.
    """

    def __init__(self, program: Program, n_joints: int, count: int) -> None:
        self._shape = shape = (n_joints + 1, count)
        self._batch = Batch(program, shape[0] * count)
        self._q, self._qd = (self._batch.rows(name, n_joints, *shape) for name in ("q", "qd"))
        for i, row in self._batch.rows("qdd", n_joints, *shape):
            row[:] = 0.0
            row[i + 1] = 1.0

    def at(self, q: FloatArray, qd: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Give D, shape (m, n, n), and h + c, shape (n, m), at states (n, m)."""
        for rows, values in ((self._q, q), (self._qd, qd)):
            for i, row in rows:
                row[:] = values[i]
        torque = self._batch.run().reshape(len(q), *self._shape)
        rest = torque[:, 0]
        return np.moveaxis(torque[:, 1:] - rest[:, None], -1, 0), rest


@dataclass(frozen=True, eq=False)
class Reference:
    """Polynomials of fifth degree through q, qd and qdd of set points: twice differentiable."""

    time: FloatArray  # of the set points, s, from 0, (N,)
    coefficients: FloatArray  # of powers of the share of an interval, (N - 1, 6, n)

    @classmethod
    def of(cls, motion: Trajectory) -> Reference:
        """Lay it through a trajectory that can be followed, see `followable`."""
        between = Between.of(motion, np.zeros((2, motion.n_joints)), slice(None))
        return cls(motion.time - motion.time[0], between.coefficients[:, :, 0, 0])

    @property
    def duration(self) -> float:
        """How long it lasts as planned, s."""
        return float(self.time[-1])

    def at(self, time: FloatArray, speed: FloatArray | float = 1.0) -> tuple[FloatArray, ...]:
        """Give q, qd and qdd, joints first, shape (n, ...), at instants s of the motion run at some speed."""
        planned = np.clip(time * speed, 0.0, self.duration)
        k = np.clip(np.searchsorted(self.time, planned, side="right") - 1, 0, len(self.coefficients) - 1)
        width = np.diff(self.time)[k]
        s = (planned - self.time[k]) / width
        c = np.moveaxis(self.coefficients[k], (-2, -1), (0, 1))
        per = speed / width
        q = ((((c[5] * s + c[4]) * s + c[3]) * s + c[2]) * s + c[1]) * s + c[0]
        qd = ((((5 * c[5] * s + 4 * c[4]) * s + 3 * c[3]) * s + 2 * c[2]) * s + c[1]) * per
        qdd = (((20 * c[5] * s + 12 * c[4]) * s + 6 * c[3]) * s + 2 * c[2]) * per**2
        return q, qd, qdd

    def sampled(self, speed: float = 1.0) -> tuple[FloatArray, ...]:
        """Give q, qd and qdd, shape (n, K), at evenly spaced instants and all set points."""
        every = np.unique(np.concatenate([np.linspace(0.0, self.duration, INSTANTS), self.time]))
        return self.at(every / speed, speed)


def followable(motion: Trajectory) -> Trajectory:
    """Take a trajectory to be followed; derivatives that contradict its positions are derived anew.

    A `TrajectoryError` refuses gaps or a single set point: nothing says then what to follow.
    """
    if motion.gaps:
        at = motion.gaps[0]
        raise TrajectoryError(
            "a motion with gaps cannot be followed",
            where=f"trajectory {motion.name}, between {motion.time[at - 1]:g} and {motion.time[at]:g} s",
            expected="one motion without a break",
            found=f"{len(motion.gaps)} gap{'s' * (len(motion.gaps) > 1)}",
            next_step="give one of its parts as a trajectory of its own",
        )
    if motion.n_set_points < 2:
        raise TrajectoryError(
            "there is no motion to follow",
            where=f"trajectory {motion.name}",
            expected="two set points or more",
            found="1 set point",
        )
    between = Reference.of(motion)
    middles = between.time[:-1] + np.diff(between.time) * np.array([[0.25], [0.5], [0.75]])
    largest = np.abs(between.at(middles)[2]).max(axis=(1, 2))
    wild = largest > np.maximum(_LARGER * np.abs(motion.qdd).max(axis=0), _SMALL)
    if not wild.any() or motion.n_set_points < FEWEST_SET_POINTS:
        return motion
    qd, qdd, _ = completed(motion.time, motion.q, None, None)
    joint = int(largest.argmax())
    warnings.warn(
        f"velocities and accelerations of {motion.name} disagree with its positions: these need up to "
        f"{largest[joint]:.3g} rad/s^2 (m/s^2) of joint {joint + 1}, the motion states "
        f"{np.abs(motion.qdd[:, joint]).max():.3g}; a quintic spline through the positions is followed",
        GdAnalyzeWarning,
        stacklevel=2,
    )
    return replace(motion, qd=qd, qdd=qdd)
