"""`gd-analyze export`: models, exact dynamics and decompositions in other languages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.options import NameList, OutputPath
from gd_analyze.cli.other_words import OF_FUNCTIONS, OF_LANGUAGES
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.errors import ModelError, OutputError, warn_caller
from gd_analyze.exporting.names import LANGUAGES

if TYPE_CHECKING:
    from gd_analyze.exporting.export_input import ExportInput


@click.command(short_help="Write a model, or exact dynamics, in C, Python, MATLAB, ...")
@robot_given
@click.option(
    "--to",
    "languages",
    type=NameList(LANGUAGES, "language", OF_LANGUAGES),
    required=True,
    metavar="LIST",
    help=f"Languages, comma-separated: {', '.join(LANGUAGES)}.",
)
@click.option(
    "--what",
    "functions",
    type=NameList(
        (
            *("torque", "derivatives", "coriolis_matrix", "forward", "payload", "friction"),
            *("regressor", "parameters", "decomposition"),
        ),
        "function",
        OF_FUNCTIONS,
    ),
    default="torque",
    metavar="LIST",
    help="Functions beside torque, D, h and c: derivatives (of torque), coriolis_matrix, forward "
    "(accelerations), payload (torque of a load), friction (of the drives), regressor, parameters (by base "
    "parameters). Or decomposition: D and h by effect, and c, of the links alone.",
)
@click.option("--name", metavar="WORD", help="Prefix of all names.  [default: from the arm's name]")
@click.option(
    "--float",
    "scalar",
    flag_value="float",
    default="double",
    show_default=False,
    help="In C: single precision.",
)
@click.option(
    "--bound/--no-bound",
    default=True,
    help="For a model: prove a bound on its error within the arm's limits, and write both.",
)
@click.option(
    "--tests",
    is_flag=True,
    help="Also write tests of the exported code: C and C++ with CMakeLists.txt, pytest, MATLAB.",
)
@options.drives
@click.option("-o", "--out", type=OutputPath(), default=Path(), help="Folder to write to.")
@click.option("--overwrite", is_flag=True, help="Replace existing files.")
@reporting
def export(
    robot: GivenRobot,
    languages: tuple[str, ...],
    functions: tuple[str, ...],
    name: str | None,
    scalar: str,
    bound: bool,
    tests: bool,
    drives: bool | None,
    out: Path,
    overwrite: bool,
    output: Output,
) -> None:
    r"""Write a simplified model, or the exact dynamics of an arm, in other languages.

    ROBOT is the model.json of a simplified model, or an arm for its exact dynamics.

    \b
    Examples:
      gd-analyze export model.json --to c
      gd-analyze export model.json --to python,matlab --out controller
      gd-analyze export puma560 --to casadi
      gd-analyze export model.json --to c,cpp --what derivatives,coriolis_matrix,forward
      gd-analyze export puma560 --to c --what decomposition
    """
    with output.working() as progress:
        from gd_analyze.certification.certificate import EXPORT_EFFORT, usual_effort
        from gd_analyze.exporting.export import languages_named, written
        from gd_analyze.exporting.vectors import names_of_tests

        chosen = languages_named(languages, scalar)
        subject = _subject(robot, functions, name, drives)
        suffixes = [suffix for language in chosen.values() for suffix in language.files]
        names = [f"{subject.name}{suffix}" for suffix in suffixes]
        names += names_of_tests(subject.name, languages) if tests else []
        paths = [out / name for name in names]
        require_outputs(*paths)
        existing = [path for path in paths if path.exists()]
        if existing and not overwrite:
            raise OutputError(
                "the file exists",
                where=", ".join(map(str, existing)),
                next_step="name another folder with --out or another name with --name, or give --overwrite",
            )
        if subject.model is not None and bound:
            progress.stage("writing the model out")
            try:
                effort = usual_effort(subject.model, EXPORT_EFFORT)
                if effort is None:
                    raise ModelError(
                        "the model is too long for a bound in seconds; `gd-analyze certify` finds one"
                    )
                certificate = gd.certify(subject.model, effort=effort, progress=progress)
                subject = replace(subject, certificate=certificate)
            except ModelError as error:
                subject = replace(subject, unproven=error.what)
                message = f"no bound is written: {error.what}; --no-bound omits it without a warning"
                warn_caller(message)
        progress.stage("writing")
        exported = written(subject, languages, scalar, tests=tests)
        exported.save(out)
    output.give(exported.result(), *exported.paths(out))


def _subject(
    robot: GivenRobot, functions: tuple[str, ...], name: str | None, drives: bool | None
) -> ExportInput:
    """What is exported: a model where a JSON file is named, an arm otherwise."""
    from gd_analyze.exporting.export_input import ExportInput
    from gd_analyze.simplification.exact import ExactForm

    if Path(robot.name).suffix.lower() == ".json":
        if drives is not None or robot != GivenRobot(robot.name):
            raise click.UsageError("--drives, --tip, --gravity and others are for arms: a model has its own")
        if "decomposition" in functions:
            raise click.UsageError("--what decomposition needs an arm: give it in place of the model")
        return ExportInput.of_model(gd.load_model(robot.name), name).with_functions(functions)
    arm = robot.load()
    if "decomposition" not in functions:
        return ExportInput.of_exact(ExactForm(arm, arm.counts_drives(drives)), name).with_functions(functions)
    if len(functions) > 1:
        raise click.UsageError("--what decomposition cannot be combined with other functions")
    if drives:
        raise click.UsageError("--what decomposition is for the links alone: omit --drives")
    return ExportInput.of_decomposition(arm, name)
