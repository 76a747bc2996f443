"""`gd-analyze equations --parameters`: the base inertial parameters, and the combinations they are."""

from __future__ import annotations

from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot
from gd_analyze.cli.output import Output
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.terminal import lines


def give_parameters(robot: GivenRobot, form: str, digits: int, out: Path | None, output: Output) -> None:
    """Give an arm's base parameters: tables for the terminal, equations otherwise."""
    if form not in ("text", "latex"):
        raise click.UsageError(f"--parameters are written as text or latex, not as {form}")
    require_outputs(out)
    with output.working() as stage:
        from gd_analyze.files import write_text
        from gd_analyze.formulas.base_parameters_result import base_equations, base_parameters_result

        arm = robot.load()
        stage("regrouping")
        base = gd.base_parameters(arm)
        text = "".join(f"{line}\n" for line in base_equations(base, form, digits))
        if out is not None:
            stage(f"writing {out.name}")
            write_text(out, text)
    if output.as_json or out is not None or (form == "text" and not output.quiet):
        output.give(base_parameters_result(base, form, text, digits), wrote=out)
    else:
        lines(text)
