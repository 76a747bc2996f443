"""Level "term": the harmonic terms of the torques, one by one."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from typing import Annotated, ClassVar, Literal

import numpy as np
from pydantic import Field

from gd_analyze.errors import ModelError
from gd_analyze.harmonics.terms import Rate, Torques, TorqueTerm
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

    def torques(self, form: ExactForm, terms: Terms) -> Torques:
        """Give them as they are."""
        return terms

    def effects(self, exact: ExactDynamics, terms: Torques) -> FloatArray:
        """Torque of every term."""
        return group_effects(exact, [{term: weight} for term, weight in terms.items()])

    def costs(self, form: ExactForm, terms: Sequence[TorqueTerm]) -> Costs:
        """Operations as factoring may find them."""
        return shared_costs(terms)

    def numbers(self, form: ExactForm, terms: Sequence[TorqueTerm]) -> Numbers:
        """Number terms that one energy's coefficient makes alike; one made by several is on its own."""
        made_by: dict[TorqueTerm, dict[int, float]] = defaultdict(dict)
        energies = zip(numbered(form.energies), form.energies.items(), strict=True)
        for number, (energy, coefficient) in energies:
            for term in form.source(energy):
                made_by[term][number] = abs(coefficient)
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
        rates = [(rate.order, rate.joint) for rate in term.rates]
        return _TorqueEntry(row=term.row, rates=rates, factors=factor_entries(term.monomial), weight=weight)

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
