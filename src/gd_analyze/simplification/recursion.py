"""An arm's exact recursion, step by step, and its changes by a simplification.

The steps are those of the folded Newton-Euler recursion in base parameters, without rearrangement, so that
each has a familiar meaning: a component of an angular velocity, a product with a moment of inertia.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from gd_analyze.arrays import Array
from gd_analyze.formulas.formula import PRIME, Symbol
from gd_analyze.operations.program import Program
from gd_analyze.operations.trace import Expression, Trace
from gd_analyze.text import joined

# Quantities in the order of one link's steps.
OUTWARD = ("p", "pd", "omega'", "omega", "omegad'", "omegad", "r", "a''", "a'", "a", "A")
INWARD = ("f", "n", "tau", "f'", "f''", "n'", "n''")
_AXES = "xyz"


class Quantity(NamedTuple):
    """A component of a link's quantity."""

    kind: str  # as in docs/notation.md; primed in the frame before its joint turns, twice in the previous one
    link: int  # from 0
    component: str = ""  # "x", "xy", or "" for a single component

    @property
    def symbol(self) -> Symbol:
        """Its symbol."""
        kind = self.kind.rstrip(PRIME)
        dots = {"p": 1, "pd": 2, "omegad": 1}.get(kind, 0)
        index = joined((self.link,)) + self.component
        return Symbol(kind.removesuffix("d"), index, dots, primes=len(self.kind) - len(kind))


def components(kind: str, link: int, values: Array) -> list[tuple[Quantity, Any]]:
    """Name the components of a quantity, shape (..., 1)."""
    if kind == "p":
        return [(Quantity("p", link), values[0, 0]), (Quantity("pd", link), values[1, 0])]
    return [
        (Quantity(kind, link, "".join(_AXES[k] for k in index[:-1])), values[index])
        for index in np.ndindex(values.shape)
    ]


# In place of a replacing step: a number alone, or the changed step's own constant.
NUMBER, CONSTANT = -1, -2


class Change(NamedTuple):
    """`step` is replaced by a sum that contains `source` (or `NUMBER`, or `CONSTANT`) times a number."""

    step: int
    source: int


Changes = Mapping[Change, float]


class Scale(NamedTuple):
    """Statement of a program's factor as a change: `sign` times that factor."""

    instead_of: Change  # present statement, if any
    change: Change
    sign: float


@dataclass(frozen=True, eq=False)
class Changed:
    """A recursion with its changes carried out."""

    program: Program
    images: Mapping[int, Any]  # image of every step still needed, by index: an expression or a number
    scales: Mapping[int, tuple[Scale, ...]]  # by the order of an expression with a numeric factor

    @cached_property
    def origins(self) -> tuple[tuple[int, ...], ...]:
        """Indices of the recursion's steps that have the value of each step of the program."""
        found: dict[int, list[int]] = defaultdict(list)
        for place in sorted(self.images):
            image = self.images[place]
            if isinstance(image, Expression):
                found[image.order].append(place)
        return tuple(tuple(found[step.order]) for step in self.program.steps)


@dataclass(frozen=True, eq=False)
class Recursion:
    """A recursion as a list of steps."""

    steps: tuple[Expression, ...]  # each after its arguments
    outputs: tuple[Any, ...]  # torques of the joints: expressions or numbers
    quantities: tuple[tuple[Quantity, Any], ...] = ()  # named quantities, in the order of evaluation

    @property
    def program(self) -> Program:
        """The unchanged recursion."""
        return self.changed({})

    @cached_property
    def arguments(self) -> tuple[tuple[Any, ...], ...]:
        """Arguments of every step: indices of earlier steps as int, constants as float, an input's name."""
        place = {step.order: k for k, step in enumerate(self.steps)}
        return tuple(
            tuple(place[x.order] if isinstance(x, Expression) else x for x in step.arguments)
            for step in self.steps
        )

    def changed(self, changes: Changes) -> Program:
        """Carry changes out, see `carried_out`."""
        return self.carried_out(changes).program

    def carried_out(self, changes: Changes) -> Changed:
        """Carry changes out; ValueError if steps replace each other in a cycle."""
        making = _Making(self, changes, Trace())
        outputs = making.outputs()
        scales = {order: tuple(found) for order, found in making.scales.items()}
        return Changed(Program.of(making.trace, outputs), making.images, scales)

    def acting(self, changes: Changes) -> dict[Change, float]:
        """Changes, with numbers that do not affect the torques set to 0."""
        trace, numbers = Trace(), dict[Change, Any]()
        for k, (change, number) in enumerate(changes.items()):
            numbers[change] = trace.record("input", f"number{k}") if number else 0.0
        needed = set(Program.of(trace, _Making(self, numbers, trace).outputs()).steps)
        left = {change: x if numbers[change] in needed else 0.0 for change, x in changes.items()}
        # A zero may fold away what others need.
        return left if left == changes else self.acting(left)


