"""What a formula says, apart from any language: a symbol that equals a signed sum of products."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True)
class Symbol:
    """A letter with what stands about it: D_12^tran, the second derivative of q_3, tau_1.

    Parameters
    ----------
    letter
        "tau" is the Greek one.
    index
        Digits and commas, or a letter that stands for any joint.
    dots
        1 for a rate, 2 for an acceleration.
    word
        Upright superscript.
    """

    letter: str
    index: str = ""
    dots: int = 0
    word: str = ""


@dataclass(frozen=True)
class Function:
    """cos or sin of a sum; the weights of its argument are whole numbers."""

    name: str
    argument: tuple[Product, ...]


class Power(NamedTuple):
    """A symbol or function, and its exponent."""

    base: Symbol | Function
    exponent: int = 1


class Product(NamedTuple):
    """A number times powers."""

    weight: float
    powers: tuple[Power, ...] = ()


class Piece(NamedTuple):
    """What stands between two places where a line may break.

    Parameters
    ----------
    quantity
        As in `Summand`.
    negative
        Sign before it.
    product
        Its weight counts by magnitude.
    opens
        Whether a bracket opens before the product.
    behind
        What the bracket that closes behind the product is multiplied with; () where none closes.
    """

    quantity: str
    negative: bool
    product: Product
    opens: bool = False
    behind: tuple[Power, ...] = ()


@dataclass(frozen=True)
class Summand:
    """Products times what they have in common; several stand in brackets.

    Parameters
    ----------
    quantity
        "inertia", "coriolis_centrifugal" or "gravity_loading"; "carried" for the torque of the next joint.
    terms
        At least one.
    behind
        Common factors; needed where there are several terms.
    """

    quantity: str
    terms: tuple[Product, ...]
    behind: tuple[Power, ...] = ()

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """One per term; the first term's sign stands before the bracket."""
        (outer, powers), *others = self.terms
        if not others:
            return (Piece(self.quantity, outer < 0, Product(outer, powers + self.behind)),)
        last = len(others)
        return tuple(
            Piece(
                self.quantity,
                (term.weight if place == 0 else term.weight * outer) < 0,
                term,
                opens=place == 0,
                behind=self.behind if place == last else (),
            )
            for place, term in enumerate(self.terms)
        )


@dataclass(frozen=True)
class Formula:
    """An equation; its right-hand side is 0 without summands.

    Parameters
    ----------
    left
        What it gives.
    summands
        In the order they are read, those of one quantity together.
    unit
        Said behind the equation where it is not evident.
    """

    left: Symbol
    summands: tuple[Summand, ...]
    unit: str = ""

    @property
    def pieces(self) -> tuple[Piece, ...]:
        """The right-hand side between the places where a line may break."""
        pieces = tuple(piece for summand in self.summands for piece in summand.pieces)
        return pieces or (Piece("carried", negative=False, product=Product(0.0)),)


@dataclass(frozen=True)
class Legend:
    """Meaning of the names in formulas.

    Parameters
    ----------
    shared
        Rates that add up those of joints with parallel axes.
    others
        All other rates, one formula per derivative, for any joint j.
    factors
        The longest cosine and sine, which explain the others, and every sliding joint's variable.
    """

    shared: tuple[Formula, ...]
    others: tuple[Formula, ...]
    factors: tuple[Formula, ...]
