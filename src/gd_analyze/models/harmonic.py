"""Models made of harmonic terms: of the torque itself, or of the energies it follows from."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Literal

from gd_analyze.harmonics.absolute_rates import AbsoluteRates
from gd_analyze.harmonics.terms import Energies, TorqueTerm
from gd_analyze.models.simplified import SimplifiedModel
from gd_analyze.models.torque_program import torque_programs
from gd_analyze.operations import Program

HarmonicLevel = Literal["term", "energy"]


@dataclass(frozen=True, eq=False, kw_only=True)
class HarmonicModel(SimplifiedModel):
    """A model of few harmonic terms.

    Parameters
    ----------
    energy
        Kept energy terms with their coefficients (level "energy", otherwise empty).
    torques
        Weights of all torque terms, in absolute rates.
    written_program
        The program of the torque; a quick way of writing it where there is none.
    """

    level: HarmonicLevel
    energy: Energies = field(default_factory=dict)
    torques: Mapping[TorqueTerm, float]
    written_program: Program | None = None

    @cached_property
    def programs(self) -> dict[str, Program]:
        """Factored programs of the kept terms."""
        quick = torque_programs(AbsoluteRates.of(self.arm), self.torques, thorough=False)
        return quick if self.written_program is None else quick | {"torque": self.written_program}
