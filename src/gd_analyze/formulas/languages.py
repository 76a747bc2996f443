"""Formulas written in plain characters, LaTeX, Typst and MathML, with the common base `Printer`."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import ClassVar

from gd_analyze.formulas.formula import (
    PRIME,
    CircularFunction,
    Formula,
    Legend,
    Piece,
    Power,
    Product,
    Symbol,
)
from gd_analyze.result import Equations

_GREEK = {"tau": "τ", "omega": "ω", "alpha": "α", "beta": "β", "gamma": "γ", "theta": "θ"}
# Range of powers of ten written without exponent: 0.00059, but 5.9e-5.
_POWERS_WITHOUT_EXPONENT = range(-4, 6)


def rounded(value: float, digits: int) -> tuple[str, int]:
    """Mantissa and power of ten of a positive number; power 0 for numbers written without exponent."""
    mantissa, _, power = f"{value:.{digits - 1}e}".partition("e")
    exponent = int(power)
    if exponent not in _POWERS_WITHOUT_EXPONENT:
        return _trimmed(mantissa), exponent
    return _trimmed(f"{float(f'{mantissa}e{power}'):.{max(digits - 1 - exponent, 0)}f}"), 0


def formatted(value: float, digits: int) -> str:
    """Write a number in one string: -0.69, 5.85e-5."""
    mantissa, exponent = rounded(abs(value), digits)
    sign = "-" if value < 0 else ""
    return f"{sign}{mantissa}e{exponent}" if exponent else f"{sign}{mantissa}"


def _trimmed(digits: str) -> str:
    return digits.rstrip("0").rstrip(".") if "." in digits else digits


@dataclass(frozen=True)
class Printer(ABC):
    """Base of the languages; subclasses write symbols, functions and powers of ten."""

    digits: int = 3  # significant digits of weights

    between_factors: ClassVar[str] = " "
    before_angle: ClassVar[str] = " "  # between a multiple and its angle
    between_summands: ClassVar[str] = " "
    brackets: ClassVar[tuple[str, str]] = ("(", ")")

    @abstractmethod
    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write a symbol raised to a power."""

    @abstractmethod
    def raised(self, text: str, exponent: int) -> str:
        """Write a power of a written expression."""

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write a function of an argument already written, raised to a power: cos²(2 q2 - q3)."""
        return f"{self.raised(name, exponent)}({argument})"

    @abstractmethod
    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write a number times a power of ten other than 1."""

    def sign(self, negative: bool, first: bool) -> str:
        """Write the sign of a summand; of the first only a minus sign."""
        if negative:
            return "-" if first else "- "
        return "" if first else "+ "

    def power(self, power: Power) -> str:
        """Write a power."""
        base, exponent = power
        if isinstance(base, CircularFunction):
            return self.function(base.name, self.sum(base.argument, self.before_angle), exponent)
        return self.symbol(base, exponent)

    def sum(self, products: Sequence[Product], separator: str | None = None) -> str:
        """Write a sum of products."""
        return self.between_summands.join(
            self.sign(product.weight < 0, place == 0) + self.product(product, separator)
            for place, product in enumerate(products)
        )

    def product(self, product: Product, separator: str | None = None) -> str:
        """Write the magnitude of a product, without a factor 1 beside another."""
        factors = [self.power(power) for power in product.powers]
        mantissa, exponent = rounded(abs(product.weight), self.digits)
        if exponent:
            factors.insert(0, self.scientific(mantissa, exponent))
        elif mantissa != "1" or not factors:
            factors.insert(0, self.plain_number(mantissa))
        return (self.between_factors if separator is None else separator).join(factors)

    def plain_number(self, digits: str) -> str:
        """Write a number without a power of ten."""
        return digits

    def body(self, piece: Piece) -> str:
        """Write a piece without its sign."""
        opening, closing = self.brackets
        behind = [closing, *map(self.power, piece.behind)] if piece.behind else []
        front = opening if piece.opens else ""
        return front + self.product(piece.product) + self.between_factors.join(behind)

    def pieces(self, formula: Formula) -> tuple[str, ...]:
        """Write the right-hand side in pieces, between which lines may break."""
        return tuple(
            self.sign(piece.negative, k == 0) + self.body(piece) for k, piece in enumerate(formula.pieces)
        )

    def right(self, formula: Formula) -> str:
        """Write the right-hand side in one line."""
        return self.between_summands.join(self.pieces(formula))

    def line(self, formula: Formula) -> str:
        """Write a formula in one line."""
        unit = self.words(f" in {formula.unit}") if formula.unit else ""
        return f"{self.symbol(formula.left)} = {self.right(formula)}{unit}"

    def legend(self, legend: Legend) -> tuple[str, ...]:
        """Write the meaning of names, one entry each; one for all velocities of single joints."""
        velocities = ", ".join(
            f"{self.symbol(formula.left)}{self.words(' is ')}{self.right(formula)}"
            for formula in legend.others
        )
        if velocities and legend.shared:
            velocities = self.words("any other ") + velocities
        entries = [*map(self.line, legend.shared), velocities, *map(self.line, legend.factors)]
        return tuple(filter(None, entries))

    def words(self, words: str) -> str:
        """Write words with the spaces about them."""
        return words


