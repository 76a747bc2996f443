"""`gd-analyze validate`: a verdict on a model over files, with an exit code and JUnit XML."""

from __future__ import annotations

from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import OutputPath, model_argument, trajectories_argument
from gd_analyze.cli.output import Output, reporting, require_outputs


@click.command(short_help="Pass or fail a model on files of motions.")
@model_argument()
@trajectories_argument(several="each motion is judged by itself")
@log_options
@click.option(
    "--fail-over",
    metavar="LIST",
    help="Exit with code 1 if a joint's error is larger on any motion: a share of its peak torque "
    "along that motion (1%), N m (0.5), `1% or 0.5`, one entry per joint with commas, all as --budget of "
    "`simplify`; or `promise`, what the model's own budget allows.",
)
@click.option(
    "--fit-friction", is_flag=True, help="With measured torques: fit friction, and show what remains."
)
@click.option("--junit", type=OutputPath(), help="JUnit XML file, with a test per motion and joint.")
@reporting
def validate(
    model: Path,
    trajectories: tuple[str, ...],
    fail_over: str | None,
    fit_friction: bool,
    junit: Path | None,
    output: Output,
) -> None:
    r"""Give a verdict on a simplified model, motion by motion.

    The result shows each joint's error against the exact dynamics of the arm, and whether the model keeps its
    promise; set points outside the arm's limits, where no certificate for these limits holds; and, for a log
    with measured torques, the differences of exact and simplified torque from them. Without --fail-over the
    exit code is 0. `gd-analyze evaluate` shows more of one motion: torques over time, payloads, dropped
    parts.

    \b
    Examples:
      gd-analyze validate model.json large-slew wrist-move
      gd-analyze validate model.json logs/ --fail-over 1% --junit junit.xml
      gd-analyze validate model.json log.csv --fit-friction --json
    """
    require_outputs(junit, option="--junit")
    with output.working() as stage:
        stage("reading")
        from gd_analyze.files import write_text
        from gd_analyze.motions.pool import motions_of
        from gd_analyze.studies.validation_result import junit_xml, validation_result

        loaded = gd.load_model(model)
        motions = motions_of(trajectories, loaded.arm, read_motion)
        stage("validating", len(motions))
        found = gd.validate(loaded, motions, fail_over=fail_over, progress=stage.advance)
        if junit is not None:
            stage(f"writing {junit.name}")
            write_text(junit, junit_xml(found))
    output.give(validation_result(found, fit_friction=fit_friction), junit)
    if not found.passed:
        click.get_current_context().exit(1)
