"""An arm's exact recursion, step by step, and what a simplification changes of it.

The steps are those of the Newton-Euler recursion in base parameters as it folds, nothing rearranged, so that
each still is what a reader knows: a component of an angular velocity, a product with a moment of inertia.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, NamedTuple

from gd_analyze.levels.recursion_names import Quantity
from gd_analyze.operations import Program, Trace
from gd_analyze.operations.trace import Expression

# In the place of a step that stands in for another: a number alone, or the changed step's own constant.
NUMBER, CONSTANT = -1, -2


class Change(NamedTuple):
    """One change of the recursion; its number is a coefficient.

    Parameters
    ----------
    step
        Place of the changed step in the recursion.
    source
        The step whose value, times the number, is part of what stands in for it; `NUMBER` where the number is
        a part by itself; or `CONSTANT` where the step remains, and the number replaces its own constant.
    """

    step: int
    source: int


@dataclass(frozen=True, eq=False)
class Recursion:
    """The steps of a recursion.

    Parameters
    ----------
    steps
        Expressions, each after its arguments; what no output needs may stand in for what one does.
    outputs
        Torques of the joints: expressions or numbers.
    quantities
        What a reader knows, each with its expression or number, in the order of their making.
    """

    steps: tuple[Expression, ...]
    outputs: tuple[Any, ...]
    quantities: tuple[tuple[Quantity, Any], ...] = ()

    @property
    def program(self) -> Program:
        """The unchanged recursion."""
        return self.changed({})

    def changed(self, changes: Mapping[Change, float]) -> Program:
        """Carry changes out.

        Raises
        ------
        ValueError
            If steps stand in for one another in a circle.
        """
        return self.images(changes)[0]

    def images(self, changes: Mapping[Change, float]) -> tuple[Program, dict[int, Any]]:
        """Carry changes out; what became of every step that is still needed, by its place."""
        trace, known = Trace(), dict[int, Any]()
        stands_in: dict[int, list[tuple[int, float]]] = {}
        constants: dict[int, float] = {}
        for (step, source), number in changes.items():
            if source == CONSTANT:
                constants[step] = number
            else:
                stands_in.setdefault(step, []).append((source, number))
        place = {step.order: k for k, step in enumerate(self.steps)}

        def needs(k: int) -> list[int]:
            if k in stands_in:
                return [source for source, _ in stands_in[k] if source != NUMBER]
            return [place[x.order] for x in self.steps[k].arguments if isinstance(x, Expression)]

        def made(k: int) -> Any:
            if k in stands_in:
                total: Any = 0.0
                for source, number in stands_in[k]:
                    total = total + (number if source == NUMBER else _times(trace, number, known[source]))
                return total
            step = self.steps[k]
            if step.operation == "input":
                return trace.record("input", step.arguments[0])
            arguments = [
                known[place[x.order]] if isinstance(x, Expression) else constants.get(k, x)
                for x in step.arguments
            ]
            if step.operation == "multiply":
                return _times(trace, *arguments)
            return trace.apply(step.operation, *arguments)

        def fill(wanted: int) -> None:
            waiting, open_ = [wanted], set[int]()
            while waiting:
                k = waiting[-1]
                if k in known:
                    waiting.pop()
                    continue
                missing = [x for x in needs(k) if x not in known]
                if not missing:
                    known[k] = made(k)
                    open_.discard(k)
                elif k in open_:
                    raise ValueError("steps stand in for one another in a circle")
                else:
                    open_.add(k)
                    waiting += missing

        outputs = []
        for output in self.outputs:
            if isinstance(output, Expression):
                fill(place[output.order])
                output = known[place[output.order]]
            outputs.append(output)
        return Program.of(trace, outputs), known


def _times(trace: Trace, a: Any, b: Any) -> Any:
    """Multiply, two constants in a row as one."""
    for number, x in ((a, b), (b, a)):
        if isinstance(number, Expression) or not isinstance(x, Expression):
            continue
        if x.operation == "negative":
            return trace.negative(_times(trace, number, x.arguments[0]))
        if x.operation == "multiply" and not isinstance(x.arguments[0], Expression):
            return trace.multiply(number * x.arguments[0], x.arguments[1])
    return trace.multiply(a, b)
