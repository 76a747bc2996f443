"""The methods of `RobotArm` that compute dynamics, at states of any leading shape."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arrays import Array, FloatArray, chunks, set_points_last
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.dynamics.forward_dynamics import joint_accelerations
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import UsageError
from gd_analyze.motions.states import States, broadcast_states
from gd_analyze.robots.arm import RobotArm


@dataclass(frozen=True, eq=False)
class ArmDynamics:
    """Dynamics of one arm; `RobotArm` documents the methods."""

    arm: RobotArm

    def inertia(self, q: ArrayLike, by_effect: bool, drives: bool | None) -> FloatArray:
        """D, shape (..., n, n), or (..., 2, n, n) by effect."""
        if by_effect and drives:
            message = "the inertia of drives belongs to neither effect"
            raise UsageError(message, where="drives", expected="drives=False or None with by_effect=True")

        def matrices(q: Array) -> Array:
            return composite.inertia(self._moments(q))

        links = self._of_effects(matrices, (self.arm.n_joints,) * 2, by_effect, q=q)
        is_with_drives = self.arm.counts_drives(drives) and not by_effect
        return links + np.diag(self.arm.drive_inertia) if is_with_drives else links

    def christoffel(self, q: ArrayLike, by_effect: bool) -> FloatArray:
        """h_ijk, shape (..., n, n, n), or (..., 2, n, n, n) by effect."""

        def coefficients(q: Array) -> Array:
            moments = self._moments(q)
            return composite.christoffel(moments, composite.brackets(moments))

        return self._of_effects(coefficients, (self.arm.n_joints,) * 3, by_effect, q=q)

    def coriolis_centrifugal(self, q: ArrayLike, qd: ArrayLike, by_effect: bool) -> FloatArray:
        """h, shape (..., n), or (..., 2, n) by effect."""

        def vector(q: Array, qd: Array) -> Array:
            moments = self._moments(q)
            return composite.coriolis_centrifugal(moments, composite.brackets(moments), qd)[0]

        return self._of_effects(vector, (self.arm.n_joints,), by_effect, q=q, qd=qd)

    def gravity_loading(self, q: ArrayLike) -> FloatArray:
        """c, shape (..., n)."""

        def vector(q: Array) -> Array:
            return composite.gravity_loading(self.arm, self._moments(q))

        return self._evaluated(vector, (self.arm.n_joints,), q=q)

    def torque(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, drives: bool | None) -> FloatArray:
        """Torque, shape (..., n)."""
        q, qd, qdd = self._states(q=q, qd=qd, qdd=qdd)
        return torque_of(self.arm, States(q, qd, qdd), drives=drives)

    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, torque: ArrayLike, drives: bool | None
    ) -> FloatArray:
        """Accelerations, shape (..., n)."""
        q, qd, torque = self._states(q=q, qd=qd, torque=torque)
        drivetrain = Drivetrain(inertia=self.arm.counts_drives(drives))
        return joint_accelerations(self.arm, q, qd, torque, drivetrain=drivetrain)

    def _states(self, **quantities: ArrayLike) -> list[FloatArray]:
        return broadcast_states(self.arm.n_joints, f"arm {self.arm.name}", UsageError, **quantities)

    def _moments(self, q: Array) -> composite.CompositeMoments:
        return composite.composite_moments(self.arm, solve_kinematics(self.arm, q))

    def _of_effects(
        self, parts: Callable[..., Array], shape: tuple[int, ...], by_effect: bool, **quantities: ArrayLike
    ) -> FloatArray:
        """Evaluate both effects, and sum them unless they are wanted apart."""
        if by_effect:
            return self._evaluated(parts, (2, *shape), **quantities)
        return self._evaluated(lambda *states: parts(*states).sum(axis=0), shape, **quantities)

    def _evaluated(
        self, function: Callable[..., Array], shape: tuple[int, ...], **quantities: ArrayLike
    ) -> FloatArray:
        """Evaluate a function of states (n, N), whose results have the set points last, chunk by chunk."""
        arrays = self._states(**quantities)
        columns = [set_points_last(array) for array in arrays]
        out = np.empty((columns[0].shape[1], *shape))
        for chunk in chunks(len(out)):
            out[chunk] = np.moveaxis(function(*(column[:, chunk] for column in columns)), -1, 0)
        return out.reshape(*arrays[0].shape[:-1], *shape)
