"""Exact elements as SymPy expressions, and as a script that makes them."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from gd_analyze.errors import UsageError
from gd_analyze.formulas.writing import exponents
from gd_analyze.harmonics.equations import Equation, Term
from gd_analyze.harmonics.terms import Factor

if TYPE_CHECKING:
    import sympy


# Python's parser takes a sum of thousands only as arguments of a function.
_SUMMED = 50


def to_sympy(equation: Equation) -> sympy.Expr:
    """Build the right-hand side in real symbols q1, q2, ..., with every digit of the coefficients.

    Raises
    ------
    UsageError
        If SymPy is not installed.
    """
    try:
        import sympy
    except ImportError:
        raise UsageError(
            "SymPy is not installed", next_step="install it: pip install 'gd-analyze[symbolic]'"
        ) from None

    functions: dict[str, Callable[[Any], Any]] = {"cos": sympy.cos, "sin": sympy.sin, "power": lambda x: x}
    summands = []
    for term in equation.terms:
        product: Any = sympy.Float(term.coefficient, 17)
        for factor in term.factors:
            argument = sum(factor.multiples[j] * sympy.Symbol(f"q{j + 1}", real=True) for j in factor.joints)
            product *= functions[factor.kind](argument)
        summands.append(product)
    return sympy.Add(*summands)


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
