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
from gd_analyze.models.torque_model import TorqueModel
from gd_analyze.operations import OperationCount, Program
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

Level = Literal["element"]


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
class SimplifiedModel(TorqueModel):
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
    def operations_full(self) -> OperationCount:
        """Operations with every part kept."""
        every = [part.label for part in parts_of(self.arm.n_joints)]
        return _programs(self.arm, every, self.drives)["torque"].count

    @cached_property
    def programs(self) -> dict[str, Program]:
        """Programs of the kept parts."""
        return _programs(self.arm, self.kept, self.drives)


def _programs(arm: RobotArm, kept: tuple[str, ...] | list[str], drives: bool) -> dict[str, Program]:
    traced = trace_parts(arm)
    expressions = traced.keep(frozenset(kept), arm.drive_inertia if drives else None)
    return {name: Program.of(traced.trace, list(array.ravel())) for name, array in expressions.items()}
