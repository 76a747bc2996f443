"""What the main job found, as terminal and JSON show it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

from gd_analyze.cli.measured_torque import show_measured_torque
from gd_analyze.cli.motions import motions_document, show_motions
from gd_analyze.cli.output import Output
from gd_analyze.cli.recursion_view import recursion_document
from gd_analyze.cli.terminal import line, sentence, table

if TYPE_CHECKING:
    from gd_analyze.results.findings import Findings


def print_findings(
    findings: Findings, folder: Path, formats: tuple[str, ...], output: Output, top: int
) -> None:
    """Print what was found and which files hold it; `top` rows of the ranking for people."""
    from gd_analyze.studies.folder import FILES

    files = [folder / FILES[name] for name in formats]
    output.give(lambda: _document(findings, files, output.warnings), lambda: _show(findings, files, top))


def _document(findings: Findings, files: list[Path], warned: list[str]) -> dict[str, Any]:
    from dataclasses import asdict

    from gd_analyze.formulas.languages import Plain
    from gd_analyze.motions.states import states_of
    from gd_analyze.results import summary
    from gd_analyze.results.frames import rows_of
    from gd_analyze.results.rows import budget_rows, element_rows, joint_rows
    from gd_analyze.simplification.recursive import RECURSIVE

    model, tables = findings.model, findings.tables
    parts = rows_of(tables["parts"], "part")
    return {
        "arm": findings.arm.name,
        "trajectory": findings.trajectory.name,
        "set_points": findings.trajectory.n_set_points,
        "headline": summary.headline(findings),
        "budget": model.accuracy.budget,
        "drives": model.drives,
        "saves": model.saves,
        "notice": model.notice,
        "level": model.level.name,
        "refitted": model.refitted,
        "levels": [one._asdict() for one in model.accuracy.levels],
        "search": [step._asdict() for step in model.accuracy.steps],
        "joints": joint_rows(findings, "simplified_model"),
        "operations": asdict(model.operations),
        "operations_full": asdict(model.operations_full),
        "equations": [Plain().line(formula) for formula in model.formulas],
        "recursion": recursion_document(model, states_of(findings.trajectory), Plain().digits)
        if model.level is RECURSIVE
        else None,
        "elements": {
            "kept": [row["part"] for row in parts if row["kept"]],
            "dropped": sorted(
                (row for row in parts if not row["kept"]), key=lambda row: -row["torque_share"]
            ),
            "operations": asdict(findings.element_model.operations),
            "operations_full": asdict(findings.element_model.operations_full),
        },
        "terms": rows_of(tables["terms"], "rank"),
        "terms_total": tables["terms"].attrs["total"],
        "terms_not_worth_keeping": summary.not_worth_keeping(findings),
        "trade_off_shares_of": tables["trade_off"].attrs["shares_of"],
        "trade_off": rows_of(tables["trade_off"], "kind", "factor"),
        "budgets": budget_rows(findings),
        "beyond": joint_rows(findings, "beyond"),
        "tube": {
            "joints": joint_rows(findings, "tube"),
            **{name: tables["tube"].attrs[name] for name in ("margin", "coarse", "note")},
        },
        "recording": _recording(findings),
        "measured_torque": _measured_torque(findings),
        "motions": motions_document(findings),
        "states_drawn": tables["beyond"].attrs["states_drawn"],
        "dominance": element_rows(findings),
        "residuals": rows_of(tables["cross_check"], "comparison"),
        "warnings": list(dict.fromkeys([*findings.warnings, *warned])),
        "provenance": dict(findings.provenance),
        "files": [str(path) for path in files],
    }


def _recording(findings: Findings) -> dict[str, Any] | None:
    """Of a measured motion: what was done with the readings, and what their noise does."""
    from gd_analyze.results import summary
    from gd_analyze.results.frames import rows_of
    from gd_analyze.results.recording_words import noise_rows

    if "recording" not in findings.tables:
        return None
    table = findings.tables["recording"]
    return {
        "said": summary.recording_told(findings),
        "treatment": table.attrs["treatment"].split("\n"),
        "joints": noise_rows(findings),
        "elements": rows_of(table[["element_noise", "within_noise", "verdict_open"]], "element"),
        "columns": [
            {key.removeprefix("column_"): value for key, value in row.items()}
            for row in rows_of(table, "column")
        ],
    }


def _measured_torque(findings: Findings) -> dict[str, Any] | None:
    from gd_analyze.results.torque_words import is_described, measured_rows, torque_sentence

    if "measured_torque" not in findings.tables:
        return None
    table = findings.tables["measured_torque"]
    return {
        "described": is_described(table),
        "said": torque_sentence(table),
        "compared": table.attrs["compared"],
        "joints": measured_rows(findings),
    }


def _show(findings: Findings, files: list[Path], top: int) -> None:
    from gd_analyze.results import summary
    from gd_analyze.simplification.element import ELEMENT
    from gd_analyze.text import number

    sentence(f"{summary.title(findings)} {summary.subtitle(findings)}", bold=True)
    sentence(summary.headline(findings))
    for told in summary.recording_told(findings):
        sentence(told)
    _show_errors(findings)
    show_measured_torque(findings)
    show_motions(findings, top)
    if findings.model.notice:
        line()
        sentence(findings.model.notice)
    if top:
        _show_ranking(findings, top)
    line()
    _show_bounds(findings)
    if unsymmetric := summary.unsymmetric_told(findings):
        sentence(unsymmetric)
    if (text := summary.text_comparison(findings)) is not None:
        sentence(
            f"The founding text's verdicts agree with ours on {text['agreed']} of {text['given']} elements."
        )
    line()
    line(f"operations  {findings.model.operations_full}")
    if findings.model.saves:
        line(f"         -> {findings.model.operations}")
    sentence(f"by level    {_by_level(findings)}", indent=" " * 12)
    if findings.model.level is not ELEMENT:
        line("            found quickly; `gd-analyze simplify` searches longer")
    check = summary.cross_check_row(findings)
    line(
        f"Pinocchio   differs by {number(check['largest_difference'])} {check['unit']} "
        f"(round-off allows {number(check['round_off_bound'])})"
    )
    for path in files:
        line(f"wrote       {path}")


def _show_errors(findings: Findings) -> None:
    """Print what every joint's torque is off by: sampled at the set points, and proven near the motion."""
    import numpy as np

    from gd_analyze.cli.joint_table import joint_table, percents
    from gd_analyze.simplification.accuracy import share_of
    from gd_analyze.text import rounded_up, share_up

    model = findings.model
    accuracy, by_peak = model.accuracy, model.accuracy.asked.wholes == {"peak"}
    whole = accuracy.errors.peak_torque if by_peak else accuracy.allowed
    columns: list[Any] = [("peak torque", accuracy.errors.peak_torque), ("allowed", accuracy.allowed)]
    if not model.saves:
        title = f"Peak torque, and the error that the budget ({accuracy.budget}) allows, {{units}}"
        joint_table(title, findings.arm, columns)
        return
    columns += [
        ("sampled", accuracy.errors.largest),
        ("share", percents(share_of(accuracy.errors.largest, whole))),
    ]
    bound = findings.tables["tube"].tube_certified.values
    if np.isfinite(bound).all():
        # A bound is never shown smaller than it is.
        columns.append(("proven", np.array([rounded_up(float(x)) for x in bound])))
        columns.append(("share", percents(share_up(float(x)) for x in share_of(bound, whole))))
    joint_table(
        f"Largest torque error (budget {accuracy.budget}), {{units}}, and its share of "
        + ("peak torque" if by_peak else "the allowed error"),
        findings.arm,
        columns,
    )


