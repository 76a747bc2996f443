"""A changed recursion as equations that a person reads: link by link, outward and back."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass
from typing import Any

from gd_analyze.formulas.formula import (
    Formula,
    Function,
    Legend,
    Piece,
    Power,
    Product,
    Symbol,
    as_formula,
    one,
)
from gd_analyze.formulas.printer import PRIME
from gd_analyze.levels.recursion import Change, Recursion
from gd_analyze.levels.recursion_names import INWARD, OUTWARD, Names, Quantity, unsigned
from gd_analyze.operations.trace import Expression

# What the symbols in it mean, those of one meaning together.
MEANINGS: tuple[tuple[tuple[Symbol, ...], str], ...] = (
    (
        (Symbol("omega"), Symbol("omega", dots=1)),
        "angular velocity and acceleration of a link, in its frame on the joint's axis",
    ),
    ((Symbol("a"),), "acceleration of that frame's origin, gravity counted in"),
    ((Symbol("A"),), "matrix by which a point r of the link has A r more"),
    ((Symbol("f"), Symbol("n")), "force and moment, about the origin, on the link and those beyond"),
    (
        (Symbol("a", primes=1), Symbol("a", primes=2)),
        "the same in that frame before its joint turns, and in the frame of the link before",
    ),
)


@dataclass(frozen=True)
class Passage:
    """Equations of one link, on the way out or back.

    Parameters
    ----------
    link
        From 0.
    outward
        Whether it tells how the link moves, or what that does to forces.
    formulas
        In the order of their making.
    """

    link: int
    outward: bool
    formulas: tuple[Formula, ...]

    @property
    def heading(self) -> str:
        """Words above them."""
        return f"Link {self.link + 1}, {'how it moves' if self.outward else 'forces and torque'}"


@dataclass(frozen=True)
class Reading:
    """A changed recursion, to read.

    Parameters
    ----------
    passages
        Outward from the base, then back to it; links without equations are left out.
    functions
        Sines and cosines.
    """

    passages: tuple[Passage, ...]
    functions: tuple[Formula, ...]

    @property
    def legend(self) -> Legend:
        """The longest plain cosine and sine, which explain the others, and all that are not plain."""
        told: list[Formula] = []
        for letter in ("C", "S"):
            own = [formula for formula in self.functions if formula.left.letter == letter]
            plain = [formula for formula in own if _is_plain(formula)]
            told += [max(plain, key=lambda formula: len(formula.left.index))] if plain else []
            told += [formula for formula in own if formula not in plain]
        return Legend((), (), tuple(told))

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """All equations, in the order they can be evaluated in."""
        return tuple(formula for passage in self.passages for formula in passage.formulas)


def read(recursion: Recursion, changes: Mapping[Change, float]) -> Reading:
    """Write a changed recursion in equations of the quantities that a reader knows.

    What is zero, is not needed any more, or only is another quantity in another frame, has no equation.
    """
    program, known = recursion.images(changes)
    needed = {step.order for step in program.steps}
    now = {quantity: _now(value, known, needed) for quantity, value in recursion.quantities}
    torques = [quantity for quantity in now if quantity.kind == "tau"]
    now |= zip(torques, map(unsigned, program.outputs), strict=True)
    told = {quantity: value for quantity, value in now.items() if value is not None}
    names = Names(program.steps, told)
    links = range(len(torques))
    passages = []
    for outward, kinds in ((True, OUTWARD), (False, INWARD)):
        for link in links if outward else reversed(links):
            own = sorted(
                (quantity for quantity in told if quantity.link == link and quantity.kind in kinds),
                key=lambda quantity: kinds.index(quantity.kind),
            )
            formulas = (_formula(quantity, *told[quantity], names) for quantity in own)
            passages.append(Passage(link, outward, tuple(filter(None, formulas))))
    functions = (Formula(symbol, (Piece(one(own)),)) for symbol, own in names.functions.items())
    return Reading(tuple(passage for passage in passages if passage.formulas), tuple(functions))


def _now(value: Any, known: Mapping[int, Any], needed: Set[int]) -> tuple[float, Any] | None:
    """Sign and what became of an expression; None where nothing needs it."""
    if not isinstance(value, Expression):
        return 1.0, value
    for sign, x in ((1.0, value), unsigned(value)):
        if x.order in known:
            other, base = unsigned(known[x.order])
            if not isinstance(base, Expression) or base.order in needed:
                return sign * other, base
    return None


def _formula(quantity: Quantity, sign: float, base: Any, names: Names) -> Formula | None:
    """Equation of a quantity; None where there is nothing to say."""
    is_torque = quantity.kind == "tau"
    if not isinstance(base, Expression):
        return Formula(quantity.symbol, (Piece(Product(sign * base)),)) if is_torque else None
    own_sign, name = names.known[base.order]
    if name != quantity.symbol:
        another = Product(sign * own_sign, (Power(name),))
        return None if _is_aside(quantity) else Formula(quantity.symbol, (Piece(another),))
    return as_formula(quantity.symbol, names.sum(base, own_sign, inside=True))


def _is_aside(quantity: Quantity) -> bool:
    """Whether nobody misses it where it is another quantity by name."""
    return PRIME in quantity.kind or quantity.kind in ("p", "pd", "A", "r")


def _is_plain(formula: Formula) -> bool:
    """Whether it is the cosine or sine of a sum of angles."""
    ((function, _),) = formula.pieces[0].product.powers
    assert isinstance(function, Function)
    return all(term.powers and term.weight == 1.0 for term in function.argument)
