"""The dynamics of one arm as functions of its state: D, h_ijk, h, c, torque and accelerations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from gd_analyze.arguments import strict
from gd_analyze.arrays import Array, FloatArray, chunks, set_points_last
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics.decomposition import torque_of
from gd_analyze.dynamics.drivetrain import Drivetrain
from gd_analyze.dynamics.forward_dynamics import joint_accelerations
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import UsageError
from gd_analyze.guesses import EXACT_DYNAMICS, guessing
from gd_analyze.motions.states import States, broadcast_states
from gd_analyze.robots.arm import RobotArm
from gd_analyze.robots.catalogue import arm_of


@dataclass(frozen=True, eq=False)
class ArmDynamics:
    """Dynamics of one arm, at states of any leading shape.

    A simplified model has the same methods.

    Parameters
    ----------
    arm
        The arm; or a shipped name, or the path of a file.
    """

    arm: RobotArm

    def __post_init__(self) -> None:
        object.__setattr__(self, "arm", arm_of(self.arm))

    if not TYPE_CHECKING:  # checkers are to refuse unknown names
        __getattr__ = guessing(EXACT_DYNAMICS)

    @strict
    def inertia(self, q: ArrayLike, *, by_effect: bool = False, drives: bool | None = None) -> FloatArray:
        """Mass matrix D.

        Parameters
        ----------
        q
            Joint variables, rad (m), shape (..., n).
        by_effect
            Give the parts of translation and rotation, which sum to D of the links.
        drives
            Add the drives' inertia to the diagonal; by default if the arm describes drives, and never by
            effect.

        Returns
        -------
        numpy.ndarray
            kg m^2 (kg m, kg), shape (..., n, n), or (..., 2, n, n) by effect.

        Raises
        ------
        UsageError
            If the shape does not fit, a value is not a number, not finite or too large, or drives are asked
            for by effect.
        ArmError
            If drives are asked for and the arm describes none.

        Examples
        --------
        >>> import gd_analyze as gd
        >>> puma = gd.types.ArmDynamics("puma560")
        >>> puma.inertia([0.0] * 6).shape
        (6, 6)
        >>> translation, rotation = puma.inertia([0.0] * 6, by_effect=True)
        """
        if by_effect and drives:
            message = "the inertia of drives belongs to neither effect"
            raise UsageError(message, where="drives", expected="drives=False or None with by_effect=True")

        def matrices(q: Array) -> Array:
            return composite.inertia(self._moments(q))

        links = self._of_effects(matrices, (self.arm.n_joints,) * 2, by_effect, q=q)
        is_with_drives = self.arm.counts_drives(drives) and not by_effect
        return links + np.diag(self.arm.drive_inertia) if is_with_drives else links

    @strict
    def christoffel(self, q: ArrayLike, *, by_effect: bool = False) -> FloatArray:
        """Coefficients h_ijk of h, so that h_i sums h_ijk qd_j qd_k over j and k.

        Parameters
        ----------
        q, by_effect
            As for `inertia`.

        Returns
        -------
        numpy.ndarray
            kg m^2 (kg m, kg), shape (..., n, n, n), or (..., 2, n, n, n) by effect.

        Raises
        ------
        UsageError
            As for `inertia`.
        """

        def coefficients(q: Array) -> Array:
            moments = self._moments(q)
            return composite.christoffel(moments, composite.brackets(moments))

        return self._of_effects(coefficients, (self.arm.n_joints,) * 3, by_effect, q=q)

    @strict
    def coriolis_centrifugal(self, q: ArrayLike, qd: ArrayLike, *, by_effect: bool = False) -> FloatArray:
        """Coriolis and centrifugal torque h.

        Parameters
        ----------
        q, qd
            Joint variables and velocities, rad (m) and per s, shape (..., n); leading axes are broadcast.
        by_effect
            Give the parts of translation and rotation, which sum to h.

        Returns
        -------
        numpy.ndarray
            N m (N), shape (..., n), or (..., 2, n) by effect.

        Raises
        ------
        UsageError
            As for `inertia`, or if the shapes cannot be broadcast.
        """

        def vector(q: Array, qd: Array) -> Array:
            moments = self._moments(q)
            return composite.coriolis_centrifugal(moments, composite.brackets(moments), qd)[0]

        return self._of_effects(vector, (self.arm.n_joints,), by_effect, q=q, qd=qd)

    def gravity_loading(self, q: ArrayLike) -> FloatArray:
        """Gravity loading c, all of it translation.

        Parameters
        ----------
        q
            Joint variables, rad (m), shape (..., n).

        Returns
        -------
        numpy.ndarray
            N m (N), shape (..., n).

        Raises
        ------
        UsageError
            As for `inertia`.
        """

        def vector(q: Array) -> Array:
            return composite.gravity_loading(self.arm, self._moments(q))

        return self._evaluated(vector, (self.arm.n_joints,), q=q)

    @strict
    def torque(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, drives: bool | None = None
    ) -> FloatArray:
        """Torque D qdd + h + c, without friction (inverse dynamics).

        Parameters
        ----------
        q, qd, qdd
            Joint variables, velocities and accelerations, rad (m) and per s, s^2, shape (..., n); leading
            axes are broadcast.
        drives
            Add the torque that accelerates the drives; by default if the arm describes drives.

        Returns
        -------
        numpy.ndarray
            N m (N), shape (..., n).

        Raises
        ------
        UsageError, ArmError
            As for `inertia`, or if the shapes cannot be broadcast.
        """
        q, qd, qdd = self._states(q=q, qd=qd, qdd=qdd)
        return torque_of(self.arm, States(q, qd, qdd), drives=drives)

    @strict
    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, torque: ArrayLike, *, drives: bool | None = None
    ) -> FloatArray:
        """Accelerations that torques cause, without friction (forward dynamics).

        Parameters
        ----------
        q, qd, torque
            Joint variables, velocities, rad (m) and per s, and torques, N m (N), shape (..., n); leading axes
            are broadcast.
        drives
            Accelerate the drives, too; by default if the arm describes drives.

        Returns
        -------
        numpy.ndarray
            rad/s^2 (m/s^2), shape (..., n).

        Raises
        ------
        UsageError
            As for `torque`.
        ArmError
            If D is singular or has a negative eigenvalue, or drives are asked for and the arm describes none.
        """
        q, qd, torque = self._states(q=q, qd=qd, torque=torque)
        drivetrain = Drivetrain(inertia=self.arm.counts_drives(drives))
        return joint_accelerations(self.arm, q, qd, torque, drivetrain=drivetrain)

    def _states(self, **quantities: ArrayLike) -> list[FloatArray]:
        return broadcast_states(self.arm, **quantities)

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
