"""`gd-analyze control`: whether a simplified model is good enough to control its arm along a motion."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

import gd_analyze as gd
from gd_analyze.cli import options
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import Amount, Parsed, command_line
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.units import Quantity

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link


def _numbers(kind: str = "", endless: str = "") -> Callable[[str], tuple[float, ...]]:
    """Reader of numbers above zero, comma-separated, or the word for infinity."""

    def read(words: str) -> tuple[float, ...]:
        numbers = []
        for place, word in enumerate(map(str.strip, words.split(",")), start=1):
            number = math.inf if endless and word == endless else Quantity.si_of(word, kind)
            if number is None or not number > 0 or (number == math.inf and word != endless):
                remark = f", or {endless}" if endless else ""
                raise click.BadParameter(f"entry {place}, {word!r}, is not a number above 0{remark}")
            numbers.append(number)
        return tuple(numbers)

    return read


def _parse_tolerance(text: str) -> gd.types.Tolerance:
    from gd_analyze.studies.control_law import Tolerance

    return Tolerance.parse(text)


@click.command(short_help="Simulate control with a simplified model; see how it tracks.")
@options.model
@options.trajectory()
@log_options
@options.payload
# Options named as the fields of `ControlSettings`, up to --within.
@click.option(
    "--loop-rate",
    "rates",
    type=_numbers("frequency", "continuous"),
    default="continuous,500,100",
    metavar="LIST",
    help="Loop rates, Hz, or `continuous`.",
)
@click.option(
    "--speeds",
    type=_numbers(),
    default="0.25,0.5,1,2",
    metavar="LIST",
    help="Speeds of the motion, as multiples of the planned one.",
)
@click.option(
    "--bandwidth",
    type=Amount("angular frequency"),
    default=20.0,
    metavar="NUMBER",
    help="Natural frequency of every joint's error, rad/s.",
)
@click.option(
    "--damping",
    type=Amount(),
    default=1.0,
    metavar="NUMBER",
    help="Damping ratio of every joint's error; 1 is critical.",
)
@click.option(
    "--torque-limits",
    "limits",
    type=lambda words: None if words == "off" else Amount()(words),
    default="1.0",
    metavar="NUMBER|off",
    help="Torque limits, as a multiple of the drives' own; `off`: no limits.",
)
@click.option("--friction", is_flag=True, help="Simulate the drives' friction; no controller compensates it.")
@click.option(
    "--within",
    "tolerance",
    type=Parsed("tolerance", _parse_tolerance),
    default="0.1deg,1mm",
    metavar="LIST",
    help="Acceptable tracking error: 0.1deg or 2mrad, and 1mm for prismatic joints.",
)
@options.folder("Folder for a report; nothing is written without it.")
@reporting
def control(
    model: Path,
    trajectory: str,
    payload: Link | None,
    out: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    output: Output,
    **loop: Any,
) -> None:
    r"""Simulate control of the exact arm along a motion, to judge the simplified model.

    Five controllers: computed torque with the exact model, the simplified one, and the exact one without h;
    fixed gains with the simplified torque; PD with the simplified c. With --payload the arm carries a load
    that none of them knows. Bounds on the tracking error stand beside the simulated one. docs/control.md says
    more.

    \b
    Examples:
      gd-analyze control model.json pick-and-place
      gd-analyze control model.json my.csv --loop-rate 1000,250 --bandwidth 30
      gd-analyze control model.json my.csv --payload 2,0,0,0.1 --out report
    """
    with output.working() as stage:
        from gd_analyze.robots.payload import carrying
        from gd_analyze.studies.control import names_of
        from gd_analyze.studies.control_law import ControlSettings
        from gd_analyze.studies.control_result import control_result
        from gd_analyze.studies.study_files import StudyFolder

        loaded = gd.load_model(model)
        settings = ControlSettings(**loop)
        settings.tolerance.require_joint_of(loaded.arm)
        moved = None if payload is None else carrying(loaded.arm, payload)
        motion = read_motion(trajectory, loaded.arm)
        files = None
        if out is not None:
            names = names_of(moved or loaded.arm, motion, settings)
            files = StudyFolder(out, "control", formats, names, overwrite=overwrite)
            require_outputs(*files.paths.values())
        stage("simulating", 100)
        study = gd.control(
            loaded,
            motion,
            settings,
            moved,
            command=command_line(),
            warned=output.warnings,
            progress=stage.advance,
        )
        result = control_result(study)
        if files is not None:
            stage(f"writing {', '.join(formats)}")
            files.write(result)
    output.give(result, *(files.paths.values() if files else ()))
