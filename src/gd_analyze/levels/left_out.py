"""What a changed recursion leaves out: where, and how much torque each change makes by itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from gd_analyze.formulas.formula import Power, Product
from gd_analyze.levels.exact_form import ExactForm
from gd_analyze.levels.kept_programs import inputs_of
from gd_analyze.levels.recursion import CONSTANT, NUMBER, Changes, Recursion
from gd_analyze.levels.recursion_names import Names, Quantity, merged, unsigned
from gd_analyze.levels.recursion_scales import scales
from gd_analyze.operations.program import UFUNCS
from gd_analyze.operations.trace import Expression, reached
from gd_analyze.states import States
from gd_analyze.vectors import FloatArray, chunks

# What stands in for a step: numbers by the source they multiply.
Instead = dict[int, float]
# Shares of peak torque that rounding makes, and ratios that are one.
_NOTHING, _EQUAL = 1e-12, 1e-9


@dataclass(frozen=True, eq=False)
class Omission:
    """One change of a recursion, what was taken out of its quantities (see `recursion_scales`) left out.

    Parameters
    ----------
    place
        Of the step.
    quantity
        What it is part of, or is.
    exact, instead
        Sums of products: what was there, and what is; () where nothing is.
    torque
        Largest magnitude at the states of what it alone changes, N m (N), shape (n,).
    share
        That over the peak torque, 0 of a joint that has none.
    """

    place: int
    quantity: Quantity
    exact: tuple[Product, ...]
    instead: tuple[Product, ...]
    torque: FloatArray
    share: FloatArray

    @property
    def changed_by(self) -> str:
        """How much larger it is than it was, where it is a multiple of that: "+2.1 %"; "" elsewhere."""
        if not self.instead or [x.powers for x in self.exact] != [x.powers for x in self.instead]:
            return ""
        ratios = [now.weight / was.weight for was, now in zip(self.exact, self.instead, strict=True)]
        return f"{100.0 * (ratios[0] - 1.0):+.2g} %" if np.ptp(ratios) <= _EQUAL * abs(ratios[0]) else ""

    @property
    def joint(self) -> int:
        """The joint that loses the largest share, from 0."""
        return int(self.share.argmax())


def omissions(form: ExactForm, changes: Changes, states: States) -> tuple[Omission, ...]:
    """List what changes do to steps that are still needed, those first that make most torque alone.

    What makes none alone is left out.

    Parameters
    ----------
    form
        The exact dynamics.
    changes
        Of their recursion.
    states
        Where torque is looked at.
    """
    words = _Words(form.recursion)
    steps = words.without_factors(changes, scales(form, changes))
    torque, peak = _alone(form.recursion, steps, states)
    out = []
    for (place, instead), largest in zip(steps.items(), torque, strict=True):
        share = np.divide(largest, peak, out=np.zeros_like(peak), where=peak > 0.0)
        if share.max(initial=0.0) > _NOTHING:
            out.append(Omission(place, words.of(place), *words.told(place, instead), largest, share))
    return tuple(sorted(out, key=lambda one: (-float(one.share.max(initial=0.0)), one.place)))


class _Words:
    """The exact recursion in words."""

    def __init__(self, recursion: Recursion) -> None:
        self.recursion, self.steps = recursion, recursion.steps
        self.names = Names(
            self.steps, {quantity: unsigned(value) for quantity, value in recursion.quantities}
        )
        self.parts = self.names.parts(self.steps)

    def of(self, place: int) -> Quantity:
        """The quantity a step is part of."""
        return self.parts[self.steps[place].order]

    def without_factors(self, changes: Changes, factors: Mapping[Quantity, float]) -> dict[int, Instead]:
        """What stands in for steps, by place, as if every quantity were as large as it was.

        So a number that only makes up for another is none that changed, and one that does not, is.
        """
        _, known = self.recursion.images(changes)
        stated: dict[int, Instead] = {}
        for (place, source), number in changes.items():
            stated.setdefault(place, {})[source] = number

        def factor(place: int) -> float:
            quantity = self.parts.get(self.steps[place].order)
            return 1.0 if quantity is None else factors.get(quantity, 1.0)

        out: dict[int, Instead] = {}
        for place in sorted(known):
            was = self._as_it_is(place)
            if not was:
                continue
            operands = [x for x in self.recursion.arguments[place] if isinstance(x, int)]
            of_operands, own = math.prod(map(factor, operands)), factor(place)
            now = {}
            for source, number in stated.get(place, was).items():
                by = (
                    1.0
                    if source == NUMBER
                    else of_operands
                    if source in (CONSTANT, place)
                    else factor(source)
                )
                now[source] = number * (by / own)
            if now != was:
                out[place] = now
        return out

    def _as_it_is(self, place: int) -> Instead:
        """An unchanged step, as what stands in for it; nothing of what no change is stated of."""
        step, arguments = self.steps[place], self.recursion.arguments[place]
        is_sum = (
            step.operation in ("add", "subtract") and len({x for x in arguments if isinstance(x, int)}) == 2
        )
        if is_sum:
            a, b = arguments
            return {a: 1.0, b: -1.0 if step.operation == "subtract" else 1.0}
        if step.operation == "multiply" and not isinstance(arguments[0], int):
            return {CONSTANT: arguments[0]}
        return {} if step.operation in ("input", "cos", "sin") else {place: 1.0}

    def told(self, place: int, instead: Instead) -> tuple[tuple[Product, ...], tuple[Product, ...]]:
        """What a step was and what it is, without what is there as it was."""
        step, names = self.steps[place], self.names
        if CONSTANT in instead:
            number, x = step.arguments
            return names.sum(x, number), names.sum(x, instead[CONSTANT])
        now: list[Product] = []
        for source, number in instead.items():
            now += [Product(number)] if source == NUMBER else names.terms(self.steps[source], number)
        then = names.sum(step)
        if len(instead) > 1 or self._as_it_is(place).keys() & instead.keys():
            then, now = _apart(names.sum(step, inside=True), merged(now))
        exact, now = then, merged(now)
        if len(exact) == 1 and exact[0].weight == -1.0 and len(exact[0].powers) == 1:
            # A quantity that the step has with the opposite sign.
            exact, now = _turned(exact), _turned(now)
        return exact, now


def _apart(
    exact: Sequence[Product], now: Sequence[Product]
) -> tuple[tuple[Product, ...], tuple[Product, ...]]:
    """Leave out what is in both."""
    before, after = ({term.powers: term.weight for term in terms} for terms in (exact, now))

    def is_new(term: Product, there: Mapping[tuple[Power, ...], float]) -> bool:
        return not math.isclose(there.get(term.powers, 0.0), term.weight, rel_tol=_EQUAL)

    return tuple(t for t in exact if is_new(t, after)), tuple(t for t in now if is_new(t, before))


def _turned(terms: tuple[Product, ...]) -> tuple[Product, ...]:
    return tuple(term._replace(weight=-term.weight) for term in terms)


def _alone(
    recursion: Recursion, changes: Mapping[int, Instead], states: States
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

    def lost(self, place: int, instead: Instead) -> FloatArray:
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
