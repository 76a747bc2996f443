"""Levels "term" and "energy": harmonic terms of the torques, or of the energies."""

from __future__ import annotations

from abc import abstractmethod
from collections import defaultdict
from collections.abc import Sequence
from typing import Any, ClassVar

import numpy as np

from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.formulas.writing import torque_formulas, torque_legend
from gd_analyze.harmonics.lagrangian import torques_of
from gd_analyze.harmonics.squares import Squares
from gd_analyze.harmonics.terms import Energies, EnergyTerm, Monomial, Torques, TorqueTerm, Velocity, summed
from gd_analyze.operations.program import Program
from gd_analyze.simplification.effects import IntegerArray, TermTorques
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.selection import Costs
from gd_analyze.simplification.torque_program import Effort, functions_of_terms, torque_program


class HarmonicLevel(Level):
    """A level whose models keep some of the dynamics' terms, each a sum of harmonic torque terms."""

    @abstractmethod
    def source(self, form: ExactForm, term: Any) -> Torques:
        """Torque terms of a term with coefficient 1."""

    @abstractmethod
    def inertia_term(self, term: Any) -> EnergyTerm | None:
        """Element of D' and monomial of a term of D'; None for any other term."""

    def torques(self, form: ExactForm, terms: Terms) -> Torques:
        """Sum the torque terms of all terms."""
        return summed((number, self.source(form, term)) for term, number in terms.items())

    def term_torques(self, form: ExactForm, terms: Terms, numbers: IntegerArray | None = None) -> TermTorques:
        """Torques of terms, or of candidates with a number for every term, to be evaluated at any states."""
        sources = [(weight, self.source(form, term)) for term, weight in terms.items()]
        return TermTorques(form.velocities, sources, numbers)

    def operations(self, form: ExactForm, terms: Terms, effort: Effort) -> int:
        """Operations that a search minimises: of all torques."""
        return self.write(form, terms, effort).count.total

    def angles(self, form: ExactForm, terms: Terms) -> set[int]:
        """Revolute joints, from 0, whose sines and cosines terms need."""
        factors = {factor for term in terms for factor in term.monomial if factor.kind != "power"}
        return {joint for factor in factors for joint in factor.joints}

    def costs(self, form: ExactForm, terms: Sequence[Any], sine_price: int) -> Costs:
        """Estimate the result of factoring: equal products are formed once, velocities multiply their sum.

        Sines and cosines are counted for as many angles as there are joints in them.
        """
        users: dict[TorqueTerm, set[int]] = defaultdict(set)
        products: dict[Monomial, set[int]] = defaultdict(set)
        brackets: dict[tuple[int, tuple[Velocity, ...]], set[int]] = defaultdict(set)
        angles: dict[int, set[int]] = defaultdict(set)
        for k, term in enumerate(terms):
            for torque_term in self.source(form, term):
                row, velocities, monomial = torque_term
                for needed in (users[torque_term], products[monomial], brackets[row, velocities]):
                    needed.add(k)
                for factor in monomial:
                    if factor.kind != "power":
                        for joint in np.flatnonzero(factor.multiples).tolist():
                            angles[joint].add(k)
        costs: dict[frozenset[int], int] = defaultdict(int)
        for members in users.values():
            costs[frozenset(members)] += 2
        for monomial, members in products.items():
            costs[frozenset(members)] += max(len(monomial) - 1, 0)
        for (_, velocities), members in brackets.items():
            costs[frozenset(members)] += len(velocities)
        for members in angles.values() if sine_price else ():
            costs[frozenset(members)] += 2 * sine_price
        return dict(costs)

    def indispensable(self, form: ExactForm, terms: Sequence[Any]) -> set[Any]:
        """One term of every D'_ii: its constant, or else the term with the largest coefficient."""
        coefficients, diagonal = self.terms(form), defaultdict[int, list[Any]](list)
        is_constant = {}
        for term in terms:
            element = self.inertia_term(term)
            if element is not None and element.i == element.j:
                diagonal[element.i].append(term)
                is_constant[term] = not element.monomial
        return {
            max(element_terms, key=lambda term: (is_constant[term], abs(coefficients[term])))
            for element_terms in diagonal.values()
        }

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Factor the torques of the terms."""
        return torque_program(form.velocities, self.torques(form, terms), effort)

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Torques in the velocities of the terms; those with the same velocities in brackets before them."""
        return torque_formulas(form.velocities, self._printed(form, terms))

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Absolute velocities, sines and cosines."""
        return torque_legend(form.velocities, self._printed(form, terms))

    def _printed(self, form: ExactForm, terms: Terms) -> Torques:
        return Squares.of(form.torques).sum(self.torques(form, terms))


class TermLevel(HarmonicLevel):
    """Explicit D, h and c: a term of D' stands in D'_ij and D'_ji alike, those of h' and c' in one row.

    Models are made for the use of D, h and c apart; h is not that of their D.
    """

    name: ClassVar[str] = "term"
    keeps: ClassVar[str] = "terms"

    def terms(self, form: ExactForm) -> Torques:
        """Every term of D', i <= j, of h' and of c', and its coefficient."""
        return form.upper_torques

    def source(self, form: ExactForm, term: TorqueTerm) -> Torques:
        """The torque of the term and, for one of D'_ij with i < j, of its equal in D'_ji."""
        if term.quantity != "inertia" or term.velocities[0].joint == term.row:
            return {term: 1.0}
        partner = TorqueTerm(term.velocities[0].joint, (Velocity(2, term.row),), term.monomial)
        return {term: 1.0, partner: 1.0}

    def costs(self, form: ExactForm, terms: Sequence[TorqueTerm], sine_price: int) -> Costs:
        """Estimate D, h and c as functions of their own: what they share is counted in each.

        A product of sines and cosines is formed once, velocities multiply the sum of their products, and the
        first term of a sum is not added. Sines and cosines are counted once, for as many angles as there are
        joints in them.
        """
        users: dict[Any, set[int]] = defaultdict(set)
        prices: dict[Any, int] = {}

        def need(step: Any, price: int, number: int) -> None:
            users[step].add(number)
            prices[step] = price

        for number, term in enumerate(terms):
            quantity, moving, monomial = term.quantity, term.velocities, term.monomial
            is_inertia = quantity == "inertia"
            need(("term", number), 1 + bool(monomial), number)
            need(("product", quantity, monomial), max(len(monomial) - 1, 0), number)
            need(("sum", quantity, term.row, moving if is_inertia else ()), -1, number)
            if quantity == "coriolis_centrifugal":
                need(("velocities", term.row, moving), len(moving), number)
            for factor in monomial:
                for joint in factor.joints if factor.kind != "power" else ():
                    need(("angle", joint), 2 * sine_price, number)
        costs: dict[frozenset[int], int] = defaultdict(int)
        for step, numbers in users.items():
            costs[frozenset(numbers)] += prices[step]
        return {numbers: price for numbers, price in costs.items() if price}

    def operations(self, form: ExactForm, terms: Torques, effort: Effort) -> int:
        """Operations that a search minimises: of D, h and c apart; what they share is counted in each."""
        torques = self.torques(form, terms)
        return functions_of_terms(form.velocities, torques, effort).operations.total

    def inertia_term(self, term: TorqueTerm) -> EnergyTerm | None:
        """Element of D' and monomial of a term of D'."""
        if term.quantity != "inertia":
            return None
        return EnergyTerm(term.row, term.velocities[0].joint, term.monomial)

    def entry(self, term: TorqueTerm) -> dict[str, Any]:
        """Row, velocities and factors."""
        return {
            "row": term.row,
            "velocities": [list(velocity) for velocity in term.velocities],
            "factors": _factor_entries(term.monomial),
        }


