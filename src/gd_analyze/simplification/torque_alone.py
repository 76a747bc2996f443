"""How much torque changes of a recursion make, each by itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.motions.states import States
from gd_analyze.operations.program import UFUNCS
from gd_analyze.operations.trace import Expression, reached
from gd_analyze.simplification.kept_programs import inputs_of
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Recursion

# What stands in for a step: numbers by the source they multiply.
Instead = dict[int, float]


def torque_alone(
    recursion: Recursion, changes: Sequence[Mapping[int, Instead]], states: States
) -> tuple[FloatArray, FloatArray]:
    """Largest torque that each change by itself takes away, (K, n), and that there is, (n,)."""
    n, inputs = len(recursion.outputs), inputs_of(states)
    torque, peak = np.zeros((len(changes), n)), np.zeros(n)
    for few in chunks(len(states)):
        run = _Run(recursion, {name: values[few] for name, values in inputs.items()})
        peak = np.maximum(peak, np.abs(run.torque).max(axis=1))
        for row, steps in zip(torque, changes, strict=True):
            np.maximum(row, run.lost(steps), out=row)
    return torque, peak


class _Run:
    """The exact recursion carried out, every step kept."""

    def __init__(self, recursion: Recursion, inputs: Mapping[str, FloatArray]) -> None:
        self.steps, self.outputs = recursion.steps, recursion.outputs
        self.count = len(next(iter(inputs.values())))
        self.place = {step.order: k for k, step in enumerate(self.steps)}
        needed = set(reached(self.outputs))
        self.values: dict[int, Any] = {}
        self.needed: list[int] = []
        for k, step in enumerate(self.steps):
            if step.operation == "input":
                self.values[k] = inputs[step.arguments[0]]
            else:
                self.values[k] = self._made(step, {})
                self.needed += [k] if step.order in needed else []

    def _of(self, x: Any, changed: Mapping[int, Any]) -> Any:
        if not isinstance(x, Expression):
            return x
        place = self.place[x.order]
        return changed[place] if place in changed else self.values[place]

    def _made(self, step: Expression, changed: Mapping[int, Any]) -> Any:
        return UFUNCS[step.operation](*(self._of(x, changed) for x in step.arguments))

    def _torque(self, changed: Mapping[int, Any]) -> FloatArray:
        rows = [np.broadcast_to(self._of(x, changed), (self.count,)) for x in self.outputs]
        return np.array(rows)

    @cached_property
    def torque(self) -> FloatArray:
        """The exact torque, (n, N)."""
        return self._torque({})

    def lost(self, steps: Mapping[int, Instead]) -> FloatArray:
        """Largest difference of each joint's torque once others stand in for some steps, (n,)."""
        changed = {place: self._standing_in(place, instead) for place, instead in steps.items()}
        first = min(steps)
        for k in self.needed:
            step = self.steps[k]
            if (
                k > first
                and k not in steps
                and any(self.place[x.order] in changed for x in step.arguments if isinstance(x, Expression))
            ):
                changed[k] = self._made(step, changed)
        return np.abs(self._torque(changed) - self.torque).max(axis=1)

    def _standing_in(self, place: int, instead: Instead) -> Any:
        """What stands in for a step, of exact values."""
        if CONSTANT in instead:
            (x,) = (x for x in self.steps[place].arguments if isinstance(x, Expression))
            return instead[CONSTANT] * self._of(x, {})
        return sum(number * (1.0 if k == NUMBER else self.values[k]) for k, number in instead.items())
