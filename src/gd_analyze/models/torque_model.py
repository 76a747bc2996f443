"""What every simplified model can do: evaluate torque, D, h and c by straight-line programs."""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import cached_property
from typing import Literal

import numpy as np

from gd_analyze.errors import ModelError
from gd_analyze.operations import OperationCount, Program
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray, set_points_last

Quantity = Literal["inertia", "coriolis_centrifugal", "gravity_loading", "torque"]


class TorqueModel(ABC):
    """A torque model of an arm, evaluated by programs that hold nothing superfluous."""

    arm: RobotArm

    @property
    @abstractmethod
    def programs(self) -> dict[str, Program]:
        """Programs of "torque", "inertia" (row by row), "coriolis_centrifugal" and "gravity_loading"."""

    @cached_property
    def operations(self) -> OperationCount:
        """Operations of one evaluation of all torques."""
        return self.programs["torque"].count

    def torque(self, q: FloatArray, qd: FloatArray, qdd: FloatArray) -> FloatArray:
        """Generalized torque of the simplified model.

        Parameters
        ----------
        q, qd, qdd
            Joint variables, rates and accelerations, rad (m) and per s, s^2, shape (..., n).

        Returns
        -------
        numpy.ndarray
            N m (N), shape (..., n).

        Raises
        ------
        ModelError
            If a last axis is not n long.
        """
        return self._evaluate("torque", q, qd, qdd)

    def inertia(self, q: FloatArray) -> FloatArray:
        """Simplified D, kg m^2, shape (..., n, n); with drives, theirs is on the diagonal."""
        n = self.arm.n_joints
        return self._evaluate("inertia", q).reshape(*np.shape(q)[:-1], n, n)

    def coriolis_centrifugal(self, q: FloatArray, qd: FloatArray) -> FloatArray:
        """Simplified h, N m, shape (..., n)."""
        return self._evaluate("coriolis_centrifugal", q, qd)

    def gravity_loading(self, q: FloatArray) -> FloatArray:
        """Simplified c, N m, shape (..., n)."""
        return self._evaluate("gravity_loading", q)

    def _evaluate(self, quantity: Quantity, *states: FloatArray) -> FloatArray:
        n = self.arm.n_joints
        arrays = np.broadcast_arrays(*(np.asarray(x, dtype=float) for x in states))
        leading = arrays[0].shape[:-1]
        inputs: dict[str, FloatArray] = {}
        for name, array in zip(("q", "qd", "qdd"), arrays, strict=False):
            if array.shape[-1:] != (n,):
                raise ModelError(
                    f"{name} does not fit the model of {self.arm.name}",
                    expected=f"shape (..., {n})",
                    found=str(array.shape),
                )
            inputs |= {f"{name}{i + 1}": row for i, row in enumerate(set_points_last(array))}
        values = self.programs[quantity].run(inputs)
        return np.ascontiguousarray(values.T).reshape(*leading, len(values))