class EnergyLevel(HarmonicLevel):
    """Terms of D' in absolute velocities and of the potential: the model is itself a mechanical system.

    Models are made for the torque; h is that of their D.
    """

    name: ClassVar[str] = "energy"
    keeps: ClassVar[str] = "energy terms"

    def terms(self, form: ExactForm) -> Energies:
        """Every term of the energies and its coefficient."""
        return form.energies

    def source(self, form: ExactForm, term: EnergyTerm) -> Torques:
        """Apply Lagrange's equations."""
        return torques_of(term, form.velocities)

    def inertia_term(self, term: EnergyTerm) -> EnergyTerm | None:
        """The term itself, if it is one of D'."""
        return None if term.is_potential else term

    def entry(self, term: EnergyTerm) -> dict[str, Any]:
        """Element and factors."""
        return {"i": term.i, "j": term.j, "factors": _factor_entries(term.monomial)}


TERM: TermLevel = TermLevel()
ENERGY: EnergyLevel = EnergyLevel()
HARMONIC_LEVELS: dict[str, HarmonicLevel] = {level.name: level for level in (TERM, ENERGY)}


def _factor_entries(monomial: Monomial) -> list[Any]:
    """Kind, multiple of every joint in the argument, and exponent of every factor."""
    return [[f.kind, list(f.multiples), monomial.count(f)] for f in dict.fromkeys(monomial)]
