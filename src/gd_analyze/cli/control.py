"""`gd-analyze control`: whether a simplified model is good enough to control its arm along a motion."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

import gd_analyze as gd
from gd_analyze.cli.given import carrying, payload_option
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import (
    FILE,
    TRAJECTORY,
    PositiveNumber,
    command_line,
    formats_option,
    number_read,
    out_option,
    overwrite_option,
    together,
)
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs

FORMATS = ("html", "pdf", "json")


class _Numbers(click.ParamType[tuple[float, ...]]):
    """Numbers above zero, comma-separated; of rates also the word for a loop without a period."""

    name = "list"

    def __init__(self, word: str = "") -> None:
        self._word = word

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """Read them."""
        if isinstance(value, tuple):
            return value
        numbers = []
        for place, entry in enumerate(str(value).split(","), start=1):
            word = entry.strip()
            number = float("inf") if self._word and word == self._word else number_read(word)
            if not number > 0 or (number == float("inf") and word != self._word):
                more = f", or {self._word}" if self._word else ""
                self.fail(f"entry {place}, {word!r}, is not a number above 0{more}", param, ctx)
            numbers.append(number)
        return tuple(numbers)


class _Scale(PositiveNumber):
    """A number above zero, or off."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Read it; infinity stands for off."""
        if value == float("inf") or str(value).strip() == "off":
            return float("inf")
        return super().convert(value, param, ctx)


_loop_options = together(
    click.option(
        "--loop-rate",
        "rates",
        type=_Numbers("continuous"),
        default="continuous,500,100",
        show_default=True,
        metavar="LIST",
        help="Loop rates, Hz, comma-separated: torque is held over a period; `continuous` holds nothing.",
    ),
    click.option(
        "--speeds",
        type=_Numbers(),
        default="0.25,0.5,1,2",
        show_default=True,
        metavar="LIST",
        help="How many times as fast as planned to run the motion, comma-separated.",
    ),
    click.option(
        "--bandwidth",
        type=PositiveNumber(),
        default=20.0,
        show_default=True,
        metavar="NUMBER",
        help="Natural frequency of every joint's error, rad/s; 6.28 rad/s are 1 Hz.",
    ),
    click.option(
        "--damping",
        type=PositiveNumber(),
        default=1.0,
        show_default=True,
        metavar="NUMBER",
        help="Damping ratio of every joint's error; 1 is critical.",
    ),
    click.option(
        "--torque-limits",
        type=_Scale(),
        default=1.0,
        show_default=True,
        metavar="NUMBER|off",
        help="Hold torque within so many times the limits of the arm's drives, or not at all.",
    ),
    click.option(
        "--friction", is_flag=True, help="Apply the drives' friction, which no controller knows of."
    ),
    click.option(
        "--within",
        metavar="LIST",
        help="Tracking error that counts as good: 0.1deg or 2mrad, and 1mm for prismatic joints.  "
        "[default: 0.1deg,1mm]",
    ),
)


@click.command(short_help="Control the arm with a simplified model, and see how it tracks.")
@click.argument("model", type=FILE, help="A model.json that gd-analyze wrote.")
@click.argument(
    "trajectory",
    type=TRAJECTORY,
    help="CSV file, log (its options: `gd-analyze columns --help`), name of a shipped trajectory, or - for "
    "standard input.",
)
@log_options
@payload_option
@_loop_options
@out_option("Folder for a report; nothing is written without it.")
@overwrite_option
@formats_option(FORMATS)
@reporting
def control(
    model: Path,
    trajectory: str,
    payload: str | None,
    rates: tuple[float, ...],
    speeds: tuple[float, ...],
    bandwidth: float,
    damping: float,
    torque_limits: float,
    friction: bool,
    within: str | None,
    out: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    output: Output,
) -> None:
    r"""Control the exact arm, simulated, along a motion, and say whether the simplified model is good enough.

    Controllers know nothing of the arm, gravity only, all but h, the simplified model, or the exact one.
    Computed torque is D (qdd_d + K_d e' + K_p e) + h + c with what the controller knows; PD compensates
    gravity only. The founding text warns of dropping h: the motion is run at several speeds to show from
    where on that costs. With --payload the arm carries a load that no controller knows of. Bounds on the
    error caused by the model's torque error stand beside the simulated error.

    \b
    Examples:
      gd-analyze control model.json pick-and-place
      gd-analyze control model.json my.csv --loop-rate 1000,250 --bandwidth 30
      gd-analyze control model.json my.csv --payload 2,0,0,0.1 --out report
    """
    with output.working() as stage:
        stage("reading")
        from gd_analyze.robots.payload import parse_payload
        from gd_analyze.studies.control import names_of
        from gd_analyze.studies.control_result import control_result
        from gd_analyze.studies.study_files import StudyFolder

        settings = gd.ControlSettings(
            bandwidth=bandwidth,
            damping=damping,
            rates=rates,
            speeds=speeds,
            limits=None if torque_limits == float("inf") else torque_limits,
            friction=friction,
            tolerance=gd.Tolerance() if within is None else gd.Tolerance.parse(within),
        )
        loaded = gd.load_model(model)
        moved = None if payload is None else carrying(loaded.arm, parse_payload(payload))
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
        output.warnings.extend(text for text in study.warnings if text not in output.warnings)
        result = control_result(study)
        if files is not None:
            stage(f"writing {', '.join(formats)}")
            files.write(result)
    output.give(result, wrote=None if files is None else [*files.paths.values()])
