"""The motion that a controller is to follow, at any instant between its set points."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.errors import TrajectoryError
from gd_analyze.trajectories import Trajectory
from gd_analyze.trajectories.between import Between
from gd_analyze.vectors import FloatArray

# What counts as rounding of a file's numbers: of positions, rad (m), and of rates, as shares of the largest.
_ROUNDING = 1e-6


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
        """Lay it through a trajectory.

        Raises
        ------
        TrajectoryError
            If the trajectory has gaps or a single set point: nothing says then what to follow.
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
        rounding = np.stack([np.full(motion.n_joints, _ROUNDING), _ROUNDING * np.abs(motion.qd).max(axis=0)])
        between = Between.of(motion, rounding, slice(None))
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
