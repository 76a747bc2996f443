"""`gd-analyze compare`: every formulation on one arm, side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.given import load_arm_carrying, payload_option
from gd_analyze.cli.options import (
    ROBOT,
    ROBOT_HELP,
    TRAJECTORY,
    TRAJECTORY_HELP,
    NameList,
    command_line,
)
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.terminal import print_json

if TYPE_CHECKING:
    from gd_analyze.report.comparison import ComparisonContext, Count

FORMATS = ("html", "pdf", "json")


@click.command(short_help="Compare the formulations' cost, speed and torques.")
@click.argument("robot", type=ROBOT, help=ROBOT_HELP)
@click.argument(
    "trajectory",
    type=TRAJECTORY,
    required=False,
    help=f"{TRAJECTORY_HELP} Left out, torques are compared at random states.",
)
@payload_option
@click.option(
    "--symbolic", is_flag=True, help="Only print the text's two-link arm in symbols, by every formulation."
)
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Folder for the results.  [default: reports/compare-ROBOT]",
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
@reporting
def compare(
    robot: str,
    trajectory: str | None,
    payload: str | None,
    symbolic: bool,
    out: Path | None,
    formats: tuple[str, ...],
    output: Output,
) -> None:
    r"""Count, time and compare every formulation of the arm's dynamics.

    Multiplications and additions are counted by running each formulation's own code on numbers that
    count, and set beside the text's polynomials. With --symbolic the two-link arm of the text goes
    through the same code as symbols (needs SymPy).

    \b
    Examples:
      gd-analyze compare puma560
      gd-analyze compare puma560 pick-and-place --payload 2,0,0,0.1
      gd-analyze compare two_link --symbolic
    """
    if symbolic:
        _symbolic(robot, output.as_json)
        return
    with output.working() as stage:
        stage("reading")
        from gd_analyze.comparison import compare as compare_formulations
        from gd_analyze.comparison.compare import STEPS
        from gd_analyze.main_job.folder import require_writable
        from gd_analyze.report.comparison import (
            FILES,
            as_document,
            comparison_context,
            default_folder,
            write_comparison,
        )
        from gd_analyze.trajectories import read_trajectory

        arm = load_arm_carrying(robot, payload)
        motion = None if trajectory is None else read_trajectory(trajectory, arm)
        folder = default_folder(arm.name) if out is None else out
        require_writable(folder)
        stage("comparing, timing, counting", STEPS)
        comparison = compare_formulations(
            arm, motion, command=command_line(), warned=output.warnings, progress=stage.advance
        )
        output.warnings.extend(warning for warning in comparison.warnings if warning not in output.warnings)
        context = comparison_context(comparison)
        stage(f"writing {', '.join(formats)}")
        write_comparison(comparison, context, folder, formats)
        files = [folder / FILES[name] for name in formats]
    if output.as_json:
        print_json(as_document(context) | {"files": [str(path) for path in files]})
    elif not output.quiet:
        _show(context, files)


def _show(context: ComparisonContext, files: list[Path]) -> None:
    from gd_analyze.cli.terminal import line, sentence, table
    from gd_analyze.formatting import number

    sentence(f"{context.title}, {context.subtitle}", bold=True)
    sentence(context.headline)
    table(
        "Kinematics and form of the equations",
        [("", "left"), ("kinematics", "left"), ("equations", "left"), ("order", "left")],
        [[row.short, row.kinematics, row.form, row.order] for row in context.methods],
    )
    rows = [
        [
            row.short,
            _sum(row.executed),
            _sum(row.folded),
            _sum(row.text),
            _microseconds(row.seconds),
            number(row.difference),
        ]
        for row in context.methods
    ]
    theirs = number(max(context.torque_differences[-1]))
    rows.append(["Pinocchio", "-", "-", "-", _microseconds(context.seconds_pinocchio), theirs])
    headings = ("executed", "folded", "text", "time", "difference")
    table(
        "Operations per set point (multiplications + additions): as executed, folded, and the text's "
        f"polynomial at n = {context.n_joints}; time in µs; largest difference of torque, "
        f"{'N m' if context.all_turning else 'N m or N'}",
        [("", "left"), *((heading, "right") for heading in headings)],
        rows,
    )
    table(
        f"Growth: slope of log(operations) over log(n), n = 6 to {context.sizes[-1]}, on a generic chain",
        [("", "left"), ("order", "left"), ("executed", "right"), ("folded", "right"), ("text", "right")],
        [
            [
                row.short,
                row.order,
                f"{row.exponent:.2f}",
                f"{row.exponent_folded:.2f}",
                "-" if row.exponent_text is None else f"{row.exponent_text:.2f}",
            ]
            for row in context.methods
        ],
    )
    line()
    line(f"round-off   explains differences up to {number(context.bounds[3])}")
    for path in files:
        line(f"wrote       {path}")


def _sum(count: Count | None) -> str:
    return "-" if count is None else f"{count.multiplications} + {count.additions}"


def _microseconds(seconds: float) -> str:
    return f"{1e6 * seconds:.2f}"


def _symbolic(robot: str, as_json: bool) -> None:
    """Print D, h and c of the two-link arm by every formulation, and whether they are the text's."""
    from gd_analyze.cli.terminal import line
    from gd_analyze.comparison import METHODS
    from gd_analyze.comparison.symbolic import ClosedForms, same, text_closed_forms, two_link_closed_forms
    from gd_analyze.errors import UsageError

    if robot != "two_link":
        raise UsageError(
            "only the text's two-link arm has closed forms here",
            where="--symbolic",
            expected="two_link",
            found=robot,
        )
    text = text_closed_forms()
    forms = {name: two_link_closed_forms(name) for name in METHODS}

    def entries(found: ClosedForms) -> dict[str, Any]:
        parts = {"D": found.inertia, "h": found.coriolis_centrifugal, "c": found.gravity_loading}
        return {
            f"{symbol}{i + 1}{j + 1 if symbol == 'D' else ''}": str(matrix[i, j])
            for symbol, matrix in parts.items()
            for i in range(matrix.rows)
            for j in range(matrix.cols)
        }

    if as_json:
        print_json(
            {
                "text": entries(text),
                "methods": {
                    name: entries(found) | {"is_the_text's": same(found, text)}
                    for name, found in forms.items()
                },
            }
        )
        return
    # Formulations that end in the same expressions are listed together.
    alike: dict[tuple[tuple[str, str], ...], list[str]] = {}
    for name, found in forms.items():
        alike.setdefault(tuple(entries(found).items()), []).append(name)
    for listed, names in alike.items():
        for label, entry in listed:
            line(f"{label:3} = {entry}")
        line()
        for name in names:
            verdict = "as the text has it" if same(forms[name], text) else "NOT what the text has"
            line(f"{METHODS[name].title}: {verdict}")
