"""Comments of a format, lines of a SymPy script, and factors for JSON."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

from gd_analyze.formulas.writing import exponents
from gd_analyze.harmonics.terms import Monomial
from gd_analyze.text import visible

# Beginning and end of a comment in each format.
_COMMENTS = {"text": ("", ""), "latex": ("% ", ""), "mathml": ("<!-- ", " -->"), "sympy": ("# ", "")}
# Python's parser accepts a sum of thousands only as arguments of a function.
_MOST_SUMMANDS = 50


def variable_names(n_joints: int) -> list[str]:
    """Names of the joints' variables: q1, q2, ..."""
    return [f"q{joint + 1}" for joint in range(n_joints)]


def sympy_symbols(names: Sequence[str]) -> Iterator[str]:
    """Definitions of real symbols, ten in a line."""
    for start in range(0, len(names), 10):
        line = names[start : start + 10]
        yield f'({", ".join(line)},) = symbols("{" ".join(line)}", real=True, seq=True)'


def sympy_name(symbol: str) -> str:
    """Name of an element in a script: Python's names have no comma between indices of two digits."""
    return symbol.replace(",", "_")


def sympy_sum(name: str, products: Sequence[str]) -> str:
    """Definition of a name as a sum."""
    if len(products) > _MOST_SUMMANDS:
        return f"{name} = Add(\n" + "".join(f"    {product},\n" for product in products) + ")"
    return f"{name} = " + " + ".join(products).replace("+ -", "- ")


def sympy_factors(factors: Monomial, angles: Sequence[str] = ()) -> Iterator[str]:
    """Sines, cosines and variables in a script; behind the joints' variables come constant `angles`."""
    for factor, exponent in exponents(factors):
        names = (*variable_names(len(factor.multiples) - len(angles)), *angles)
        summands = [f"{m}*{name}" for m, name in zip(factor.multiples, names, strict=True) if m]
        argument = re.sub(r"\b1\*", "", " + ".join(summands)).replace("+ -", "- ")
        base = argument if factor.kind == "power" else f"{factor.kind}({argument})"
        yield f"{base}**{exponent}" if exponent > 1 else base


def comment(sentences: Iterable[str], form: str, width: int) -> str:
    """Sentences as a comment of a format, and an empty line."""
    before, after = _COMMENTS[form]
    out = ""
    for sentence in filter(None, sentences):
        # Two hyphens would end an XML comment.
        safe = re.sub("-(?=-)", "- ", sentence) if form == "mathml" else sentence
        lines = textwrap.wrap(f"{visible(safe)}.", width - len(before) - len(after))
        out += "".join(f"{before}{line}{after}\n" for line in lines)
    return f"{out}\n"


def factor_documents(factors: Monomial) -> list[dict[str, Any]]:
    """Factors of a term and their exponents, for JSON."""
    return [factor._asdict() | {"exponent": exponent} for factor, exponent in exponents(factors)]
