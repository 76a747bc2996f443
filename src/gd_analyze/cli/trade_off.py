"""`gd-analyze trade-off`: operations against torque error, at every level of simplification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.levels import budget_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import sentence, table

if TYPE_CHECKING:
    from gd_analyze.simplification.trade_off import TradeOffPoint


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
    r"""Simplify for a tenth of the budget up to ten times it, at every level, with and without refit.

    Thorough, it takes seven times as long as `simplify` at every level: some minutes for six joints. Each
    point of level recursive is refitted.

    Pick a point and make its model with `simplify --budget` or `simplify --operations`.

    \b
    Examples:
      gd-analyze trade-off puma560
      gd-analyze trade-off puma560 pick-and-place --quick
    """
    from gd_analyze.cli.joint_table import counts

    with output.working() as stage:
        from gd_analyze.simplification.trade_off import FACTORS, KINDS, kinds_for

        stage("reading")
        allowed = gd.Budget.parse(budget)
        exact = given.exact()
        kinds = kinds_for(exact.form)
        stage("simplifying", len(kinds) * len(FACTORS))
        points = gd.trade_off(exact, allowed, kinds=kinds, thorough=not quick, progress=stage.advance)
    absent = [level.name for level, refit in KINDS if not refit and (level, refit) not in kinds]
    output.give(
        lambda: {
            "arm": exact.arm.name,
            "drives": exact.form.drives,
            "states": dict(exact.states.described),
            "budget": str(allowed),
            "shares_of": allowed.shares_of,
            "operations_full": counts(exact.form.operations),
            "saves": any(point.operations.total < exact.form.operations.total for point in points),
            "points": [
                {
                    "level": point.level.name,
                    "refit": point.refit,
                    "budget": point.budget,
                    "operations": counts(point.operations),
                    "largest_share": point.error_share,
                }
                for point in points
            ],
            "levels_not_tried": absent,
            "warnings": output.warnings,
        },
        lambda: _show(exact, points, absent),
    )


def _show(exact: gd.ExactDynamics, points: tuple[TradeOffPoint, ...], absent: list[str]) -> None:
    from gd_analyze.cli.joint_table import arm_in_words
    from gd_analyze.figures.trade_off import kind_name
    from gd_analyze.simplification.exact_form import too_many_terms
    from gd_analyze.simplification.trade_off import curves

    arm = arm_in_words(exact.arm, exact.form.drives)
    sentence(f"{arm}, over {exact.states.in_words}", bold=True)
    by_kind = curves(points)
    table(
        "Multiplications and additions of one torque evaluation, by budget",
        ["budget", *(kind_name(level.name, refit) for level, refit in by_kind)],
        [
            [row[0].budget, *(str(point.operations.total) for point in row)]
            for row in zip(*by_kind.values(), strict=True)
        ],
        "r",
    )
    if absent:
        sentence(
            f"Not tried, as the arm has {too_many_terms(exact.form)}: level {' and '.join(absent)}. Models "
            "that are sums of so many terms take more operations than the exact torque."
        )
    full = exact.form.operations.total
    if all(point.operations.total >= full for point in points):
        sentence(
            f"Nothing is saved within any of these budgets: no model found takes fewer operations than "
            f"the {full} of the exact torque, which is given."
        )
    else:
        sentence(f"The exact torque takes {full}; where a model would not take fewer, that is given.")
