"""Formulas in Typst's mathematics."""

from __future__ import annotations

import re

from gd_analyze.formulas.formula import Symbol
from gd_analyze.formulas.printer import PRIME, Printer

_DOTS = ("", "dot", "dot.double")


class Typst(Printer):
    """Writes C_(23) and 5.85 times 10^(-5)."""

    apart = close = " thin "
    brackets = ("paren.l ", " paren.r")

    def symbol(self, symbol: Symbol, exponent: int = 1) -> str:
        """Write tau_(1), dot.double(q)_(2), C_(23)^2, D_(12)^"tran"."""
        base = f"{_DOTS[symbol.dots]}({symbol.letter})" if symbol.dots else symbol.letter
        base += PRIME * symbol.primes
        # Letters side by side would be one name.
        index = f"_({re.sub('(?<=.)(?=[a-z])', ' ', symbol.index)})" if symbol.index else ""
        word = f'^"{symbol.word}"' if symbol.word else ""
        return f"{base}{index}{word}{_raised(exponent)}"

    def function(self, name: str, argument: str, exponent: int) -> str:
        """Write cos^2(2 thin q_(2) - q_(3))."""
        return f"{name}{_raised(exponent)}({argument})"

    def scientific(self, mantissa: str, exponent: int) -> str:
        """Write 5.85 times 10^(-5)."""
        return f"{mantissa} times 10^({exponent})"

    def words(self, words: str) -> str:
        """Write words with the spaces about them."""
        return words.replace(words.strip(), f'"{words.strip()}"')


def _raised(exponent: int) -> str:
    return f"^{exponent}" if exponent != 1 else ""
