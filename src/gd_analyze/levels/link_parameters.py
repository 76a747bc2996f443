"""Which regrouped parameters of which links a changed recursion keeps."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from gd_analyze.formulas.formula import Symbol
from gd_analyze.formulas.printer import PRIME
from gd_analyze.formulations.regrouped_links import regrouped
from gd_analyze.labels import joined
from gd_analyze.levels.exact_form import ExactForm
from gd_analyze.levels.left_out import by_step
from gd_analyze.levels.recursion import CONSTANT, Change
from gd_analyze.levels.recursion_names import INWARD, Names, Quantity, unsigned
from gd_analyze.operations.trace import Expression, reached

_AXES = "xyz"
# Of every link in this order: mass, first moments, second moments, and the drive's inertia.
KINDS = ("M", "MX", "MY", "MZ", "Pxx", "Pyy", "Pzz", "Pxy", "Pxz", "Pyz", "J")
_UNITS = ("kg", *3 * ["kg m"], *7 * ["kg m^2"])


@dataclass(frozen=True)
class LinkParameter:
    """A regrouped parameter, and what a model makes of it.

    Parameters
    ----------
    link
        From 0.
    kind
        One of `KINDS`.
    number
        In the exact recursion, SI.
    places
        Steps of the exact recursion that multiply with it.
    kept
        Numbers that those left multiply with, as if all stood for the parameter.
    """

    link: int
    kind: str
    number: float
    places: int
    kept: tuple[float, ...]

    @property
    def symbol(self) -> Symbol:
        """P_4xy, MX_4."""
        letter = self.kind.rstrip(_AXES)
        return Symbol(letter, joined((self.link,)) + self.kind.removeprefix(letter))

    @property
    def unit(self) -> str:
        """Its unit where the joint turns or slides alike."""
        return _UNITS[KINDS.index(self.kind)]

    @property
    def is_changed(self) -> bool:
        """Whether a step that is left multiplies with another number."""
        return any(number != self.number for number in self.kept)

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


def link_parameters(form: ExactForm, changes: Mapping[Change, float]) -> tuple[LinkParameter, ...]:
    """Parameters of all links, in the order of `KINDS`; drives' inertia only where they count."""
    recursion, steps = form.recursion, by_step(changes)
    _, known = recursion.images(changes)
    numbers = _numbers(form)
    places, kept = defaultdict[Quantity, int](int), defaultdict[Quantity, list[float]](list)
    for place, key in _users(form, numbers):
        places[key] += 1
        instead = steps.get(place, {})
        if place in known and (not instead or CONSTANT in instead):
            step = recursion.steps[place]
            (own,) = (x for x in step.arguments if not isinstance(x, Expression))
            kept[key].append(numbers[key] * (instead.get(CONSTANT, own) / own))
    return tuple(
        LinkParameter(key.link, key.kind, number, places[key], tuple(kept[key]))
        for key, number in numbers.items()
    )


def _numbers(form: ExactForm) -> dict[Quantity, float]:
    """Every parameter and its number."""
    out: dict[Quantity, float] = {}
    for i, link in enumerate(regrouped(form.arm).links):
        own = [link.mass, *link.first, *(link.second[_pair(kind)] for kind in KINDS[4:10])]
        drive = [] if form.drive_inertia is None else [form.drive_inertia[i]]
        out |= {Quantity(kind, i): float(number) for kind, number in zip(KINDS, own + drive, strict=False)}
    return out


def _pair(kind: str) -> tuple[int, int]:
    return _AXES.index(kind[1]), _AXES.index(kind[2])


def _users(form: ExactForm, numbers: Mapping[Quantity, float]) -> list[tuple[int, Quantity]]:
    """Steps that multiply with a parameter, by place, each with that."""
    recursion = form.recursion
    told = {quantity: unsigned(value) for quantity, value in recursion.quantities}
    names = Names(recursion.steps, told)
    of, needed = names.parts(recursion.steps), set(reached(recursion.outputs))
    out = []
    for place, step in enumerate(recursion.steps):
        is_product = step.operation == "multiply" and not isinstance(step.arguments[0], Expression)
        if not is_product or step.order not in needed:
            continue
        number, operand = step.arguments
        target, factor = of[step.order], names.quantity.get(operand.order)
        # What stands before the force or moment of a further link is a length or of a rotation.
        if target.kind.rstrip(PRIME) not in INWARD or (factor and factor.kind[0] in "fn"):
            continue
        found = [key for key in _of_link(target, numbers) if abs(numbers[key]) == abs(number)]
        likely = [key for key in found if factor and key.kind == _expected(target, factor)]
        out += [(place, key) for key in (likely or found)[:1]]
    return out


def _of_link(target: Quantity, numbers: Mapping[Quantity, float]) -> list[Quantity]:
    """Parameters that a step towards a quantity may have."""
    kinds = KINDS[-1:] if target.kind == "tau" else KINDS[:-1]
    return [key for kind in kinds if (key := Quantity(kind, target.link)) in numbers]


def _expected(target: Quantity, factor: Quantity) -> str:
    """Parameter with which a component of a or A acts on one of a force or a moment; "" if with none."""
    towards, kind = target.component, target.kind.rstrip(PRIME)
    if factor.kind == "A" and kind == "f":
        return f"M{factor.component[1].upper()}"
    others = [axis for axis in _AXES if axis not in towards + factor.component[:1]]
    if factor.kind not in ("a", "A") or kind != "n" or len(others) != 1:
        return ""
    if factor.kind == "a":
        return f"M{others[0].upper()}"
    return "P" + "".join(sorted(others[0] + factor.component[1]))
