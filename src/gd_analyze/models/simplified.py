"""What a user takes away: a simplified model that evaluates torque, D, h and c, and what it promises."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal, TypedDict

import numpy as np

from gd_analyze.dominance import ROUND_OFF_SHARE, peak_magnitude
from gd_analyze.errors import ModelError
from gd_analyze.operations import OperationCount, Program
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray, set_points_last

Level = Literal["element", "term", "energy"]
LEVELS: tuple[Level, ...] = ("element", "term", "energy")
Quantity = Literal["inertia", "coriolis_centrifugal", "gravity_loading", "torque"]


@dataclass(frozen=True, eq=False)
class ErrorTable:
    """Torque error of a model over given states, per joint; N m (N for a sliding joint), shape (n,).

    Parameters
    ----------
    peak_torque
        Largest magnitude of the exact torque.
    largest, rms
        Largest and root mean square error.
    """

    peak_torque: FloatArray
    largest: FloatArray
    rms: FloatArray

    @classmethod
    def of(cls, exact: FloatArray, simplified: FloatArray) -> ErrorTable:
        """Compare torques of shape (N, n); what is only round-off counts as no error."""
        error = simplified - exact
        error[np.abs(error) <= ROUND_OFF_SHARE * np.abs(exact).max()] = 0.0
        return cls(peak_magnitude(exact), np.abs(error).max(axis=0), np.sqrt(np.mean(error**2, axis=0)))

    @classmethod
    def nothing(cls, n_joints: int) -> ErrorTable:
        """No torque and no error: what a model holds before it has been measured."""
        return cls(*(np.zeros(n_joints) for _ in range(3)))

    @property
    def largest_share(self) -> FloatArray:
        """Largest error over peak torque; 0 where there is neither, infinite where only an error is."""
        return _share(self.largest, self.peak_torque)

    @property
    def rms_share(self) -> FloatArray:
        """RMS error over peak torque."""
        return _share(self.rms, self.peak_torque)


def _share(error: FloatArray, peak: FloatArray) -> FloatArray:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(error == 0.0, 0.0, error / peak)


class ModelFacts(TypedDict):
    """What models of all levels are made with, see `SimplifiedModel`; all but the level."""

    arm: RobotArm
    drives: bool
    refitted: bool
    budget: FloatArray
    budget_stated: str
    promise: ErrorTable
    made_for: Mapping[str, str | int]
    operations_full: OperationCount
    provenance: Mapping[str, str]


@dataclass(frozen=True, eq=False, kw_only=True)
class SimplifiedModel(ABC):
    """An arm's torque model with something left out, and the error it states.

    Evaluated by programs that hold nothing superfluous. `ElementModel` and `HarmonicModel` say what is kept.

    Parameters
    ----------
    arm
        The arm it stands for.
    level
        "element" keeps D_ij and h_i by effect and c_i as a whole, the text's own method; "term" keeps single
        harmonic terms of the torques; "energy" keeps harmonic terms of the kinetic and potential energy, so
        that the model is itself a mechanical system, with symmetric D and dD/dt - 2C skew.
    drives
        Whether drive inertia is part of the model.
    refitted
        Whether kept coefficients were refitted to absorb what was dropped.
    budget, budget_stated
        Allowed torque error per joint, N m, shape (n,), and how the user put it.
    promise
        Error over the states it was made for: sampled, not a bound elsewhere.
    made_for
        Those states, in words and numbers.
    operations_full
        Operations of the exact model in the same form.
    provenance
        Versions, time, command.
    """

    arm: RobotArm
    level: Level
    drives: bool
    refitted: bool = False
    budget: FloatArray
    budget_stated: str
    promise: ErrorTable
    made_for: Mapping[str, str | int]
    operations_full: OperationCount
    provenance: Mapping[str, str] = field(default_factory=dict)

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
