"""Formulas of an arm's dynamics as values, and what writes them in a language."""

from gd_analyze.formulas.formula import Formula, Function, Legend, Piece, Power, Product, Summand, Symbol
from gd_analyze.formulas.latex import Latex
from gd_analyze.formulas.legend import element_legend, torque_legend
from gd_analyze.formulas.mathml import MathML, PageMathML
from gd_analyze.formulas.numbers import number, rounded
from gd_analyze.formulas.parts import part_symbol, parts_formulas
from gd_analyze.formulas.plain import Plain
from gd_analyze.formulas.sympy import to_sympy
from gd_analyze.formulas.typst import Typst
from gd_analyze.formulas.writing import (
    element_formula,
    energy_formulas,
    exponents,
    powers,
    term_formula,
    torque_formulas,
)

__all__ = [
    "Formula",
    "Function",
    "Latex",
    "Legend",
    "MathML",
    "PageMathML",
    "Piece",
    "Plain",
    "Power",
    "Product",
    "Summand",
    "Symbol",
    "Typst",
    "element_formula",
    "element_legend",
    "energy_formulas",
    "exponents",
    "number",
    "part_symbol",
    "parts_formulas",
    "powers",
    "rounded",
    "term_formula",
    "to_sympy",
    "torque_formulas",
    "torque_legend",
]
