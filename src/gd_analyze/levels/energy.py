"""Level "energy": the harmonic terms of the kinetic and potential energy, from which torques follow."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import ClassVar

import numpy as np

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.terms import Energies, EnergyTerm, Torques, TorqueTerm
from gd_analyze.levels.exact import ExactDynamics, ExactForm
from gd_analyze.levels.harmonic import (
    FactorEntry,
    HarmonicLevel,
    factor_entries,
    group_effects,
    monomial_of,
    numbered,
    shared_costs,
)
from gd_analyze.levels.level import Costs, Entry, Numbers, Terms
from gd_analyze.vectors import FloatArray


class _EnergyEntry(Entry):
    i: int
    j: int
    factors: list[FactorEntry]
    coefficient: float


class EnergyLevel(HarmonicLevel):
    """Terms of D' in absolute rates and of the potential: the model is a mechanical system itself."""

    name: ClassVar[str] = "energy"
    summary: ClassVar[str] = "the model remains a mechanical system, with symmetric D and its own energy"
    keeps: ClassVar[str] = "energy terms"
    is_mechanical: ClassVar[bool] = True
    entry: ClassVar[type[Entry]] = _EnergyEntry

    def terms(self, form: ExactForm) -> Energies:
        """Every term of the energies and its coefficient."""
        return form.energies

    def torques(self, form: ExactForm, terms: Terms) -> Torques:
        """Apply Lagrange's equations."""
        return form.torques_of(terms)

    def effects(self, exact: ExactDynamics, terms: Energies) -> FloatArray:
        """Torque that follows from every term."""
        sources = ((coefficient, exact.form.source(term)) for term, coefficient in terms.items())
        return group_effects(
            exact, [{t: coefficient * w for t, w in of.items()} for coefficient, of in sources]
        )

    def costs(self, form: ExactForm, terms: Sequence[EnergyTerm]) -> Costs:
        """Operations of the torque terms, as factoring may find them, by the energy terms that make them."""
        users: dict[TorqueTerm, list[int]] = defaultdict(list)
        for k, energy in enumerate(terms):
            for term in form.source(energy):
                users[term].append(k)
        torque_terms = list(users)
        gathered: dict[frozenset[int], int] = defaultdict(int)
        for members, operations in shared_costs(torque_terms).items():
            gathered[frozenset(k for m in members for k in users[torque_terms[m]])] += operations
        return dict(gathered)

    def numbers(self, form: ExactForm, terms: Sequence[EnergyTerm]) -> Numbers:
        """Number coefficients that are alike the same."""
        number = dict(zip(form.energies, numbered(form.energies), strict=True))
        magnitudes = [abs(form.energies[term]) for term in terms]
        return Numbers(np.array([number[term] for term in terms], dtype=int), np.array(magnitudes))

    def to_entry(self, term: EnergyTerm, weight: float) -> Entry:
        """Write element, factors and coefficient."""
        return _EnergyEntry(i=term.i, j=term.j, factors=factor_entries(term.monomial), coefficient=weight)

    def from_entry(self, form: ExactForm, entry: _EnergyEntry) -> tuple[EnergyTerm, float]:
        """Read it back, of an element that the arm has."""
        term = EnergyTerm(entry.i, entry.j, monomial_of(form.arm, entry.factors))
        if not (term.i == term.j == -1 or 0 <= term.i <= term.j < form.arm.n_joints):
            raise ModelError(f"{term} is no term of the arm's equations")
        return term, entry.coefficient
