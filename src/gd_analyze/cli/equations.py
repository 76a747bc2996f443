"""`gd-analyze equations`: the exact equations of motion of an arm."""

from __future__ import annotations

import re
import textwrap
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.base_parameters import give_parameters
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.options import digits_option, number_read, out_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.terminal import WIDTH, lines

if TYPE_CHECKING:
    from collections.abc import Sequence

    from gd_analyze.harmonics.equations import Equation
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
        found = [*each_equation(harmonics, elements, min_share=min_share, progress=stage.advance)]
        body = _written(found, form, digits, arm.n_joints)
        header = _header(harmonics, found, form, whole=not elements, min_share=min_share)
        if out is not None:
            stage(f"writing {out.name}")
            write_text(out, header + body)
    if output.as_json or terms or out is not None:
        output.give(_result(harmonics, found, form, body, digits, tables=terms), wrote=out)
    else:
        lines(body if output.quiet else header + body)


def _written(found: Sequence[Equation], form: str, digits: int, n_joints: int) -> str:
    """All equations, one after the other, in one of the formats."""
    from gd_analyze.formulas.languages import Latex, MathML, Plain
    from gd_analyze.formulas.sympy import sympy_head, sympy_line
    from gd_analyze.formulas.writing import element_formula

    if form == "sympy":
        return sympy_head(n_joints) + "".join(f"{sympy_line(equation)}\n" for equation in found)
    formulas = map(element_formula, found)
    if form == "text":
        plain = Plain(digits)
        return "".join(f"{plain.wrapped(formula, WIDTH)}\n" for formula in formulas)
    printer = Latex(digits) if form == "latex" else MathML(digits)
    return "".join(f"{printer.line(formula)}\n" for formula in formulas)


def _header(
    harmonics: Harmonics, found: Sequence[Equation], form: str, *, whole: bool, min_share: float
) -> str:
    """Arm, number of terms, units and legend, as a comment of the format."""
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.formulas.writing import factor_legend
    from gd_analyze.text import visible

    arm = harmonics.arm
    cut = f", shares of at least {100 * min_share:g} %" if min_share > 0 else ""
    about = [f"{arm.title or arm.name}: {sum(len(equation.terms) for equation in found)} terms{cut}"]
    about.append("Units: kg, m, s, rad" + "; D is symmetric, and elements not shown are zero" * whole)
    if any(equation.symbol.startswith("h") for equation in found):
        about[-1] += "; h_i is the sum over j and k of h_ijk qd_j qd_k, and h_ikj = h_ijk"
    factors = {factor for equation in found for term in equation.terms for factor in term.factors}
    about += [", ".join(Plain().legend(factor_legend(factors)))] if factors else []
    before, after = _COMMENTS[form]
    # Two hyphens would end a comment of XML.
    about = [re.sub("-(?=-)", "- ", text) if form == "mathml" else text for text in about if text]
    room = WIDTH - len(before) - len(after)
    pieces = [piece for text in about for piece in textwrap.wrap(f"{visible(text)}.", room)]
    return "".join(f"{before}{piece}{after}\n" for piece in pieces) + "\n"


def _result(
    harmonics: Harmonics, found: Sequence[Equation], form: str, body: str, digits: int, *, tables: bool
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
            Fact("", "Terms", sum(len(equation.terms) for equation in found), shown="count"),
            Fact("noise", "", dict(zip(("inertia", "potential"), harmonics.noise, strict=True))),
            Fact("gap", "", harmonics.gap),
            Fact("equations", "", documents),
            Fact("format", "", form),
            Fact("written", "", body),
        ),
        parts=tuple(_table(equation, digits) for equation in found) if tables else (),
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
