"""`gd-analyze compare`: every formulation on one arm, side by side."""

from __future__ import annotations

from pathlib import Path

import click

from gd_analyze.cli import options
from gd_analyze.cli.given import GivenRobot, robot_given
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import command_line
from gd_analyze.cli.output import Output, reporting, require_outputs


@click.command(short_help="Compare the formulations' cost, speed and torques.")
@robot_given
@options.trajectory("Without one: torques are compared at random states.")
@log_options
@options.payload
@click.option(
    "--symbolic", is_flag=True, help="Only print FGL87's two-link arm in symbols, by every formulation."
)
@options.folder("Folder for the results.  [default: reports/compare-ROBOT[-TRAJECTORY]]")
@reporting
def compare(
    robot: GivenRobot,
    trajectory: str | None,
    payload: str | None,
    symbolic: bool,
    out: Path | None,
    overwrite: bool,
    formats: tuple[str, ...],
    output: Output,
) -> None:
    r"""Count, time and compare every formulation of the arm's dynamics.

    Multiplications and additions are counted by running each formulation's own code on numbers that count,
    and shown beside the founding text's polynomials. With --symbolic the same code runs on symbols for the
    founding text's two-link arm (needs SymPy).

    \b
    Examples:
      gd-analyze compare puma560
      gd-analyze compare puma560 pick-and-place --payload 2,0,0,0.1
      gd-analyze compare two_link --symbolic
    """
    if symbolic:
        from gd_analyze.studies.symbolic import symbolic_result

        output.give(symbolic_result(robot.name))
        return
    with output.working() as stage:
        from gd_analyze.studies import comparison
        from gd_analyze.studies.study_files import StudyFolder

        arm = robot.load(payload)
        motion = None if trajectory is None else read_motion(trajectory, arm)
        names = comparison.names_of(arm, motion)
        folder = out or Path("reports") / "-".join(["compare", *filter(None, names)])
        files = StudyFolder(folder, "comparison", formats, names, overwrite=overwrite)
        require_outputs(*files.paths.values())
        stage("comparing, timing, counting", comparison.STEPS)
        found = comparison.compare(
            arm, motion, command=command_line(), warned=output.warnings, progress=stage.advance
        )
        output.warn(found.warnings)
        result = comparison.comparison_result(found)
        stage(f"writing {', '.join(formats)}")
        files.write(result)
    output.give(result, *files.paths.values())
