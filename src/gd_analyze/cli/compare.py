"""`gd-analyze compare`: every formulation on one arm, side by side."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.given import GivenRobot, load_arm_carrying, payload_option, robot_given
from gd_analyze.cli.log_options import log_options, read_motion
from gd_analyze.cli.options import (
    command_line,
    formats_option,
    out_option,
    overwrite_option,
    trajectory_argument,
)
from gd_analyze.cli.output import Output, reporting
from gd_analyze.cli.outputs import require_outputs
from gd_analyze.cli.terminal import line, print_json, sentence, table

if TYPE_CHECKING:
    from gd_analyze.studies.symbolic import ClosedForms

FORMATS = ("html", "pdf", "json")


@click.command(short_help="Compare the formulations' cost, speed and torques.")
@robot_given
@trajectory_argument("Left out, torques are compared at random states.")
@log_options
@payload_option
@click.option(
    "--symbolic", is_flag=True, help="Only print FGL87's two-link arm in symbols, by every formulation."
)
@out_option("Folder for the results.  [default: reports/compare-ROBOT[-TRAJECTORY]]")
@overwrite_option
@formats_option(FORMATS)
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

    Multiplications and additions are counted by running each formulation's own code on numbers that
    count, and set beside the founding text's polynomials. With --symbolic its two-link arm goes
    through the same code as symbols (needs SymPy).

    \b
    Examples:
      gd-analyze compare puma560
      gd-analyze compare puma560 pick-and-place --payload 2,0,0,0.1
      gd-analyze compare two_link --symbolic
    """
    if symbolic:
        _symbolic(robot.name, output.as_json)
        return
    with output.working() as stage:
        stage("reading")
        from gd_analyze.studies.compare import STEPS, names_of
        from gd_analyze.studies.compare import compare as compare_formulations
        from gd_analyze.studies.comparison_document import comparison_document
        from gd_analyze.studies.comparison_files import FILES, default_folder, write_comparison
        from gd_analyze.studies.study_files import require_folder

        arm = load_arm_carrying(robot, payload)
        motion = None if trajectory is None else read_motion(trajectory, arm)
        folder = default_folder(arm, motion) if out is None else out
        files = [folder / FILES[name] for name in formats]
        require_outputs(*files)
        strangers = require_folder(folder, formats, FILES, names_of(arm, motion), overwrite=overwrite)
        stage("comparing, timing, counting", STEPS)
        comparison = compare_formulations(
            arm, motion, command=command_line(), warned=output.warnings, progress=stage.advance
        )
        output.warnings.extend(warning for warning in comparison.warnings if warning not in output.warnings)
        stage(f"writing {', '.join(formats)}")
        write_comparison(comparison, folder, formats, strangers)
    document = comparison_document(comparison)
    output.give(lambda: document | {"files": [str(path) for path in files]}, lambda: _show(document, files))


def _show(told: dict[str, Any], files: list[Path]) -> None:
    from gd_analyze.text import number

    def pair(count: dict[str, int] | None) -> str:
        return "-" if count is None else f"{count['multiplications']} + {count['additions']}"

    def microseconds(seconds: float) -> str:
        return f"{1e6 * seconds:.2f}"

    sentence(f"{told['title']}, {told['subtitle']}", bold=True)
    sentence(told["headline"])
    methods = told["methods"]
    table(
        "Kinematics and form of the equations",
        ["", "kinematics", "equations", "order"],
        [[row["short"], row["kinematics"], row["form"], row["order"]] for row in methods],
        "llll",
    )
    rows = [
        [
            row["short"],
            *(pair(row[which]) for which in ("executed", "folded", "text")),
            microseconds(row["seconds"]),
            number(row["difference"]),
        ]
        for row in methods
    ]
    theirs = number(max(told["torque_differences"][-1]))
    rows.append(["Pinocchio", "-", "-", "-", microseconds(told["seconds_pinocchio"]), theirs])
    table(
        "Operations per set point (multiplications + additions): as executed, folded, and FGL87's "
        f"polynomial at n = {told['n_joints']}; time in µs; largest difference of torque, "
        f"{'N m' if told['all_turning'] else 'N m or N'}",
        ["", "executed", "folded", "FGL87", "time", "difference"],
        rows,
    )
    slopes = ("exponent", "exponent_folded", "exponent_text")
    table(
        f"Growth: slope of log(operations) over log(n), n = 6 to {told['sizes'][-1]}, on a generic chain",
        ["", "order", "executed", "folded", "FGL87"],
        [
            [row["short"], row["order"], *("-" if row[s] is None else f"{row[s]:.2f}" for s in slopes)]
            for row in methods
        ],
        "ll",
    )
    line()
    line(f"round-off   explains differences up to {number(told['bounds'][3])}")
    for path in files:
        line(f"wrote       {path}")


def _symbolic(robot: str, as_json: bool) -> None:
    """Print D, h and c of the two-link arm by every formulation, and whether they are the founding text's."""
    from gd_analyze.dynamics.methods import METHODS
    from gd_analyze.errors import UsageError
    from gd_analyze.studies.symbolic import same, text_closed_forms, two_link_closed_forms

    if robot != "two_link":
        raise UsageError(
            "only the founding text's two-link arm has closed forms here",
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

    methods = {name: entries(found) | {"is_the_text's": same(found, text)} for name, found in forms.items()}
    if as_json:
        print_json({"text": entries(text), "methods": methods})
        return
    # Formulations that end in the same expressions are listed together.
    alike: dict[tuple[tuple[str, Any], ...], list[str]] = {}
    for name, told in methods.items():
        alike.setdefault(tuple(told.items()), []).append(METHODS[name].title)
    for (*listed, (_, is_the_texts)), titles in alike.items():
        for label, entry in listed:
            line(f"{label:3} = {entry}")
        line()
        for title in titles:
            line(f"{title}: {'as FGL87 has it' if is_the_texts else 'NOT what FGL87 has'}")
