"""Exact equations and base (minimal) inertial parameters as text and as results."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, field

from gd_analyze.dynamics.base_parameters import BaseParameters
from gd_analyze.formulas.base_symbols import BaseSymbols, parted_name
from gd_analyze.formulas.formula import Formula, Piece, Product, Symbol
from gd_analyze.formulas.languages import LatexPrinter, MathML, Plain, Written, formatted
from gd_analyze.formulas.languages import equation_part as written_equations
from gd_analyze.formulas.scripts import (
    comment,
    factor_documents,
    sympy_factors,
    sympy_name,
    sympy_sum,
    sympy_symbols,
    variable_names,
)
from gd_analyze.formulas.writing import base_formula, element_formula, factor_legend, powers
from gd_analyze.harmonics.equations import Equation
from gd_analyze.harmonics.terms import Factor
from gd_analyze.harmonics.transform import Harmonics
from gd_analyze.result import Column, Fact, Part, Result, Shown, Table, Value


class WrittenElements(tuple[Equation, ...]):
    """Exact equations of elements; they print as text and, in a notebook, as mathematics."""

    __slots__ = ()

    def __str__(self) -> str:
        return repr(self._written)

    def _repr_latex_(self) -> str:
        return self._written._repr_latex_()

    @property
    def _written(self) -> Written:
        return Written(tuple(map(element_formula, self)))


def equation_text(equation: Equation, form: str, digits: int, width: int) -> str:
    """Write one equation in a format, with its line feed."""
    if form == "sympy":
        return f"{sympy_line(equation)}\n"
    formula = element_formula(equation)
    if form == "text":
        return f"{Plain(digits).wrapped(formula, width)}\n"
    return f"{(LatexPrinter(digits) if form == 'latex' else MathML(digits)).line(formula)}\n"


def sympy_head(n_joints: int) -> str:
    """Beginning of a SymPy script: imports and symbols."""
    lines = ("from sympy import Add, cos, sin, symbols", "", *sympy_symbols(variable_names(n_joints)), "")
    return "".join(f"{line}\n" for line in lines)


def sympy_line(equation: Equation) -> str:
    """Definition of an element in a script, with every digit of the coefficients."""
    products = ["*".join([repr(term.coefficient), *sympy_factors(term.factors)]) for term in equation.terms]
    return sympy_sum(sympy_name(equation.symbol), products or ["0"])


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
        units = "Units: kg, m, s, rad"
        if self.whole:
            units += "; D is symmetric, and elements not shown are zero"
        if self.has_christoffel:
            units += "; h_i is the sum over j and k of h_ijk qd_j qd_k, and h_ikj = h_ijk"
        legend = ", ".join(Plain().legend(factor_legend(self.factors)))
        return comment(
            (f"{arm.title or arm.name}: {self.terms} terms{cut}", units, legend), self.form, self.width
        )


def equations_result(
    harmonics: Harmonics, elements: Sequence[Equation], terms: int, form: str, body: str, digits: int
) -> Result:
    """Facts of the exact equations, and a table of terms for each of the elements."""
    arm = harmonics.arm
    documents = [
        asdict(equation)
        | {"terms": [asdict(term) | {"factors": factor_documents(term.factors)} for term in equation.terms]}
        for equation in elements
    ]
    return Result(
        title=f"{arm.title or arm.name}: exact equations",
        facts=(
            Value("arm", arm.name),
            Shown("Terms", str(terms)),
            Value("noise", dict(zip(("inertia", "potential"), harmonics.noise, strict=True))),
            Value("gap", harmonics.gap),
            Value("equations", documents),
            Value("format", form),
            Value("written", body),
        ),
        parts=tuple(_table(equation, digits) for equation in elements),
    )


def _table(equation: Equation, digits: int) -> Table:
    terms, plain = equation.terms, Plain()
    products = [plain.product(Product(1.0, powers(term.factors))) for term in terms]
    return Table(
        None,
        f"{equation.symbol} ({equation.unit})",
        (
            Column("term", products, shown="text"),
            Column("coefficient", [formatted(term.coefficient, digits) for term in terms], shown="text"),
            Column("effect", [term.effect for term in terms], shown="text"),
            Column("links", [_spans(term.links) for term in terms], shown="text"),
            Column("share", [term.share for term in terms], shown="percent"),
        ),
        note="" if terms else "zero",
    )


def _spans(links: tuple[int, ...]) -> str:
    """Write 2-4, 6 for 2, 3, 4, 6."""
    starts = [s for s in links if s - 1 not in links]
    ends = [s for s in links if s + 1 not in links]
    return ", ".join(str(a) if a == b else f"{a}-{b}" for a, b in zip(starts, ends, strict=True))


def base_equations(
    base: BaseParameters, form: str, digits: int, symbols: BaseSymbols | None = None
) -> Iterable[str]:
    """MX2 = mx2 + 0.432 m3..6 = 3.8 kg m, a line each; in symbols mx2 and others follow."""
    printer = LatexPrinter(digits) if form == "latex" else Plain(digits)
    formulas = map(base_formula, base) if symbols is None else symbols.formulas()
    for parameter, formula in zip(base, formulas, strict=True):
        unit = f" {parameter.unit}"
        if form == "latex":
            unit = rf" \; \mathrm{{{parameter.unit.replace(' ', '~')}}}"
        yield f"{printer.line(formula)} = {printer.sum((Product(parameter.number),))}{unit}"
    if symbols is not None:
        yield from map(printer.line, symbols.definitions())


def base_parameters_result(
    base: BaseParameters, form: str, text: str, digits: int, symbols: BaseSymbols | None = None
) -> Result:
    """The parameters with their combinations, the acting parameters of every link, and the frames."""
    effects = ("number", "translation", "rotation", *(("drive",) if base.drives else ()))
    of_effects = {
        name: [formatted(getattr(parameter, name), digits) for parameter in base] for name in effects
    }
    links = range(1, base.arm.n_joints + 1)
    acting = zip(*(_acting(base, link) for link in links), strict=True)
    vectors = {
        "origin": [frame.translation for frame in base.frames],
        "x": [frame.rotation[:, 0] for frame in base.frames],
        "z": [frame.rotation[:, 2] for frame in base.frames],
    }
    of_axes = {
        name: [" ".join(formatted(x, digits) for x in vector) for vector in by_frame]
        for name, by_frame in vectors.items()
    }
    zeros = sum(parameter.number == 0.0 for parameter in base)
    parameters = [
        asdict(parameter) | {"combination": [s._asdict() for s in parameter.combination]}
        for parameter in base
    ]
    return Result(
        title=f"{base.arm.title or base.arm.name}: base (minimal) inertial parameters",
        facts=(
            Value("arm", base.arm.name),
            Fact("drives", "Drives included", base.drives),
            Shown("Base parameters", str(len(base)), note=f"of {len(base.original)} parameters"),
            Shown("Base parameters that are zero", str(zeros)),
            Value("parameters", parameters),
            Value("acting_alone", [{"kind": kind, "link": link} for kind, link in base.acting_alone]),
            Value("never_acting", [{"kind": kind, "link": link} for kind, link in base.never_acting]),
            Value("frames", [asdict(frame) for frame in base.frames]),
            *([] if symbols is None else [Value("symbols", dict(symbols.values))]),
            Value("format", form),
            Value("written", text),
        ),
        parts=(
            _texts(
                "Base parameters",
                "Translation: masses at their centres. Rotation: inertias about these. Pxx, Pxy, ... are "
                "second moments, Ixx = Pyy + Pzz, Ixy = -Pxy; m3..6 = m3 + m4 + m5 + m6.",
                symbol=[parameter.symbol for parameter in base],
                **of_effects,
                unit=[parameter.unit for parameter in base],
            ),
            *_combinations(base, symbols, digits),
            _texts(
                "Effect of the links' parameters on the torques",
                link=[*map(str, links)],
                **dict(zip(("alone", "combined", "never"), acting, strict=True)),
            ),
            _texts(
                "Frames of the parameters: origin (m) and axes in the link's own frame",
                link=[*map(str, links)],
                **of_axes,
            ),
        ),
    )


def _combinations(base: BaseParameters, symbols: BaseSymbols | None, digits: int) -> list[Part]:
    """The combinations; in symbols with what their parameters and symbols stand for."""
    if symbols is None:
        return [written_equations(None, "Combinations", map(base_formula, base), digits=digits)]
    note = (
        "Centre (x2, y2, z2) and inertia about it (I2xx, ...) are in link frame 2; what is zero is left out."
    )
    values = [
        Formula(Symbol(*parted_name(name)), (Piece(Product(value)),))
        for name, value in symbols.values.items()
    ]
    return [
        written_equations("combinations", "Combinations", symbols.formulas(), digits=digits),
        written_equations(
            "links", "Parameters of the links", symbols.definitions(), note=note, digits=digits
        ),
        written_equations(None, "Symbols, SI units", values, digits=digits),
    ]


def _texts(title: str, note: str = "", /, **columns: Sequence[str]) -> Table:
    texts = tuple(Column(name, cells, shown="text") for name, cells in columns.items())
    return Table(None, title, texts, note)


def _acting(base: BaseParameters, link: int) -> tuple[str, str, str]:
    """Parameters of a link that act alone, in combination only, and never."""
    of_link = [kind for kind, parameter_link in base.original if parameter_link == link]
    alone = [kind for kind in of_link if (kind, link) in base.acting_alone]
    never = [kind for kind in of_link if (kind, link) in base.never_acting]
    combined = [kind for kind in of_link if kind not in (*alone, *never)]
    return _named(alone, of_link), _named(combined, of_link), _named(never, of_link)


def _named(kinds: Sequence[str], of_link: Sequence[str]) -> str:
    """Names of a link's parameters, or "all but" and the names excluded if these are fewer."""
    excluded = [kind for kind in of_link if kind not in kinds]
    if len(excluded) < len(kinds) - 1:
        return f"all but {' '.join(excluded)}" if excluded else "all"
    return " ".join(kinds)
