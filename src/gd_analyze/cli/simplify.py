"""`gd-analyze simplify`: the fewest operations that meet a torque error budget."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import Given, given_dynamics
from gd_analyze.cli.levels import BUDGET, budget_option, level_option, simplify_options
from gd_analyze.cli.options import command_line, digits_option, margin_option, out_option
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.recursion_view import recursion_document, show_recursion
from gd_analyze.cli.terminal import WIDTH, line, lines, sentence

if TYPE_CHECKING:
    from gd_analyze.certification.certificate import Certificate


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

    The error is that at the states the model is made for; elsewhere it may be larger, unless --certified.
    Equations of levels term and energy are in absolute rates, see docs/simplification.md.

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
        from gd_analyze.simplification.search_options import SearchOptions
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

    output.give(
        lambda: (
            _document(model, exact.states, certificate, digits) | {"seconds": seconds} | output.about(out)
        ),
        lambda: _show(model, exact.states, certificate, seconds, digits),
        out,
    )


def _document(
    model: gd.SimplifiedModel, states: gd.States, certificate: Certificate | None, digits: int
) -> dict[str, Any]:
    from gd_analyze.cli.joint_table import counts, joint_rows, norm_rows, promise_values
    from gd_analyze.formulas.languages import Plain

    accuracy = model.accuracy
    columns = promise_values(accuracy) | {"certified": None if certificate is None else certificate.certified}
    where = {} if certificate is None else {"certified_within": certificate.region.where}
    document: dict[str, Any] = {
        "arm": model.arm.name,
        "level": model.level.name,
        "refitted": model.refitted,
        "drives": model.drives,
        "budget": accuracy.budget,
        "fitted_on": dict(accuracy.fitted_on),
        "operations": counts(model.operations),
        "operations_full": counts(model.operations_full),
        "levels": [one._asdict() for one in accuracy.levels],
        "search": [step._asdict() for step in accuracy.steps],
        "solved": accuracy.solved,
        "cut_short": accuracy.cut_short,
        "saves": model.saves,
        "notice": model.notice,
        "joints": joint_rows(model.arm, columns),
        "norms": norm_rows(accuracy.norms),
    } | where
    if model.level is gd.LEVELS["element"]:
        return document | {"kept": _labels(model), "dropped": _labels(model, dropped=True)}
    plain = Plain(digits)
    return (
        document
        | {
            "terms": len(model.terms),
            "equations": [plain.line(formula) for formula in model.formulas],
            "legend": list(plain.legend(model.legend)),
        }
        | (recursion_document(model, states, digits) if model.level is gd.LEVELS["recursive"] else {})
    )


def _labels(model: gd.SimplifiedModel, dropped: bool = False) -> list[str]:
    from gd_analyze.simplification.element import parts_of

    return [p.label for p in parts_of(model.arm.n_joints) if (p in model.terms) != dropped]


def _show(
    model: gd.SimplifiedModel,
    states: gd.States,
    certificate: Certificate | None,
    seconds: float,
    digits: int,
) -> None:
    from gd_analyze.cli.joint_table import arm_in_words, promise_table
    from gd_analyze.formulas.languages import Plain
    from gd_analyze.motions.states import in_words
    from gd_analyze.results.error_words import errs_by, norms_told
    from gd_analyze.results.summary import nothing_gained, worst_error
    from gd_analyze.text import amount, rounded_up

    accuracy, arm = model.accuracy, model.arm
    full, left = model.operations_full, model.operations
    if model.saves:
        proven = certificate and worst_error(model, certificate.certified)
        answer = f"{left.total} instead of {full.total} operations, " + (
            f"no error above {proven.in_words}, proven" if proven else errs_by(model)
        )
        sentence(f"{arm_in_words(arm, model.drives)}: {answer}", bold=True)
    else:
        sentence(f"{arm_in_words(arm)}: {nothing_gained(model)}", bold=True)
    line(f"operations  {full}")
    if model.saves:
        line(f"         -> {left}")
    refitted = ", refitted" if model.refitted else ""
    sentence(
        f"{model.size[0]} of {model.size[1]} {model.level.keeps}{refitted}, budget {accuracy.budget}, for "
        f"{in_words(accuracy.fitted_on)}; in {seconds:.2g} s"
    )
    for tried in accuracy.levels:
        sentence(f"Level {tried.level}: {tried.why or f'{tried.operations} operations'}.")
    sentence(f"Operations after each step of the search: {accuracy.search}.")
    promise_table(accuracy, arm)
    line()
    sentence(f"{norms_told(accuracy.norms, arm)}.")
    line()
    if model.notice:
        sentence(model.notice)
        line()
    if certificate is not None:
        bounds = ", ".join(
            amount(rounded_up(float(bound)), joint.effort_unit)
            for bound, joint in zip(certificate.certified, model.arm.joints, strict=True)
        )
        sentence(
            f"Certified: no state within {certificate.where} has an error above {bounds} at the joints. "
            f"{certificate.note}"
        )
        line()
    if model.level is gd.LEVELS["element"]:
        for heading, dropped in (("Kept", False), ("Dropped", True)):
            sentence(heading, bold=True)
            sentence(", ".join(_labels(model, dropped)) or "nothing")
        return
    if model.level is gd.LEVELS["recursive"]:
        show_recursion(model, states, digits)
        return
    plain = Plain(digits)
    sentence("The model, in kg, m, s, rad", bold=True)
    for formula in model.formulas:
        lines(plain.wrapped(formula, WIDTH) + "\n")
    meanings = plain.legend(model.legend)
    if meanings:
        line()
        sentence("; ".join(meanings) + ".")
