"""`gd-analyze diagnose`: why logs and an arm's file disagree."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli import log_options, options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.options import command_line
from gd_analyze.cli.output import Output, reporting, require_outputs

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link


@click.command(short_help="Say why logs and an arm's file disagree, and what mends it.")
@robot_given
@log_options.logs
@options.payload
@options.folder("Folder for a report; without it none is written.", option="--report")
@reporting
def diagnose(
    robot: GivenRobot,
    logs: tuple[str, ...],
    payload: Link | None,
    report: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    output: Output,
) -> None:
    r"""Say why logs and an arm's file disagree.

    Signs, units, gears, columns, zeros, coupled joints, gravity, payloads and late torques are tried, alone
    and in pairs. The answer names what explains the log, with the options that mend it.

    \b
    Examples:
      gd-analyze diagnose my_robot.urdf log.csv
      gd-analyze diagnose my_robot.urdf log.csv --torque-sign -1
      gd-analyze diagnose my_robot.urdf a.csv b.csv --report report
      gd-analyze diagnose my_robot.urdf logs
    """
    with output.working() as progress:
        from gd_analyze.diagnosis.answer import has_useless_columns, is_for_identification, word_of
        from gd_analyze.results.diagnosis_result import diagnosis_result
        from gd_analyze.results.findings import provenance
        from gd_analyze.studies.study_files import StudyFolder

        arm = robot.load(payload, logs)
        motions = log_options.read_logs(logs, arm, progress)
        inputs = [arm.name, *(motion.fingerprint for motion in motions)]
        files = StudyFolder(report, "diagnosis", formats, inputs, overwrite=overwrite)
        require_outputs(*files.paths)
        progress.stage("diagnosing")
        diagnosis = gd.diagnose(arm, motions)
        result = diagnosis_result(diagnosis, provenance(command_line()))
        files.write(result, progress)
        carried = log_options.words_typed("--payload")
        main_job = ["gd-analyze", *robot.words, *logs, *log_options.words_of_reading(), *carried]
        next_command = shlex.join(main_job)
        identify, word = is_for_identification(diagnosis), word_of(diagnosis)
        if has_useless_columns(diagnosis):
            next_command = log_options.command_of_columns(robot.words, logs[0])
        elif word == "tells nothing":
            next_command = log_options.command_that_excites(robot.words)
        elif word != "agrees" or identify:
            next_command = log_options.command_that_mends(
                [*robot.words, *logs],
                main_job,
                identify=identify,
                remedy=diagnosis.remedy.options if diagnosis.remedy.is_all_typed else "",
            )
    # Standard input cannot be read again.
    output.give(result, *files.paths, next_command="" if "-" in logs else next_command)
