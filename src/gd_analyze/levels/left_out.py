"""What a changed recursion leaves out: where, and how much torque each change makes by itself."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gd_analyze.formulas.formula import Product
from gd_analyze.levels.kept_programs import inputs_of
from gd_analyze.levels.recursion import CONSTANT, NUMBER, Change, Recursion
from gd_analyze.levels.recursion_names import Names, Quantity, unsigned
from gd_analyze.operations.program import UFUNCS
from gd_analyze.operations.trace import Expression, reached
from gd_analyze.states import States
from gd_analyze.vectors import FloatArray, chunks


@dataclass(frozen=True, eq=False)
class Omission:
    """One change of a recursion.

    Parameters
    ----------
    place
        Of the step.
    quantity
        What it is part of, or is.
    exact, instead
        Sums of products: what was there, and what is; () where nothing is.
    is_refit
        Whether only a number is another.
    torque
        Largest magnitude at the states of what it alone changes, N m (N), shape (n,).
    share
        That over the peak torque, 0 of a joint that has none.
    """

    place: int
    quantity: Quantity
    exact: tuple[Product, ...]
    instead: tuple[Product, ...]
    is_refit: bool
    torque: FloatArray
    share: FloatArray

    @property
    def changed_by(self) -> str:
        """How much larger a number is than it was, where only that changed: "+2.1 %"; "" elsewhere."""
        if not self.is_refit or not self.instead:
            return ""
        return f"{100.0 * (self.instead[0].weight / self.exact[0].weight - 1.0):+.2g} %"

    @property
    def joint(self) -> int:
        """The joint that loses the largest share, from 0."""
        return int(self.share.argmax())


def omissions(recursion: Recursion, changes: Mapping[Change, float], states: States) -> tuple[Omission, ...]:
    """List what changes do to steps that are still needed, those first that make most torque alone.

    What makes none alone is left out.

    Parameters
    ----------
    recursion
        The exact one.
    changes
        Of it.
    states
        Where torque is looked at.
    """
    _, known = recursion.images(changes)
    steps = by_step(changes)
    wanted = [place for place in steps if place in known]
    torque, peak = _alone(recursion, {place: steps[place] for place in wanted}, states)
    names = _Exact(recursion)
    out = []
    for place, largest in zip(wanted, torque, strict=True):
        exact, instead = names.told(place, steps[place])
        if not largest.any():
            continue
        share = np.divide(largest, peak, out=np.zeros_like(peak), where=peak > 0.0)
        out.append(Omission(place, names.of(place), exact, instead, CONSTANT in steps[place], largest, share))
    return tuple(sorted(out, key=lambda one: (-float(one.share.max(initial=0.0)), one.place)))


def by_step(changes: Mapping[Change, float]) -> dict[int, dict[int, float]]:
    """Changes of the same step together."""
    out: dict[int, dict[int, float]] = {}
    for (step, source), number in changes.items():
        out.setdefault(step, {})[source] = number
    return out


class _Exact:
    """The exact recursion in words."""

    def __init__(self, recursion: Recursion) -> None:
        self.steps = recursion.steps
        told = {quantity: unsigned(value) for quantity, value in recursion.quantities}
        self.names = Names(recursion.steps, told)
        self.parts = self.names.parts(recursion.steps)

    def of(self, place: int) -> Quantity:
        """The quantity a step is part of."""
        return self.parts[self.steps[place].order]

    def told(
        self, place: int, instead: Mapping[int, float]
    ) -> tuple[tuple[Product, ...], tuple[Product, ...]]:
        """What a step was and what it is; of a sum without some summands these alone."""
        step, names = self.steps[place], self.names
        if CONSTANT in instead:
            number, x = step.arguments
            return names.sum(x, number), names.sum(x, instead[CONSTANT])
        if len(instead) == 1 and step.operation in ("add", "subtract"):
            ((source, number),) = instead.items()
            a, b = step.arguments
            sign = -1.0 if step.operation == "subtract" else 1.0
            left = None if source == NUMBER else self.steps[source]
            for kept, weight, other, lost in ((a, 1.0, b, sign), (b, sign, a, 1.0)):
                if kept is left and number == weight:
                    return names.sum(other, lost), ()
        now: tuple[Product, ...] = ()
        for source, number in instead.items():
            now += (Product(number),) if source == NUMBER else names.sum(self.steps[source], number)
        was, now = names.sum(step), tuple(term for term in now if term.weight)
        if len(was) == 1 and was[0].weight == -1.0 and len(was[0].powers) == 1:
            # A quantity that the step has with the opposite sign.
            was, now = _turned(was), _turned(now)
        return was, now


def _turned(terms: tuple[Product, ...]) -> tuple[Product, ...]:
    return tuple(term._replace(weight=-term.weight) for term in terms)


def _alone(
    recursion: Recursion, changes: Mapping[int, Mapping[int, float]], states: States
) -> tuple[FloatArray, FloatArray]:
    """Largest torque that each change by itself takes away, (K, n), and that there is, (n,)."""
    n, inputs = len(recursion.outputs), inputs_of(states)
    torque, peak = np.zeros((len(changes), n)), np.zeros(n)
    for few in chunks(len(states)):
        run = _Run(recursion, {name: values[few] for name, values in inputs.items()})
        peak = np.maximum(peak, np.abs(run.torque).max(axis=1))
        for row, (place, instead) in zip(torque, changes.items(), strict=True):
            np.maximum(row, run.lost(place, instead), out=row)
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

    def lost(self, place: int, instead: Mapping[int, float]) -> FloatArray:
        """Largest difference of each joint's torque once something stands in for a step, (n,)."""
        if CONSTANT in instead:
            (x,) = (x for x in self.steps[place].arguments if isinstance(x, Expression))
            step = UFUNCS[self.steps[place].operation]
            now = step(instead[CONSTANT], self._of(x, {}))
        else:
            now = sum(number * (1.0 if k == NUMBER else self.values[k]) for k, number in instead.items())
        changed: dict[int, Any] = {place: now}
        for k in self.needed:
            step = self.steps[k]
            if k > place and any(
                isinstance(x, Expression) and self.place[x.order] in changed for x in step.arguments
            ):
                changed[k] = self._made(step, changed)
        return np.abs(self._torque(changed) - self.torque).max(axis=1)