class _Making:
    """Execution of changes; their numbers may be expressions."""

    def __init__(self, recursion: Recursion, changes: Mapping[Change, Any], trace: Trace) -> None:
        self.recursion, self.trace = recursion, trace
        self.images: dict[int, Any] = {}
        self.scales: dict[int, list[Scale]] = defaultdict(list)
        self._stands_in: dict[int, list[tuple[int, Any]]] = defaultdict(list)
        self._constants: dict[int, Any] = {}
        # Expressions that, possibly times -1, are the value of a step of the recursion.
        self._placed: dict[int, tuple[int, float]] = {}
        for (step, source), number in changes.items():
            if source == CONSTANT:
                self._constants[step] = number
            else:
                self._stands_in[step].append((source, number))

    def outputs(self) -> list[Any]:
        """Changed torques."""
        place = {step.order: k for k, step in enumerate(self.recursion.steps)}
        return [
            self.image(place[x.order]) if isinstance(x, Expression) else x for x in self.recursion.outputs
        ]

    def image(self, wanted: int) -> Any:
        """Image of a step."""
        waiting, begun = [wanted], set[int]()
        images = self.images
        while waiting:
            k = waiting[-1]
            if k in images:
                waiting.pop()
                continue
            stands_in = self._stands_in.get(k)
            needs = self.recursion.arguments[k] if stands_in is None else [source for source, _ in stands_in]
            missing = [x for x in needs if isinstance(x, int) and x != NUMBER and x not in images]
            if not missing:
                images[k] = x = self._made(k)
                if isinstance(x, Expression):
                    if x.operation == "negative":
                        self._placed.setdefault(x.arguments[0].order, (k, -1.0))
                    self._placed.setdefault(x.order, (k, 1.0))
            elif k in begun:
                raise ValueError("steps replace each other in a cycle")
            else:
                begun.add(k)
                waiting += missing
        return images[wanted]

    def _made(self, k: int) -> Any:
        if k in self._stands_in:
            total: Any = 0.0
            for source, number in self._stands_in[k]:
                if source == NUMBER:
                    total = total + number
                else:
                    total = total + self._scaled(Change(k, source), number, self.images[source], None)
            return total
        step, arguments = self.recursion.steps[k], self.recursion.arguments[k]
        if step.operation == "input":
            return self.trace.record("input", arguments[0])
        values = [self.images[x] if isinstance(x, int) else self._constants.get(k, x) for x in arguments]
        if step.operation != "multiply":
            return self.trace.apply(step.operation, *values)
        own = next((a for a, x in zip(values, arguments, strict=True) if not isinstance(x, int)), None)
        if isinstance(values[0], Expression):
            values.reverse()
        return self._scaled(Change(k, CONSTANT), values[0], values[1], None if own is None else values[1])

    def _scaled(self, stated: Change, number: Any, x: Any, own: Any) -> Any:
        """Multiply, and note how to state the constant; `own` is the factor of the step's own constant."""
        product = _times(self.trace, number, x)
        sign, inner = (-1.0, product.arguments[0]) if _is(product, "negative") else (1.0, product)
        if not _is(inner, "multiply") or isinstance(inner.arguments[0], Expression):
            return product
        factor = inner.arguments[1]
        if own is not None and factor is own:
            self.scales[inner.order].append(Scale(stated, stated, sign))
        elif own is not None and _is(own, "negative") and own.arguments[0] is factor:
            self.scales[inner.order].append(Scale(stated, stated, -sign))
        elif factor.order in self._placed:
            place, other = self._placed[factor.order]
            self.scales[inner.order].append(Scale(stated, Change(stated.step, place), sign * other))
        return product


def _is(x: Any, operation: str) -> bool:
    return isinstance(x, Expression) and x.operation == operation


def _times(trace: Trace, a: Any, b: Any) -> Any:
    """Multiply, merging two successive constants."""
    if isinstance(a, Expression) or not isinstance(b, Expression):
        return trace.multiply(a, b)
    if b.operation == "negative":
        return trace.negative(_times(trace, a, b.arguments[0]))
    if b.operation == "multiply" and not isinstance(b.arguments[0], Expression):
        return trace.multiply(a * b.arguments[0], b.arguments[1])
    return trace.multiply(a, b)


def restated(changes: Changes, numbers: Mapping[int, float], changed: Changed) -> dict[Change, float]:
    """State new factors of the changed program, given by their expression's order."""
    found = [(scale, number) for order, number in numbers.items() for scale in changed.scales.get(order, ())]
    gone = {scale.instead_of for scale, _ in found}
    out = {change: number for change, number in changes.items() if change not in gone}
    for scale, number in found:
        out[scale.change] = out.get(scale.change, 0.0) + scale.sign * number
    return out
