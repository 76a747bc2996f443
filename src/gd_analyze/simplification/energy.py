"""Level "energy": the harmonic terms of the kinetic and potential energy, from which torques follow."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np
from pydantic import TypeAdapter

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.lagrangian import torques_of
from gd_analyze.harmonics.terms import Energies, EnergyTerm, Torques
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.harmonic import (
    FactorEntry,
    HarmonicLevel,
    factor_entries,
    monomial_of,
    numbered,
)
from gd_analyze.simplification.level import Checked, Coefficient, Numbers


class _EnergyEntry(Checked):
    i: int
    j: int
    factors: list[FactorEntry]
    coefficient: Coefficient


class EnergyLevel(HarmonicLevel):
    """Terms of D' in absolute velocities and of the potential: the model is a mechanical system itself."""

    name: ClassVar[str] = "energy"
    keeps: ClassVar[str] = "energy terms"
    is_mechanical: ClassVar[bool] = True
    entries: ClassVar[TypeAdapter[Any]] = TypeAdapter(list[_EnergyEntry])

    def terms(self, form: ExactForm) -> Energies:
        """Every term of the energies and its coefficient."""
        return form.energies

    def source(self, form: ExactForm, term: EnergyTerm) -> Torques:
        """Apply Lagrange's equations."""
        return torques_of(term, form.velocities)

    def numbers(self, form: ExactForm, terms: Sequence[EnergyTerm]) -> Numbers:
        """Number coefficients that are alike the same."""
        number = numbered(form.energies)
        magnitudes = [abs(form.energies[term]) for term in terms]
        return Numbers(np.array([number[term] for term in terms], dtype=int), np.array(magnitudes))

    def to_entry(self, term: EnergyTerm, weight: float) -> Checked:
        """Write element, factors and coefficient."""
        return _EnergyEntry(i=term.i, j=term.j, factors=factor_entries(term.monomial), coefficient=weight)

    def from_entry(self, form: ExactForm, entry: _EnergyEntry) -> tuple[EnergyTerm, float]:
        """Read it back, of an element that the arm has."""
        term = EnergyTerm(entry.i, entry.j, monomial_of(form.arm, entry.factors))
        if not (term.i == term.j == -1 or 0 <= term.i <= term.j < form.arm.n_joints):
            raise ModelError(f"{term} is no term of the arm's equations")
        return term, entry.coefficient


ENERGY: EnergyLevel = EnergyLevel()
