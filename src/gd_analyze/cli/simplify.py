"""Verbs about what may be dropped: `simplify`, `rank` single terms, and `trade-off` at every level."""

from __future__ import annotations

import time
from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.options import command_line
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.text import SINE_PRICE


@click.command(short_help="Find a model of few terms within a torque budget.")
@given_dynamics
@options.budget()
@options.level()
@options.at_set_points
@options.seconds
@click.option(
    "--sine-price",
    type=click.IntRange(0),
    default=SINE_PRICE,
    show_default=True,
    metavar="OPERATIONS",
    help="Operations that a sine or cosine counts as when models are compared.",
)
@click.option(
    "--certified",
    is_flag=True,
    help="Give only a model whose budget is proven, near the motion or within the arm's limits.",
)
@options.verdicts
@options.margin
@click.option(
    "--velocities",
    type=click.Choice(("absolute", "joint")),
    default=None,
    help="Print D, h and c by element in joint velocities, or torques in the velocities of the model's "
    "terms, mostly absolute (levels term and energy).  [default: joint at level term, else absolute]",
)
@options.digits("Significant digits of the equations printed; files keep all.")
@options.out("Write the model into this JSON file.")
@reporting
def simplify(
    inputs: Given,
    budget: gd.types.Budget,
    level: str,
    seconds: float,
    sine_price: int,
    certified: bool,
    at_set_points: bool,
    verdicts: str,
    velocities: str | None,
    margin: gd.types.Margin | None,
    digits: int,
    out: Path | None,
    output: Output,
) -> None:
    r"""Simplify an arm's equations of motion to few terms within a torque budget.

    The budget holds near the motion, or near each of several, and is proven where the proof succeeds; without
    a trajectory, within the arm's limits as far as a search finds. docs/simplification.md says more.

    \b
    Examples:
      gd-analyze simplify puma560
      gd-analyze simplify puma560 pick-and-place --level energy --budget 0.5%
      gd-analyze simplify puma560 pick-and-place large-slew -o model.json
      gd-analyze simplify puma560 --budget "1% or 10% friction"
      gd-analyze simplify puma560 --certified -o model.json
    """
    if velocities == "joint" and level not in ("term", "energy"):
        raise click.UsageError("--velocities joint needs --level term or --level energy")
    require_outputs(out)
    with output.working() as progress:
        from gd_analyze.results.findings import provenance
        from gd_analyze.results.simplified_result import simplified_result
        from gd_analyze.simplification.levels import level_named
        from gd_analyze.simplification.model_file import replaces_model
        from gd_analyze.simplification.search import SearchOptions
        from gd_analyze.simplification.search_time import SearchTime
        from gd_analyze.studies.simplifying import require_consistent, search_beside_log

        replaces = out is not None and replaces_model(out)
        limit = SearchTime(seconds)
        search_options = SearchOptions(level_named(level), sine_price=sine_price, time=limit)
        require_consistent(
            search_options.level,
            has_motion=bool(inputs.trajectories),
            margin=margin,
            at_set_points=at_set_points,
            certified=certified,
            verdicts=verdicts,
        )
        start = time.perf_counter()
        exact, motion = inputs.exact(progress)
        held_model = search_beside_log(
            exact,
            motion,
            budget,
            search_options,
            margin=margin,
            at_states=at_set_points,
            certified=certified,
            verdicts=verdicts,
            provenance=provenance(command_line()),
            progress=progress,
        )
        elapsed = time.perf_counter() - start
        by_element = level == "term" if velocities is None else velocities == "joint"
        result = simplified_result(held_model, exact.states, elapsed, digits, joint_velocities=by_element)
        if out is not None:
            progress.stage(f"writing {out.name}")
            gd.save_model(held_model.model, out)
    output.give(result, out, replaced="a model" if replaces else "")


@click.command("rank-terms", short_help="Rank every term of D, h and c by its torque.")
@given_dynamics
@options.level(("term", "energy"))
@options.number("--top", 20, "Number of terms to print; --json gives all.")
@reporting
def rank_terms(inputs: Given, level: str, top: int, output: Output) -> None:
    r"""Rank single terms by their torque, alone and together with all terms ranked below.

    "Without" is the largest torque error of a model without a term and all terms ranked below it. Velocities
    and rows are absolute ones.

    \b
    Examples:
      gd-analyze rank-terms puma560 pick-and-place
      gd-analyze rank-terms puma560 --no-drives --level energy --top 40
    """
    with output.working() as progress:
        from gd_analyze.results.term_results import ranking_result
        from gd_analyze.simplification.harmonic import HARMONIC_LEVELS

        exact, _ = inputs.exact(progress)
        progress.stage("ranking")
        result = ranking_result(gd.tables.rank_terms(exact, HARMONIC_LEVELS[level]), exact, level, top)
    output.give(result)


@click.command("trade-off", short_help="Operations against torque error, for all levels.")
@given_dynamics
@options.budget("Budget to scale, as for `simplify`.")
@click.option(
    "--quick",
    is_flag=True,
    help="Take all models of a level from one elimination: seconds, but more operations.",
)
@reporting
def trade_off(inputs: Given, budget: gd.types.Budget, quick: bool, output: Output) -> None:
    r"""Simplify at every level of terms, for a tenth to ten times the budget.

    Some minutes for six joints. `simplify --at-set-points --budget` makes the
    model of a point.

    \b
    Examples:
      gd-analyze trade-off puma560
      gd-analyze trade-off puma560 pick-and-place --quick
    """
    with output.working() as progress:
        from gd_analyze.results.term_results import trade_off_result

        exact, _ = inputs.exact(progress)
        points = gd.trade_off(exact, budget, thorough=not quick, progress=progress)
    output.give(trade_off_result(points, exact, budget))
