"""Level "term": the harmonic terms of the torques, one by one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from itertools import combinations_with_replacement
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import Field, TypeAdapter

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.lagrangian import torques_of
from gd_analyze.harmonics.terms import Torques, TorqueTerm, Velocity
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.harmonic import (
    FactorEntry,
    HarmonicLevel,
    factor_entries,
    monomial_of,
    numbered,
)
from gd_analyze.simplification.level import Checked, Coefficient, Numbers


class _TorqueEntry(Checked):
    row: int
    velocities: Annotated[list[tuple[Literal[1, 2], int]], Field(max_length=2)]
    factors: list[FactorEntry]
    weight: Coefficient


class TermLevel(HarmonicLevel):
    """Terms of tau' in absolute velocities."""

    name: ClassVar[str] = "term"
    keeps: ClassVar[str] = "torque terms"
    entries: ClassVar[TypeAdapter[Any]] = TypeAdapter(list[_TorqueEntry])

    def terms(self, form: ExactForm) -> Torques:
        """Every torque term and its weight."""
        return form.torques

    def source(self, form: ExactForm, term: TorqueTerm) -> Torques:
        """Nothing but the term."""
        return {term: 1.0}

    def numbers(self, form: ExactForm, terms: Sequence[TorqueTerm]) -> Numbers:
        """Number terms that one energy's coefficient makes alike; one made by several is on its own."""
        made_by: dict[TorqueTerm, dict[int, float]] = defaultdict(dict)
        for energy, number in numbered(form.energies).items():
            for term in torques_of(energy, form.velocities):
                made_by[term][number] = abs(form.energies[energy])
        alone = enumerate(form.torques.items(), start=len(form.energies))
        numbers = {term: (number, abs(weight)) for number, (term, weight) in alone}
        numbers |= {term: next(iter(by.items())) for term, by in made_by.items() if len(by) == 1}
        parameter, magnitude = np.array([numbers[term] for term in terms]).reshape(-1, 2).T
        return Numbers(parameter.astype(int), magnitude)

    def to_entry(self, term: TorqueTerm, weight: float) -> Checked:
        """Write row, velocities, factors and weight."""
        factors = factor_entries(term.monomial)
        return _TorqueEntry(row=term.row, velocities=list(term.velocities), factors=factors, weight=weight)

    def from_entry(self, form: ExactForm, entry: _TorqueEntry) -> tuple[TorqueTerm, float]:
        """Read it back, in absolute velocities that the arm has."""
        velocities = tuple(Velocity(*velocity) for velocity in entry.velocities)
        term = TorqueTerm(entry.row, velocities, monomial_of(form.arm, entry.factors))
        joints = range(form.arm.n_joints)
        pairs = combinations_with_replacement([Velocity(1, joint) for joint in joints], 2)
        if term.row not in joints or velocities not in {
            (),
            *((Velocity(2, joint),) for joint in joints),
            *pairs,
        }:
            raise ModelError(f"{term} is no term of the arm's equations")
        return term, entry.weight


TERM: TermLevel = TermLevel()
