"""Formulas in plain characters: tau2 = tau3 + 3.8 pd2 + (0.77 S3 - 0.02 C3) p2 p3 - 37.2 C2."""

from __future__ import annotations

import re
from collections.abc import Iterable
from itertools import groupby

from gd_analyze.formulas.formula import Formula, Legend, Symbol
from gd_analyze.formulas.printer import PRIME, Printer
from gd_analyze.result import Equations


class Plain(Printer):
    """Writes C23 S4² pd3 and 5.85e-5; p is a velocity already, so that one dot goes without a d."""

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write tau1, qdd2, C9,10², p_j, D12^tran, omegad'3x."""
        dots = symbol.dots - (symbol.letter == "p")
        index = f"_{symbol.index}" if symbol.index.isalpha() else symbol.index
        word = f"^{symbol.word}" if symbol.word else ""
        return f"{symbol.letter}{'d' * dots}{PRIME * symbol.primes}{index}{word}{_superscript(exponent)}"

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write cos²(2 q2 - q3)."""
        return f"{name}{_superscript(exponent)}({argument})"

    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write 5.85e-5."""
        return f"{mantissa}e{exponent}"

    def wrapped(self, formula: Formula, width: int) -> str:
        """Write a formula in lines no longer than this, unless a single piece is, with a hanging indent."""
        start = f"{self.symbol(formula.left)} = "
        first, *others = self.pieces(formula)
        lines = [start + first]
        for piece in others:
            if len(lines[-1]) + 1 + len(piece) <= width:
                lines[-1] += " " + piece
            else:
                lines.append(" " * len(start) + piece)
        return "\n".join(lines)


def _superscript(exponent: int) -> str:
    return str(exponent).translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹")) if exponent != 1 else ""


def equations(
    key: str,
    title: str,
    formulas: Iterable[Formula],
    legend: Legend | None = None,
    note: str = "",
    digits: int = 3,
) -> Equations:
    """Make formulas a part of a result, weights with so many digits."""
    plain, formulas = Plain(digits), tuple(formulas)
    explained = () if legend is None else plain.legend(legend)
    return Equations(key, title, tuple(map(plain.line, formulas)), formulas, legend, explained, note)


_DOTS = ("", r"\dot", r"\ddot")
_GREEK = {"tau": r"\tau", "omega": r"\omega"}


class Latex(Printer):
    r"""Writes C_{23} and 5.85 \cdot 10^{-5}."""

    apart = r" \, "

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        r"""Write \tau_{1}, \ddot{q}_{2}, C_{23}^{2}, D_{12}^{\mathrm{tran}}."""
        letter = _GREEK.get(symbol.letter, symbol.letter)
        base = f"{_DOTS[symbol.dots]}{{{letter}}}" if symbol.dots else letter
        base += PRIME * symbol.primes
        index = f"_{{{symbol.index}}}" if symbol.index else ""
        word = rf"^{{\mathrm{{{symbol.word}}}}}" if symbol.word else ""
        return f"{base}{index}{word}{_raised(exponent)}"

    def function(self, name: str, argument: str, exponent: int) -> str:
        r"""Write \cos^{2}(2 q_{2} - q_{3})."""
        return rf"\{name}{_raised(exponent)}({argument})"

    def words(self, words: str) -> str:
        r"""Write \text{ is }."""
        return rf"\text{{{words}}}"

    def scientific(self, mantissa: str, exponent: int) -> str:
        r"""Write 5.85 \cdot 10^{-5}."""
        return rf"{mantissa} \cdot 10^{{{exponent}}}"


def _raised(exponent: int) -> str:
    return f"^{{{exponent}}}" if exponent != 1 else ""


_TYPST_DOTS = ("", "dot", "dot.double")


class Typst(Printer):
    """Writes C_(23) and 5.85 times 10^(-5)."""

    apart = close = " thin "
    brackets = ("paren.l ", " paren.r")

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write tau_(1), dot.double(q)_(2), C_(23)^2, D_(12)^"tran"."""
        base = f"{_TYPST_DOTS[symbol.dots]}({symbol.letter})" if symbol.dots else symbol.letter
        base += PRIME * symbol.primes
        # Letters side by side would be one name.
        index = f"_({re.sub('(?<=.)(?=[a-z])', ' ', symbol.index)})" if symbol.index else ""
        word = f'^"{symbol.word}"' if symbol.word else ""
        return f"{base}{index}{word}{_typst_raised(exponent)}"

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write cos^2(2 thin q_(2) - q_(3))."""
        return f"{name}{_typst_raised(exponent)}({argument})"

    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write 5.85 times 10^(-5)."""
        return f"{mantissa} times 10^({exponent})"

    def words(self, words: str) -> str:
        """Write words with the spaces about them."""
        return words.replace(words.strip(), f'"{words.strip()}"')


def _typst_raised(exponent: int) -> str:
    return f"^{exponent}" if exponent != 1 else ""


_THIN, _SPACE = '<mspace width=".16em"/>', '<mspace width=".3em"/>'
_ACCENTS = ("", "˙", "¨")
_GREEK_LETTERS = {"tau": "τ", "omega": "ω"}


class MathML(Printer):
    """Writes a formula as one element."""

    apart = close = between = ""
    brackets = ("<mo>(</mo>", "<mo>)</mo>")

    def sign(self, negative: bool, first: bool) -> str:
        """Write the sign of a summand; the first one's only where it is negative."""
        return "<mo>−</mo>" if negative else "" if first else "<mo>+</mo>"

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write a letter with its accent, index and superscript."""
        base = f"<mi>{_GREEK_LETTERS.get(symbol.letter, symbol.letter)}</mi>"
        if symbol.dots:
            base = f'<mover accent="true">{base}<mo stretchy="false">{_ACCENTS[symbol.dots]}</mo></mover>'
        index = _mathml_index(symbol.index)
        above = f"<mtext>{symbol.word}</mtext>" if symbol.word else _mathml_exponent(exponent)
        if symbol.primes:
            primes = f"<mo>{'′' * symbol.primes}</mo>"
            above = f"<mrow>{primes}{above}</mrow>" if above else primes
        tag = f"m{'sub' if index else ''}{'sup' if above else ''}"
        return f"<{tag}>{base}{index}{above}</{tag}>" if index or above else base

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write cos or sin with its argument in brackets."""
        head = f"<mi>{name}</mi>"
        if exponent != 1:
            head = f"<msup>{head}{_mathml_exponent(exponent)}</msup>"
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


def _mathml_index(index: str) -> str:
    """Write numbers upright and letters, one by one, slanted."""
    parts = re.findall(r"[^a-z]+|[a-z]", index)
    written = "".join(f"<mi>{part}</mi>" if part.isalpha() else f"<mn>{part}</mn>" for part in parts)
    return f"<mrow>{written}</mrow>" if len(parts) > 1 else written


def _mathml_exponent(exponent: int) -> str:
    return f"<mn>{exponent}</mn>" if exponent != 1 else ""
