"""`gd-analyze rank`: every term of D, h and c by the torque that goes with it."""

from __future__ import annotations

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.options import level_option, number_option
from gd_analyze.cli.output import Output, reporting


@click.command(short_help="Rank every term of D, h and c by its torque.")
@given_dynamics
@level_option(("term", "energy"), "term")
@number_option("--top", 20, "Terms to print; --json has all.")
@reporting
def rank(given: Given, level: str, top: int, output: Output) -> None:
    r"""Rank single terms by their torque, alone and together with all terms ranked below.

    "Without" is the largest torque error of a model without a term and all terms ranked below it. If you
    accept that error, all these terms may be dropped together. Velocities and rows are absolute ones, see
    docs/simplification.md.

    \b
    Examples:
      gd-analyze rank puma560 pick-and-place
      gd-analyze rank puma560 --no-drives --level energy --top 40
    """
    with output.working() as stage:
        stage("reading")
        from gd_analyze.results.term_results import ranking_result

        exact = given.exact()
        stage("ranking")
        result = ranking_result(gd.rank_terms(exact, gd.LEVELS[level]), exact, level, top)
    output.give(result)
