"""The motion that a controller is to follow, at any instant between its set points."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.between import Between
from gd_analyze.motions.derived_rates import FEWEST_SET_POINTS, complete_rates
from gd_analyze.motions.trajectory import Trajectory

# The polynomials' accelerations go with those given where they are at most so many times as large, and where
# they are below so many rad/s^2 (m/s^2).
_LARGER, _SMALL = 3.0, 1e-2


@dataclass(frozen=True, eq=False)
class Reference:
    """Polynomials of fifth degree through q, qd and qdd of a trajectory's set points: twice differentiable.

    Parameters
    ----------
    time
        Of the set points, s, from 0, shape (N,).
    coefficients
        Of powers of the share of an interval, shape (N - 1, 6, n).
    """

    time: FloatArray
    coefficients: FloatArray

    @classmethod
    def of(cls, motion: Trajectory) -> Reference:
        """Lay it through a trajectory that can be followed, see `followable`."""
        return cls(motion.time - motion.time[0], _quintics(motion))

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


def followable(motion: Trajectory) -> Trajectory:
    """Take a trajectory to be followed; where its rates do not go with its positions, with rates that do.

    Raises
    ------
    TrajectoryError
        If the trajectory has gaps or a single set point: nothing says then what to follow.

    Warns
    -----
    GdAnalyzeWarning
        If rates and accelerations are derived anew from the positions.
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
    qd, qdd, _ = complete_rates(motion.time, motion.q, None, None)
    joint = int(largest.argmax())
    warnings.warn(
        f"rates and accelerations of {motion.name} do not go with its positions: between set points joint "
        f"{joint + 1} would need up to {largest[joint]:.3g} rad/s^2 (m/s^2), and states "
        f"{np.abs(motion.qdd[:, joint]).max():.3g}; a quintic spline through the positions is followed",
        GdAnalyzeWarning,
        stacklevel=2,
    )
    return replace(motion, qd=qd, qdd=qdd)


def _quintics(motion: Trajectory) -> FloatArray:
    """Coefficients of powers of the share of every interval, shape (N - 1, 6, n)."""
    exactly = np.zeros((2, motion.n_joints))
    return Between.of(motion, exactly, slice(None)).coefficients[:, :, 0, 0]


def at_speed(motion: Trajectory, speed: float) -> Trajectory:
    """Run a trajectory so many times as fast."""
    if speed == 1.0:
        return motion
    return replace(
        motion,
        time=motion.time / speed,
        qd=motion.qd * speed,
        qdd=motion.qdd * speed**2,
        name=f"{motion.name} at {speed:g} times its speed",
        recording=None,
        motions=(),
    )
