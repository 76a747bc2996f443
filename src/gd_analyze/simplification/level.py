"""Levels of simplification: how far the dynamics are split before parts are dropped.

Search, models, certificates and reports use this interface and know no level by name.
"""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.harmonics.terms import EnergyTerm, Torques
from gd_analyze.operations.program import Program
from gd_analyze.simplification.effects import TermTorques
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.torque_program import Effort

# Content of a model: a number by term, or by change of a program, of the level's own type.
Terms = Mapping[Any, float]
# Operations by the set of candidates, by index, that need them.
Costs = Mapping[frozenset[int], int]
# Free numbers of a refit: index of the one that scales each term, (K,). Terms whose coefficients differ only
# in sign and powers of two share one, so that arithmetic stays shared.
IntegerArray = NDArray[np.int64]


class Level(ABC):
    """A level of simplification; each class has one value."""

    name: ClassVar[str]  # for users
    keeps: ClassVar[str]  # unit in which models are counted, in the plural
    has_torque_terms: ClassVar[bool] = False  # sums of harmonic terms, whose coefficients can be refitted
    is_program: ClassVar[bool] = False  # a model is its program, without terms
    has_symmetric_inertia: ClassVar[bool] = False
    # A search minimises the operations of D, h and c, not of the torque
    is_structured: ClassVar[bool] = False
    is_mechanical: ClassVar[bool] = False  # models are mechanical systems: h is that of their D

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"

    def __str__(self) -> str:
        return self.name

    @abstractmethod
    def terms(self, form: ExactForm) -> Terms:
        """Content of the exact dynamics: all terms, or no change."""

    @abstractmethod
    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Write the torque of terms as a program."""

    @abstractmethod
    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Equations of the joints' torques in readable form."""

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Meaning of the symbols; by default all are those of [FGL87]."""
        return Legend((), (), ())

    def size(self, form: ExactForm, terms: Terms) -> tuple[int, int]:
        """Number of terms or simplified steps of a model, and of all."""
        return len(terms), len(self.terms(form))

    @abstractmethod
    def entry(self, term: Any) -> Any:
        """A term as a model file names it, in plain values."""

    def from_entries(self, form: ExactForm, entries: Sequence[Any]) -> Terms:
        """Find terms among the arm's as a model file names them; a ModelError if one is not there, or twice."""
        by_entry = {json.dumps(self.entry(term)): term for term in self.terms(form)}
        coefficients, terms = self.terms(form), {}
        for place, entry in enumerate(entries):
            term = by_entry.get(json.dumps(entry))
            if term is None or term in terms:
                message = "a term is stated twice" if term else f"{form.arm.name} has no such term"
                raise ModelError(message, where=f"terms.{place}", found=json.dumps(entry)[:120])
            terms[term] = coefficients[term]
        return terms

    def torques(self, form: ExactForm, terms: Terms) -> Torques:
        """Harmonic terms of the torques; ModelError if a model is not a sum of terms."""
        raise ModelError(
            f"a model of level {self.name} has no harmonic terms",
            expected="a model of level term or energy",
            found=f"level {self.name}",
            next_step="make one with `gd-analyze simplify`",
        )


class CandidateLevel(Level):
    """A level whose models keep some of the exact dynamics' terms."""

    @abstractmethod
    def source(self, form: ExactForm, term: Any) -> Torques:
        """Torque terms of a term with coefficient 1."""

    @abstractmethod
    def term_torques(self, form: ExactForm, terms: Terms, numbers: IntegerArray | None = None) -> TermTorques:
        """Torques of terms, or of candidates with a number for every term, to be evaluated at any states."""

    @abstractmethod
    def inertia_term(self, term: Any) -> EnergyTerm | None:
        """Element of D' and monomial of a term of D'; None for any other term."""

    @abstractmethod
    def operations(self, form: ExactForm, terms: Terms, effort: Effort) -> int:
        """Operations that a search minimises, with programs written with this effort."""

    @abstractmethod
    def angles(self, form: ExactForm, terms: Terms) -> set[int]:
        """Revolute joints, from 0, whose sines and cosines terms need."""

    @abstractmethod
    def costs(self, form: ExactForm, terms: Sequence[Any], sine_price: int) -> Costs:
        """Estimate operations by the set of terms that need them; a sine or cosine counts as `sine_price`."""

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

    def numbers(self, form: ExactForm, terms: Sequence[Any]) -> IntegerArray:
        """Free numbers of a refit; by default every term has its own."""
        return np.arange(len(terms))
