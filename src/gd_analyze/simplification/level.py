"""What a level of simplification is: how far the dynamics are split before something is left out.

Search, models, certificates and reports ask the level and know none by name.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.harmonics.terms import Torques
from gd_analyze.operations.program import Program
from gd_analyze.simplification.accuracy import SearchStep
from gd_analyze.simplification.effort import THOROUGH, Effort
from gd_analyze.simplification.exact import ExactDynamics, ExactForm
from gd_analyze.text import LARGEST_COEFFICIENT

# What a model is made of: a number by term, or by change of a program, of whatever kind the level's are.
Terms = Mapping[Any, float]
# Operations by the set of candidates, numbered in their order, that need them.
Costs = Mapping[frozenset[int], int]
# Free numbers of a refit: which one scales each term, and the magnitude of its coefficient, both (K,). Terms
# whose coefficients are alike but for sign and powers of two share one, so that arithmetic stays shared.
Numbers = tuple[NDArray[np.int64], FloatArray]
# What a term is multiplied by.
Coefficient = Annotated[float, Field(ge=-LARGEST_COEFFICIENT, le=LARGEST_COEFFICIENT)]


class Checked(BaseModel):
    """What a model file states: nothing unknown is in it, and no infinite number."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class Level(ABC):
    """A level of simplification; there is one value of each."""

    name: ClassVar[str]  # as users call it
    keeps: ClassVar[str]  # what its models are counted in, in the plural
    has_torque_terms: ClassVar[bool] = False  # sums of harmonic terms, whose coefficients can be refitted
    always_refits: ClassVar[bool] = False
    is_mechanical: ClassVar[bool] = False  # models are mechanical systems, with a symmetric D
    entries: ClassVar[TypeAdapter[Any]]  # schema of the terms in a model file

    def __repr__(self) -> str:
        return f"{type(self).__name__}()"

    def __str__(self) -> str:
        return self.name

    @abstractmethod
    def terms(self, form: ExactForm) -> Terms:
        """What makes the exact dynamics: all terms there are, or no change."""

    @abstractmethod
    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Write the torque that terms make as a program."""

    def write_steps(self, form: ExactForm, steps: Sequence[Terms], most: int) -> list[Program]:
        """Write programs of terms that become more, up to the first of more than `most` operations."""
        programs: list[Program] = []
        for terms in steps:
            program = self.write(form, terms, THOROUGH)
            if program.count.total > most:
                break
            programs.append(program)
        return programs

    @abstractmethod
    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Equations of the joints' torques, as a person would write them."""

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Meaning of the names in them: by default all are the founding text's."""
        return Legend((), (), ())

    def size(self, form: ExactForm, terms: Terms) -> tuple[int, int]:
        """How many terms or simplified steps a model has, and of how many."""
        return len(terms), len(self.terms(form))

    @abstractmethod
    def to_entry(self, term: Any, weight: float) -> Checked:
        """Write a term for a model file."""

    @abstractmethod
    def from_entry(self, form: ExactForm, entry: Any) -> tuple[Any, float]:
        """Read a term back; a ModelError if no arm of this make has it."""

    def to_entries(self, terms: Terms) -> list[Any]:
        """Write terms for a model file, in plain values."""
        return [self.to_entry(*term).model_dump(mode="json") for term in terms.items()]

    def from_entries(self, form: ExactForm, entries: Sequence[Any]) -> dict[Any, float]:
        """Read terms back; a ModelError where one is stated twice, or none of the arm's."""
        stated = [self.from_entry(form, entry) for entry in self.entries.validate_python(entries)]
        terms = dict(stated)
        if len(terms) < len(stated):
            raise ModelError("a term is stated twice")
        return terms

    def torques(self, form: ExactForm, terms: Terms) -> Torques:
        """Harmonic terms of the torques that terms make; ModelError where a model is no sum of terms."""
        what, found = f"a model of level {self.name} has no harmonic terms", f"level {self.name}"
        expected, next_step = "a model of level term or energy", "make one with `gd-analyze simplify`"
        raise ModelError(what, expected=expected, found=found, next_step=next_step)


class CandidateLevel(Level):
    """A level whose models keep some of the exact dynamics' terms."""

    # Whether `costs` are what a program takes, so that an integer program's optimum is final.
    is_priced_exactly: ClassVar[bool] = False

    @abstractmethod
    def effects(self, exact: ExactDynamics, terms: Terms) -> FloatArray:
        """Torque that each term makes at each state, N m, shape (K, n, N)."""

    @abstractmethod
    def costs(self, form: ExactForm, terms: Sequence[Any], sine_price: int) -> Costs:
        """Operations by the set of terms that need them; a sine or cosine counts as `sine_price`."""

    def numbers(self, form: ExactForm, terms: Sequence[Any]) -> Numbers:
        """Free numbers of a refit: by default every term has its own."""
        return np.arange(len(terms)), np.ones(len(terms))


class Found(NamedTuple):
    """Outcome of a search: fields as of `SimplifiedModel` and `Accuracy`."""

    terms: Terms
    program: Program
    refitted: bool
    steps: tuple[SearchStep, ...]
    solved: bool = False
    cut_short: bool = False
