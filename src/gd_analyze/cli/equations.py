"""`gd-analyze equations`: the exact equations of motion of an arm."""

from __future__ import annotations

import re
import textwrap
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.base_parameters import give_parameters
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.options import digits_option, number_read, out_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.terminal import WIDTH, lines
from gd_analyze.text import visible

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gd_analyze.harmonics.equations import Equation
    from gd_analyze.harmonics.terms import Factor
    from gd_analyze.harmonics.transform import Harmonics
    from gd_analyze.result import Result, Table

# Beginning and end of a comment in each format.
_COMMENTS = {"text": ("", ""), "latex": ("% ", ""), "mathml": ("<!-- ", " -->"), "sympy": ("# ", "")}


class Share(click.ParamType[float]):
    """A share of 0 to 1, written 1% or 0.01."""

    name = "share"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it."""
        words = str(value).strip()
        number = number_read(words.removesuffix("%")) / (100 if words.endswith("%") else 1)
        if not 0 <= number <= 1:
            self.fail(f"{value!r} is not a share of 0 to 1, such as 1% or 0.01", param, ctx)
        return number


@click.command(short_help="Print the exact equations of motion.")
@robot_given
@click.option(
    "--element",
    "elements",
    metavar="LABEL",
    multiple=True,
    help="D12, h112 or c2; h1 for all h_1jk; D, h or c for all of a kind. May be repeated; all of them by "
    "default.",
)
@click.option(
    "--min-share",
    metavar="SHARE",
    type=Share(),
    default="0%",
    show_default=True,
    help="Leave out terms that stay below this share of the element's largest term.",
)
@click.option(
    "--format",
    "form",
    type=click.Choice([*_COMMENTS]),
    default="text",
    show_default=True,
    help="How to write them: sympy is a Python script, the others are one equation each.",
)
@click.option("--terms", is_flag=True, help="Print a table of terms for every element: effect, links, share.")
@click.option(
    "--parameters",
    is_flag=True,
    help="Print the base (minimal) inertial parameters instead, and the combinations of the links' masses, "
    "first moments and inertias that they are.",
)
@digits_option("Significant digits of coefficients; sympy keeps all.")
@out_option("Write the equations into this file.")
@reporting
def equations(
    robot: GivenRobot,
    elements: tuple[str, ...],
    min_share: float,
    form: str,
    terms: bool,
    parameters: bool,
    digits: int,
    out: Path | None,
    output: Output,
) -> None:
    r"""Print the exact equations of motion: every term of D, h and c.

    The terms are found from numeric values, so that any arm has them; see docs/equations.md.

    \b
    Examples:
      gd-analyze equations puma560 --min-share 1%
      gd-analyze equations puma560 --element D11 --element h1 --terms
      gd-analyze equations my_arm.toml --format latex -o my_arm.tex
      gd-analyze equations puma560 --parameters
    """
    if parameters:
        if elements or terms or min_share > 0:
            raise click.UsageError(
                "--parameters are of the whole arm: without --element, --min-share, --terms"
            )
        give_parameters(robot, form, digits, out, output)
        return
    if terms and (form != "text" or out is not None):
        raise click.UsageError("--terms is a table for the terminal: it goes without --format and --out")
    require_outputs(out)
    with output.working() as stage:
        from gd_analyze.files import write_text
        from gd_analyze.harmonics.equations import each_equation, elements_named, harmonics_for

        arm = robot.load()
        stage("identifying")
        harmonics = harmonics_for(arm, elements)
        stage("writing out", len(elements_named(elements, arm.n_joints)))
        found, texts, heading = [], [], _Heading(harmonics, form, min_share, whole=not elements)
        for equation in each_equation(harmonics, elements, min_share=min_share, progress=stage.advance):
            heading.note(equation)
            texts.append(_written(equation, form, digits))
            # Terms take much more memory than their text.
            found += [equation] if terms or output.as_json else []
        body = _before(form, arm.n_joints) + "".join(texts)
        header = str(heading)
        if out is not None:
            stage(f"writing {out.name}")
            write_text(out, header + body)
    if output.as_json or terms or out is not None:
        output.give(_result(harmonics, found, heading.terms, form, body, digits), wrote=out)
    else:
        lines(body if output.quiet else header + body)


def _before(form: str, n_joints: int) -> str:
    from gd_analyze.formulas.sympy import sympy_head

    return sympy_head(n_joints) if form == "sympy" else ""


def _written(equation: Equation, form: str, digits: int) -> str:
    from gd_analyze.formulas.languages import Latex, MathML, Plain
    from gd_analyze.formulas.sympy import sympy_line
    from gd_analyze.formulas.writing import element_formula

    if form == "sympy":
        return f"{sympy_line(equation)}\n"
    formula = element_formula(equation)
    if form == "text":
        return f"{Plain(digits).wrapped(formula, WIDTH)}\n"
    return f"{(Latex(digits) if form == 'latex' else MathML(digits)).line(formula)}\n"


@dataclass
class _Heading:
    """Arm, number of terms, units and legend, as a comment of the format."""

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
        from gd_analyze.formulas.writing import factor_legend

        arm = self.harmonics.arm
        cut = f", shares of at least {100 * self.min_share:g} %" if self.min_share > 0 else ""
        units = "Units: kg, m, s, rad" + "; D is symmetric, and elements not shown are zero" * self.whole
        if self.has_christoffel:
            units += "; h_i is the sum over j and k of h_ijk qd_j qd_k, and h_ikj = h_ijk"
        legend = ", ".join(Plain().legend(factor_legend(self.factors)))
        before, after = _COMMENTS[self.form]
        room, out = WIDTH - len(before) - len(after), ""
        for text in filter(None, (f"{arm.title or arm.name}: {self.terms} terms{cut}", units, legend)):
            # Two hyphens would end a comment of XML.
            safe = re.sub("-(?=-)", "- ", text) if self.form == "mathml" else text
            pieces = textwrap.wrap(f"{visible(safe)}.", room)
            out += "".join(f"{before}{piece}{after}\n" for piece in pieces)
        return f"{out}\n"


def _result(
    harmonics: Harmonics, found: Sequence[Equation], terms: int, form: str, body: str, digits: int
) -> Result:
    from dataclasses import asdict

    from gd_analyze.formulas.writing import exponents
    from gd_analyze.result import Fact, Result

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
    from gd_analyze.formulas.formula import Product
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.formulas.printer import number
    from gd_analyze.formulas.writing import powers
    from gd_analyze.result import Column, Table

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
