"""Equations with the arm's numbers as symbols: as text, LaTeX, MathML and a SymPy script, and as a result."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction
from itertools import groupby
from typing import Any

from gd_analyze.formulas import formula as parts
from gd_analyze.formulas.formula import NO_PIECES, CircularFunction, Formula, Piece, Power, Product, Symbol
from gd_analyze.formulas.languages import LatexPrinter, MathML, Plain, Printer
from gd_analyze.formulas.scripts import (
    comment,
    factor_documents,
    sympy_factors,
    sympy_name,
    sympy_sum,
    sympy_symbols,
    variable_names,
)
from gd_analyze.formulas.writing import QUANTITIES, exponents, factor_legend, part_symbol, powers
from gd_analyze.harmonics.arm_symbols import ArmSymbol
from gd_analyze.harmonics.symbolic import SymbolicElement, SymbolicEquations, SymbolicTerm, each_group
from gd_analyze.harmonics.terms import Factor
from gd_analyze.result import Result, Shown, Value
from gd_analyze.text import pretty

# Coefficients are sums of halves, quarters, ...: all their digits are written.
_ALL_DIGITS = 17
_PRINTERS: dict[str, Printer] = {
    "text": Plain(_ALL_DIGITS),
    "latex": LatexPrinter(_ALL_DIGITS),
    "mathml": MathML(_ALL_DIGITS),
}


def symbolic_text(equations: SymbolicEquations, form: str, width: int, heading: bool = True) -> str:
    """All equations and the values of symbols in a format, headed by a comment if asked."""
    lines = _script(equations) if form == "sympy" else _formulas(equations, form, width)
    body = "".join(f"{line}\n" for line in lines)
    return _heading(equations, form, width) + body if heading else body


def _formulas(equations: SymbolicEquations, form: str, width: int) -> Iterator[str]:
    printer = _PRINTERS[form]
    for formula in symbolic_formulas(equations):
        yield printer.wrapped(formula, width) if isinstance(printer, Plain) else printer.line(formula)
    if equations.symbols and form == "text":
        yield ""
    for symbol in equations.symbols:
        left, number = printer.symbol(_symbol(symbol)), _number(printer, symbol.number)
        if isinstance(printer, MathML):
            unit = printer.words(pretty(symbol.unit)) if symbol.unit else ""
            yield f"<math><mrow>{left}<mo>=</mo>{number}{unit}</mrow></math>"
        elif isinstance(printer, LatexPrinter):
            unit = symbol.unit.replace(" ", r" \, ").replace("^2", "^{2}")
            yield f"{left} = {number}" + (rf" \, \mathrm{{{unit}}}" if unit else "")
        else:
            yield f"{left} = {number} {symbol.unit}".rstrip()


def _number(printer: Printer, value: float) -> str:
    """A number with every digit."""
    mantissa, _, exponent = repr(abs(value)).partition("e")
    size = printer.scientific(mantissa, int(exponent)) if exponent else printer.plain_number(mantissa)
    return printer.sign(value < 0, first=True) + size


def symbolic_formulas(equations: SymbolicEquations) -> Iterator[Formula]:
    """Formulas of the elements' parts; a part that is zero beside another is left out."""
    for label, grouped in groupby(equations.elements, key=lambda element: element.label):
        parts_of_element = [*grouped]
        nonzero = [part for part in parts_of_element if part.terms]
        for part in nonzero:
            yield symbolic_formula(part, equations)
        if not nonzero:
            yield Formula(part_symbol(label), NO_PIECES)


def symbolic_formula(element: SymbolicElement, equations: SymbolicEquations) -> Formula:
    """Formula of one effect of an element: D12^tran = (m2 a1 a2 + m2 a1 x2) C2 + ..."""
    left = part_symbol(element.label, element.effect or "both")
    quantity = QUANTITIES[element.label[0]]
    pieces: list[Piece] = []
    for factors, terms in each_group(element):
        products = tuple(
            Product(term.coefficient, tuple(Power(_symbol(symbol), k) for symbol, k in _ordered(term)))
            for term in terms
        )
        pieces += parts.bracketed(quantity, products, _powers(factors, equations))
    return Formula(left, tuple(pieces) or NO_PIECES)


def _powers(factors: tuple[Factor, ...], equations: SymbolicEquations) -> tuple[Power, ...]:
    """Sines, cosines and distances; those of constant angles are written out: cos(alpha2)."""
    out: list[Power] = []
    for factor, exponent in exponents(factors):
        (*joints,) = factor.joints
        place = joints[0] - equations.arm.n_joints
        if place < 0:
            out += powers((factor,) * exponent)
        else:
            angle = Product(float(factor.multiples[joints[0]]), (Power(_symbol(equations.angles[place])),))
            out.append(Power(CircularFunction(factor.kind, (angle,)), exponent))
    return tuple(out)


