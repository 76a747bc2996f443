"""Level "element": each effect of each element of D and h, and each of c; the founding text's method."""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, ClassVar

import numpy as np
from pydantic import TypeAdapter

from gd_analyze.arrays import Array, FloatArray
from gd_analyze.dynamics import composite_moments as composite
from gd_analyze.dynamics.dominance import Element, elements
from gd_analyze.dynamics.generalized_dalembert import EFFECTS
from gd_analyze.dynamics.kinematics import solve_kinematics
from gd_analyze.errors import ModelError
from gd_analyze.formulas.formula import Formula
from gd_analyze.formulas.writing import parts_formulas
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Trace, is_constant
from gd_analyze.robots.arm import RobotArm
from gd_analyze.simplification.effort import Effort
from gd_analyze.simplification.exact import ExactDynamics, ExactForm
from gd_analyze.simplification.level import CandidateLevel, Checked, Costs, Terms


@dataclass(frozen=True)
class Part:
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


def parts_of(n_joints: int) -> tuple[Part, ...]:
    """All parts of an arm of n joints, in the order of its elements."""
    return tuple(
        Part(element, effect)
        for element in elements(n_joints)
        for effect in (EFFECTS[:1] if element.quantity == "gravity_loading" else EFFECTS)
    )


def kept_effects(n_joints: int, kept: Collection[Part]) -> dict[str, str]:
    """Effect kept of every element, by its label: one effect, "both" or "nothing"."""
    names = {(): "nothing", EFFECTS[:1]: EFFECTS[0], EFFECTS[1:]: EFFECTS[1], EFFECTS: "both"}
    chosen: dict[str, list[str]] = {element.label: [] for element in elements(n_joints)}
    for part in parts_of(n_joints):
        if part in kept:
            chosen[part.element.label].append(part.effect)
    return {label: names[tuple(effects)] for label, effects in chosen.items()}


def torque_by_part(quantities: Mapping[Any, Any], qdd: FloatArray, parts: tuple[Part, ...]) -> FloatArray:
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

    def expression(self, part: Part) -> object:
        """Expression (or constant) of one part."""
        return part.values(self.quantities)[0]

    def torque(self, parts: Collection[Part], drive_inertia: Array | None) -> Array:
        """Expressions of the torques (n,) from some parts alone; drive inertia (n,) is added to D."""
        inertia, h, c = self.assembled(parts, drive_inertia)
        return np.einsum("ij,j->i", inertia, self.qdd) + h + c

    def assembled(self, parts: Collection[Part], drive_inertia: Array | None) -> tuple[Array, Array, Array]:
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


def _blocks(trace: Trace, outputs: list[object], sine_price: int) -> dict[frozenset[int], int]:
    """Operations by the set of parts that need them, given each part's expression."""
    above: dict[int, int] = defaultdict(int)
    for p, expression in enumerate(outputs):
        if isinstance(expression, Expression):
            above[expression.order] |= 1 << p
    weights: dict[int, int] = defaultdict(int)
    for node in reversed(trace.expressions):
        parts = above.get(node.order, 0)
        if not parts:
            continue
        for argument in node.arguments:
            if isinstance(argument, Expression):
                above[argument.order] |= parts
        if node.operation not in ("input", "negative"):
            weights[parts] += sine_price if node.operation in ("sin", "cos") else 1
    count = range(len(outputs))
    return {frozenset(p for p in count if parts >> p & 1): weight for parts, weight in weights.items()}


def _assembly(traced: TracedParts, parts: Sequence[Part], drives: bool) -> dict[frozenset[int], int]:
    """Operations that assemble parts to torques, by the parts that need them; constants are summed before."""
    costs: dict[frozenset[int], int] = {}
    effects: dict[Element, list[int]] = {}
    for p, part in enumerate(parts):
        if is_constant(traced.expression(part), 0.0):
            costs[frozenset([p])] = 1  # dropping it costs nothing
        else:
            effects.setdefault(part.element, []).append(p)
    for element, live in effects.items():
        varying = any(isinstance(traced.expression(parts[p]), Expression) for p in live)
        if varying or element.j is None:
            costs |= {frozenset([p]): 1 for p in live}
        joints = 1 if element.i == element.j else 2
        if element.j is not None and not (drives and joints == 1):
            either = frozenset(live)
            costs[either] = costs.get(either, 0) + 2 * joints - (1 if varying else 0)
    return costs


class _PartEntry(Checked):
    part: str


class ElementLevel(CandidateLevel):
    """Parts are kept or dropped whole: each has the weight 1."""

    name: ClassVar[str] = "element"
    keeps: ClassVar[str] = "parts of elements"
    is_priced_exactly: ClassVar[bool] = True
    entries: ClassVar[TypeAdapter[Any]] = TypeAdapter(list[_PartEntry])

    def terms(self, form: ExactForm) -> Terms:
        """Parts in the order of their elements."""
        return dict.fromkeys(parts_of(form.arm.n_joints), 1.0)

    def effects(self, exact: ExactDynamics, terms: Terms) -> FloatArray:
        """Torques of the parts, from the decomposition."""
        return torque_by_part(exact.quantities, exact.states.qdd, tuple(terms))

    def costs(self, form: ExactForm, terms: Sequence[Part], sine_price: int) -> Costs:
        """Operations as traced, including those that assemble torques."""
        traced = trace_parts(form.arm)
        shared = _blocks(traced.trace, [traced.expression(part) for part in terms], sine_price)
        return dict(Counter(shared) + Counter(_assembly(traced, terms, form.drives)))

    def write(self, form: ExactForm, terms: Terms, effort: Effort) -> Program:
        """Extract the parts' operations from the trace."""
        traced = trace_parts(form.arm)
        return Program.of(traced.trace, list(traced.torque(terms, form.drive_inertia)))

    def formulas(self, form: ExactForm, terms: Terms) -> tuple[Formula, ...]:
        """Kept effects times accelerations, as in [FGL87] Eq. (3.4-24)."""
        n = form.arm.n_joints
        return parts_formulas(kept_effects(n, terms), n, form.drives)

    def to_entry(self, term: Part, weight: float) -> Checked:
        """Write the part's label."""
        return _PartEntry(part=term.label)

    def from_entry(self, form: ExactForm, entry: _PartEntry) -> tuple[Part, float]:
        """Find the part with this label."""
        parts = {part.label: part for part in parts_of(form.arm.n_joints)}
        if entry.part not in parts:
            first, *_, last = parts
            what = f"{entry.part!r} is not a part of a {form.arm.n_joints}-joint arm"
            raise ModelError(what, expected=f"labels such as {first!r} or {last!r}")
        return parts[entry.part], 1.0


ELEMENT: ElementLevel = ElementLevel()
