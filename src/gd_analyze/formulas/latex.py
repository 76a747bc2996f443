"""Formulas in LaTeX, for mathematics mode."""

from __future__ import annotations

from gd_analyze.formulas.formula import Symbol
from gd_analyze.formulas.printer import PRIME, Printer

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
