"""`gd-analyze ROBOT TRAJECTORY`, the main job, and `gd-analyze report`, which rebuilds its reports."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import (
    command_of_columns,
    command_that_excites,
    command_that_mends,
    log_options,
    read_motions,
)
from gd_analyze.cli.options import FILE, command_line
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.cli.rules import is_given
from gd_analyze.files import RESULT_FILES, require_one_run

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings
    from gd_analyze.robots.parts import Link

RUN_FORMATS = tuple(RESULT_FILES)
# What can be rebuilt from analysis.h5.
MADE_AGAIN = RUN_FORMATS[1:]


class MainJobContext(click.Context):
    """The main job is called without a verb, and its messages say so."""

    @property
    def command_path(self) -> str:
        """`gd-analyze`."""
        return self.parent.command_path if self.parent is not None else super().command_path


@click.command(hidden=True)
@robot_given
@options.trajectories()
@log_options
@options.folder("Folder for the results.  [default: reports/ROBOT-TRAJECTORY[-OPTIONS]]", RUN_FORMATS)
@options.named_budget()
@options.level()
@options.verdicts
@options.at_set_points
@options.seconds
@options.drives
@options.payload
@options.margin
@options.dominance
@click.option("--fit-friction", is_flag=True, help="Fit friction to the measured torques of a log.")
@click.option(
    "--christoffel/--no-christoffel",
    default=None,
    help="Store h_ijk.  [default: for up to 8192 set points]",
)
@click.option(
    "--every-set-point/--no-every-set-point",
    default=None,
    help="Of more than 8192 set points a selection is shown. Also store D, h, c and torques at all.  "
    "[default: for up to 131072]",
)
@click.option("--by-link", is_flag=True, help="Also store what each link contributes.")
@click.option("--terms", is_flag=True, help="Also store the terms T1..T4, R1, R2 of h.")
@options.top
@reporting
def analyze(
    robot: GivenRobot,
    trajectories: tuple[str, ...],
    out: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    payload: Link | None,
    top: int,
    output: Output,
    **settings: Any,
) -> None:
    """Decompose, rank, simplify, store and report: the main job."""
    with output.working() as progress:
        from gd_analyze.studies.main_job import find
        from gd_analyze.studies.settings import Settings, default_folder
        from gd_analyze.studies.steps.read import source_of
        from gd_analyze.studies.study_files import write_findings

        run_settings = Settings(**settings)
        arm = robot.load(payload, trajectories)
        motion = read_motions(trajectories, arm, progress)
        folder = default_folder(arm, motion, run_settings) if out is None else out
        require_outputs(*(folder / RESULT_FILES[name] for name in formats))
        mark = source_of(arm, motion, run_settings)["run"]
        strangers = require_one_run(folder, RESULT_FILES, formats, mark, overwrite=overwrite)
        findings = find(
            arm,
            motion,
            run_settings,
            command=command_line(),
            warned=output.warnings,
            progress=progress,
        )
        del motion  # the findings hold what is shown of a long one, whose memory the reports can use
        model = folder / RESULT_FILES["json"] if "json" in formats else None
        findings = findings.with_next(_next_command(findings, robot, trajectories, model))
        write_findings(findings, folder, formats, strangers, progress)
    _give(findings, folder, formats, output, top)


def _next_command(
    findings: Findings, robot: GivenRobot, trajectories: Sequence[str], model: Path | None
) -> str:
    """What to type beside a log: what mends the file, or fits its links to the log, or else an export."""
    if "diagnosis" not in findings.tables or "-" in trajectories:
        return ""
    stated, typed = findings.tables["diagnosis"].attrs, shlex.split(command_line())
    verdict = findings.tables["measured_torque"].attrs["verdict"]
    if stated["useless_columns"]:
        return command_of_columns(robot.words, trajectories[0])
    if verdict == "tells nothing":
        return command_that_excites(robot.words)
    if verdict == "agrees" and not stated["identify"]:
        source = robot.words if model is None else [str(model)]
        return shlex.join(["gd-analyze", "export", *source, "--to", "c"])
    # A folder that is named holds this run when the command is typed.
    again = ["--overwrite"] if is_given("--out") and not is_given("--overwrite") else []
    return command_that_mends(
        [*robot.words, *trajectories],
        [*typed, *again],
        identify=bool(stated["identify"]),
        remedy=str(stated["options"]),
    )


analyze.context_class = MainJobContext


@click.command(short_help="Rebuild the reports of a stored analysis.")
@click.argument("analysis", type=FILE, help="The analysis.h5 of a folder that the main job wrote.")
@options.folder("Folder for the reports.  [default: the file's own]", MADE_AGAIN)
@options.top
@reporting
def report(
    analysis: Path, out: Path | None, overwrite: bool, formats: tuple[str, ...], top: int, output: Output
) -> None:
    r"""Rebuild the reports of a stored analysis.h5, without computing anything.

    Reports beside the file are replaced. The terminal shows what the main job showed.

    \b
    Examples:
      gd-analyze report reports/puma560-pick-and-place/analysis.h5
      gd-analyze report analysis.h5 --format html --out elsewhere
    """
    with output.working() as progress:
        from gd_analyze.studies.study_files import write_findings

        folder = analysis.parent if out is None else out
        findings = gd.load_findings(analysis)
        require_outputs(*(folder / RESULT_FILES[name] for name in formats))
        strangers: tuple[Path, ...] = ()
        if (folder / RESULT_FILES["h5"]).resolve() != analysis.resolve():
            mark = findings.provenance.get("run", "")
            strangers = require_one_run(folder, RESULT_FILES, formats, mark, overwrite=overwrite)
        write_findings(findings, folder, formats, strangers, progress)
    output.warn(findings.warnings)  # JSON repeats the run's warnings, standard error does not
    _give(findings, folder, formats, output, top)


def _give(
    findings: Findings,
    folder: Path,
    formats: tuple[str, ...],
    output: Output,
    top: int,
) -> None:
    """Print what was found and which files hold it; `top` rows of the ranking for people."""
    from gd_analyze.report.main_report import JSON, TERMINAL, main_result

    result = main_result(findings, JSON if output.as_json else TERMINAL, top)
    paths = (folder / RESULT_FILES[name] for name in formats)
    next_command = findings.provenance.get("next", "")
    output.give(result, *paths, folder=folder, next_command=next_command)
