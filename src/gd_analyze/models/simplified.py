"""What a user takes away: a simplified model that can be evaluated, and what it promises."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

import numpy as np

from gd_analyze.dominance import ROUND_OFF_SHARE, peak_magnitude
from gd_analyze.errors import ModelError
from gd_analyze.models.element_level import parts_of, trace_parts
from gd_analyze.operations import OperationCount, Program
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray, set_points_last

Level = Literal["element"]
Quantity = Literal["inertia", "coriolis_centrifugal", "gravity_loading", "torque"]


@dataclass(frozen=True, eq=False)
class ErrorTable:
    """Torque error of a model along one trajectory, per joint; N m (N for a sliding joint), shape (n,).

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


@dataclass(frozen=True, eq=False)
class SimplifiedModel:
    """An arm's torque model with parts left out, and the error it states.

    Parameters
    ----------
    arm
        The arm it stands for.
    level
        Structure of the simplification; "element" keeps or drops D_ij, h_i by effect and c_i.
    kept
        Labels of what is kept, see `gd_analyze.models.parts_of`.
    drives
        Whether drive inertia is part of the model (on the diagonal of D).
    budget
        Allowed torque error per joint, N m, shape (n,), and `budget_stated` as the user put it.
    promise
        Error along the trajectory it was made for: sampled at its set points, not a bound elsewhere.
    made_for
        Name, fingerprint and number of set points of that trajectory, as strings and numbers.
    provenance
        Versions, time, command.
    """

    arm: RobotArm
    level: Level
    kept: tuple[str, ...]
    drives: bool
    budget: FloatArray
    budget_stated: str
    promise: ErrorTable
    made_for: Mapping[str, str | int]
    provenance: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        known = [part.label for part in parts_of(self.arm.n_joints)]
        unknown = sorted(set(self.kept) - set(known))
        if unknown:
            raise ModelError(
                f"{unknown[0]!r} is not a part of a {self.arm.n_joints}-joint arm",
                expected=f"labels such as {known[0]!r} or {known[-1]!r}",
            )

    @property
    def dropped(self) -> tuple[str, ...]:
        """Labels of what is left out."""
        kept = set(self.kept)
        return tuple(part.label for part in parts_of(self.arm.n_joints) if part.label not in kept)

    @cached_property
    def operations(self) -> OperationCount:
        """Operations of one evaluation of all torques."""
        return self._programs["torque"].count

    @cached_property
    def operations_full(self) -> OperationCount:
        """Operations with every part kept."""
        every = [part.label for part in parts_of(self.arm.n_joints)]
        return _programs(self.arm, every, self.drives)["torque"].count

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

    @cached_property
    def _programs(self) -> dict[str, Program]:
        return _programs(self.arm, self.kept, self.drives)

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
        values = self._programs[quantity].run(inputs)
        return np.ascontiguousarray(values.T).reshape(*leading, len(values))


def _programs(arm: RobotArm, kept: tuple[str, ...] | list[str], drives: bool) -> dict[str, Program]:
    traced = trace_parts(arm)
    expressions = traced.keep(frozenset(kept), arm.drive_inertia if drives else None)
    return {name: Program.of(traced.trace, list(array.ravel())) for name, array in expressions.items()}
