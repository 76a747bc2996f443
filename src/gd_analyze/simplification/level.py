"""Levels of simplification: what a model keeps or drops, and how this is written, printed and stored."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.harmonics.terms import Torques
from gd_analyze.operations.program import Program
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.torque_program import Effort
from gd_analyze.text import LARGEST_COEFFICIENT

# Content of a model: a number by term or part, of the level's own type.
Terms = Mapping[Any, float]
# What a term is multiplied by.
Coefficient = Annotated[float, Field(ge=-LARGEST_COEFFICIENT, le=LARGEST_COEFFICIENT)]


class Checked(BaseModel):
    """Base of a model file's entries: unknown keys and infinite numbers are refused."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Level(ABC):
    """A level of simplification; each class has one value."""

    name: ClassVar[str]  # for users
    keeps: ClassVar[str]  # unit in which models are counted, in the plural
    entries: ClassVar[TypeAdapter[Any]]  # schema of the terms in a model file

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
    def to_entry(self, term: Any, weight: float) -> Checked:
        """Write a term for a model file."""

    @abstractmethod
    def from_entry(self, form: ExactForm, entry: Any) -> tuple[Any, float]:
        """Read a term back; a ModelError if the arm cannot have it."""

    def to_entries(self, terms: Terms) -> list[Any]:
        """Write terms for a model file, as plain values."""
        return [self.to_entry(*term).model_dump(mode="json") for term in terms.items()]

    def from_entries(self, form: ExactForm, entries: Sequence[Any]) -> dict[Any, float]:
        """Read terms back; a ModelError if one is stated twice, or is not of the arm."""
        stated = [self.from_entry(form, entry) for entry in self.entries.validate_python(entries)]
        terms = dict(stated)
        if len(terms) < len(stated):
            raise ModelError("a term is stated twice")
        return terms

    def torques(self, form: ExactForm, terms: Terms) -> Torques:
        """Harmonic terms of the torques; ModelError if a model is not a sum of terms."""
        raise ModelError(
            f"a model of level {self.name} has no harmonic terms",
            expected="a model of level term or energy",
            found=f"level {self.name}",
            next_step="make one with `gd-analyze simplify`",
        )
