"""Omissions of a simplified recursion, their torque, and the remaining parameters."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from gd_analyze.arrays import FloatArray, chunks
from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.formulas.formula import PRIME, Power, Product, Symbol
from gd_analyze.formulas.languages import Plain
from gd_analyze.motions.states import States
from gd_analyze.operations.program import UFUNCS, Program
from gd_analyze.operations.trace import Expression, reached
from gd_analyze.simplification.effort import inputs_of
from gd_analyze.simplification.exact import ExactForm
from gd_analyze.simplification.recursion import CONSTANT, INWARD, NUMBER, Changes, Quantity, Recursion
from gd_analyze.simplification.recursive import Names, SimplifiedQuantities, merged, scales, unsigned
from gd_analyze.text import joined

# Replacement of a step: numbers by the source they multiply.
Instead = dict[int, float]
# Share of peak torque that is rounding, and tolerance of ratios equal to one.
_NOTHING, _EQUAL = 1e-12, 1e-9
_AXES = "xyz"
# Most characters of a sum that a table shows in full.
_LONGEST = 24
# Parameters of every link: mass, first moments, second moments, and the drive's inertia.
KINDS = ("M", "MX", "MY", "MZ", "Pxx", "Pyy", "Pzz", "Pxy", "Pxz", "Pyz", "J")
_UNITS = ("kg", *3 * ["kg m"], *7 * ["kg m^2"])


@dataclass(frozen=True, eq=False)
class Omission:
    """One change of a recursion, with factors of its quantities (`recursive.scales`) removed."""

    places: tuple[int, ...]  # indices of the steps, usually one
    quantity: Quantity  # the quantity that they belong to
    exact: tuple[Product, ...]  # original sum in that quantity
    instead: tuple[Product, ...]  # present sum; () if nothing is left
    torque: FloatArray  # (n,), largest change of torque at the states by it alone, N m (N)
    share: FloatArray  # (n,), of the peak torque; 0 for a joint without torque

    @property
    def changed_by(self) -> str:
        """Relative change, if it is a multiple of the original: "+2.1 %"; otherwise ""."""
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
    """List changes of steps still needed, by their torque alone at states, the largest first."""
    steps = _Steps(form.recursion)
    together = steps.together(steps.without_factors(changes, scales(form, changes)))
    torque, peak = torque_alone(form.recursion, together, states)
    out = []
    for instead, largest in zip(together, torque, strict=True):
        share = np.divide(largest, peak, out=np.zeros_like(peak), where=peak > 0.0)
        if share.max(initial=0.0) > _NOTHING:
            quantity = steps.quantity_of(min(instead))
            exact, now = steps.before_and_after(quantity, instead)
            out.append(Omission(tuple(instead), quantity, exact, now, largest, share))
    return tuple(sorted(out, key=lambda one: (-float(one.share.max(initial=0.0)), one.places)))


def first_terms(terms: Sequence[Product], plain: Plain) -> str:
    """A sum in plain characters; only the first term of a long one."""
    whole = plain.sum(terms)
    return whole if len(terms) < 2 or len(whole) <= _LONGEST else f"{plain.sum(terms[:1])} + …"


class _Steps:
    """Steps of the exact recursion, their quantities, and sums of named quantities."""

    def __init__(self, recursion: Recursion) -> None:
        self.recursion, self.steps = recursion, recursion.steps
        self.values = dict(recursion.quantities)
        self.names = Names(self.steps, {quantity: unsigned(value) for quantity, value in self.values.items()})
        # A quantity may be a step with its sign changed, which is also a step.
        whole = {x.order: quantity for quantity, x in recursion.quantities if isinstance(x, Expression)}
        self.parts = whole | self.names.parts(self.steps)

    def quantity_of(self, place: int) -> Quantity:
        """The quantity that a step belongs to."""
        return self.parts[self.steps[place].order]

    def without_factors(self, changes: Changes, factors: Mapping[Quantity, float]) -> dict[int, Instead]:
        """Replacements of steps, by index, without numbers that only compensate each other."""
        stated: dict[int, Instead] = {}
        for (place, source), number in changes.items():
            stated.setdefault(place, {})[source] = number

        def factor(place: int) -> float:
            quantity = self.parts.get(self.steps[place].order)
            return 1.0 if quantity is None else factors.get(quantity, 1.0)

        out: dict[int, Instead] = {}
        for place in sorted(self.recursion.carried_out(changes).images):
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
        """Group changes that add the same new step to one quantity."""
        by_source: dict[tuple[Quantity, int], dict[int, Instead]] = {}
        out: list[dict[int, Instead]] = []
        for place, instead in changes.items():
            foreign = instead.keys() - {NUMBER, CONSTANT, place, *self.recursion.arguments[place]}
            keys = [(self.quantity_of(place), source) for source in sorted(foreign)]
            group = next((by_source[key] for key in keys if key in by_source), None)
            if group is None:
                group = {}
                out.append(group)
            group[place] = instead
            by_source |= dict.fromkeys(keys, group)
        return out

    def _as_it_is(self, place: int) -> Instead:
        """An unchanged step, written as a replacement; empty for steps that changes cannot state."""
        step, arguments = self.steps[place], self.recursion.arguments[place]
        operands = [x for x in arguments if isinstance(x, int)]
        if step.operation in ("add", "subtract") and len(set(operands)) == 2:
            a, b = operands
            return {a: 1.0, b: -1.0 if step.operation == "subtract" else 1.0}
        if step.operation == "multiply" and len(operands) == 1:
            return {CONSTANT: arguments[0]}
        return {} if step.operation in ("input", "cos", "sin") else {place: 1.0}

    def before_and_after(
        self, quantity: Quantity, changes: Mapping[int, Instead]
    ) -> tuple[tuple[Product, ...], tuple[Product, ...]]:
        """Original and present sum of a quantity, without their common terms."""
        whole = self.values[quantity]
        _, base = unsigned(whole)
        sign, _ = self.names.known[base.order]
        known = {self.steps[place].order: self._now(place, instead) for place, instead in changes.items()}
        first = self.steps[min(changes)]
        if first.operation in ("cos", "sin"):  # occurs in more than this quantity
            return self.names.sum(first), merged(known[first.order])
        if whole is not base and whole.order in known:
            return (Product(1.0, (Power(quantity.symbol),)),), merged(known[whole.order])
        if known.get(base.order) == []:
            return (Product(1.0, (Power(quantity.symbol),)),), ()
        exact = self.names.sum(base, sign, inside=True)
        now = merged(self.names.terms(base, sign, inside=True, instead=known))
        before, after = ({term.powers: term.weight for term in terms} for terms in (exact, now))

        def is_new(term: Product, there: Mapping[tuple[Power, ...], float]) -> bool:
            return not math.isclose(there.get(term.powers, 0.0), term.weight, rel_tol=_EQUAL)

        return tuple(t for t in exact if is_new(t, after)), tuple(t for t in now if is_new(t, before))

    def _now(self, place: int, instead: Instead) -> list[Product]:
        """Replacement of a step, as a sum."""
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


def torque_alone(
    recursion: Recursion, changes: Sequence[Mapping[int, Instead]], states: States
) -> tuple[FloatArray, FloatArray]:
    """Largest torque that each change alone removes, (K, n), and peak torque, (n,)."""
    steps, arguments, inputs = recursion.steps, recursion.arguments, inputs_of(states)
    place = {step.order: k for k, step in enumerate(steps)}
    outputs = [place[x.order] if isinstance(x, Expression) else x for x in recursion.outputs]
    needed = set(reached(recursion.outputs))
    live = [k for k, step in enumerate(steps) if step.operation != "input" and step.order in needed]
    lost, peak = np.zeros((len(changes), len(outputs))), np.zeros(len(outputs))
    for few in chunks(len(states)):
        values = Program(steps, steps).run({name: rows[few] for name, rows in inputs.items()})
        exact = _rows(outputs, values, {})
        peak = np.maximum(peak, np.abs(exact).max(axis=1))
        for row, instead in zip(lost, changes, strict=True):
            changed = {k: _standing_in(arguments[k], own, values) for k, own in instead.items()}
            first = min(instead)
            for k in live:
                operands = (x for x in arguments[k] if isinstance(x, int))
                if k > first and k not in instead and any(x in changed for x in operands):
                    changed[k] = UFUNCS[steps[k].operation](*_rows(arguments[k], values, changed))
            np.maximum(row, np.abs(_rows(outputs, values, changed) - exact).max(axis=1), out=row)
    return lost, peak


def _rows(places: Sequence[Any], values: FloatArray, changed: Mapping[int, FloatArray]) -> FloatArray:
    """Values of steps by index, or of constants, after some changes."""
    found = [changed.get(x, values[x]) if isinstance(x, int) else x for x in places]
    return np.array([np.broadcast_to(x, values.shape[1:]) for x in found])


def _standing_in(arguments: Sequence[Any], instead: Instead, values: FloatArray) -> Any:
    """Value of a replacement, from exact values."""
    if CONSTANT in instead:
        (x,) = (x for x in arguments if isinstance(x, int))
        return instead[CONSTANT] * values[x]
    return sum(number * (1.0 if k == NUMBER else values[k]) for k, number in instead.items())


@dataclass(frozen=True)
class LinkParameter:
    """A regrouped parameter of a link, and its use in a model."""

    link: int  # from 0
    kind: str  # one of `KINDS`
    number: float  # in the exact recursion, SI
    places: int  # products with it in the exact recursion
    kept: tuple[float, ...]  # numbers in the remaining ones, as values of the parameter

    @property
    def symbol(self) -> Symbol:
        """P_4xy, MX_4."""
        letter = self.kind.rstrip(_AXES)
        return Symbol(letter, joined((self.link,)) + self.kind.removeprefix(letter))

    @property
    def unit(self) -> str:
        """Unit, the same for revolute and prismatic joints."""
        return _UNITS[KINDS.index(self.kind)]

    @property
    def is_changed(self) -> bool:
        """Whether a remaining step multiplies by another number."""
        return not all(math.isclose(number, self.number, rel_tol=1e-9) for number in self.kept)

    @property
    def state(self) -> str:
        """One of "kept", "refitted", "partly kept", "dropped", "never acts"."""
        if not self.places:
            return "never acts"
        if not self.kept:
            return "dropped"
        if len(self.kept) < self.places:
            return "partly kept"
        return "refitted" if self.is_changed else "kept"


def link_parameters(form: ExactForm, changes: Changes) -> tuple[LinkParameter, ...]:
    """Parameters of all links; drive inertias only if included."""
    numbers: dict[Quantity, float] = {}
    for i, link in enumerate(regrouped(form.arm).links):
        second = (link.second[_AXES.index(kind[1]), _AXES.index(kind[2])] for kind in KINDS[4:10])
        drive = [] if form.drive_inertia is None else [form.drive_inertia[i]]
        own = zip(KINDS, [link.mass, *link.first, *second, *drive], strict=False)
        numbers |= {Quantity(kind, i): float(number) for kind, number in own}
    exact = SimplifiedQuantities(form.recursion, {})
    model = SimplifiedQuantities(form.recursion, changes, scales(form, changes))
    places, kept = defaultdict[Quantity, int](int), defaultdict[Quantity, list[float]](list)
    for (key, _), (into, factor, weight) in _uses(exact, numbers).items():
        places[key] += 1
        now = _weight(model, into, factor)
        if now is not None:
            kept[key].append(numbers[key] * (now / weight))
    return tuple(
        LinkParameter(key.link, key.kind, number, places[key], tuple(kept[key]))
        for key, number in numbers.items()
    )


def _uses(
    exact: SimplifiedQuantities, numbers: Mapping[Quantity, float]
) -> dict[tuple[Quantity, Symbol], tuple[Quantity, Symbol, float]]:
    """Uses of parameters: factor, resulting quantity, and number."""
    of_symbol = {quantity.symbol: quantity for quantity in exact.values}
    out: dict[tuple[Quantity, Symbol], tuple[Quantity, Symbol, float]] = {}
    for into in exact.values:
        if into.kind.rstrip(PRIME) not in INWARD:
            continue
        kinds = KINDS[-1:] if into.kind == "tau" else KINDS[:-1]
        own = [key for kind in kinds if (key := Quantity(kind, into.link)) in numbers]
        for term in exact.sum(into):
            if len(term.powers) != 1 or term.powers[0].exponent != 1:
                continue
            symbol = term.powers[0].base
            # A factor of the next link's force or moment is a length or part of a rotation.
            if not isinstance(symbol, Symbol) or symbol.letter in ("f", "n"):
                continue
            found = [key for key in own if abs(numbers[key]) == abs(term.weight)]
            factor = of_symbol.get(symbol)
            likely = [key for key in found if factor and key.kind == _expected(into, factor)]
            for key in (likely or found)[:1]:
                out.setdefault((key, symbol), (into, symbol, term.weight))
    return out


def _weight(model: SimplifiedQuantities, into: Quantity, factor: Symbol) -> float | None:
    """Number with which a factor enters a quantity; None if it does not."""
    if into not in model.values:
        return None
    sign, symbol = 1.0, factor
    for quantity in model.values:
        if quantity.symbol == factor:
            sign, symbol = model.name(quantity) or (0.0, factor)
    weights = [term.weight for term in model.sum(into) if term.powers == (Power(symbol),)]
    return sign * weights[0] if weights and sign else None


def _expected(target: Quantity, factor: Quantity) -> str:
    """Parameter with which a component of a or A enters one of a force or moment; "" if none."""
    towards, kind = target.component, target.kind.rstrip(PRIME)
    if factor.kind == "A" and kind == "f":
        return f"M{factor.component[1].upper()}"
    others = [axis for axis in _AXES if axis not in towards + factor.component[:1]]
    if factor.kind not in ("a", "A") or kind != "n" or len(others) != 1:
        return ""
    if factor.kind == "a":
        return f"M{others[0].upper()}"
    return "P" + "".join(sorted(others[0] + factor.component[1]))
