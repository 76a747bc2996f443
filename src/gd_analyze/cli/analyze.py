"""`gd-analyze ROBOT TRAJECTORY`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.given import load_arm_carrying, payload_option
from gd_analyze.cli.levels import level_option, simplify_options
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
    from gd_analyze.findings import Findings
    from gd_analyze.report.context import Context
    from gd_analyze.robots import RobotArm

FORMATS = ("h5", "json", "csv", "html", "pdf")
_SHORT = {
    "translation": "tran",
    "rotation": "rot",
    "both": "both",
    "negligible": "negl.",
    "neither": "-",
    "": "",
}
_COUNTS = ("multiplications", "additions", "sines_cosines")


class MainJobContext(click.Context):
    """The main job is called without a verb, and its messages shall say so."""

    @property
    def command_path(self) -> str:
        """`gd-analyze`."""
        return self.parent.command_path if self.parent is not None else super().command_path


class MainJob(click.Command):
    """A command that stands for the program itself."""

    context_class = MainJobContext


@click.command(cls=MainJob, hidden=True)
@click.argument("robot", type=ROBOT, help=ROBOT_HELP)
@click.argument("trajectory", type=TRAJECTORY, help=TRAJECTORY_HELP)
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Folder for the results.  [default: reports/ROBOT-TRAJECTORY]",
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
@click.option(
    "--budget",
    default="1%",
    show_default=True,
    metavar="LIST",
    help="Allowed torque error: a share of each joint's peak torque (1%) or N m (0.5); one for all joints, "
    "or one per joint, comma-separated.",
)
@level_option(None, "term; element for an arm of more than 2000 terms")
@simplify_options
@click.option("--drives", is_flag=True, help="Include drive inertia, as a contribution of its own.")
@payload_option
@click.option(
    "--no-coupling", is_flag=True, help="Leave h_ijk out of analysis.h5: 2 n^3 numbers per set point."
)
@click.option("--by-link", is_flag=True, help="Also store what each link contributes.")
@click.option("--terms", is_flag=True, help="Also store the terms T1..T4, R1, R2 that h consists of.")
@click.option(
    "--top",
    type=click.IntRange(min=0),
    default=12,
    show_default=True,
    metavar="NUMBER",
    help="Rows of the ranking to print.",
)
@reporting
def analyze(
    robot: str,
    trajectory: str,
    out: Path | None,
    formats: tuple[str, ...],
    budget: str,
    level: str | None,
    refit: bool,
    operations: int | None,
    drives: bool,
    payload: str | None,
    no_coupling: bool,
    by_link: bool,
    terms: bool,
    top: int,
    output: Output,
) -> None:
    """Decompose, rank, simplify, store and report: the main job."""
    with output.working() as stage:
        stage("reading")
        from gd_analyze.levels import Budget
        from gd_analyze.main_job import find
        from gd_analyze.results import FILES, default_folder, require_writable, write_findings
        from gd_analyze.trajectories import read_trajectory

        allowed = Budget.parse(budget)
        arm = load_arm_carrying(robot, payload)
        motion = read_trajectory(trajectory, arm)
        folder = default_folder(arm, motion) if out is None else out
        require_writable(folder)
        decomposed = 0

        def progress(done: int) -> None:
            nonlocal decomposed
            decomposed += done
            stage.advance(done)
            if decomposed == motion.n_set_points:
                stage("checking, ranking, simplifying")

        stage("decomposing", motion.n_set_points)
        findings = find(
            arm,
            motion,
            budget=allowed,
            level=level,
            refit=refit,
            operations=operations,
            drives=drives,
            coupling=not no_coupling,
            by_link=by_link,
            terms=terms,
            command=command_line(),
            warned=output.warnings,
            progress=progress,
        )
        output.warnings.extend(warning for warning in findings.warnings if warning not in output.warnings)
        stage(f"writing {', '.join(formats)}")
        write_findings(findings, folder, formats)
        files = [folder / FILES[name] for name in formats]
        if not output.quiet or output.as_json:
            from gd_analyze.report.context import build_context

            context = build_context(findings)
    if output.as_json:
        print_json(_document(findings, context, files))
    elif not output.quiet:
        _show(findings, context, files, top)


def _document(findings: Findings, context: Context, files: list[Path]) -> dict[str, Any]:
    from dataclasses import asdict

    from gd_analyze.cli.simplify import _labels, model_equations
    from gd_analyze.tables import _term

    return {
        "arm": findings.arm.name,
        "trajectory": findings.trajectory.name,
        "set_points": findings.trajectory.n_set_points,
        "headline": context.headline,
        "budget": context.budget,
        "joints": [asdict(row) for row in context.joint_errors],
        "operations": dict(zip(_COUNTS, context.operations, strict=True)),
        "operations_full": dict(zip(_COUNTS, context.operations_full, strict=True)),
        "level": findings.model.level.name,
        "refitted": findings.model.refitted,
        "search": context.search,
        "equations": list(model_equations(findings.model)),
        "elements": {
            "kept": _labels(findings.element_model),
            "dropped": [asdict(row) for row in context.dropped],
            "operations": dict(zip(_COUNTS, context.element_operations, strict=True)),
            "operations_full": dict(zip(_COUNTS, context.element_operations_full, strict=True)),
        },
        "terms": [_term(term) for term in findings.terms.terms],
        "terms_not_worth_keeping": context.terms_not_worth_keeping,
        "trade_off": [
            {
                "level": point.level.name,
                "refit": point.refit,
                "budget": point.budget,
                "operations": point.operations.total,
                "largest_share": point.error_share,
            }
            for point in findings.trade_off
        ],
        "beyond": [asdict(row) for row in context.beyond],
        "states_drawn": context.drawn,
        "dominance": [asdict(row) for row in context.dominance],
        "residuals": [asdict(residual) for residual in findings.residuals],
        "warnings": list(findings.warnings),
        "provenance": dict(findings.provenance),
        "files": [str(path) for path in files],
    }


def _show(findings: Findings, context: Context, files: list[Path], top: int) -> None:
    from gd_analyze.cli.terminal import line, sentence
    from gd_analyze.report.context import number, percent

    sentence(f"{context.title} {context.subtitle}", bold=True)
    sentence(context.headline)
    _show_errors(findings.arm, context)
    if top:
        _show_ranking(context, top)
    line()
    certified = [row for row in context.beyond if row.certified_share is not None]
    if certified:
        worst = max(certified, key=lambda row: row.certified_share or 0.0)
        sentence(
            "Certified: no state between the extremes of this trajectory errs by more than "
            f"{percent(worst.certified_share or 0.0).replace('< ', '')} of a joint's peak torque "
            f"(joint {worst.joint})."
        )
    if context.text_source:
        agreed, compared = context.text_agreement
        sentence(f"The text's verdicts agree with ours on {agreed} of {compared} elements of D and h.")
    full, left = findings.model.operations_full, findings.model.operations
    line(f"operations  {full}")
    line(f"         -> {left}")
    asked = next((row for row in context.trade_off if row.is_asked), None)
    if asked is not None:
        kinds = (f"{level}{' refit' if refit else ''}" for level, refit in context.trade_off_kinds)
        counts = ", ".join(f"{kind} {n}" for kind, n in zip(kinds, asked.operations, strict=True))
        sentence(f"by level    {counts}, quickly counted", indent=" " * 12)
    residual = max(findings.residuals, key=lambda r: r.largest / r.bound)
    line(
        f"Pinocchio   differs by at most {number(residual.largest)} {residual.unit} "
        f"(round-off allows {number(residual.bound)})"
    )
    for path in files:
        line(f"wrote       {path}")


def _show_errors(arm: RobotArm, context: Context) -> None:
    from gd_analyze.cli.joint_table import joint_table
    from gd_analyze.report.context import number, percent

    rows = context.joint_errors
    joint_table(
        f"Torque error of the simplified model (budget {context.budget}), {{units}} and share of peak torque",
        arm,
        [
            ("peak torque", "right", [number(row.peak_torque) for row in rows]),
            ("allowed", "right", [number(row.allowed) for row in rows]),
            ("largest", "right", [number(row.largest) for row in rows]),
            ("share", "right", [percent(row.largest_share) for row in rows]),
            ("RMS", "right", [number(row.rms) for row in rows]),
            ("share", "right", [percent(row.rms_share) for row in rows]),
        ],
    )


def _show_ranking(context: Context, top: int) -> None:
    from gd_analyze.cli.terminal import table
    from gd_analyze.report.context import number, percent

    with_text = bool(context.text_source)
    shown = context.dominance[:top]
    table(
        f"Ranking by torque, {len(shown)} of {len(context.dominance)} elements: largest part by effect "
        "(D in kg m², h and c in N m), largest torque, its joint and its share of that joint's peak torque",
        [("", "left"), ("tran", "right"), ("rot", "right"), ("torque", "right"), ("joint", "right")]
        + [("share", "right"), ("verdict", "left"), ("kept", "left")]
        + ([("text", "left")] if with_text else []),
        [
            [
                row.element,
                number(row.translation_peak),
                number(row.rotation_peak),
                number(row.torque_peak),
                str(row.torque_joint),
                percent(row.torque_share),
                *(_SHORT[word] for word in words),
            ]
            for row in shown
            for words in [(row.verdict, row.kept, *([row.text_verdict] if with_text else []))]
        ],
    )
