"""`gd-analyze sweep`: numbers of an arm varied along a motion, for design."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import log_options, read_motions
from gd_analyze.cli.options import command_line
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.text import LEVEL_NAMES

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link


@click.command(short_help="Vary numbers of an arm: torque, verdicts, operations.")
@robot_given
@options.trajectories()
@log_options
@click.option(
    "--vary",
    multiple=True,
    required=True,
    metavar="NAME=LOW..HIGH[:COUNT]",
    help="A number by its key in arm files, as joint2.a, joint2.a_mm, link3.com.x, gravity.z; or speed, a "
    "multiple of the motion's. COUNT values, 21 without it. May be repeated: every combination.",
)
@options.number("--samples", None, "Draw this many arms from the ranges, in place of a grid.", 1)
@options.number("--seed", 0, "Seed of the samples.")
@options.budget("Allowed torque error, as for the main job.")
@options.share("--dominance", "10%", "As for the main job.")
@options.share("--precision", "0.02%", "Share of the range to which changes of verdicts are bisected.")
@click.option(
    "--operations",
    type=click.Choice(["quick", *LEVEL_NAMES, "none"]),
    default=None,
    help="Operations of the simplified model at every point: a quick count, 0.1 s a point, or of a level's "
    "model, seconds a point.  [default: quick on grids of up to 1000 points]",
)
@options.drives
@options.payload
@options.number("--jobs", 1, "Number of processes for geometries and operations.", 1)
@options.folder("Folder for sweep.h5 (for xarray) and reports; nothing is written without it.",
                ("h5", "html", "pdf", "json"))  # fmt: skip
@reporting
def sweep(
    robot: GivenRobot,
    trajectories: tuple[str, ...],
    vary: tuple[str, ...],
    dominance: float,
    payload: Link | None,
    out: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    output: Output,
    **settings: Any,
) -> None:
    r"""Vary numbers of an arm along a motion: peak torque by effect, verdicts, and where these change.

    Everything else is kept: a longer link keeps its mass, its inertia, and its centre of mass in the link
    frame, and the joints keep their motion.

    \b
    Examples:
      gd-analyze sweep puma560 pick-and-place --vary joint2.a=0.2..0.6:50
      gd-analyze sweep puma560 pick-and-place --vary link3.mass=1..8:9 --vary speed=0.1..2:20
      gd-analyze sweep puma560 pick-and-place --vary link3.mass=1..5 --samples 10000
    """
    with output.working() as stage:
        from gd_analyze.results.findings import provenance_of_run
        from gd_analyze.robots.description import describe_in_full
        from gd_analyze.studies.study_files import StudyFolder
        from gd_analyze.studies.sweep_result import sweep_result

        arm = robot.load(payload, trajectories)
        motion = read_motions(trajectories, arm)
        words, files = [arm.name, motion.name, *vary, str(dominance), *map(str, settings.values())], None
        if out is not None:
            files = StudyFolder(out, "sweep", formats, words, overwrite=overwrite)
            require_outputs(*files.paths.values())
        dataset = gd.sweep(
            arm, motion, vary, threshold=dominance, stage=stage, progress=stage.advance, **settings
        )
        inputs = [describe_in_full(arm), motion.fingerprint]
        result = sweep_result(dataset, arm, provenance_of_run(command_line(), words, inputs, repeats=True))
        if files is not None:
            stage(f"writing {', '.join(formats)}")
            files.write(result, dataset)
    output.give(result, *(files.paths.values() if files else ()))
