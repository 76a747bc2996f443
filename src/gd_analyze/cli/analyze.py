"""`gd-analyze ROBOT TRAJECTORY`: the main job."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from gd_analyze.cli.options import ROBOT, TRAJECTORY, reporting

if TYPE_CHECKING:
    from gd_analyze.findings import Findings

_SHORT = {"translation": "tran", "rotation": "rot", "both": "both", "negligible": "negl.", "neither": "-", "": ""}
_FORMATS = "h5,json,csv,html,pdf"
# Below this a decomposition takes a fraction of a second and a progress bar would only flicker.
_LONG = 100_000


@click.command(hidden=True)
@click.argument("robot", type=ROBOT)
@click.argument("trajectory", type=TRAJECTORY)
@click.option("-o", "--out", type=click.Path(path_type=Path), help="Folder for the results.")
@click.option(
    "--format",
    "formats",
    default=_FORMATS,
    show_default=True,
    metavar="LIST",
    help="Which files to write.",
)
@click.option(
    "--budget",
    default="1%",
    show_default=True,
    metavar="LIST",
    help="Allowed torque error: share of each joint's peak torque (1%), or N m (0.5); one, or one per joint.",
)
@click.option("--drives", is_flag=True, help="Include drive inertia as a separate contribution.")
@click.option("--no-coupling", is_flag=True, help="Do not store h_ijk (2 n^3 numbers per set point).")
@click.option("--by-link", is_flag=True, help="Also store what each link contributes.")
@click.option("--terms", is_flag=True, help="Also store the text's terms T1..T4, R1, R2 of h.")
@click.option("--top", default=12, show_default=True, help="Rows of the ranking to print.")
@reporting
def analyze(
    robot: str,
    trajectory: str,
    out: Path | None,
    formats: str,
    budget: str,
    drives: bool,
    no_coupling: bool,
    by_link: bool,
    terms: bool,
    top: int,
    as_json: bool,
    quiet: bool,
    debug: bool,
) -> None:
    """Decompose, rank, simplify, store and report: the main job."""
    from gd_analyze.cli.terminal import print_json, progress_bar, warnings_told
    from gd_analyze.main_job import FILES, default_folder
    from gd_analyze.main_job import analyze as run
    from gd_analyze.robots import load_arm
    from gd_analyze.simplification import Budget
    from gd_analyze.trajectories import read_trajectory

    allowed = Budget.parse(budget)
    chosen = tuple(name.strip() for name in formats.split(",") if name.strip())
    with warnings_told(quiet) as warned:
        arm = load_arm(robot)
        motion = read_trajectory(trajectory, arm)
    folder = default_folder(arm, motion) if out is None else out
    long = motion.n_set_points >= _LONG and not quiet
    with progress_bar("decomposing", motion.n_set_points, long) as progress:
        findings = run(
            arm,
            motion,
            folder,
            formats=chosen,
            budget=allowed,
            drives=drives,
            coupling=not no_coupling,
            by_link=by_link,
            terms=terms,
            command=shlex.join(["gd-analyze", *sys.argv[1:]]),
            warned=warned,
            progress=progress,
        )
    files = [folder / FILES[name] for name in FILES if name in chosen]
    if as_json:
        print_json(_summary(findings, files))
    elif not quiet:
        _show(findings, files, top)


def _summary(findings: Findings, files: list[Path]) -> dict[str, Any]:
    from dataclasses import asdict

    from gd_analyze.report.context import build_context

    context = build_context(findings)
    return {
        "arm": findings.arm.name,
        "trajectory": findings.trajectory.name,
        "set_points": findings.trajectory.n_set_points,
        "headline": context.headline,
        "budget": context.budget,
        "joints": [asdict(row) for row in context.joint_errors],
        "operations": dict(zip(("multiplications", "additions", "sines_cosines"), context.operations, strict=True)),
        "operations_full": dict(
            zip(("multiplications", "additions", "sines_cosines"), context.operations_full, strict=True)
        ),
        "kept": list(findings.model.kept),
        "dropped": [asdict(row) for row in context.dropped],
        "dominance": [asdict(row) for row in context.dominance],
        "residuals": [asdict(residual) for residual in findings.residuals],
        "warnings": list(findings.warnings),
        "files": [str(path) for path in files],
    }


def _show(findings: Findings, files: list[Path], top: int) -> None:
    from gd_analyze.cli.terminal import console, table
    from gd_analyze.report.context import build_context, number, percent

    context = build_context(findings)
    screen = console()
    screen.print(f"[bold]{context.title}[/bold] {context.subtitle}", markup=True)
    screen.print(context.headline)
    screen.print(
        table(
            f"Torque error of the simplified model, budget {context.budget}: N m, of peak torque",
            [("joint", "left"), ("peak", "right"), ("allowed", "right"), ("largest", "right"), ("", "right")]
            + [("RMS", "right"), ("", "right")],
            [
                [
                    f"{row.joint} {row.name}",
                    f"{number(row.peak_torque)}{'' if row.unit == 'N m' else ' ' + row.unit}",
                    number(row.allowed),
                    number(row.largest),
                    percent(row.largest_share),
                    number(row.rms),
                    percent(row.rms_share),
                ]
                for row in context.joint_errors
            ],
        )
    )
    with_text = bool(context.text_source)
    shown = context.dominance[:top]
    screen.print(
        table(
            f"Ranking by torque, {len(shown)} of {len(context.dominance)} elements (D kg m²; h, c N m)",
            [("", "left"), ("tran", "right"), ("rot", "right"), ("torque", "right"), ("joint", "right")]
            + [("of peak", "right"), ("verdict", "left"), ("kept", "left")]
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
    )
    if with_text:
        agreed, compared = context.text_agreement
        screen.print(f"The text's verdicts agree with ours on {agreed} of {compared} elements of D and h.")
    full, left = findings.model.operations_full, findings.model.operations
    screen.print(f"operations  {full}\n         ->  {left}")
    largest = max(findings.residuals, key=lambda residual: residual.largest / residual.bound)
    screen.print(
        f"Pinocchio   differs by at most {number(largest.largest)} {largest.unit} "
        f"(round-off allows {number(largest.bound)})"
    )
    for path in files:
        screen.print(f"wrote       {path}", soft_wrap=True)
