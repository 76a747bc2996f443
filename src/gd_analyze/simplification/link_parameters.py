"""Which regrouped parameters of which links a changed recursion keeps."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass

from gd_analyze.dynamics.regrouped_links import regrouped
from gd_analyze.formulas.formula import Power, Symbol
from gd_analyze.formulas.printer import PRIME
from gd_analyze.simplification.exact_form import ExactForm
from gd_analyze.simplification.recursion import Changes
from gd_analyze.simplification.recursion_names import INWARD, Quantity
from gd_analyze.simplification.recursion_scales import scales
from gd_analyze.simplification.recursion_told import Told
from gd_analyze.text import joined

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
        Products with it in the exact recursion.
    kept
        Numbers in those that are left, as if all stood for the parameter.
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
    """Parameters of all links, in the order of `KINDS`; drives' inertia only where they count."""
    recursion, numbers = form.recursion, _numbers(form)
    exact = Told(recursion, {})
    model = Told(recursion, changes, scales(form, changes))
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


def _uses(
    exact: Told, numbers: Mapping[Quantity, float]
) -> dict[tuple[Quantity, Symbol], tuple[Quantity, Symbol, float]]:
    """Where parameters act: by each and what it multiplies, into which quantity, and with which number."""
    of_symbol = {quantity.symbol: quantity for quantity in exact.values}
    out: dict[tuple[Quantity, Symbol], tuple[Quantity, Symbol, float]] = {}
    for into in exact.values:
        if into.kind.rstrip(PRIME) not in INWARD:
            continue
        for term in exact.sum(into):
            if len(term.powers) != 1 or term.powers[0].exponent != 1:
                continue
            symbol = term.powers[0].base
            # What stands before the force or moment of a further link is a length or of a rotation.
            if not isinstance(symbol, Symbol) or symbol.letter in ("f", "n"):
                continue
            found = [key for key in _of_link(into, numbers) if abs(numbers[key]) == abs(term.weight)]
            factor = of_symbol.get(symbol)
            likely = [key for key in found if factor and key.kind == _expected(into, factor)]
            for key in (likely or found)[:1]:
                out.setdefault((key, symbol), (into, symbol, term.weight))
    return out


def _weight(model: Told, into: Quantity, factor: Symbol) -> float | None:
    """Number by which something goes into a quantity; None where it does not."""
    if into not in model.values:
        return None
    sign, symbol = 1.0, factor
    for quantity in model.values:
        if quantity.symbol == factor:
            sign, symbol = model.name(quantity) or (0.0, factor)
    weights = [term.weight for term in model.sum(into) if term.powers == (Power(symbol),)]
    return sign * weights[0] if weights and sign else None


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
