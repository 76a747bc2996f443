"""Exact elements as expressions of SymPy."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from gd_analyze.errors import UsageError
from gd_analyze.harmonics.equations import Equation

if TYPE_CHECKING:
    import sympy


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
