"""The PDF's words and numbers as JSON values, formatted and ordered; the template only lays them out."""

from __future__ import annotations

from typing import Any

from gd_analyze.figures.elements import LETTERS
from gd_analyze.figures.torques import CONTRIBUTIONS, Contributions
from gd_analyze.report.arm_data import arm_data
from gd_analyze.report.harmonic_data import harmonic_data
from gd_analyze.report.joint_document import beyond, joints, longest_bar
from gd_analyze.report.measured_document import measured_document
from gd_analyze.report.model_document import founding_method, kept_matrix, operations, trade_off
from gd_analyze.report.motions_document import motions_told
from gd_analyze.report.old_numbering import numbering
from gd_analyze.report.ranking_document import elements_ranked, founding_text, terms_ranked
from gd_analyze.report.recording_document import recording_document
from gd_analyze.report.recursion_document import recursion_data
from gd_analyze.results import summary
from gd_analyze.results.error_words import norms_told
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.rows import element_rows
from gd_analyze.results.words import SYMBOLS, VERDICTS, told
from gd_analyze.text import figures, percent, pretty


def document(findings: Findings) -> dict[str, Any]:
    """Everything the template shows but the figures."""
    arm, model, count = findings.arm, findings.model, findings.trajectory.n_set_points
    ranked, rows = element_rows(findings), joints(findings)
    return {
        **summary.opening(findings),
        "numbers": numbering(findings),
        "letters": LETTERS,
        "n_joints": arm.n_joints,
        "n_set_points": count,
        "thinned_to": 0,
        "all_turning": all(arm.is_revolute),
        "warnings": list(findings.warnings),
        "budget": model.accuracy.budget,
        "shares_of": model.accuracy.asked.shares_of,
        "in_torque": model.accuracy.asked.wholes == {"torque"},
        "is_mechanical": model.level.is_mechanical,
        "saves": model.saves,
        "norms": norms_told(model.accuracy.norms, arm),
        "unsymmetric": summary.unsymmetric_told(findings),
        "refitted": model.refitted,
        "drives": model.drives,
        "contributions": [[name, CONTRIBUTIONS[name]] for name in Contributions.of(findings).parts],
        "search": model.accuracy.search,
        "operations": operations(model.operations_full, model.operations),
        "joints": rows,
        "longest_bar": longest_bar(rows),
        "harmonic": harmonic_data(model),
        "recursion": recursion_data(findings),
        "elements": founding_method(findings),
        "kept": kept_matrix({row["element"]: told(row, "kept") for row in ranked}, arm.n_joints),
        "dominance": elements_ranked(findings, ranked),
        "threshold": percent(float(findings.dominance.attrs["threshold"])),
        "verdicts": [
            f"{number} {VERDICTS[verdict]}"
            for verdict in VERDICTS
            if (number := summary.verdict_counts(findings).get(verdict))
        ],
        "text": founding_text(findings),
        "trade_off": trade_off(findings),
        "by_motion": motions_told(findings),
        "terms": terms_ranked(findings),
        "beyond": beyond(findings),
        "measured": measured_document(findings),
        "cross_check": _cross_check(findings),
        "recording": recording_document(findings),
        "arm": arm_data(arm),
        "run": findings.provenance.get("run", ""),
        "provenance": [
            [label.replace("_", " "), value] for label, value in summary.provenance_lines(findings)
        ],
    }


def _cross_check(findings: Findings) -> list[dict[str, str]]:
    return [
        {
            "symbol": SYMBOLS[row["quantity"]],
            "quantity": row["quantity"].replace("_", " "),
            "largest_difference": figures(row["largest_difference"]),
            "round_off_bound": figures(row["round_off_bound"]),
            "unit": pretty(row["unit"]),
        }
        for row in rows_of(findings.tables["cross_check"], "comparison")
    ]
