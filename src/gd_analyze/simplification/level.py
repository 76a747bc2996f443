"""Levels of simplification: what a model keeps or drops, and how this is written, printed and stored."""

from __future__ import annotations

import json
from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Any, ClassVar

from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.harmonics.terms import Torques
from gd_analyze.operations.program import Program
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.torque_program import Effort

# Content of a model: the exact coefficient by term or part, of the level's own type.
Terms = Mapping[Any, float]


class Level(ABC):
    """A level of simplification; each class has one value."""

    name: ClassVar[str]  # for users
    keeps: ClassVar[str]  # unit in which models are counted, in the plural

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"

    def __str__(self) -> str:
        return self.name

    def __reduce__(self) -> str:
        """Name of the one value, by which it is pickled."""
        return self.name.upper()

    @abstractmethod
    def terms(self, form: ExactForm) -> Terms:
        """All terms of the exact dynamics."""

    @abstractmethod
    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Write the torque of terms as a program."""

    @abstractmethod
    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Equations of the joints' torques in readable form."""

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Meaning of the symbols; by default all are those of [FGL87]."""
        return Legend((), (), ())

    @abstractmethod
    def entry(self, term: Any) -> Any:
        """A term as a file names it, in plain values."""

    def from_entries(self, form: ExactForm, entries: Sequence[Any]) -> dict[Any, float]:
        """Find terms among the arm's as a file names them; a ModelError if one is not there, or is twice."""
        terms = dict[Any, float]()
        coefficients = self.terms(form) if entries else {}
        by_entry = {json.dumps(self.entry(term)): term for term in coefficients}
        for place, entry in enumerate(entries):
            term = by_entry.get(json.dumps(entry))
            if term is None or term in terms:
                message = f"{form.arm.name} has no such term" if term is None else "a term is stated twice"
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
