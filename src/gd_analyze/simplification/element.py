"""Level "element", [FGL87]'s method: each effect of each element of D and h, and each of c, by verdicts."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics.dominance import DOMINANCE_THRESHOLD, Element, elements, text_verdicts
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.dynamics.verdicts import least_changes, representing
from gd_analyze.errors import UsageError
from gd_analyze.formulas.formula import Formula
from gd_analyze.formulas.writing import parts_formulas
from gd_analyze.operations.program import OperationCount, Program
from gd_analyze.operations.trace import Trace
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.budget import Budget
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.exact_dynamics import ExactDynamics
from gd_analyze.simplification.level import Level, Terms
from gd_analyze.simplification.model import SimplifiedModel, model_of_terms
from gd_analyze.simplification.torque_program import Effort
from gd_analyze.text import in_python

VERDICT_SOURCES = ("own", "text")


@dataclass(frozen=True)
class ElementPart:
    """One effect of one element; gravity loading has no split and counts as translation."""

    element: Element
    effect: str

    @property
    def label(self) -> str:
        """D12 translation, h3 rotation, c2."""
        if self.element.quantity == "gravity_loading":
            return self.element.label
        return f"{self.element.label} {self.effect}"

    def values(self, quantities: Mapping[Any, Any]) -> Array:
        """Value of the part at every state, shape (N,), from `quantities` as for `Element.parts`."""
        return self.element.parts(quantities)[EFFECTS.index(self.effect)]


def parts_of(n_joints: int) -> tuple[ElementPart, ...]:
    """All parts of an arm of n joints, in the order of its elements."""
    return tuple(
        ElementPart(element, effect)
        for element in elements(n_joints)
        for effect in (EFFECTS[:1] if element.quantity == "gravity_loading" else EFFECTS)
    )


def kept_effects(n_joints: int, kept_parts: Collection[ElementPart]) -> dict[str, str]:
    """Effect kept of every element, by its label: one effect, "both" or "nothing"."""
    names = {(): "nothing", EFFECTS[:1]: EFFECTS[0], EFFECTS[1:]: EFFECTS[1], EFFECTS: "both"}
    chosen: dict[str, list[str]] = {element.label: [] for element in elements(n_joints)}
    for part in parts_of(n_joints):
        if part in kept_parts:
            chosen[part.element.label].append(part.effect)
    return {label: names[tuple(effects)] for label, effects in chosen.items()}


def torque_by_part(
    quantities: Mapping[Any, Any], qdd: FloatArray, parts: tuple[ElementPart, ...]
) -> FloatArray:
    """Torque of every part, N m, (P, n, N), from a decomposition and accelerations (N, n) at its states."""
    count, n = qdd.shape
    out = np.zeros((len(parts), n, count))
    for p, part in enumerate(parts):
        values = part.values(quantities)
        for joint, factor in part.element.torque_factors(quantities).items():
            out[p, joint] = values * factor
    return out


@dataclass(frozen=True)
class TracedParts:
    """The arithmetic of every part."""

    trace: Trace
    qdd: Array  # inputs, (n,)
    quantities: Mapping[str, Array]  # D, h and c by effect at one state, as a decomposition has them

    def expression(self, part: ElementPart) -> object:
        """Expression (or constant) of one part."""
        return part.values(self.quantities)[0]

    def torque(self, parts: Collection[ElementPart], drive_inertia: Array | None) -> Array:
        """Expressions of the torques (n,) from some parts alone; drive inertia (n,) is added to D."""
        inertia, h, c = self.assembled(parts, drive_inertia)
        return np.einsum("ij,j->i", inertia, self.qdd) + h + c

    def assembled(
        self, parts: Collection[ElementPart], drive_inertia: Array | None
    ) -> tuple[Array, Array, Array]:
        """Expressions of D (n, n), h and c (n,) from some parts alone."""
        n = len(self.qdd)
        inertia, h, c = (np.full(shape, 0.0, dtype=object) for shape in ((n, n), n, n))
        for part in (part for part in parts_of(n) if part in parts):
            i, j = part.element.i, part.element.j
            if part.element.quantity == "gravity_loading":
                c[i] = self.expression(part)
            elif j is None:
                h[i] = h[i] + self.expression(part)
            else:
                inertia[i, j] = inertia[i, j] + self.expression(part)
                inertia[j, i] = inertia[i, j]
        if drive_inertia is not None:
            for i in range(n):
                inertia[i, i] = inertia[i, i] + float(drive_inertia[i])
        return inertia, h, c


@lru_cache(maxsize=8)
def trace_parts(arm: RobotArm) -> TracedParts:
    """Run the formulation once on numbers that record their arithmetic."""
    trace = Trace()
    q, qd, qdd = (trace.inputs(name, arm.n_joints) for name in ("q", "qd", "qdd"))
    kinematics = solve_kinematics(arm, q)
    moments = composite.composite_moments(arm, kinematics)
    quantities = {
        "inertia": composite.inertia(moments),
        "coriolis_centrifugal": composite.coriolis_centrifugal(moments, composite.brackets(moments), qd)[0],
        "gravity_loading": composite.gravity_loading(arm, moments),
    }
    states_first = {name: np.moveaxis(values, -1, 0) for name, values in quantities.items()}
    return TracedParts(trace, qdd[:, 0], states_first)


class ElementLevel(Level):
    """Parts are kept whole, by verdicts and without a search: each has the weight 1."""

    name: ClassVar[str] = "element"
    keeps: ClassVar[str] = "parts of elements"

    def terms(self, form: ExactForm) -> Terms:
        """Parts in the order of their elements."""
        return dict.fromkeys(parts_of(form.arm.n_joints), 1.0)

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Extract the parts' operations from the trace."""
        traced = trace_parts(form.arm)
        return Program.of(traced.trace, list(traced.torque(terms, form.drive_inertia)))

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Kept effects times accelerations, as in [FGL87] Eq. (3.4-24)."""
        n = form.arm.n_joints
        return parts_formulas(kept_effects(n, terms), n, form.drives)

    def entry(self, term: ElementPart) -> str:
        """The part's label."""
        return term.label


