"""`gd-analyze certify`: a bound on a model's torque error that no state exceeds."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import TRAJECTORY, margin_option, model_argument
from gd_analyze.cli.output import Output, reporting


@click.command(short_help="Bound a model's torque error along a motion or over a box.")
@model_argument("`simplify`")
@click.option(
    "--along",
    type=TRAJECTORY,
    metavar="TRAJECTORY",
    help="Bound the error at all states within --margin of a motion: a CSV file, a shipped name, or - for "
    "standard input. Without it, at all states within the arm's ranges and its velocity and acceleration "
    "limits.",
)
@log_options
@margin_option("With --along: how far states may be from the motion")
@click.option(
    "--effort",
    type=click.IntRange(min=1),
    default=250_000,
    show_default=True,
    help="Positions per joint at which the error is evaluated; ten times as many for every angle beyond the "
    "fourth that it depends on, up to the seventh; along a motion a twentieth as many small boxes; for D a "
    "thirtieth as many positions. Any number gives a valid bound, more give a tighter one.",
)
@reporting
def certify(model: Path, along: str | None, margin: str | None, effort: int, output: Output) -> None:
    r"""Bound the torque error of a simplified model along a motion, or within the arm's limits.

    With --along, the bound holds for every state within the margins of the motion, between its set points
    too; a second bound holds for all combinations of values between the motion's extremes. Without it, the
    bound holds for all states within the arm's limits, and the largest error that a search found is shown
    beside it. Both are for the program in the file. For a model of level energy the smallest eigenvalue of D
    is bounded as well. Allowed and sampled errors are measured again if their states are available: drawn
    ones, a shipped trajectory's, or those of --along. The same input gives the same figures on any machine.

    \b
    Examples:
      gd-analyze certify model.json
      gd-analyze certify model.json --along pick-and-place
      gd-analyze certify model.json --along my.csv --margin 0.5deg,qd=1%
    """
    if margin is not None and along is None:
        raise click.UsageError("--margin goes with --along")
    with output.working() as stage:
        stage("reading")
        from gd_analyze.certification.proof import proof
        from gd_analyze.simplification.model_checks import measured_at

        around = gd.Margin.of(margin)
        loaded = gd.load_model(model)
        motion = None if along is None else read_motion(along, loaded.arm)
        if motion:
            loaded = replace(loaded, accuracy=loaded.accuracy.along(motion.fingerprint))
        if motion and loaded.accuracy.fitted_on.get("trajectory_fingerprint") == motion.fingerprint:
            loaded = measured_at(loaded, gd.states_of(motion))
        stage("certifying", 100 * loaded.arm.n_joints * (1 if motion is None else 2))
        result = proof(loaded, motion, margin=around, effort=effort, progress=stage.advance)
    output.give(result)