class Plain(Printer):
    """Plain characters: tau2 = tau3 + 3.8 pdd2 + (0.77 S3 - 0.02 C3) pd2 pd3."""

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write tau1, qdd2, C9,10², p_j, D12^tran, omegad'3x."""
        index = f"_{symbol.index}" if symbol.index.isalpha() else symbol.index
        word = f"^{symbol.word}" if symbol.word else ""
        return self.raised(
            f"{symbol.letter}{'d' * symbol.dots}{PRIME * symbol.primes}{index}{word}", exponent
        )

    def raised(self, text: str, exponent: int) -> str:
        """Write C23²."""
        digits = str(exponent).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return text if exponent == 1 else text + digits

    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write 5.85e-5."""
        return f"{mantissa}e{exponent}"

    def wrapped(self, formula: Formula, width: int) -> str:
        """Write a formula in lines of up to this width, with a hanging indent."""
        start = f"{self.symbol(formula.left)} = "
        first, *following = self.pieces(formula)
        lines = [start + first]
        for piece in following:
            if len(lines[-1]) + 1 + len(piece) <= width:
                lines[-1] += " " + piece
            else:
                lines.append(" " * len(start) + piece)
        return "\n".join(lines)


def equation_part(
    key: str | None,
    title: str,
    formulas: Iterable[Formula],
    legend: Legend | None = None,
    note: str = "",
    digits: int = 3,
    most_lines: int | None = None,
) -> Equations:
    """Formulas as a part of a result, with this many digits; `most_lines` is that of `Equations`."""
    plain, formulas = Plain(digits), tuple(formulas)
    explained = () if legend is None else plain.legend(legend)
    lines = tuple(map(plain.line, formulas))
    return Equations(key, title, lines, formulas, legend, explained, note, most_lines)


class LatexPrinter(Printer):
    r"""LaTeX for mathematics mode: C_{23}, 5.85 \cdot 10^{-5}."""

    between_factors = r" \, "

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        r"""Write \tau_{1}, \ddot{q}_{2}, C_{23}^{2}, D_{12}^{\mathrm{tran}}."""
        letter = rf"\{symbol.letter}" if symbol.letter in _GREEK else symbol.letter
        base = rf"\{'d' * symbol.dots}ot{{{letter}}}" if symbol.dots else letter
        base += PRIME * symbol.primes
        index = f"_{{{symbol.index}}}" if symbol.index else ""
        word = rf"^{{\mathrm{{{symbol.word}}}}}" if symbol.word else ""
        return self.raised(f"{base}{index}{word}", exponent)

    def raised(self, text: str, exponent: int) -> str:
        """Write C_{23}^{2}."""
        return text if exponent == 1 else f"{text}^{{{exponent}}}"

    def function(self, name: str, argument: str, exponent: int) -> str:
        r"""Write \cos^{2}(2 q_{2} - q_{3})."""
        return super().function(rf"\{name}", argument, exponent)

    def words(self, words: str) -> str:
        r"""Write \text{ is }."""
        return rf"\text{{{words}}}"

    def scientific(self, mantissa: str, exponent: int) -> str:
        r"""Write 5.85 \cdot 10^{-5}."""
        return rf"{mantissa} \cdot 10^{{{exponent}}}"


@dataclass(frozen=True, repr=False)
class Written:
    """Formulas that print as text and, in a notebook, as mathematics."""

    formulas: tuple[Formula, ...]
    legend: Legend | None = None

    def __repr__(self) -> str:
        plain = Plain()
        lines = [plain.wrapped(formula, 100) for formula in self.formulas]
        return "\n".join([*lines, *(plain.legend(self.legend) if self.legend else ())])

    def _repr_latex_(self) -> str:
        latex = LatexPrinter()
        lines = (latex.line(formula).replace("=", "&=", 1) for formula in self.formulas)
        return r"$\begin{aligned} " + r" \\ ".join(lines) + r" \end{aligned}$"


class Typst(Printer):
    """Typst's mathematics: C_(23), 5.85 times 10^(-5)."""

    between_factors = before_angle = " thin "
    brackets = ("paren.l ", " paren.r")

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write tau_(1), dot.double(q)_(2), C_(23)^2, D_(12)^"tran"."""
        base = f"{('', 'dot', 'dot.double')[symbol.dots]}({symbol.letter})" if symbol.dots else symbol.letter
        base += PRIME * symbol.primes
        # Adjacent letters would form one name.
        index = f"_({re.sub('(?<=.)(?=[a-z])', ' ', symbol.index)})" if symbol.index else ""
        word = f'^"{symbol.word}"' if symbol.word else ""
        return self.raised(f"{base}{index}{word}", exponent)

    def raised(self, text: str, exponent: int) -> str:
        """Write C_(23)^2."""
        return text if exponent == 1 else f"{text}^{exponent}"

    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write 5.85 times 10^(-5)."""
        return f"{mantissa} times 10^({exponent})"

    def words(self, words: str) -> str:
        """Write words with the spaces about them."""
        return words.replace(words.strip(), f'"{words.strip()}"')


