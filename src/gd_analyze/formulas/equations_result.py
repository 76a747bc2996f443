"""Exact equations as a file with a heading, and as a result with a table of terms per element."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from gd_analyze.formulas.formula import Product
from gd_analyze.formulas.languages import Latex, MathML, Plain
from gd_analyze.formulas.printer import number
from gd_analyze.formulas.writing import element_formula, exponents, factor_legend, powers
from gd_analyze.harmonics.equations import Equation, Term
from gd_analyze.harmonics.terms import Factor
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.result import Column, Fact, Result, Table
from gd_analyze.text import visible

# Beginning and end of a comment in each format.
COMMENTS = {"text": ("", ""), "latex": ("% ", ""), "mathml": ("<!-- ", " -->"), "sympy": ("# ", "")}
# Python's parser takes a sum of thousands only as arguments of a function.
_SUMMED = 50


def equation_text(equation: Equation, form: str, digits: int, width: int) -> str:
    """Write one equation in a format, with its line feed."""
    if form == "sympy":
        return f"{sympy_line(equation)}\n"
    formula = element_formula(equation)
    if form == "text":
        return f"{Plain(digits).wrapped(formula, width)}\n"
    return f"{(Latex(digits) if form == 'latex' else MathML(digits)).line(formula)}\n"


def sympy_head(n_joints: int) -> str:
    """Beginning of a script of SymPy: imports and symbols."""
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
    products = []
    for term in equation.terms:
        factors = (f"{_sympy(factor)}{f'**{n}' * (n > 1)}" for factor, n in exponents(term.factors))
        products.append("*".join([repr(term.coefficient), *factors]))
    if len(products) > _SUMMED:
        return f"{left}Add(\n" + "".join(f"    {product},\n" for product in products) + ")"
    return left + (" + ".join(products).replace("+ -", "- ") or "0")


def _sympy(factor: Factor) -> str:
    angles = [f"{m}*q{j + 1}" for j, m in enumerate(factor.multiples) if m]
    argument = re.sub(r"\b1\*", "", " + ".join(angles)).replace("+ -", "- ")
    return argument if factor.kind == "power" else f"{factor.kind}({argument})"


@dataclass
class Heading:
    """Arm, number of terms, units and legend, as a comment of the format."""

    width: int
    harmonics: Harmonics
    form: str
    min_share: float
    whole: bool
    terms: int = 0
    has_christoffel: bool = False
    factors: set[Factor] = field(default_factory=set)

    def note(self, equation: Equation) -> None:
        """Count an equation, and collect its factors."""
        self.terms += len(equation.terms)
        self.has_christoffel |= equation.symbol.startswith("h")
        self.factors.update(factor for term in equation.terms for factor in term.factors)

    def __str__(self) -> str:
        arm = self.harmonics.arm
        cut = f", shares of at least {100 * self.min_share:g} %" if self.min_share > 0 else ""
        units = "Units: kg, m, s, rad" + "; D is symmetric, and elements not shown are zero" * self.whole
        if self.has_christoffel:
            units += "; h_i is the sum over j and k of h_ijk qd_j qd_k, and h_ikj = h_ijk"
        legend = ", ".join(Plain().legend(factor_legend(self.factors)))
        before, after = COMMENTS[self.form]
        room, out = self.width - len(before) - len(after), ""
        for text in filter(None, (f"{arm.title or arm.name}: {self.terms} terms{cut}", units, legend)):
            # Two hyphens would end a comment of XML.
            safe = re.sub("-(?=-)", "- ", text) if self.form == "mathml" else text
            out += "".join(f"{before}{piece}{after}\n" for piece in textwrap.wrap(f"{visible(safe)}.", room))
        return f"{out}\n"


def equations_result(
    harmonics: Harmonics, found: Sequence[Equation], terms: int, form: str, body: str, digits: int
) -> Result:
    """Facts of the exact equations, and a table of terms for each of those found."""

    def document(term: Term) -> dict[str, Any]:
        factors = [factor._asdict() | {"exponent": power} for factor, power in exponents(term.factors)]
        return asdict(term) | {"factors": factors}

    arm = harmonics.arm
    return Result(
        title=f"{arm.title or arm.name}: exact equations",
        facts=(
            Fact("arm", "", arm.name),
            Fact("", "Terms", terms, shown="count"),
            Fact("noise", "", dict(zip(("inertia", "potential"), harmonics.noise, strict=True))),
            Fact("gap", "", harmonics.gap),
            Fact("equations", "", [asdict(one) | {"terms": [*map(document, one.terms)]} for one in found]),
            Fact("format", "", form),
            Fact("written", "", body),
        ),
        parts=tuple(_table(equation, digits) for equation in found),
    )


def _table(equation: Equation, digits: int) -> Table:
    terms, plain = equation.terms, Plain()
    products = [plain.product(Product(1.0, powers(term.factors))) for term in terms]
    return Table(
        "",
        f"{equation.symbol} ({equation.unit})",
        (
            Column("", "term", products, shown="text"),
            Column("", "coefficient", [number(term.coefficient, digits) for term in terms], shown="text"),
            Column("", "effect", [term.effect for term in terms], shown="text"),
            Column("", "links", [_spans(term.links) for term in terms], shown="text"),
            Column("", "share", [term.share for term in terms], shown="percent"),
        ),
        note="" if terms else "zero",
    )


def _spans(links: tuple[int, ...]) -> str:
    """Write 2-4, 6 for 2, 3, 4, 6."""
    starts = [s for s in links if s - 1 not in links]
    ends = [s for s in links if s + 1 not in links]
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in zip(starts, ends, strict=True))
