"""`gd-analyze trade-off`: operations against torque error, at every level of simplification."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import ROBOT, ROBOT_HELP, reporting
from gd_analyze.cli.payload import load_arm_carrying, payload_option
from gd_analyze.cli.states import described, states_given, states_options, trajectory_argument

if TYPE_CHECKING:
    from gd_analyze.levels import Budget, ExactDynamics
    from gd_analyze.search.trade_off import TradeOffPoint


@click.command("trade-off", short_help="Operations against torque error, for all levels.")
@click.argument("robot", type=ROBOT, help=ROBOT_HELP)
@trajectory_argument
@click.option(
    "--budget",
    default="1%",
    show_default=True,
    metavar="LIST",
    help="The budget that is multiplied, as for `simplify`.",
)
@click.option("--drives", is_flag=True, help="Include drive inertia.")
@payload_option
@states_options
@click.option(
    "--quick",
    is_flag=True,
    help="All budgets of a level from one elimination: seconds instead of minutes, more operations.",
)
@reporting
def trade_off(
    robot: str,
    trajectory: str | None,
    budget: str,
    drives: bool,
    payload: str | None,
    states: int,
    seed: int,
    quick: bool,
    as_json: bool,
    quiet: bool,
    debug: bool,
) -> None:
    r"""Simplify for a tenth of the budget up to ten times it, at every level, with and without refit.

    Pick a point and make its model with `simplify --budget` or `simplify --operations`.

    \b
    Examples:
      gd-analyze trade-off puma560 --drives
      gd-analyze trade-off puma560 pick-and-place --quick
    """
    from gd_analyze.cli.terminal import print_json, stages, warnings_told

    with warnings_told(quiet) as told, stages(quiet) as stage:
        from gd_analyze.levels import Budget, ExactDynamics
        from gd_analyze.search.trade_off import FACTORS, KINDS
        from gd_analyze.search.trade_off import trade_off as run

        stage("reading")
        allowed = Budget.parse(budget)
        arm = load_arm_carrying(robot, payload)
        exact = ExactDynamics.of(arm, states_given(arm, trajectory, states, seed), drives)
        stage("simplifying", len(KINDS) * len(FACTORS))
        points = run(exact, allowed, thorough=not quick, progress=stage.advance)
    if as_json:
        print_json(_document(exact, allowed, points, told))
    elif not quiet:
        _show(exact, points)


def _document(
    exact: ExactDynamics, budget: Budget, points: tuple[TradeOffPoint, ...], told: list[str]
) -> dict[str, Any]:
    from dataclasses import asdict

    return {
        "arm": exact.arm.name,
        "drives": exact.form.drives,
        "states": dict(exact.states.described),
        "budget": str(budget),
        "points": [
            {
                "level": point.level.name,
                "refit": point.refit,
                "budget": point.budget,
                "operations": {**asdict(point.operations), "total": point.operations.total},
                "largest_share": point.error_share,
            }
            for point in points
        ],
        "warnings": told,
    }


def _show(exact: ExactDynamics, points: tuple[TradeOffPoint, ...]) -> None:
    from gd_analyze.cli.terminal import sentence, table
    from gd_analyze.levels import ELEMENT, TERM
    from gd_analyze.search import curves

    arm = exact.arm
    drives = ", with drives" if exact.form.drives else ""
    sentence(f"{arm.title or arm.name}{drives}, over {described(exact.states.described)}", bold=True)
    by_kind = curves(points)
    table(
        "Multiplications and additions of one torque evaluation, by budget",
        [
            ("budget", "right"),
            *((f"{level}{' refit' if refit else ''}", "right") for level, refit in by_kind),
        ],
        [
            [row[0].budget, *(str(point.operations.total) for point in row)]
            for row in zip(*by_kind.values(), strict=True)
        ],
    )
    full = [level.exact_operations(exact.form).total for level in (ELEMENT, TERM)]
    sentence(f"Exact: {full[0]} by elements, {full[1]} by harmonic terms.")
