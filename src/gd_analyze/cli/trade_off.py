"""`gd-analyze trade-off`: operations against torque error, at every level of simplification."""

from __future__ import annotations

from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.levels import budget_option
from gd_analyze.cli.output import Output, reporting

if TYPE_CHECKING:
    from gd_analyze.result import Result
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
    with output.working() as stage:
        from gd_analyze.simplification.trade_off import FACTORS, KINDS, kinds_for

        stage("reading")
        allowed = gd.Budget.parse(budget)
        exact = given.exact()
        kinds = kinds_for(exact.form)
        stage("simplifying", len(kinds) * len(FACTORS))
        points = gd.trade_off(exact, allowed, kinds=kinds, thorough=not quick, progress=stage.advance)
    absent = [level.name for level, refit in KINDS if not refit and (level, refit) not in kinds]
    output.give(_result(exact, allowed, points, absent))


def _result(
    exact: gd.ExactDynamics, budget: gd.Budget, points: tuple[TradeOffPoint, ...], absent: list[str]
) -> Result:
    from dataclasses import asdict

    from gd_analyze.figures.trade_off import kind_name
    from gd_analyze.result import Column, Fact, Result, Table
    from gd_analyze.results.model_facts import drives_text
    from gd_analyze.simplification.exact_form import too_many_terms
    from gd_analyze.simplification.trade_off import curves

    arm, full = exact.arm, exact.form.operations
    by_kind = curves(points)
    budgets = [point.budget for point in next(iter(by_kind.values()), ())]
    curve = Table(
        "",
        "Multiplications and additions of one torque evaluation, by budget",
        (
            Column("", "budget", budgets, shown="text"),
            *(
                Column("", kind_name(level.name, refit), [p.operations.total for p in row], shown="count")
                for (level, refit), row in by_kind.items()
            ),
        ),
        note="Where no model takes fewer operations, the exact torque counts.",
    )
    rows = Table(
        "points",
        "",
        (
            Column("level", "", [point.level.name for point in points]),
            Column("refit", "", [point.refit for point in points]),
            Column("budget", "", [point.budget for point in points]),
            Column("operations", "", [asdict(p.operations) | {"total": p.operations.total} for p in points]),
            Column("largest_share", "", [point.error_share for point in points]),
        ),
    )
    saves = any(point.operations.total < full.total for point in points)
    return Result(
        title=f"{arm.title or arm.name}: operations against torque error",
        subtitle=", ".join(
            filter(None, [f"over {exact.states.in_words}", drives_text(arm, exact.form.drives)])
        ),
        facts=(
            Fact("arm", "", arm.name),
            Fact("drives", "", exact.form.drives),
            Fact("states", "", dict(exact.states.described)),
            Fact("budget", "", str(budget)),
            Fact("shares_of", "", budget.shares_of),
            Fact(
                "operations_full",
                "Operations of the exact torque",
                asdict(full) | {"total": full.total},
                text=str(full),
            ),
            Fact("saves", "" if saves else "Operations saved within these budgets", saves, text="none"),
            Fact(
                "levels_not_tried", "Levels not tried" * bool(absent), absent, note=too_many_terms(exact.form)
            ),
        ),
        parts=(curve, rows),
    )