ELEMENT: ElementLevel = ElementLevel()


def model_by_verdicts(
    exact: ExactDynamics,
    verdicts: str = "own",
    threshold: float = DOMINANCE_THRESHOLD,
    budget: Budget | str | float | None = None,
) -> SimplifiedModel:
    """Keep the dominant parts by verdicts over the states ("own"), or by [FGL87]'s ("text").

    The model may miss the budget beside which its error is stated. UsageError if the text has no verdicts on
    the arm.
    """
    parts = dict.fromkeys(_own(exact, threshold) if verdicts == "own" else _of_text(exact.form), 1.0)
    exact = exact.under(budget)
    return model_of_terms(exact, ELEMENT, parts, exact.allowed(budget), str(Budget.of(budget)))


def require_search(level: Level, value: str) -> None:
    """Raise a UsageError for options of a search at level element."""
    if level is ELEMENT:
        message, expected = "level element searches no model: verdicts say what it keeps", "none"
        next_step = "take another level; `gd-analyze certify` proves a bound of any model"
        raise UsageError(message, where="level", expected=expected, found=value, next_step=next_step)


def require_verdicts(verdicts: str, level: Level) -> None:
    """Raise a UsageError for verdicts of an unknown source, or of any but the usual at another level."""
    if verdicts not in VERDICT_SOURCES or (verdicts != VERDICT_SOURCES[0] and level is not ELEMENT):
        message, expected = "verdicts are those of level element", " or ".join(VERDICT_SOURCES)
        found = f"{in_python(verdicts)} at level {level}"
        raise UsageError(message, where="verdicts", expected=f"{expected}, with level element", found=found)


def _own(exact: ExactDynamics, threshold: float) -> Iterator[ElementPart]:
    """Parts that represent their element."""
    all_elements = elements(exact.arm.n_joints)
    quantities = {
        name: np.asarray(exact.quantities[name]) for name in {element.quantity for element in all_elements}
    }
    for element in all_elements:
        parts = element.parts(quantities)
        part_peaks, peak = np.abs(parts).max(axis=1), np.abs(parts.sum(axis=0)).max()
        least = least_changes(part_peaks, peak, np.abs(quantities[element.quantity]).max(), threshold)
        represents = representing(part_peaks, least)
        yield from (ElementPart(element, EFFECTS[k]) for k in np.flatnonzero(represents))


def _of_text(form: ExactForm) -> Iterator[ElementPart]:
    """Parts that [FGL87] calls dominant, and gravity loading."""
    text = text_verdicts(form.arm.name)
    if text is None:
        raise UsageError(
            f"[FGL87] has no verdicts on {form.arm.name}",
            where="verdicts",
            expected="puma560, the arm of its Figs 3.10 and 3.11",
            next_step="use the verdicts over the states: own",
        )
    for part in parts_of(form.arm.n_joints):
        if text.verdicts.get(part.element.label, "both") in (part.effect, "both"):
            yield part


def operations_by_quantity(form: ExactForm, parts: Iterable[ElementPart]) -> dict[str, OperationCount]:
    """Operations of D, h and c by element from some parts: each alone, and together."""
    traced = trace_parts(form.arm)
    inertia, h, c = traced.assembled(set(parts), form.drive_inertia)
    outputs = {"D": inertia[np.triu_indices(len(h))].tolist(), "h": h.tolist(), "c": c.tolist()}
    outputs["D, h and c"] = [value for values in outputs.values() for value in values]
    return {name: Program.of(traced.trace, values).count for name, values in outputs.items()}
