"""`gd-analyze equations`: the exact equations of motion of an arm, as a person would write them."""

from __future__ import annotations

from pathlib import Path
from tempfile import SpooledTemporaryFile
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.base_parameters import give_parameters
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.options import digits_option, number_read, out_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.terminal import lines, table

if TYPE_CHECKING:
    from gd_analyze.harmonics.equations import Equation, Term
    from gd_analyze.harmonics.transform import Harmonics

# Characters of equations up to which no temporary file is used.
_IN_MEMORY = 2**26


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
    type=click.Choice(["text", "latex", "mathml", "sympy"]),
    default="text",
    show_default=True,
    help="How to write them: sympy is a Python script, the others are one equation each.",
)
@click.option("--terms", is_flag=True, help="Print a table of terms for every element: effect, links, share.")
@click.option(
    "--parameters",
    is_flag=True,
    help="Print the base parameters instead: the least numbers that torque is linear in, and what each "
    "combines of the links' masses, first moments and inertias.",
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

    The terms are read off numeric values, so that any arm has them; see docs/equations.md.

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
    with SpooledTemporaryFile(_IN_MEMORY, "w+", encoding="utf-8") as body:
        with output.working() as stage:
            import time

            from gd_analyze.cli.written_equations import Told, save, show, written, written_before
            from gd_analyze.harmonics.equations import each_equation, elements_named, harmonics_for

            arm = robot.load()
            stage("identifying")
            start = time.perf_counter()
            harmonics = harmonics_for(arm, elements)
            seconds = time.perf_counter() - start
            stage("writing out", len(elements_named(elements, arm.n_joints)))
            told, found = Told(), []
            body.write(written_before(form, arm.n_joints))
            for equation in each_equation(harmonics, elements, min_share=min_share, progress=stage.advance):
                told.note(equation)
                # Terms by themselves take much more memory than their text.
                found += [equation] if terms or output.as_json else []
                body.write("" if terms else written(equation, form, digits))
            header = told.header(harmonics, form, whole=not elements, min_share=min_share, seconds=seconds)
            if out is not None:
                stage(f"writing {out.name}")
                save(out, header, body)
        if output.as_json or out is not None:
            body.seek(0)
            about = {"format": form, "written": body.read()} if output.as_json else {}
            output.give(lambda: _document(harmonics, found, seconds) | about | output.about(out), wrote=out)
        elif not terms:
            show(header if not output.quiet else "", body)
        else:
            if not output.quiet:
                lines(header.rstrip() + "\n")
            _show_tables(found, digits)


def _show_tables(found: list[Equation], digits: int) -> None:
    from gd_analyze.formulas.formula import Product
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.formulas.printer import number
    from gd_analyze.formulas.writing import powers

    for equation in found:
        rows = [
            [
                Plain().product(Product(1.0, powers(term.factors))),
                number(term.coefficient, digits),
                term.effect,
                _spans(term.links),
                f"{100 * term.share:.3g} %",
            ]
            for term in equation.terms
        ]
        zero = "" if rows else " is zero"
        headings = ["term", "coefficient", "effect", "links", "share"]
        table(f"{equation.symbol}{zero} ({equation.unit})", headings, rows, "lrllr")


def _spans(links: tuple[int, ...]) -> str:
    """Write 2-4, 6 for 2, 3, 4, 6."""
    spans: list[list[int]] = []
    for s in links:
        if spans and s == spans[-1][-1] + 1:
            spans[-1].append(s)
        else:
            spans.append([s])
    return ", ".join(str(span[0]) if len(span) == 1 else f"{span[0]}-{span[-1]}" for span in spans)


def _document(harmonics: Harmonics, found: list[Equation], seconds: float) -> dict[str, Any]:
    from dataclasses import asdict

    from gd_analyze.formulas.writing import exponents

    def factors(term: Term) -> list[dict[str, Any]]:
        return [factor._asdict() | {"exponent": exponent} for factor, exponent in exponents(term.factors)]

    return {
        "arm": harmonics.arm.name,
        "seconds": seconds,
        "noise": {"inertia": harmonics.noise[0], "potential": harmonics.noise[1]},
        "gap": harmonics.gap,
        "equations": [
            asdict(equation)
            | {"terms": [asdict(term) | {"factors": factors(term)} for term in equation.terms]}
            for equation in found
        ],
    }
