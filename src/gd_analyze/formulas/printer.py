"""Writing formulas, as far as it is the same in all languages."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import ClassVar

from gd_analyze.formulas.formula import Formula, Function, Legend, Piece, Power, Product, Symbol

# Powers of ten that are written out: 0.00059, but 5.9e-5.
_EVERYDAY = range(-4, 6)


def rounded(value: float, digits: int) -> tuple[str, int]:
    """Mantissa and power of ten of a positive number; power 0 for numbers that are written out.

    Examples
    --------
    >>> rounded(0.0712, 2), rounded(1234.0, 2), rounded(5.85e-5, 2)
    (('0.071', 0), ('1200', 0), ('5.8', -5))
    """
    shown, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if exponent not in _EVERYDAY:
        return _trimmed(shown), exponent
    return _trimmed(f"{float(f'{shown}e{power}'):.{max(digits - 1 - exponent, 0)}f}"), 0


def number(value: float, digits: int) -> str:
    """Write a number in one string: -0.69, 5.85e-5."""
    mantissa, exponent = rounded(abs(value), digits)
    sign = "-" if value < 0 else ""
    return f"{sign}{mantissa}e{exponent}" if exponent else f"{sign}{mantissa}"


def _trimmed(shown: str) -> str:
    return shown.rstrip("0").rstrip(".") if "." in shown else shown


@dataclass(frozen=True)
class Printer(ABC):
    """Base of the languages, which write symbols, functions and powers of ten."""

    digits: int = 3  # significant digits of weights

    # Between factors, between a multiple and its angle, between summands, and around brackets' content.
    apart: ClassVar[str] = " "
    close: ClassVar[str] = " "
    between: ClassVar[str] = " "
    brackets: ClassVar[tuple[str, str]] = ("(", ")")

    @abstractmethod
    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write a symbol raised to a power."""

    @abstractmethod
    def raised(self, text: str, exponent: int) -> str:
        """Write a power of what is written already."""

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write a function of an argument already written, raised to a power: cos²(2 q2 - q3)."""
        return f"{self.raised(name, exponent)}({argument})"

    @abstractmethod
    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write a number times a power of ten other than 1."""

    def sign(self, negative: bool, first: bool) -> str:
        """Write the sign of a summand; the first one's only if it is negative."""
        return ("-" if first else "- ") if negative else "" if first else "+ "

    def power(self, power: Power) -> str:
        """Write a power."""
        base, exponent = power
        if isinstance(base, Function):
            return self.function(base.name, self.sum(base.argument, self.close), exponent)
        return self.symbol(base, exponent)

    def sum(self, products: Sequence[Product], apart: str | None = None) -> str:
        """Write a sum of products."""
        return self.between.join(
            self.sign(product.weight < 0, place == 0) + self.product(product, apart)
            for place, product in enumerate(products)
        )

    def product(self, product: Product, apart: str | None = None) -> str:
        """Write the magnitude of a product, without a factor 1 beside another."""
        factors = [self.power(power) for power in product.powers]
        mantissa, exponent = rounded(abs(product.weight), self.digits)
        if exponent:
            factors.insert(0, self.scientific(mantissa, exponent))
        elif mantissa != "1" or not factors:
            factors.insert(0, self.plain_number(mantissa))
        return (self.apart if apart is None else apart).join(factors)

    def plain_number(self, digits: str) -> str:
        """Write a number without a power of ten."""
        return digits

    def body(self, piece: Piece) -> str:
        """Write a piece without its sign."""
        opening, closing = self.brackets
        behind = [closing, *map(self.power, piece.behind)] if piece.behind else []
        return (opening if piece.opens else "") + self.product(piece.product) + self.apart.join(behind)

    def pieces(self, formula: Formula) -> tuple[str, ...]:
        """Write the right-hand side in pieces, between which a line may break."""
        return tuple(
            self.sign(piece.negative, k == 0) + self.body(piece) for k, piece in enumerate(formula.pieces)
        )

    def right(self, formula: Formula) -> str:
        """Write the right-hand side in one line."""
        return self.between.join(self.pieces(formula))

    def line(self, formula: Formula) -> str:
        """Write a formula in one line."""
        unit = self.words(f" in {formula.unit}") if formula.unit else ""
        return f"{self.symbol(formula.left)} = {self.right(formula)}{unit}"

    def legend(self, legend: Legend) -> tuple[str, ...]:
        """Write the meaning of names, one entry each; one for all velocities that are a joint's own."""
        others = ", ".join(
            f"{self.symbol(other.left)}{self.words(' is ')}{self.right(other)}" for other in legend.others
        )
        if others and legend.shared:
            others = self.words("any other ") + others
        entries = [*map(self.line, legend.shared), others, *map(self.line, legend.factors)]
        return tuple(filter(None, entries))

    def words(self, words: str) -> str:
        """Write words with the spaces about them."""
        return words