def _show_bounds(findings: Findings) -> None:
    """Say what is proven near the motion, and what between its extremes."""
    from gd_analyze.results import summary

    sentence(summary.tube_sentence(findings))
    bound = findings.tables["beyond"].certified
    if findings.model.saves and bound.notnull().all():
        worst = summary.worst_error(findings.model, bound.values)
        sentence(
            f"Between the extremes of this trajectory, in any combination, the bound is {worst.in_words}."
        )


def _by_level(findings: Findings) -> str:
    """Operations of every level under the budget asked for, and in brackets those of its refitted model."""
    asked = findings.tables["trade_off"].sel(factor=1.0)
    kinds = zip(asked.level.values, asked.refit.values, asked.operations.values, strict=True)
    counts: dict[str, str] = {}
    for level, refit, operations in kinds:
        counts[level] = f"{counts[level]} (refitted {operations})" if refit else f"{level} {operations}"
    return ", ".join(counts.values())


def _show_ranking(findings: Findings, top: int) -> None:
    from gd_analyze.figures.elements import LETTERS
    from gd_analyze.results.rows import element_rows
    from gd_analyze.results.words import VERDICTS, told
    from gd_analyze.text import amount, fitting, number, percent, pretty

    rows = element_rows(findings)
    with_text = any(row["text_verdict"] for row in rows)
    shown = rows[:top]
    cells = []
    for row in shown:
        parts = [row["part_peak_translation"], row["part_peak_rotation"]]
        factor, unit = fitting(parts, row["unit"])
        cells.append(
            [
                row["element"],
                *(number(part / factor) for part in parts),
                pretty(unit),
                amount(row["torque_peak"], row["torque_unit"]),
                str(row["torque_joint"]),
                percent(row["torque_share"]),
                VERDICTS[told(row)],
                LETTERS[told(row, "kept")],
                *([LETTERS.get(row["text_verdict"], "")] if with_text else []),
            ]
        )
    table(
        f"Ranking by torque, {len(shown)} of {len(rows)} elements: largest part by effect, largest torque, "
        "its joint and its share of that joint's peak torque",
        ["", "tran", "rot", "", "torque", "joint", "share", "verdict", "kept"] + ["FGL87"] * with_text,
        cells,
        "lrrlrrrlll",
    )
