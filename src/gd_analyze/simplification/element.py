"""Level "element": each effect of each element of D and h, and each of c; the founding text's method."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar

from pydantic import TypeAdapter

from gd_analyze.arrays import FloatArray
from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula
from gd_analyze.formulas.parts import parts_formulas
from gd_analyze.operations.program import Program
from gd_analyze.simplification.effort import Effort
from gd_analyze.simplification.exact import ExactDynamics
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.level import CandidateLevel, Checked, Costs, Terms
from gd_analyze.simplification.part_costs import part_costs
from gd_analyze.simplification.parts import Part, kept_effects, parts_of, torque_by_part, trace_parts


class _PartEntry(Checked):
    part: str


class ElementLevel(CandidateLevel):
    """Parts are kept or dropped as they are: each has the weight 1."""

    name: ClassVar[str] = "element"
    keeps: ClassVar[str] = "parts of elements"
    is_priced_exactly: ClassVar[bool] = True
    entries: ClassVar[TypeAdapter[Any]] = TypeAdapter(list[_PartEntry])

    def terms(self, form: ExactForm) -> Terms:
        """Parts in the order of their elements."""
        return dict.fromkeys(parts_of(form.arm.n_joints), 1.0)

    def effects(self, exact: ExactDynamics, terms: Terms) -> FloatArray:
        """Their torques, as the decomposition has them."""
        return torque_by_part(exact.quantities, exact.states.qdd, tuple(terms))

    def costs(self, form: ExactForm, terms: Sequence[Part]) -> Costs:
        """Operations as traced."""
        return part_costs(trace_parts(form.arm), tuple(terms), form.drives)

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Take what the parts need of the trace; there is only this way."""
        traced = trace_parts(form.arm)
        return Program.of(traced.trace, list(traced.torque(terms, form.drive_inertia)))

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Kept effects times accelerations, as [FGL87] Eq. (3.4-24) has them."""
        n = form.arm.n_joints
        return parts_formulas(kept_effects(n, terms), n, form.drives)

    def to_entry(self, term: Part, weight: float) -> Checked:
        """Write the part's label."""
        return _PartEntry(part=term.label)

    def from_entry(self, form: ExactForm, entry: _PartEntry) -> tuple[Part, float]:
        """Find the part of that label."""
        parts = {part.label: part for part in parts_of(form.arm.n_joints)}
        if entry.part not in parts:
            labels = list(parts)
            raise ModelError(
                f"{entry.part!r} is not a part of a {form.arm.n_joints}-joint arm",
                expected=f"labels such as {labels[0]!r} or {labels[-1]!r}",
            )
        return parts[entry.part], 1.0


ELEMENT = ElementLevel()
