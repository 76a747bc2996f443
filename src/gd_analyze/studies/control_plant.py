"""What is controlled: the exact arm, and the motion that it is to follow."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.errors import GdAnalyzeWarning, TrajectoryError
from gd_analyze.motions.between import Between
from gd_analyze.motions.trajectory import Trajectory
from gd_analyze.motions.velocities import FEWEST_SET_POINTS, completed
from gd_analyze.operations.program import Batch, Program
from gd_analyze.simplification.exact_form import ExactForm

# The polynomials' accelerations go with those given where they are at most so many times as large, and where
# they are below so many rad/s^2 (m/s^2).
_LARGER, _SMALL = 3.0, 1e-2


class Dynamics:
    """D and h + c of many states from a program of the torque.

    Torque is D qdd + h + c: what it is without acceleration, and what one of each joint adds to that.

    Parameters
    ----------
    program
        Of an arm of n joints.
    n_joints, count
        n, and states m of one call.
    """

    def __init__(self, program: Program, n_joints: int, count: int) -> None:
        self.n, self.count = n_joints, count
        shape = (n_joints + 1, count)
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
        torque = self._batch.run().reshape(self.n, self.n + 1, self.count)
        rest = torque[:, 0]
        inertia = torque[:, 1:] - rest[:, None]
        return np.moveaxis(inertia, -1, 0), rest


class Plant:
    """An arm that torques move.

    Parameters
    ----------
    form
        Its exact dynamics.
    friction
        Whether the drives' friction acts.
    count
        States of one call.
    """

    def __init__(self, form: ExactForm, friction: bool, count: int) -> None:
        self._dynamics = Dynamics(form.program, form.arm.n_joints, count)
        self._resistance = Drivetrain(friction=friction).resistance_of(form.arm)
        self._has_friction = friction

    def resistance(self, qd: FloatArray) -> FloatArray:
        """Friction that the torque has to overcome, shape (n, m)."""
        return self._resistance(qd.T).T if self._has_friction else np.zeros_like(qd)

    def accelerations(self, q: FloatArray, qd: FloatArray, driving: FloatArray) -> FloatArray:
        """D qdd = driving - h - c; all of shape (n, m)."""
        inertia, rest = self._dynamics.at(q, qd)
        solved = np.linalg.solve(inertia, (driving - rest).T[..., None])
        return np.asarray(solved[..., 0].T, dtype=float)


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
    """Take a trajectory to be followed, with velocities that agree with its positions.

    Raises
    ------
    TrajectoryError
        If the trajectory has gaps or a single set point: nothing says then what to follow.

    Warns
    -----
    GdAnalyzeWarning
        If velocities and accelerations disagree with the positions, and are derived from these.
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
