"""Level "recursive": the exact recursion of Newton and Euler, some of whose steps are changed."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from pydantic import TypeAdapter

from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula, Legend
from gd_analyze.operations.program import Program
from gd_analyze.operations.sharing import rewritten
from gd_analyze.operations.trace import Expression
from gd_analyze.simplification.effort import COUNTING, POINT, Effort
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.level import Checked, Coefficient, Level, Terms
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Change
from gd_analyze.simplification.recursion_reading import Reading, read, scales

# Rearrangements of a model that is only looked at: tenths of a second.
_FEW_TRIES = 60


class _ChangeEntry(Checked):
    step: int
    source: int
    number: Coefficient


class RecursiveLevel(Level):
    """Changes of the recursion, see `recursion.Change`; without any it is exact."""

    name: ClassVar[str] = "recursive"
    keeps: ClassVar[str] = "simplified steps"
    always_refits: ClassVar[bool] = True
    entries: ClassVar[TypeAdapter[Any]] = TypeAdapter(list[_ChangeEntry])

    def terms(self, form: ExactForm) -> Terms:
        """No change."""
        return {}

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Carry the changes out; in a model that is given, the steps are rewritten in fewer operations."""
        program = form.recursion.changed(terms)
        if effort.shared <= COUNTING.shared:
            return program
        return rewritten(program, _FEW_TRIES) if effort == POINT else rewritten(program)

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Equations of the quantities that the recursion passes on, in the order of their making."""
        return self.reading(form, terms).formulas

    def legend(self, form: ExactForm, terms: Terms) -> Legend:
        """Sines and cosines."""
        return self.reading(form, terms).legend

    def reading(self, form: ExactForm, terms: Terms) -> Reading:
        """Its equations link by link."""
        return read(form.recursion, terms, scales(form, terms))

    def size(self, form: ExactForm, terms: Terms) -> tuple[int, int]:
        """Steps simplified, of all."""
        steps = [step for step in form.recursion.program.steps if step.operation != "input"]
        return len({change.step for change in terms}), len(steps)

    def to_entry(self, term: Change, weight: float) -> Checked:
        """Write the places of both steps and the number."""
        return _ChangeEntry(step=term.step, source=term.source, number=weight)

    def from_entry(self, form: ExactForm, entry: _ChangeEntry) -> tuple[Change, float]:
        """Read it back, of steps that the arm's recursion has."""
        steps = form.recursion.steps
        for place, least in ((entry.step, 0), (entry.source, min(NUMBER, CONSTANT))):
            if not least <= place < len(steps):
                expected = f"steps from 0 to {len(steps) - 1}"
                raise ModelError(f"the recursion has no step {place}", expected=expected)
        step = steps[entry.step]
        numbers = [x for x in step.arguments if step.operation != "input" and not isinstance(x, Expression)]
        if entry.source == CONSTANT and not numbers:
            raise ModelError(f"step {entry.step} of the recursion has no constant to be replaced")
        return Change(entry.step, entry.source), entry.number

    def from_entries(self, form: ExactForm, entries: Sequence[Any]) -> dict[Change, float]:
        """Read changes back that can be carried out together; otherwise as every level does."""
        changes = super().from_entries(form, entries)
        try:
            form.recursion.changed(changes)
        except ValueError as error:
            raise ModelError(f"the changes cannot be carried out: {error}") from None
        return changes


RECURSIVE: RecursiveLevel = RecursiveLevel()
