"""Level "term": the harmonic terms of the torques, one by one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.lagrangian import torques_of
from gd_analyze.harmonics.terms import Rate, Torques, TorqueTerm
from gd_analyze.levels.exact import ExactForm
from gd_analyze.levels.harmonic import FactorEntry, HarmonicLevel, factor_entries, monomial_of, numbered
from gd_analyze.levels.level import Entry, Numbers


class _TorqueEntry(Entry):
    row: int
    rates: Annotated[list[tuple[Literal[1, 2], int]], Field(max_length=2)]
    factors: list[FactorEntry]
    weight: float


class TermLevel(HarmonicLevel):
    """Terms of tau' in absolute rates."""

    name: ClassVar[str] = "term"
    summary: ClassVar[str] = "torque terms one by one, the fewest operations"
    keeps: ClassVar[str] = "torque terms"
    entry: ClassVar[type[Entry]] = _TorqueEntry

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
            for term in torques_of(energy, form.rates):
                made_by[term][number] = abs(form.energies[energy])
        fresh = len(form.energies)
        parameter, magnitude = [], []
        place = {term: k for k, term in enumerate(form.torques)}
        for term in terms:
            makers = made_by[term]
            alone = fresh + place[term], abs(form.torques[term])
            number, size = next(iter(makers.items())) if len(makers) == 1 else alone
            parameter.append(number)
            magnitude.append(size)
        return Numbers(np.array(parameter, dtype=int), np.array(magnitude))

    def to_entry(self, term: TorqueTerm, weight: float) -> Entry:
        """Write row, rates, factors and weight."""
        factors = factor_entries(term.monomial)
        return _TorqueEntry(row=term.row, rates=list(term.rates), factors=factors, weight=weight)

    def from_entry(self, form: ExactForm, entry: _TorqueEntry) -> tuple[TorqueTerm, float]:
        """Read it back, in absolute rates that the arm has."""
        rates = tuple(Rate(*rate) for rate in entry.rates)
        term = TorqueTerm(entry.row, rates, monomial_of(form.arm, entry.factors))
        n, joints = form.arm.n_joints, [rate.joint for rate in rates]
        if not (
            0 <= term.row < n
            and [rate.order for rate in rates] in ([], [2], [1, 1])
            and joints == sorted(joints)
            and all(0 <= joint < n for joint in joints)
        ):
            raise ModelError(f"{term} is no term of the arm's equations")
        return term, entry.weight
