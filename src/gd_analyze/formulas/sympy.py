"""Exact elements as a script of SymPy, in real symbols q1, q2, .., with every digit of the coefficients."""

from __future__ import annotations

from gd_analyze.formulas.writing import exponents
from gd_analyze.harmonics.equations import Equation, Term
from gd_analyze.harmonics.terms import Factor

# Python's parser takes a sum of thousands only as arguments of a function.
_SUMMED = 50


def sympy_head(n_joints: int) -> str:
    """Beginning of a script: imports and symbols."""
    names = [f"q{j + 1}" for j in range(n_joints)]
    return (
        "from sympy import Add, cos, sin, symbols\n\n"
        f"({', '.join(names)}{',' if n_joints == 1 else ''}) = symbols({' '.join(names)!r}, "
        "real=True, seq=True)\n\n"
    )


def sympy_line(equation: Equation) -> str:
    """Definition of an element in a script, with every digit of the coefficients."""
    # No name in Python may hold the comma between indices of two digits.
    left = f"{equation.symbol.replace(',', '_')} = "
    products = [_product(term) for term in equation.terms]
    if len(products) > _SUMMED:
        return f"{left}Add(\n" + "".join(f"    {product},\n" for product in products) + ")"
    return left + (" + ".join(products).replace("+ -", "- ") or "0")


def _product(term: Term) -> str:
    powers = [
        _function(factor) + (f"**{exponent}" if exponent > 1 else "")
        for factor, exponent in exponents(term.factors)
    ]
    return "*".join([repr(term.coefficient), *powers])


def _function(factor: Factor) -> str:
    signed = [
        f"{'-' if m < 0 else ''}{f'{abs(m)}*' if abs(m) > 1 else ''}q{j + 1}"
        for j, m in enumerate(factor.multiples)
        if m
    ]
    argument = " + ".join(signed).replace("+ -", "- ")
    return argument if factor.kind == "power" else f"{factor.kind}({argument})"
