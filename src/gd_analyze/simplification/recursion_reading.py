"""A changed recursion as equations that a person reads: link by link, outward and back."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

from gd_analyze.formulas.formula import Formula, Function, Legend, Piece, Symbol, as_formula, one
from gd_analyze.formulas.printer import PRIME
from gd_analyze.simplification.recursion import Changes, Recursion
from gd_analyze.simplification.recursion_names import INWARD, OUTWARD, Quantity
from gd_analyze.simplification.recursion_told import Told

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
        In the order they can be evaluated in.
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


def read(recursion: Recursion, changes: Changes, factors: Mapping[Quantity, float] | None = None) -> Reading:
    """Write a changed recursion in equations of the quantities that a reader knows.

    What is zero, is not needed any more, or only is another quantity in another frame, has no equation.

    Parameters
    ----------
    recursion
        The exact one.
    changes
        Of it.
    factors
        What is taken out of quantities, see `recursion_scales`.
    """
    told = Told(recursion, changes, factors)
    links = range(len(recursion.outputs))
    passages: list[tuple[int, bool, list[Formula]]] = []
    for outward, kinds in ((True, OUTWARD), (False, INWARD)):
        for link in links if outward else reversed(links):
            own = sorted(
                (quantity for quantity in told.values if quantity.link == link and quantity.kind in kinds),
                key=lambda quantity: kinds.index(quantity.kind),
            )
            sums = [
                as_formula(quantity.symbol, told.sum(quantity)) for quantity in own if _says(quantity, told)
            ]
            passages.append((link, outward, sums))
    functions = (Formula(symbol, (Piece(one(own)),)) for symbol, own in told.names.functions.items())
    ordered = (Passage(link, outward, sums) for (link, outward, _), sums in _in_order(passages))
    return Reading(tuple(passage for passage in ordered if passage.formulas), tuple(functions))


def _in_order(
    passages: Sequence[tuple[int, bool, Sequence[Formula]]],
) -> Iterator[tuple[tuple[int, bool, Sequence[Formula]], tuple[Formula, ...]]]:
    """Bring forward what an equation before it needs: a changed step may take in what is told of later."""
    left = {formula.left: formula for _, _, formulas in passages for formula in formulas}

    def with_needed(symbol: Symbol | Function) -> Iterator[Formula]:
        if not isinstance(symbol, Symbol) or (formula := left.pop(symbol, None)) is None:
            return
        for piece in formula.pieces:
            for base, _ in piece.product.powers:
                yield from with_needed(base)
        yield formula

    for passage in passages:
        yield passage, tuple(one for formula in passage[2] for one in with_needed(formula.left))


def _says(quantity: Quantity, told: Told) -> bool:
    """Whether a quantity's equation says anything."""
    name = told.name(quantity)
    if quantity.kind == "tau":
        return True
    return name is not None and (name[1] == quantity.symbol or not _is_aside(quantity))


def _is_aside(quantity: Quantity) -> bool:
    """Whether nobody misses it where it is another quantity by name."""
    return PRIME in quantity.kind or quantity.kind in ("p", "pd", "A", "r")


def _is_plain(formula: Formula) -> bool:
    """Whether it is the cosine or sine of a sum of angles."""
    ((function, _),) = formula.pieces[0].product.powers
    assert isinstance(function, Function)
    return all(term.powers and term.weight == 1.0 for term in function.argument)
