"""Models made of harmonic terms: of the torque itself, or of the energies it follows from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from gd_analyze.harmonics.basis import Basis
from gd_analyze.harmonics.lagrangian import EnergyTerm, TorqueTerm, absolute_rates, sum_of_torques
from gd_analyze.models.simplified import ErrorTable
from gd_analyze.models.torque_model import TorqueModel
from gd_analyze.models.torque_program import torque_programs
from gd_analyze.operations import OperationCount, Program
from gd_analyze.robots import RobotArm
from gd_analyze.vectors import FloatArray

HarmonicLevel = Literal["term", "energy"]


@dataclass(frozen=True, eq=False)
class HarmonicModel(TorqueModel):
    """A torque model of few harmonic terms, and the error it states.

    Parameters
    ----------
    arm
        The arm it stands for.
    level
        "energy": kept terms of the kinetic and potential energy; the model is itself a mechanical system,
        with symmetric D and dD/dt - 2C skew. "term": torque terms kept one by one.
    energy
        Kept energy terms with their coefficients (level "energy", otherwise empty).
    torques
        Weights of all torque terms, in absolute rates.
    drives
        Whether drive inertia is in it.
    refitted
        Whether kept coefficients were refitted to absorb what was dropped.
    budget, budget_stated
        Allowed torque error per joint, N m, shape (n,), and how the user put it.
    promise
        Error over the states it was made for: sampled, not a bound.
    made_for
        Those states, in words and numbers.
    operations_full
        Operations of the exact model in the same form.
    provenance
        Versions, time, command.
    """

    arm: RobotArm
    level: HarmonicLevel
    energy: tuple[EnergyTerm, ...]
    torques: Mapping[TorqueTerm, float]
    drives: bool
    refitted: bool
    budget: FloatArray
    budget_stated: str
    promise: ErrorTable
    made_for: Mapping[str, str | int]
    operations_full: OperationCount
    provenance: Mapping[str, str] = field(default_factory=dict)

    @cached_property
    def programs(self) -> dict[str, Program]:
        """Factored programs of the kept terms."""
        return torque_programs(Basis.of(self.arm), self.torques)


def torques_of_energy(arm: RobotArm, energy: tuple[EnergyTerm, ...]) -> dict[TorqueTerm, float]:
    """Torque terms that follow from energy terms, each with its own coefficient."""
    rates = absolute_rates(Basis.of(arm))
    return sum_of_torques({term: term.coefficient for term in energy}, rates)