class MathML(Printer):
    """Presentation MathML, which browsers show without a script or font: one element per formula."""

    between_factors = before_angle = between_summands = ""
    brackets = ("<mo>(</mo>", "<mo>)</mo>")

    def sign(self, negative: bool, first: bool) -> str:
        """Write the sign of a summand; the first one's only if it is negative."""
        if negative:
            return "<mo>−</mo>"
        return "" if first else "<mo>+</mo>"

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write a letter with its accent, index and superscript."""
        base = f"<mi>{_GREEK.get(symbol.letter, symbol.letter)}</mi>"
        if symbol.dots:
            accent = f'<mo stretchy="false">{("", "˙", "¨")[symbol.dots]}</mo>'
            base = f'<mover accent="true">{base}{accent}</mover>'
        # Numbers are upright; letters, one by one, italic.
        parts = re.findall(r"[^a-z]+|[a-z]", symbol.index)
        index = "".join(f"<mi>{part}</mi>" if part.isalpha() else f"<mn>{part}</mn>" for part in parts)
        index = f"<mrow>{index}</mrow>" if len(parts) > 1 else index
        power = f"<mn>{exponent}</mn>" if exponent != 1 else ""
        above = f"<mtext>{symbol.word}</mtext>" if symbol.word else power
        if symbol.primes:
            primes = f"<mo>{'′' * symbol.primes}</mo>"
            above = f"<mrow>{primes}{above}</mrow>" if above else primes
        tag = f"m{'sub' if index else ''}{'sup' if above else ''}"
        return f"<{tag}>{base}{index}{above}</{tag}>" if index or above else base

    def raised(self, text: str, exponent: int) -> str:
        """Write an element with its exponent."""
        return text if exponent == 1 else f"<msup>{text}<mn>{exponent}</mn></msup>"

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write cos or sin with its argument in brackets."""
        head = self.raised(f"<mi>{name}</mi>", exponent)
        return f"{head}<mo>&#x2061;</mo><mrow>{argument.join(self.brackets)}</mrow>"

    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write a mantissa times a power of ten."""
        power = f"<mn>{abs(exponent)}</mn>"
        if exponent < 0:
            power = f"<mrow><mo>−</mo>{power}</mrow>"
        return f"<mn>{mantissa}</mn><mo>·</mo><msup><mn>10</mn>{power}</msup>"

    def plain_number(self, digits: str) -> str:
        """Write a number without a power of ten."""
        return f"<mn>{digits}</mn>"

    def words(self, words: str) -> str:
        """Write words with a space before them."""
        return f'<mspace width=".3em"/><mtext>{words.strip()}</mtext>'

    def line(self, formula: Formula) -> str:
        """Write a formula in one line."""
        unit = self.words(f"in {formula.unit}") if formula.unit else ""
        content = f"{self.symbol(formula.left)}<mo>=</mo>{self.right(formula)}{unit}"
        return f"<math><mrow>{content}</mrow></math>"

    def legend(self, legend: Legend) -> tuple[str, ...]:
        """Write the meaning of names, one entry each."""
        otherwise = self.words("otherwise") if legend.shared else ""
        velocities = (
            f"<math>{self.symbol(formula.left)}<mo>=</mo>{self.right(formula)}{otherwise}</math>"
            for formula in legend.others
        )
        return (*map(self.line, legend.shared), *velocities, *map(self.line, legend.factors))


class PageMathML(MathML):
    """MathML in several elements per formula, between which a browser may break a line."""

    # By default browsers set factors without space between them, and brackets larger than their content.
    between_factors = '<mspace width=".16em"/>'
    brackets = ('<mo stretchy="false">(</mo>', '<mo stretchy="false">)</mo>')

    def left(self, formula: Formula) -> str:
        """Write the left-hand side and the equals sign."""
        return f"<math>{self.symbol(formula.left)}<mo>=</mo></math>"

    def elements(self, formula: Formula) -> tuple[str, ...]:
        """Write the right-hand side, an element per piece."""
        out = []
        for place, piece in enumerate(formula.pieces):
            sign = self.sign(piece.negative, first=place == 0)
            if place:
                # Browsers treat a sign that begins an element as a prefix, without space after it.
                sign = sign.replace("<mo>", '<mo rspace=".25em">')
            out.append(f"<math>{sign}{self.body(piece)}</math>")
        return tuple(out)
