"""`gd-analyze ROBOT TRAJECTORY`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import GivenRobot, drives_option, load_arm_carrying, payload_option, robot_given
from gd_analyze.cli.levels import budget_option, level_option, simplify_options
from gd_analyze.cli.log_options import log_options, read_motions
from gd_analyze.cli.options import (
    command_line,
    formats_option,
    margin_option,
    out_option,
    overwrite_option,
    top_option,
    trajectories_argument,
)
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs

FORMATS = ("h5", "json", "csv", "html", "pdf")


class MainJobContext(click.Context):
    """The main job is called without a verb, and its messages shall say so."""

    @property
    def command_path(self) -> str:
        """`gd-analyze`."""
        return self.parent.command_path if self.parent is not None else super().command_path


class MainJob(click.Command):
    """A command that stands for the program itself."""

    context_class = MainJobContext


@click.command(cls=MainJob, hidden=True)
@robot_given
@trajectories_argument()
@log_options
@out_option("Folder for the results.  [default: reports/ROBOT-TRAJECTORY[-OPTIONS]]")
@overwrite_option
@formats_option(FORMATS)
@budget_option()
@level_option()
@simplify_options
@drives_option
@payload_option
@margin_option("How far states may be from the motion for which the model's errors are proven")
@click.option(
    "--fit-friction",
    is_flag=True,
    help="Say which friction explains measured torques beside the model.",
)
@click.option(
    "--no-christoffel", is_flag=True, help="Leave h_ijk out of analysis.h5: 2 n^3 numbers per set point."
)
@click.option("--by-link", is_flag=True, help="Also store what each link contributes.")
@click.option("--terms", is_flag=True, help="Also store the terms T1..T4, R1, R2 that h consists of.")
@top_option
@reporting
def analyze(
    robot: GivenRobot,
    trajectories: tuple[str, ...],
    out: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    budget: str,
    payload: str | None,
    no_christoffel: bool,
    top: int,
    output: Output,
    **settings: Any,
) -> None:
    """Decompose, rank, simplify, store and report: the main job."""
    from gd_analyze.cli.findings import print_findings

    with output.working() as stage:
        stage("reading")
        from gd_analyze.studies.main_job import Origin, default_folder, source_of
        from gd_analyze.studies.main_job_files import FILES, require_folder, write_findings

        how = gd.Settings(budget=gd.Budget.parse(budget), christoffel=not no_christoffel, **settings)
        arm = load_arm_carrying(robot, payload)
        motion = read_motions(trajectories, arm)
        folder = default_folder(arm, motion, how) if out is None else out
        require_outputs(*(folder / FILES[name] for name in formats))
        mark = source_of(arm, motion, how)["run"]
        strangers = require_folder(folder, formats, mark, overwrite=overwrite)
        origin = Origin(command_line(), tuple(output.warnings))
        findings = gd.find(arm, motion, how, origin=origin, progress=stage)
        stage(f"writing {', '.join(formats)}")
        write_findings(findings, folder, formats, strangers)
        output.warnings.extend(warning for warning in findings.warnings if warning not in output.warnings)
    print_findings(findings, folder, formats, output, top)
