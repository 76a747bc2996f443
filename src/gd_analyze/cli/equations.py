"""`gd-analyze equations`: the exact equations of motion of an arm, or its base inertial parameters."""

from __future__ import annotations

from pathlib import Path

import click

from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, joint_values, robot_given
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.cli.rules import excludes, needs
from gd_analyze.cli.terminal import WIDTH, lines
from gd_analyze.files import write_text

# Forms by the ending of the file that they are written into.
_FORMS = {".tex": "latex", ".mml": "mathml", ".py": "sympy"}


@click.command(short_help="Print the exact equations of motion.")
@robot_given
@click.option(
    "--element",
    "elements",
    metavar="LABEL",
    multiple=True,
    help="D12, h112 or c2; h1 for all h_1jk; D, h or c for all of a kind. May be repeated.  [default: all]",
)
@options.share("--min-share", "0%", "Leave out terms below this share of the element's largest term.")
@click.option(
    "--format",
    "form",
    type=click.Choice(["text", "latex", "mathml", "sympy"]),
    help="An equation per element, or a Python script for SymPy.  [default: by the ending of --out, .tex, "
    ".mml or .py; else text]",
)
@click.option("--terms", is_flag=True, help="Print a table of terms for every element: effect, links, share.")
@click.option(
    "--at",
    metavar="LIST",
    help="Print D, h and c as numbers, with their parts, at these joint positions: degrees or m, "
    "comma-separated. h is its coefficients h_ijk.",
)
@click.option(
    "--velocity",
    metavar="LIST",
    help="With --at: joint velocities, degrees/s or m/s; h is then its value.",
)
@click.option(
    "--parameters",
    is_flag=True,
    help="Print the base inertial parameters instead, each as a combination of the links' own; with "
    "--symbolic by masses, centres, inertias and lengths.",
)
@click.option(
    "--symbolic",
    is_flag=True,
    help="Write lengths, masses and inertias as symbols, and list their values. Equations of arms of more "
    "than four joints need --element.",
)
@options.digits("Significant digits of numbers; equations of sympy and --symbolic keep all.")
@options.out("Write the equations into this file.")
@reporting
def equations(
    robot: GivenRobot,
    elements: tuple[str, ...],
    min_share: float,
    form: str | None,
    terms: bool,
    at: str | None,
    velocity: str | None,
    parameters: bool,
    symbolic: bool,
    digits: int,
    out: Path | None,
    output: Output,
) -> None:
    r"""Print the exact equations of motion: every term of D, h and c.

    \b
    Examples:
      gd-analyze equations puma560 --min-share 1%
      gd-analyze equations puma560 --element D11 --element h1 --terms
      gd-analyze equations my_arm.toml --format latex -o my_arm.tex
      gd-analyze equations puma560 --at 0,-30,90,0,0,0 --element D
      gd-analyze equations puma560 --parameters
      gd-analyze equations scara --symbolic --format sympy -o scara.py
    """
    of_formulas = ("--min-share", "--format", "--terms", "--parameters", "--symbolic", "--out")
    excludes("--at", *of_formulas, as_it="prints a table of numbers to the terminal")
    needs("--velocity", "--at")
    excludes("--symbolic", "--terms", "--min-share", as_it="writes every term")
    excludes("--parameters", "--element", "--terms", "--min-share", as_it="is for the whole arm")
    excludes("--terms", "--format", "--out", as_it="prints a table to the terminal")
    if at is not None:
        _give_posture(robot, elements, at, velocity, digits, output)
        return
    form = form or _FORMS.get(out.suffix if out is not None else "", "text")
    if parameters:
        _give_parameters(robot, symbolic, form, digits, out, output)
        return
    if symbolic:
        _give_symbolic(robot, elements, form, out, output)
        return
    require_outputs(out)
    with output.working() as progress:
        from gd_analyze.formulas.results import Heading, equation_text, equations_result, sympy_head
        from gd_analyze.harmonics.equations import each_equation, harmonics_for

        arm = robot.load()
        progress.stage("identifying")
        harmonics = harmonics_for(arm, elements)
        listed_equations, texts = [], []
        heading = Heading(WIDTH, harmonics, form, min_share, whole=not elements)
        for equation in each_equation(harmonics, elements, min_share=min_share, progress=progress):
            heading.note(equation)
            texts.append(equation_text(equation, form, digits, WIDTH))
            # Terms take much more memory than their text.
            listed_equations += [equation] if terms or output.as_json else []
        body = (sympy_head(arm.n_joints) if form == "sympy" else "") + "".join(texts)
        header = str(heading)
        if out is not None:
            progress.stage(f"writing {out.name}")
            write_text(out, header + body)
    if output.as_json or terms or out is not None:
        output.give(equations_result(harmonics, listed_equations, heading.terms, form, body, digits), out)
    else:
        lines(body if output.quiet else header + body)


def _give_posture(
    robot: GivenRobot, elements: tuple[str, ...], at: str, velocity: str | None, digits: int, output: Output
) -> None:
    """Give the elements as numbers at one posture."""
    with output.working():
        from gd_analyze.results.posture import posture_result

        arm = robot.load()
        q = joint_values(arm, at, "--at")
        qd = None if velocity is None else joint_values(arm, velocity, "--velocity")
        result = posture_result(arm, q, qd, elements, digits=digits)
    output.give(result)


def _give_symbolic(
    robot: GivenRobot, elements: tuple[str, ...], form: str, out: Path | None, output: Output
) -> None:
    """Give the equations in symbols."""
    require_outputs(out)
    with output.working() as progress:
        from gd_analyze.formulas.symbolic import symbolic_equations_result, symbolic_text
        from gd_analyze.harmonics.symbolic import symbolic_equations

        arm = robot.load()
        equations = symbolic_equations(arm, elements, progress=progress)
        text = symbolic_text(equations, form, WIDTH)
        if out is not None:
            progress.stage(f"writing {out.name}")
            write_text(out, text)
    if output.as_json or out is not None:
        output.give(symbolic_equations_result(equations, form, text), out)
    else:
        lines(symbolic_text(equations, form, WIDTH, heading=False) if output.quiet else text)


def _give_parameters(
    robot: GivenRobot, symbolic: bool, form: str, digits: int, out: Path | None, output: Output
) -> None:
    """Give the base inertial parameters: tables for the terminal, equations otherwise."""
    if form not in ("text", "latex"):
        raise click.UsageError(f"--parameters writes text or latex, not {form}")
    require_outputs(out)
    with output.working() as progress:
        from gd_analyze.dynamics.base_parameters import base_parameters
        from gd_analyze.formulas.base_symbols import base_symbols
        from gd_analyze.formulas.results import base_equations, base_parameters_result

        arm = robot.load()
        progress.stage("regrouping")
        base = base_parameters(arm)
        symbols = base_symbols(base) if symbolic else None
        text = "".join(f"{line}\n" for line in base_equations(base, form, digits, symbols))
        if out is not None:
            progress.stage(f"writing {out.name}")
            write_text(out, text)
    if output.as_json or out is not None or (form == "text" and not output.quiet):
        output.give(base_parameters_result(base, form, text, digits, symbols), out)
    else:
        lines(text)
