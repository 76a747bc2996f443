"""Formulas independent of any language: a symbol that equals a signed sum of products."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

# Mark of vectors in a frame other than their own.
PRIME = "'"


@dataclass(frozen=True)
class Symbol:
    """A letter with its index and accents: D_12^tran, the second derivative of q_3, tau_1."""

    letter: str  # A Latin letter, "tau" or "omega"
    # Digits and commas, followed by letters of a component; or a letter for any joint
    index: str = ""
    dots: int = 0  # 1 for a velocity, 2 for an acceleration
    word: str = ""  # upright superscript
    primes: int = 0  # number of primes behind the letter


class Power(NamedTuple):
    """A symbol or function, and its exponent."""

    base: Symbol | CircularFunction
    exponent: int = 1


class Product(NamedTuple):
    """A number times powers."""

    weight: float
    powers: tuple[Power, ...] = ()


@dataclass(frozen=True)
class CircularFunction:
    """cos or sin of a sum; the weights of its argument are whole numbers."""

    name: str
    argument: tuple[Product, ...]


@dataclass(frozen=True)
class Piece:
    """A summand, or one of those in a bracket: lines may break between pieces."""

    product: Product  # its sign precedes it, or the bracket that it opens
    # "inertia", "coriolis_centrifugal" or "gravity_loading"; "carried" for the torque of the next joint
    quantity: str = ""
    opens: bool = False  # whether a bracket opens before it
    behind: tuple[Power, ...] = ()  # factor of the bracket that closes behind it; () if none closes

    @property
    def negative(self) -> bool:
        """Whether it has a minus sign."""
        return self.product.weight < 0


@dataclass(frozen=True)
class Formula:
    """An equation."""

    left: Symbol
    pieces: tuple[Piece, ...]  # in reading order, grouped by quantity; `NO_PIECES` for zero
    unit: str = ""  # named behind the equation if it is not evident


NO_PIECES = (Piece(Product(0.0), "carried"),)


class Legend(NamedTuple):
    """Meaning of the names in formulas."""

    shared: tuple[Formula, ...]  # absolute velocities that are sums over joints with parallel axes
    others: tuple[Formula, ...]  # all other velocities, one formula per derivative, for any joint j
    # The longest cosine and sine, which explain the others, and the variable of every prismatic joint
    factors: tuple[Formula, ...]


def alone(base: Symbol | CircularFunction) -> Product:
    """A symbol or function by itself."""
    return Product(1.0, (Power(base),))


def as_formula(left: Symbol, terms: Iterable[Product]) -> Formula:
    """Formula of a sum of products."""
    return Formula(left, tuple(map(Piece, terms)) or NO_PIECES)


def bracketed(quantity: str, terms: tuple[Product, ...], common: tuple[Power, ...]) -> tuple[Piece, ...]:
    """Products times a common factor, in brackets if there are several and a factor."""
    if not common or len(terms) < 2:
        return tuple(Piece(Product(weight, powers + common), quantity) for weight, powers in terms)
    # The first sign precedes the bracket.
    outer = 1.0 if terms[0].weight > 0 else -1.0
    last = len(terms) - 1
    return tuple(
        Piece(Product(outer * weight if k else weight, powers), quantity, k == 0, common if k == last else ())
        for k, (weight, powers) in enumerate(terms)
    )
