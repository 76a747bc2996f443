"""The exact arm under control: accelerations of many states at once, from its shortest program."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.operations.program import Batch, Program
from gd_analyze.simplification.exact_form import ExactForm


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
        self._slides = friction

    def resistance(self, qd: FloatArray) -> FloatArray:
        """Friction that the torque has to overcome, shape (n, m)."""
        return self._resistance(qd.T).T if self._slides else np.zeros_like(qd)

    def accelerations(self, q: FloatArray, qd: FloatArray, driving: FloatArray) -> FloatArray:
        """D qdd = driving - h - c; all of shape (n, m)."""
        inertia, rest = self._dynamics.at(q, qd)
        solved = np.linalg.solve(inertia, (driving - rest).T[..., None])
        return np.asarray(solved[..., 0].T, dtype=float)
