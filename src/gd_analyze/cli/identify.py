"""`gd-analyze identify`: the links, drives and friction that logs of an arm support."""

from __future__ import annotations

import shlex
from pathlib import Path

import click

import gd_analyze as gd
from gd_analyze.cli import log_options, options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.options import TRAJECTORY, command_line
from gd_analyze.cli.output import Output, reporting, require_outputs


@click.command(short_help="Fit links, drives and friction to logs with torques.")
@robot_given
@log_options.logs
@click.option(
    "--held-out",
    type=TRAJECTORY,
    multiple=True,
    metavar="LOG",
    help="A log that is predicted, not fitted, or a folder; may be repeated.  [default: the last third of "
    "every log]",
)
@click.option(
    "--loaded",
    type=TRAJECTORY,
    multiple=True,
    metavar="LOG",
    help="A log with an unknown payload, which is identified, too, or a folder. May be repeated.",
)
@click.option(
    "--mass",
    type=options.Amount("mass", 1e-3, 1e3),
    metavar="KG",
    help="Mass of that payload, if known: all torques are scaled to meet it.",
)
@click.option(
    "--plain",
    is_flag=True,
    help="Plain least squares: bodies may be physically inconsistent.",
)
@click.option(
    "--no-model",
    is_flag=True,
    help="Skip the search for the model that the logs support.",
)
@click.option(
    "--anyway",
    is_flag=True,
    help="Identify even where `diagnose` finds a cause beside the links' numbers, or a column is useless.",
)
@options.out("Write the identified arm into this TOML file.")
@options.folder("Folder for a report; without it none is written.", option="--report")
@reporting
def identify(
    robot: GivenRobot,
    logs: tuple[str, ...],
    held_out: tuple[str, ...],
    loaded: tuple[str, ...],
    mass: float | None,
    plain: bool,
    no_model: bool,
    anyway: bool,
    out: Path | None,
    report: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    output: Output,
) -> None:
    r"""Fit an arm's links, drives and friction to logs of motions and torques.

    What the logs do not determine keeps the file's values. The result states how well the fit predicts
    held-out torques, and what of it is doubtful. With -o the last line is the command that takes the fitted
    arm along the logs, read in the same way.

    \b
    Examples:
      gd-analyze identify my_robot.urdf log.csv -o identified.toml
      gd-analyze identify my_robot.urdf a.csv b.csv --held-out c.csv --report report
      gd-analyze identify my_robot.urdf bare.csv --loaded gripping.csv --mass 2.8
      gd-analyze simplify identified.toml log.csv --budget uncertainty
    """
    require_outputs(out)
    with output.working() as progress:
        from gd_analyze.results.findings import provenance
        from gd_analyze.robots.arm_toml import require_name_of_toml
        from gd_analyze.studies.identification_result import identification_result, supported
        from gd_analyze.studies.study_files import StudyFolder

        if out is not None:
            require_name_of_toml(out)
        arm = robot.load(logs=logs, masses=False)
        fitted, held_out_motions, carrying = (
            log_options.read_logs(words, arm, progress) for words in (logs, held_out, loaded)
        )
        motions = [motion.fingerprint for motion in (*fitted, *held_out_motions, *carrying)]
        inputs = [arm.name, *motions, str(plain), *([] if mass is None else [f"{mass:g} kg"])]
        files = StudyFolder(report, "identification", formats, inputs, overwrite=overwrite)
        require_outputs(*files.paths)
        progress.stage("identifying")
        identification = gd.identify(
            arm,
            fitted,
            held_out=held_out_motions or None,
            loaded=carrying or None,
            mass=mass,
            physical=not plain,
            anyway=anyway,
        )
        if out is not None:
            # Before the search for a model, which may take long or come to nothing.
            progress.stage(f"writing {out.name}")
            gd.save_arm(identification.arm, out)
        progress.stage("simplifying")
        answer = None if no_model or identification.doubts else supported(identification, fitted[0])
        result = identification_result(identification, answer, provenance(command_line()))
        files.write(result, progress)
    next_command = ""  # standard input cannot be read again
    if out is not None and "-" not in logs:
        next_command = shlex.join(["gd-analyze", str(out), *logs, *log_options.words_of_reading()])
    output.give(result, out, *files.paths, next_command=next_command)
