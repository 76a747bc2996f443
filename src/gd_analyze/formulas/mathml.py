"""Formulas in presentation MathML, which browsers show without a script or a font of the page's own."""

from __future__ import annotations

import re
from itertools import groupby

from gd_analyze.formulas.formula import Formula, Legend, Symbol
from gd_analyze.formulas.printer import Printer

_THIN, _SPACE = '<mspace width=".16em"/>', '<mspace width=".3em"/>'
_DOTS = ("", "˙", "¨")
_GREEK = {"tau": "τ", "omega": "ω"}


class MathML(Printer):
    """Writes a formula as one element."""

    apart = close = between = ""
    brackets = ("<mo>(</mo>", "<mo>)</mo>")

    def sign(self, negative: bool, first: bool) -> str:
        """Write the sign of a summand; the first one's only where it is negative."""
        return "<mo>−</mo>" if negative else "" if first else "<mo>+</mo>"

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write a letter with its accent, index and superscript."""
        base = f"<mi>{_GREEK.get(symbol.letter, symbol.letter)}</mi>"
        if symbol.dots:
            base = f'<mover accent="true">{base}<mo stretchy="false">{_DOTS[symbol.dots]}</mo></mover>'
        index = _index(symbol.index)
        above = f"<mtext>{symbol.word}</mtext>" if symbol.word else _exponent(exponent)
        if symbol.primes:
            primes = f"<mo>{'′' * symbol.primes}</mo>"
            above = f"<mrow>{primes}{above}</mrow>" if above else primes
        tag = f"m{'sub' if index else ''}{'sup' if above else ''}"
        return f"<{tag}>{base}{index}{above}</{tag}>" if index or above else base

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write cos or sin with its argument in brackets."""
        head = f"<mi>{name}</mi>"
        if exponent != 1:
            head = f"<msup>{head}{_exponent(exponent)}</msup>"
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
        return f"{_SPACE}<mtext>{words.strip()}</mtext>"

    def line(self, formula: Formula) -> str:
        """Write a formula in one line."""
        unit = self.words(f"in {formula.unit}") if formula.unit else ""
        content = f"{self.symbol(formula.left)}<mo>=</mo>{self.right(formula)}{unit}"
        return f"<math><mrow>{content}</mrow></math>"

    def legend(self, legend: Legend) -> tuple[str, ...]:
        """Write what names mean, one entry each."""
        otherwise = self.words("otherwise") if legend.shared else ""
        others = (
            f"<math>{self.symbol(other.left)}<mo>=</mo>{self.right(other)}{otherwise}</math>"
            for other in legend.others
        )
        return (*map(self.line, legend.shared), *others, *map(self.line, legend.factors))


class PageMathML(MathML):
    """Writes a formula as several elements, between which a browser may break a line."""

    # Browsers set factors without any space between them, and brackets larger than what is in them.
    apart = _THIN
    brackets = ('<mo stretchy="false">(</mo>', '<mo stretchy="false">)</mo>')

    def left(self, formula: Formula) -> str:
        """Write the left-hand side and the sign of equality."""
        return f"<math>{self.symbol(formula.left)}<mo>=</mo></math>"

    def elements(self, formula: Formula) -> tuple[str, ...]:
        """Write the right-hand side, an element per piece."""
        out = []
        for place, piece in enumerate(formula.pieces):
            sign = self.sign(piece.negative, first=place == 0)
            if place:
                # At the beginning of an element browsers take it for a prefix, without any space behind it.
                sign = sign.replace("<mo>", '<mo rspace=".25em">')
            out.append(f"<math>{sign}{self.body(piece)}</math>")
        return tuple(out)

    def by_quantity(self, formula: Formula) -> tuple[tuple[str, tuple[str, ...]], ...]:
        """Write the right-hand side as quantities, each with its elements."""
        both = zip(formula.pieces, self.elements(formula), strict=True)
        groups = groupby(both, key=lambda pair: pair[0].quantity)
        return tuple((quantity, tuple(element for _, element in group)) for quantity, group in groups)


def _index(index: str) -> str:
    """Write numbers upright and letters, one by one, slanted."""
    parts = re.findall(r"[^a-z]+|[a-z]", index)
    written = "".join(f"<mi>{part}</mi>" if part.isalpha() else f"<mn>{part}</mn>" for part in parts)
    return f"<mrow>{written}</mrow>" if len(parts) > 1 else written


def _exponent(exponent: int) -> str:
    return f"<mn>{exponent}</mn>" if exponent != 1 else ""
