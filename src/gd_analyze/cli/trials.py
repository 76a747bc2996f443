"""Verbs that try a model: `evaluate` and `certify`."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.log_options import log_options, read_motion, read_motions
from gd_analyze.cli.options import DRAWN, TRAJECTORY, OutputPath
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.cli.rules import excludes, is_given, needs

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link


@click.command(short_help="Errors of a model on motions, and a verdict.")
@options.model
@options.trajectories(DRAWN, several="each motion is judged by itself")
@log_options
@click.option(
    "--fail-over",
    metavar="LIST",
    default="stated",
    show_default=True,
    help="Exit with code 1 if a joint's error is larger on any motion: as --budget of `simplify`, along that "
    "motion; `promise`, what the model's budget allowed, or at level element its error; "
    "`stated`, what the model states for these states; "
    "or `none`, as with --payload by default.",
)
@click.option("--strict", is_flag=True, help="Fail also where the model states nothing.")
@click.option("--arm", metavar="ROBOT", help="Another version of the model's arm, whose exact torque counts.")
@options.payload
@click.option(
    "--fit-friction", is_flag=True, help="With measured torques: fit friction, and show what remains."
)
@options.states
@options.out("CSV file for exact and simplified torque over time, of one motion.")
@click.option("--junit", type=OutputPath(), help="JUnit XML file, with a test per motion and joint.")
@reporting
def evaluate(
    model: Path,
    trajectories: tuple[str, ...],
    fail_over: str,
    strict: bool,
    arm: str | None,
    payload: Link | None,
    fit_friction: bool,
    states: int,
    seed: int,
    out: Path | None,
    junit: Path | None,
    output: Output,
) -> None:
    r"""Compare a simplified model with exact dynamics on motions, or at drawn states, and give a verdict.

    At states for which the model states nothing there is no verdict unless --fail-over names one. Set points
    outside the arm's limits are listed, and measured torques compared. With --payload the exact torque is
    that of the loaded arm; the model is unchanged.

    \b
    Examples:
      gd-analyze evaluate reports/puma560-pick-and-place/model.json large-slew
      gd-analyze evaluate model.json logs/ --fail-over 1% --junit junit.xml
      gd-analyze evaluate model.json large-slew --payload 1.5,0,0,0.1
      gd-analyze evaluate model.json
    """
    if out is not None and not trajectories:
        raise click.UsageError("-o writes torque over time, and needs a trajectory")
    if payload is not None and not is_given("--fail-over"):
        fail_over = "none"
    require_outputs(out)
    require_outputs(junit, option="--junit")
    with output.working() as progress:
        from gd_analyze.files import write_text
        from gd_analyze.motions.pool import motions_of
        from gd_analyze.motions.states import states_in_box
        from gd_analyze.robots.payload import carrying
        from gd_analyze.simplification.model_torque import torque_csv
        from gd_analyze.studies.evaluation_result import evaluation_result, junit_xml

        loaded = gd.load_model(model)
        reference_arm = loaded.arm if arm is None else gd.load_arm(arm)
        read = partial(read_motion, progress=progress)
        motions = motions_of(trajectories, loaded.arm, read) if trajectories else []
        if out is not None and len(motions) > 1:
            raise click.UsageError(f"-o writes torque over time along one motion, not {len(motions)}")
        evaluation = gd.evaluate(
            loaded,
            motions or states_in_box(loaded.arm, states, seed),
            reference_arm if payload is None else carrying(reference_arm, payload),
            fail_over=fail_over,
            strict=strict,
            progress=progress,
        )
        unloaded = None if payload is None else reference_arm
        result = evaluation_result(evaluation, payload, unloaded, fit_friction=fit_friction)
        if out is not None:
            progress.stage(f"writing {out.name}")
            write_text(out, torque_csv(motions[0], evaluation.motions[0]))
        if junit is not None:
            progress.stage(f"writing {junit.name}")
            write_text(junit, junit_xml(evaluation))
    output.give(result, *filter(None, (out, junit)))
    if evaluation.verdict == "failed":
        click.get_current_context().exit(1)


@click.command(short_help="Bound a model's torque error along a motion or over a box.")
@options.model
@click.option(
    "--along",
    type=TRAJECTORY,
    multiple=True,
    metavar="TRAJECTORY",
    help="Bound the error near a motion: a CSV file, a shipped name, or - for standard input; for a model of "
    "several motions, each of them. Without it, within the arm's limits.",
)
@log_options
@options.margin
@click.option(
    "--effort",
    type=click.IntRange(min=1),
    default=250_000,
    help="Positions per joint at which the error is evaluated; any number gives a valid bound, a larger one "
    "a tighter bound.",
)
@click.option("--check", is_flag=True, help="Prove again the certificate stated in the model's file.")
@reporting
def certify(
    model: Path,
    along: tuple[str, ...],
    margin: gd.types.Margin | None,
    effort: int,
    check: bool,
    output: Output,
) -> None:
    r"""Bound the torque error of a simplified model along a motion, or within the arm's limits.

    With --along, a second bound holds for all combinations of values between the motion's extremes. The
    largest error that a search found is shown beside each bound, and D's smallest eigenvalue is bounded.

    --check proves again what the file states: the exit code is 0 if every bound holds, 1 if one does not. If
    the motion is not a shipped one, name its file with --along, and each of several motions.

    \b
    Examples:
      gd-analyze certify model.json
      gd-analyze certify model.json --along pick-and-place
      gd-analyze certify model.json --along my.csv --margin 0.5deg,qd=1%
      gd-analyze certify model.json --check
    """
    needs("--margin", "--along")
    excludes("--check", "--margin", "--effort", as_it="takes margin and effort from the model's file")
    with output.working() as progress:
        from gd_analyze.motions.margin import Margin
        from gd_analyze.motions.states import states_of
        from gd_analyze.simplification.model_file import fault_of_file, measured_at
        from gd_analyze.studies.proof import proof, proven_again

        loaded = gd.load_model(model)
        motion = read_motions(along, loaded.arm, progress) if along else None
        if motion:
            loaded = loaded.stating(loaded.accuracy.along(motion.fingerprint))
        if motion and loaded.accuracy.fitted_on.get("trajectory_fingerprint") == motion.fingerprint:
            try:
                loaded = measured_at(loaded, states_of(motion))
            except gd.GdAnalyzeError as error:
                raise fault_of_file(model, error) from None
        if check:
            result, holds = proven_again(loaded, motion, progress=progress)
        else:
            result, holds = (
                proof(loaded, motion, margin=margin or Margin(), effort=effort, progress=progress),
                True,
            )
    output.give(result)
    if not holds:
        click.get_current_context().exit(1)
