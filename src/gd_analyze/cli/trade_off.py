"""`gd-analyze trade-off`: operations against torque error, at every level of simplification."""

from __future__ import annotations

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.options import budget_option
from gd_analyze.cli.output import Output, reporting


@click.command("trade-off", short_help="Operations against torque error, for all levels.")
@given_dynamics
@budget_option("The budget that is multiplied, as for `simplify`.")
@click.option(
    "--quick",
    is_flag=True,
    help="All budgets of a level from one elimination: seconds instead of minutes, more operations.",
)
@reporting
def trade_off(given: Given, budget: str, quick: bool, output: Output) -> None:
    r"""Simplify at every level, with and without refit, for a tenth of the budget up to ten times the budget.

    Without --quick this takes seven times as long as `simplify` at every level: some minutes for six joints.
    Each point of level recursive is refitted.

    `simplify --budget` or `simplify --operations` makes the model of a point.

    \b
    Examples:
      gd-analyze trade-off puma560
      gd-analyze trade-off puma560 pick-and-place --quick
    """
    with output.working() as stage:
        stage("reading")
        from gd_analyze.results.term_results import trade_off_result
        from gd_analyze.simplification.trade_off import FACTORS, kinds_for

        allowed = gd.Budget.parse(budget)
        exact = given.exact()
        kinds = kinds_for(exact.form)
        stage("simplifying", len(kinds) * len(FACTORS))
        points = gd.trade_off(exact, allowed, kinds=kinds, thorough=not quick, progress=stage.advance)
    output.give(trade_off_result(points, kinds, exact, allowed))
