"""Formulas in plain characters: tau2 = tau3 + 3.8 pd2 + (0.77 S3 - 0.02 C3) p2 p3 - 37.2 C2."""

from __future__ import annotations

from collections.abc import Iterable

from gd_analyze.formulas.formula import Formula, Legend, Symbol
from gd_analyze.formulas.printer import PRIME, Printer
from gd_analyze.result import Equations


class Plain(Printer):
    """Writes C23 S4² pd3 and 5.85e-5; p is a rate already, so that one dot goes without a d."""

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
