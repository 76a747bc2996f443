"""The equations that `identify` would obtain from a planned motion, and their determinant."""

from __future__ import annotations

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.dynamics.base_parameters import link_regressor
from gd_analyze.dynamics.friction import own_columns
from gd_analyze.identification.estimate import described, plausible_sizes
from gd_analyze.identification.rows import Unknowns, columns_of_unknowns
from gd_analyze.motions.measured import CREEPING_SHARE
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.limits import BoxLimits

_DRAWN_STATES = 200  # states drawn to find usual torques and acting parameters
# Singular values below this share are round-off, of indistinguishable parameters.
_ACTING_SHARE = 1e-9
_DIFFERENCE_STEP = 1e-6  # step of a difference that stands for a derivative


class ExpectedEquations:
    """Rows of an arm's links, drives and friction, in plausible sizes and usual torques.

    Parameters
    ----------
    arm, limits
        The arm, and finite limits of its states.
    """

    def __init__(self, arm: RobotArm, limits: BoxLimits) -> None:
        self.arm, self.fastest, n = arm, limits.velocity[:, None], arm.n_joints
        lowest = np.array([limits.lower, -limits.velocity, -limits.acceleration])[:, :, None]
        highest = np.array([limits.upper, limits.velocity, limits.acceleration])[:, :, None]
        states = np.random.default_rng(0).uniform(lowest, highest, (3, n, _DRAWN_STATES))
        self.unknowns = unknowns = Unknowns(n)
        self.sizes = plausible_sizes(arm, described(arm), [], unknowns)
        self.sizes[unknowns.of_friction] = 1.0
        # Noise and friction of a joint are assumed proportional to its usual torque.
        self.usual, self.acting = np.ones((n, 1, 1)), np.eye(unknowns.count)
        rows = self.rows(states)[..., : unknowns.of_drives.stop]
        self.usual = np.sqrt(np.square(rows).sum(axis=2, keepdims=True).mean(axis=1, keepdims=True))
        strength, directions = np.linalg.svd(self.rows(states).reshape(-1, unknowns.count))[1:]
        self.acting = directions[: int((strength > _ACTING_SHARE * strength[0]).sum())].T

    def rows(self, states: FloatArray) -> FloatArray:
        """Rows of every joint at q, qd and qdd (3, n, N): a column per acting direction, (n, N, columns)."""
        q, qd, qdd = states
        speed = qd / self.fastest
        # A differentiable sign: `identify` leaves out creeping joints.
        own = own_columns(qdd, np.tanh(speed / CREEPING_SHARE), speed)
        own[..., 1:] *= self.usual
        whole = columns_of_unknowns(self.unknowns, link_regressor(self.arm, q, qd, qdd), own)
        rows = np.ascontiguousarray(np.swapaxes(whole, 1, 2))
        return rows @ (self.sizes[:, None] * self.acting) / self.usual

    def log_determinant(self, states: FloatArray) -> tuple[float, FloatArray]:
        """Log determinant of the normal equations, and its derivatives by the states, (3, n, N)."""
        n, count = self.arm.n_joints, states.shape[2]
        # Rows depend only on the state at their instant: each number is varied at all instants at once.
        steps = _DIFFERENCE_STEP * np.eye(3 * n + 1)[1:].reshape(3, n, -1, 1)
        near = self.rows((states[:, :, None] + steps).reshape(3, n, -1)).reshape(n, 3 * n + 1, count, -1)
        rows = near[:, 0].reshape(n * count, -1)
        normal = rows.T @ rows
        solved = np.linalg.solve(normal, rows.T).T.reshape(n, count, -1)
        products = np.einsum("ijNp,iNp->jN", near, solved)
        slope = 2.0 * (products[1:] - products[0]) / _DIFFERENCE_STEP
        return float(np.linalg.slogdet(normal)[1]), slope.reshape(states.shape)

    def condition(self, states: FloatArray) -> float:
        """Condition number."""
        rows = self.rows(states)
        return float(np.linalg.cond(rows.reshape(-1, rows.shape[2])))