def _ordered(term: SymbolicTerm) -> list[tuple[ArmSymbol, int]]:
    """Symbols with their exponents: masses and inertias, gravity, then lengths."""
    return sorted(term.symbols, key=lambda power: "mIg".find(power[0].letter) % 4)


def _symbol(symbol: ArmSymbol) -> Symbol:
    return Symbol(symbol.letter, symbol.index)


def _heading(equations: SymbolicEquations, form: str, width: int) -> str:
    """Arm, number of terms, units and legend, as a comment of the format."""
    arm = equations.arm
    letters = {element.label[0] for element in equations.elements}
    parted = " and ".join(letter for letter in "Dh" if letter in letters)
    effects = f"; {parted} = translation (tran) + rotation (rot)" if parted else ""
    effects += ", and parts not shown are zero" if parted and form != "sympy" else ""
    sentences = [
        f"{arm.title or arm.name}: {equations.n_terms} terms, with symbols for the arm's numbers",
        f"Units: kg, m, s, rad{effects}",
    ]
    if "h" in letters:
        sentences.append("h_i is the sum over j and k of h_ijk qd_j qd_k, and h_ikj = h_ijk")
    if form != "sympy":
        n = arm.n_joints
        factors = {
            factor._replace(multiples=factor.multiples[:n])
            for element in equations.elements
            for term in element.terms
            for factor in term.factors
            if factor.joints[0] < n
        }
        sentences.append(", ".join(Plain().legend(factor_legend(factors))))
    return comment(sentences, form, width)


def _script(equations: SymbolicEquations) -> Iterator[str]:
    """Lines of a SymPy script: symbols, their values, and the elements by effect."""
    names = [symbol.name for symbol in equations.symbols]
    yield "from sympy import Add, Integer, cos, sin, symbols"
    yield ""
    yield from sympy_symbols(variable_names(equations.arm.n_joints))
    yield from sympy_symbols(names)
    yield ""
    yield "# The arm's numbers, SI units."
    yield "values = {"
    for symbol in equations.symbols:
        yield f"    {symbol.name}: {symbol.number!r},{f'  # {symbol.unit}' if symbol.unit else ''}"
    yield "}"
    yield ""
    labels: dict[str, list[str]] = {}
    for element in equations.elements:
        label = sympy_name(element.label)
        name = f"{label}_{element.effect}" if element.effect else label
        labels.setdefault(label, []).append(name)
        yield sympy_sum(name, [_product(term, equations) for term in element.terms] or ["Integer(0)"])
        if element.effect == "rotation":
            yield sympy_sum(label, labels[label])


def _product(term: SymbolicTerm, equations: SymbolicEquations) -> str:
    """One term in Python, its coefficient as an exact fraction."""
    powers_of_symbols = ((symbol.name, exponent) for symbol, exponent in _ordered(term))
    factors = [f"{name}**{exponent}" if exponent > 1 else name for name, exponent in powers_of_symbols]
    factors += sympy_factors(term.factors, [angle.name for angle in equations.angles])
    weight = Fraction(term.coefficient)
    size = abs(weight.numerator)
    if size != 1 or not factors:
        factors.insert(0, f"Integer({size})" if not factors else str(size))
    quotient = "" if weight.denominator == 1 else f"/{weight.denominator}"
    return f"{'-' if weight < 0 else ''}{'*'.join(factors)}{quotient}"


def symbolic_equations_result(equations: SymbolicEquations, form: str, written: str) -> Result:
    """Facts of equations in symbols: the values of symbols, and what was written."""
    arm = equations.arm

    def document(element: SymbolicElement) -> dict[str, Any]:
        terms = [
            {
                "coefficient": term.coefficient,
                "symbols": {symbol.name: exponent for symbol, exponent in term.symbols},
                "factors": factor_documents(term.factors),
            }
            for term in element.terms
        ]
        return {"label": element.label, "effect": element.effect, "terms": terms}

    symbols = [
        {"symbol": symbol.name, "number": symbol.number, "unit": symbol.unit} for symbol in equations.symbols
    ]
    return Result(
        title=f"{arm.title or arm.name}: equations in symbols",
        facts=(
            Value("arm", arm.name),
            Shown("Terms", str(equations.n_terms)),
            Shown("Symbols", str(len(symbols))),
            Value("symbols", symbols),
            Value("angles", [angle.name for angle in equations.angles]),
            Value("equations", [document(element) for element in equations.elements]),
            Value("error", equations.error),
            Value("format", form),
            Value("written", written),
        ),
    )
