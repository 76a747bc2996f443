"""`gd-analyze figures`: elements of D, h and c by effect along a motion, as files."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import log_options, read_motions
from gd_analyze.cli.options import NameList
from gd_analyze.cli.output import Output, reporting, require_outputs
from gd_analyze.files import write_together
from gd_analyze.text import counted

if TYPE_CHECKING:
    from gd_analyze.robots.parts import Link

FIGURE_FORMATS = NameList(("svg", "pdf", "png", "csv"), "format")
SHOWN_EFFECTS = NameList(("combined", "translation", "rotation", "centrifugal", "coriolis"), "effect")


@click.command(short_help="Draw the elements of D, h and c by effect, as files.")
@robot_given
@options.trajectories()
@log_options
@click.option(
    "--to", type=FIGURE_FORMATS, default="svg", metavar="LIST", help="svg, pdf, png, csv; comma-separated."
)
@click.option("--element", "elements", metavar="LABEL", multiple=True, help="D12, h3 or c2; repeatable.")
@click.option("--x", type=click.Choice(("time", "set-point")), default="time", help="Quantity on the x-axis.")
@click.option(
    "--effects",
    type=SHOWN_EFFECTS,
    default="combined,translation,rotation",
    metavar="LIST",
    help="Curves of each element; of h also centrifugal and coriolis.",
)
@click.option("--marks/--no-marks", default=None, help="Mark set points.  [default: if there are up to 50]")
@options.share("--dominance", "10%", "As for the main job.")
@options.drives
@options.payload
@options.out("Folder for the files.  [default: figures]")
@reporting
def figures(
    robot: GivenRobot,
    trajectories: tuple[str, ...],
    to: tuple[str, ...],
    payload: Link | None,
    dominance: float,
    drives: bool | None,
    out: Path | None,
    output: Output,
    **look: Any,
) -> None:
    r"""Draw D, h and c by effect, and which effect dominates when.

    The files are inertia, coriolis_centrifugal, gravity_loading and dominance, as far as --element needs
    them. dominance.csv has parts, shares, verdict and torque at every set point.

    \b
    Examples:
      gd-analyze figures puma560 pick-and-place --to pdf,png
      gd-analyze figures puma560 pick-and-place --element D12 --element h1 --x set-point
      gd-analyze figures puma560 pick-and-place --to csv
    """
    folder = Path("figures") if out is None else out
    with output.working() as progress:
        from gd_analyze.figures.dominance import element_figures, element_numbers
        from gd_analyze.figures.run import Run
        from gd_analyze.report.pdf import drawing_file
        from gd_analyze.result import Fact, Result

        arm = robot.load(payload, trajectories)
        motion = read_motions(trajectories, arm, progress)
        progress.stage("decomposing")
        run = Run.of(arm, motion, dominance, drives)
        progress.stage("drawing")
        contents = {
            folder / f"{name}.{form}": drawing_file(figure, form)
            for name, figure in element_figures(run, **look).items()
            for form in to
            if form != "csv"
        }
        if "csv" in to:
            contents[folder / "dominance.csv"] = element_numbers(run, look["elements"]).encode()
        require_outputs(*contents)
        write_together(contents)
    motion_text = f"{motion.name}, {counted(motion.n_set_points, 'set point')}"
    facts = Fact("arm", "Arm", arm.title or arm.name), Fact("trajectory", "Trajectory", motion_text)
    output.give(Result(title="Figures of elements by effect", facts=facts), *contents)
