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
from gd_analyze.formulas.sympy import sympy_line
from gd_analyze.formulas.writing import element_formula, exponents, factor_legend, powers
from gd_analyze.harmonics.equations import Equation
from gd_analyze.harmonics.terms import Factor
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.result import Column, Fact, Result, Table
from gd_analyze.text import visible

# Beginning and end of a comment in each format.
COMMENTS = {"text": ("", ""), "latex": ("% ", ""), "mathml": ("<!-- ", " -->"), "sympy": ("# ", "")}


def equation_text(equation: Equation, form: str, digits: int, width: int) -> str:
    """Write one equation in a format, with its line feed."""
    if form == "sympy":
        return f"{sympy_line(equation)}\n"
    formula = element_formula(equation)
    if form == "text":
        return f"{Plain(digits).wrapped(formula, width)}\n"
    return f"{(Latex(digits) if form == 'latex' else MathML(digits)).line(formula)}\n"


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
        from gd_analyze.formulas.languages import Plain

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
            pieces = textwrap.wrap(f"{visible(safe)}.", room)
            out += "".join(f"{before}{piece}{after}\n" for piece in pieces)
        return f"{out}\n"


def equations_result(
    harmonics: Harmonics, found: Sequence[Equation], terms: int, form: str, body: str, digits: int
) -> Result:
    """Facts of the exact equations, and a table of terms for each of those found."""

    def term_document(term: Any) -> dict[str, Any]:
        factors = [factor._asdict() | {"exponent": power} for factor, power in exponents(term.factors)]
        return asdict(term) | {"factors": factors}

    arm = harmonics.arm
    documents = [asdict(one) | {"terms": [*map(term_document, one.terms)]} for one in found]
    return Result(
        title=f"{arm.title or arm.name}: exact equations",
        facts=(
            Fact("arm", "", arm.name),
            Fact("", "Terms", terms, shown="count"),
            Fact("noise", "", dict(zip(("inertia", "potential"), harmonics.noise, strict=True))),
            Fact("gap", "", harmonics.gap),
            Fact("equations", "", documents),
            Fact("format", "", form),
            Fact("written", "", body),
        ),
        parts=tuple(_table(equation, digits) for equation in found),
    )


def _table(equation: Equation, digits: int) -> Table:

    terms = equation.terms
    products = [Plain().product(Product(1.0, powers(term.factors))) for term in terms]
    coefficients = [number(term.coefficient, digits) for term in terms]
    return Table(
        "",
        f"{equation.symbol} ({equation.unit})",
        (
            Column("", "term", products, shown="text"),
            Column("", "coefficient", coefficients, shown="text"),
            Column("", "effect", [term.effect for term in terms], shown="text"),
            Column("", "links", [_spans(term.links) for term in terms], shown="text"),
            Column("", "share", [term.share for term in terms], shown="percent"),
        ),
        note="" if terms else "zero",
    )


def _spans(links: tuple[int, ...]) -> str:
    """Write 2-4, 6 for 2, 3, 4, 6."""
    spans: list[list[int]] = []
    for s in links:
        if spans and s == spans[-1][-1] + 1:
            spans[-1].append(s)
        else:
            spans.append([s])
    return ", ".join(str(span[0]) if len(span) == 1 else f"{span[0]}-{span[-1]}" for span in spans)
