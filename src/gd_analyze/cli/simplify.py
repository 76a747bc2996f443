"""`gd-analyze simplify`: the fewest operations that meet a torque error budget."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.levels import BUDGET, budget_option, level_option, simplify_options
from gd_analyze.cli.options import command_line, digits_option, margin_option, out_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs

if TYPE_CHECKING:
    from gd_analyze.certification.certificate import Certificate
    from gd_analyze.result import Part, Result


@click.command(short_help="Find a model of few terms within a torque budget.")
@given_dynamics
@budget_option(
    f"{BUDGET} Or, of all joints together, a share of the torque's norm (1% norm at 95% of states)."
)
@level_option()
@simplify_options
@click.option(
    "--effort",
    type=click.FloatRange(0.0, 1000.0, min_open=True),
    default=1.0,
    show_default=True,
    metavar="FACTOR",
    help="How much to search, as a multiple of the usual, which takes seconds, for seven joints half a "
    "minute, and a minute at most; the best found by then is given.",
)
@click.option(
    "--certified",
    is_flag=True,
    help="Make the budget hold, proven, for every state within the arm's limits; where a trajectory is "
    "given, for every state within --margin of the motion, between its set points too.",
)
@margin_option("With --certified and a trajectory: how far states may be from the motion")
@digits_option("Significant digits of the equations printed; files keep all.")
@out_option("Write the model into this JSON file.")
@reporting
def simplify(
    given: Given,
    budget: str,
    level: str | None,
    refit: bool,
    operations: int | None,
    effort: float,
    certified: bool,
    margin: str | None,
    digits: int,
    out: Path | None,
    output: Output,
) -> None:
    r"""Simplify an arm's equations of motion to few terms within a torque budget.

    The error holds at the states the model is fitted on; elsewhere it may be larger, unless --certified.
    Equations of levels term and energy are in absolute velocities, see docs/simplification.md.

    \b
    Examples:
      gd-analyze simplify puma560
      gd-analyze simplify puma560 pick-and-place --level energy --budget 0.5%
      gd-analyze simplify puma560 pick-and-place large-slew -o model.json
      gd-analyze simplify puma560 --budget "1% or 10% friction" --operations 80
      gd-analyze simplify puma560 --budget "1% norm at 95% of states"
      gd-analyze simplify puma560 --certified -o model.json
      gd-analyze simplify my_arm.toml --refit --level energy -o model.json
    """
    require_outputs(out)
    with output.working() as stage:
        import time

        from gd_analyze.results.provenance import provenance
        from gd_analyze.simplification.levels import SearchOptions
        from gd_analyze.simplification.simplify import simplify_exact

        how = SearchOptions(None if level is None else gd.LEVELS[level], refit, operations, effort=effort)
        if certified and (refit or operations is not None):
            raise click.UsageError("--certified goes without --refit and --operations")
        if margin is not None and not (certified and given.trajectories):
            raise click.UsageError("--margin goes with --certified and a trajectory")
        around = gd.Margin.of(margin)  # one that is not understood shall fail before any computing
        allowed = gd.Budget.parse(budget)
        start = time.perf_counter()
        exact, motion = given.exact_along()
        source = provenance(command_line())
        certificate = None
        if certified:
            stage("searching and certifying")
            region = gd.Box.of(exact.arm) if motion is None else gd.Tube.along(exact.arm, motion, around)
            model, certificate = gd.simplify_certified(
                exact,
                allowed,
                region,
                level=how.level,
                effort=effort,
                provenance=source,
                progress=stage.advance,
            )
        else:
            model = simplify_exact(
                exact, allowed, how, provenance=source, progress=stage.advance, stage=stage
            )
        seconds = time.perf_counter() - start
        if out is not None:
            stage(f"writing {out.name}")
            gd.save_model(model, out)

    output.give(_result(model, exact.states, certificate, seconds, digits), wrote=out)


def _result(
    model: gd.SimplifiedModel,
    states: gd.States,
    certificate: Certificate | None,
    seconds: float,
    digits: int,
) -> Result:
    from gd_analyze.motions.states import in_words
    from gd_analyze.result import Column, Fact, Result, Table
    from gd_analyze.results.model_facts import (
        drives_text,
        headline,
        joint_errors,
        norm_facts,
        operation_facts,
        worst_error,
    )

    accuracy, arm = model.accuracy, model.arm
    bound = None if certificate is None else certificate.certified
    joints = joint_errors(model, bound)
    spread = () if accuracy.uncertainty is None else (Column("uncertainty", "", accuracy.uncertainty),)
    certified = [None] * arm.n_joints if bound is None else bound
    joints = replace(joints, columns=(*joints.columns, Column("certified", "", certified), *spread))
    proven: tuple[Fact, ...] = ()
    answer = None
    if certificate is not None and bound is not None:
        worst = worst_error(model, bound)
        answer = f"Torque error at most {worst.text} (joint {worst.joint}), proven"
        proven = (
            Fact("certified_within", "Proven for every state", certificate.region.where),
            Fact("", "Proof" * bool(certificate.note), certificate.note),
        )
    took = (
        f"{one.operations} operations" if not one.why else f"not tried: {one.why}" for one in accuracy.levels
    )
    levels = [
        Fact("", f"Level {one.level}", None, text=text)
        for one, text in zip(accuracy.levels, took, strict=True)
    ]
    search = Table(
        "search",
        "Operations after each step of the search",
        (
            Column("name", "step", [step.name for step in accuracy.steps], shown="text"),
            Column("operations", "operations", [step.operations for step in accuracy.steps], shown="count"),
        ),
        note="Effort used up before the end." if accuracy.cut_short else "",
    )
    kept = f"{model.size[0]} of {model.size[1]} {model.level.keeps}{', refitted' * model.refitted}"
    return Result(
        title=", ".join(filter(None, [arm.title or arm.name, drives_text(arm, model.drives)])),
        headline=headline(model, answer),
        facts=(
            Fact("arm", "", arm.name),
            Fact("level", "Level", model.level.name, note=kept),
            Fact("refitted", "", model.refitted),
            Fact("drives", "", model.drives),
            Fact("budget", "Budget", accuracy.budget),
            Fact("fitted_on", "States", dict(accuracy.fitted_on), text=in_words(accuracy.fitted_on)),
            *operation_facts(model),
            *levels,
            Fact("levels", "", [one._asdict() for one in accuracy.levels]),
            Fact("solved", "", accuracy.solved),
            Fact("cut_short", "", accuracy.cut_short),
            *proven,
            *norm_facts(accuracy.norms, arm),
            Fact("seconds", "Time", seconds, "s"),
        ),
        parts=(joints, search, *_model_parts(model, states, digits)),
        notices=(model.notice,) if model.notice else (),
    )


def _model_parts(model: gd.SimplifiedModel, states: gd.States, digits: int) -> tuple[Part, ...]:
    """What the model is: parts kept, or equations."""
    from gd_analyze.formulas.languages import equations
    from gd_analyze.result import Fact
    from gd_analyze.results.recursion_parts import recursion_parts
    from gd_analyze.simplification.element import ELEMENT, parts_of
    from gd_analyze.simplification.recursive import RECURSIVE

    if model.level is ELEMENT:
        parts = parts_of(model.arm.n_joints)
        kept = [part.label for part in parts if part in model.terms]
        dropped = [part.label for part in parts if part not in model.terms]
        return Fact("kept", "Kept", kept), Fact("dropped", "Dropped" * bool(dropped), dropped)
    title = "Equations, in kg, m, s, rad"
    written = equations("equations", title, model.formulas, model.legend, digits=digits)
    facts = (Fact("terms", "", len(model.terms)), Fact("legend", "", list(written.legend_lines)))
    if model.level is not RECURSIVE:
        return (*facts, written)
    return (
        *facts,
        Fact("equations", "", list(written.lines)),
        *recursion_parts(model, states, digits),
    )
