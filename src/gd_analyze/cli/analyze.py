"""`gd-analyze ROBOT TRAJECTORY`: the main job."""

from __future__ import annotations

from pathlib import Path

import click

from gd_analyze.cli.given import load_arm_carrying, payload_option
from gd_analyze.cli.levels import level_option, simplify_options
from gd_analyze.cli.options import (
    ROBOT,
    ROBOT_HELP,
    TRAJECTORY,
    TRAJECTORY_HELP,
    NameList,
    command_line,
    top_option,
)
from gd_analyze.cli.output import Output, reporting

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
@click.argument("robot", type=ROBOT, help=ROBOT_HELP)
@click.argument("trajectory", type=TRAJECTORY, help=TRAJECTORY_HELP)
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Folder for the results.  [default: reports/ROBOT-TRAJECTORY]",
)
@click.option(
    "--format",
    "formats",
    type=NameList(FORMATS, "format"),
    default=",".join(FORMATS),
    show_default=True,
    metavar="LIST",
    help="Which files to write, comma-separated.",
)
@click.option(
    "--budget",
    default="1%",
    show_default=True,
    metavar="LIST",
    help="Allowed torque error: a share of each joint's peak torque (1%) or N m (0.5); one for all joints, "
    "or one per joint, comma-separated.",
)
@level_option(None, "term; element for an arm of more than 2000 terms")
@simplify_options
@click.option("--drives", is_flag=True, help="Include drive inertia, as a contribution of its own.")
@payload_option
@click.option(
    "--no-coupling", is_flag=True, help="Leave h_ijk out of analysis.h5: 2 n^3 numbers per set point."
)
@click.option("--by-link", is_flag=True, help="Also store what each link contributes.")
@click.option("--terms", is_flag=True, help="Also store the terms T1..T4, R1, R2 that h consists of.")
@top_option
@reporting
def analyze(
    robot: str,
    trajectory: str,
    out: Path | None,
    formats: tuple[str, ...],
    budget: str,
    level: str | None,
    refit: bool,
    operations: int | None,
    drives: bool,
    payload: str | None,
    no_coupling: bool,
    by_link: bool,
    terms: bool,
    top: int,
    output: Output,
) -> None:
    """Decompose, rank, simplify, store and report: the main job."""
    from gd_analyze.cli.findings import print_findings

    with output.working() as stage:
        stage("reading")
        from gd_analyze import analyze as run
        from gd_analyze.levels import Budget
        from gd_analyze.main_job import Origin, Settings
        from gd_analyze.main_job.folder import default_folder
        from gd_analyze.trajectories import read_trajectory

        settings = Settings(
            budget=Budget.parse(budget),
            level=level,
            refit=refit,
            operations=operations,
            drives=drives,
            coupling=not no_coupling,
            by_link=by_link,
            terms=terms,
        )
        arm = load_arm_carrying(robot, payload)
        motion = read_trajectory(trajectory, arm)
        folder = default_folder(arm, motion) if out is None else out
        origin = Origin(command_line(), tuple(output.warnings))
        findings = run(arm, motion, folder, settings, formats=formats, origin=origin, progress=stage)
        output.warnings.extend(warning for warning in findings.warnings if warning not in output.warnings)
    print_findings(findings, folder, formats, output, top)
