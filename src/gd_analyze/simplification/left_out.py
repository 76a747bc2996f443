"""What a changed recursion leaves out: where, and how much torque each change makes by itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from gd_analyze.arrays import FloatArray
from gd_analyze.formulas.formula import Power, Product
from gd_analyze.motions.states import States
from gd_analyze.operations.trace import Expression
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.recursion import CONSTANT, NUMBER, Changes, Recursion
from gd_analyze.simplification.recursion_names import Names, Quantity, merged, unsigned
from gd_analyze.simplification.recursion_scales import scales
from gd_analyze.simplification.torque_alone import Instead, torque_alone

# Shares of peak torque that rounding makes, and ratios that are one.
_NOTHING, _EQUAL = 1e-12, 1e-9


@dataclass(frozen=True, eq=False)
class Omission:
    """One change of a recursion, what was taken out of its quantities (see `recursion_scales`) left out.

    Parameters
    ----------
    places
        Of the steps, mostly one.
    quantity
        What they are part of, or are.
    exact, instead
        Sums of products in that quantity: what was there, and what is; () where nothing is.
    torque
        Largest magnitude at the states of what it alone changes, N m (N), shape (n,).
    share
        That over the peak torque, 0 of a joint that has none.
    """

    places: tuple[int, ...]
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
        if np.ptp(ratios) > _EQUAL * abs(ratios[0]):
            return ""
        more = 100.0 * (ratios[0] - 1.0)
        return f"{more:+.0f} %" if abs(more) >= 99.5 else f"{more:+.2g} %"

    @property
    def joint(self) -> int:
        """The joint that loses the largest share, from 0."""
        return int(self.share.argmax())


def omissions(form: ExactForm, changes: Changes, states: States) -> tuple[Omission, ...]:
    """List what changes do to steps that are still needed, those first that make most torque alone.

    What makes none alone is left out. Changes of one quantity that take the same step in are one, as they
    add it and take it away.

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
    together = words.together(words.without_factors(changes, scales(form, changes)))
    torque, peak = torque_alone(form.recursion, together, states)
    out = []
    for steps, largest in zip(together, torque, strict=True):
        share = np.divide(largest, peak, out=np.zeros_like(peak), where=peak > 0.0)
        if share.max(initial=0.0) > _NOTHING:
            quantity = words.of(min(steps))
            out.append(Omission(tuple(steps), quantity, *words.told(quantity, steps), largest, share))
    return tuple(sorted(out, key=lambda one: (-float(one.share.max(initial=0.0)), one.places)))


class _Words:
    """The exact recursion in words."""

    def __init__(self, recursion: Recursion) -> None:
        self.recursion, self.steps = recursion, recursion.steps
        self.values = dict(recursion.quantities)
        told = {quantity: unsigned(value) for quantity, value in self.values.items()}
        self.names = Names(self.steps, told)
        # A quantity may be a step turned round, and that a step of its own.
        whole = {
            value.order: quantity for quantity, value in recursion.quantities if isinstance(value, Expression)
        }
        self.parts = whole | dict(self.names.parts(self.steps))

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
            own = factor(place)
            of_operands = math.prod(factor(x) for x in self.recursion.arguments[place] if isinstance(x, int))
            now = {}
            for source, number in stated.get(place, was).items():
                if source == NUMBER:
                    now[source] = number / own
                else:
                    by = of_operands if source in (CONSTANT, place) else factor(source)
                    now[source] = number * (by / own)
            if now != was:
                out[place] = now
        return out

    def together(self, changes: Mapping[int, Instead]) -> list[dict[int, Instead]]:
        """Put changes side by side that take the same step into one quantity, which they had not before."""
        by_source: dict[tuple[Quantity, int], dict[int, Instead]] = {}
        out: list[dict[int, Instead]] = []
        for place, instead in changes.items():
            foreign = instead.keys() - {NUMBER, CONSTANT, place, *self.recursion.arguments[place]}
            keys = [(self.of(place), source) for source in sorted(foreign)]
            group = next((by_source[key] for key in keys if key in by_source), None)
            if group is None:
                group = {}
                out.append(group)
            group[place] = instead
            by_source |= dict.fromkeys(keys, group)
        return out

    def _as_it_is(self, place: int) -> Instead:
        """An unchanged step, as what stands in for it; nothing of what no change is stated of."""
        step, arguments = self.steps[place], self.recursion.arguments[place]
        operands = [x for x in arguments if isinstance(x, int)]
        if step.operation in ("add", "subtract") and len(set(operands)) == 2:
            a, b = operands
            return {a: 1.0, b: -1.0 if step.operation == "subtract" else 1.0}
        if step.operation == "multiply" and len(operands) == 1:
            return {CONSTANT: arguments[0]}
        return {} if step.operation in ("input", "cos", "sin") else {place: 1.0}

    def told(
        self, quantity: Quantity, changes: Mapping[int, Instead]
    ) -> tuple[tuple[Product, ...], tuple[Product, ...]]:
        """What a quantity was and what it is, without what is there as it was."""
        whole = self.values[quantity]
        _, base = unsigned(whole)
        sign, _ = self.names.known[base.order]
        known = {self.steps[place].order: self._now(place, instead) for place, instead in changes.items()}
        first = self.steps[min(changes)]
        if first.operation in ("cos", "sin"):
            # It is in more quantities than this.
            return self.names.sum(first), merged(known[first.order])
        if whole is not base and whole.order in known:
            return (Product(1.0, (Power(quantity.symbol),)),), merged(known[whole.order])
        if known.get(base.order) == []:
            return (Product(1.0, (Power(quantity.symbol),)),), ()
        exact = self.names.sum(base, sign, inside=True)
        now = merged(self.names.terms(base, sign, inside=True, instead=known))
        return _apart(exact, now)

    def _now(self, place: int, instead: Instead) -> list[Product]:
        """What stands in for a step, as a sum."""
        out: list[Product] = []
        for source, number in instead.items():
            if source == NUMBER:
                out += [Product(number)] if number else []
            elif source == CONSTANT:
                (x,) = (x for x in self.steps[place].arguments if isinstance(x, Expression))
                out += self.names.terms(x, number)
            else:
                out += self.names.terms(self.steps[source], number, inside=source == place)
        return out


def _apart(
    exact: Sequence[Product], now: Sequence[Product]
) -> tuple[tuple[Product, ...], tuple[Product, ...]]:
    """Leave out what is in both."""
    before, after = ({term.powers: term.weight for term in terms} for terms in (exact, now))

    def is_new(term: Product, there: Mapping[tuple[Power, ...], float]) -> bool:
        return not math.isclose(there.get(term.powers, 0.0), term.weight, rel_tol=_EQUAL)

    return tuple(t for t in exact if is_new(t, after)), tuple(t for t in now if is_new(t, before))
