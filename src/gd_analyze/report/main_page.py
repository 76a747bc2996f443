"""The interactive report: one HTML file that opens offline and asks the network for nothing."""

from __future__ import annotations

import json
from typing import Any

from markupsafe import Markup

from gd_analyze import text as formatting
from gd_analyze.dynamics.dominance import elements
from gd_analyze.figures.torques import CONTRIBUTIONS
from gd_analyze.figures.trade_off import kind_name
from gd_analyze.formulas.formula import Legend
from gd_analyze.formulas.languages import PageMathML
from gd_analyze.report.beyond_chart import beyond_chart, place
from gd_analyze.report.budget_equations import budget_equations
from gd_analyze.report.budget_path import DECADES, BudgetPath
from gd_analyze.report.interactive import MOST_POINTS, NEAR, page_data
from gd_analyze.report.measured_document import measured_document
from gd_analyze.report.motions_document import motions_told
from gd_analyze.report.old_numbering import numbering
from gd_analyze.report.page_environment import environment, style, template_text
from gd_analyze.report.recording_document import recording_document
from gd_analyze.report.recursion_document import recursion_shown
from gd_analyze.report.stroboscope import stroboscope
from gd_analyze.report.terms import exact_elements, ranked_rows, shared_accelerations, tallies, torque_names
from gd_analyze.results import summary
from gd_analyze.results.error_words import norms_told
from gd_analyze.results.findings import Findings
from gd_analyze.results.frames import rows_of
from gd_analyze.results.rows import Row, dropped_parts, element_rows, joint_rows, trade_off_rows
from gd_analyze.robots.plausibility import inconsistent_inertias
from gd_analyze.text import inertia_label

SCRIPTS = (
    "chart.js",
    "trade_off.js",
    "plots.js",
    "viewer.js",
    "budget.js",
    "table.js",
    "switches.js",
    "fold.js",
)
# What the appendices are called where there is little room.
SHORT_TITLES = {
    "motion": "Motion",
    "recording": "Readings",
    "measured": "Measured",
    "effects": "Effects",
    "ranking": "Elements",
    "motions": "Motions",
    "terms": "Terms",
    "model": "Savings",
    "beyond": "Beyond",
    "elements": "By hand",
    "equations": "Equations",
    "data": "Data",
}
# Rows of the ranking of single terms.
TERMS_SHOWN = 40
_MATHS = PageMathML()


def render_html(findings: Findings) -> str:
    """Write the interactive report of one run.

    Parameters
    ----------
    findings
        What the main job found.

    Returns
    -------
    str
        A complete document; styles, scripts and data are inside it.

    Examples
    --------
    >>> import gd_analyze as gd
    >>> arm = gd.load_arm("two_link")
    >>> page = render_html(gd.find(arm, gd.read_trajectory("two-link-swing", arm)))
    >>> page.startswith("<!doctype html>")
    True
    """
    path, data = BudgetPath.of(findings), page_data(findings)
    shown = _content(findings, path) | _mathematics(findings, path) | numbering(findings)
    frame = {
        "data": _json(data | {"budgets": path.data(findings)}),
        "trade_off_legend": data["figures"].get("trade-off", {}).get("traces", ()),
        "style": style("report.css"),
        "scripts": Markup("\n".join(template_text(name) for name in SCRIPTS)),
    }
    return environment().get_template("report.html.j2").render(shown | frame)


def _content(findings: Findings, path: BudgetPath) -> dict[str, Any]:
    """Rows, sentences and figures of the page."""
    arm, model, tables, count = (
        findings.arm,
        findings.model,
        findings.tables,
        findings.trajectory.n_set_points,
    )
    rows, trade_off = element_rows(findings), tables["trade_off"]
    joints = joint_rows(findings, "simplified_model", "beyond", "tube")
    ranked = {row["element"]: row for row in rows}
    return {
        **summary.opening(findings),
        "findings": findings,
        "arm": arm,
        "doubts": [*arm.doubts, *inconsistent_inertias(arm)],
        "model": model,
        "elements_only": findings.element_model,
        "steps": summary.search_steps(findings),
        "kinds": list(dict.fromkeys(joint.kind for joint in arm.joints)),
        "joints": joints,
        "dominance": rows,
        "ranked": ranked,
        "panels": _panels(ranked, arm.n_joints),
        "order": {element.label: place for place, element in enumerate(elements(arm.n_joints))},
        "threshold": float(findings.dominance.attrs["threshold"]),
        "verdict_counts": summary.verdict_counts(findings),
        "text": summary.text_comparison(findings),
        "dropped": dropped_parts(findings),
        "by_motion": motions_told(findings),
        "terms": ranked_rows(findings, TERMS_SHOWN),
        "terms_total": tables["terms"].attrs["total"],
        "not_worth_keeping": summary.not_worth_keeping(findings),
        "trade_off": trade_off_rows(findings),
        "trade_off_kinds": [
            kind_name(kind["level"], kind["refit"]).capitalize() for kind in rows_of(trade_off, "kind")
        ],
        "path": path,
        "norms": norms_told(model.accuracy.norms, arm),
        "tube": tables["tube"],
        "tube_sentence": summary.tube_sentence(findings),
        "unsymmetric": summary.unsymmetric_told(findings),
        "budget_place": place(1.0, *DECADES),
        "contributions": {
            name: words for name, words in CONTRIBUTIONS.items() if name != "drives" or model.drives
        },
        "recording": recording_document(findings),
        **_limits(findings),
        "short_titles": SHORT_TITLES,
        "proven": any(row.get("tube_certified") is not None for row in joints),
        "drawn": tables["beyond"].attrs["states_drawn"],
        "beyond_chart": beyond_chart(joints),
        "smallest_payload": min(joints, key=lambda row: row["mass_within_budget"]),
        "bound_ratio": summary.bound_ratio(findings),
        "uncertain": summary.above_allowed(joints, "uncertainty"),
        "outside": summary.above_allowed(joints, "within_limits"),
        "cross_check": rows_of(tables["cross_check"], "comparison"),
        "run": findings.provenance.get("run", ""),
        "provenance": summary.provenance_lines(findings),
        "measured": measured_document(findings),
        "still": stroboscope(arm, findings.trajectory.q, findings.trajectory.gaps),
        "thinned_to": MOST_POINTS if count > MOST_POINTS else None,
    }


def _panels(ranked: dict[str, Row], n_joints: int) -> dict[str, list[Row]]:
    """Rows of all elements by quantity, in the order of the matrix."""
    grouped: dict[str, list[Row]] = {}
    for element in elements(n_joints):
        grouped.setdefault(element.quantity, []).append(ranked[element.label])
    return grouped


def _mathematics(findings: Findings, path: BudgetPath) -> dict[str, Any]:
    """Formulas of the model, of the parts that the element level keeps and of the exact elements."""
    n, model, form = findings.arm.n_joints, findings.model, findings.model.form
    has_terms = model.level.has_torque_terms
    return {
        "torque_lines": budget_equations(findings, path) if has_terms else (),
        "torque_legend": _legend(torque_names(findings)),
        "tallies": tallies(form.torques, model.torques, n) if has_terms else (),
        "kept_torques": model.torques if has_terms else {},
        "shared_accelerations": _legend(shared_accelerations(form.velocities)),
        "parts_formulas": findings.element_model.formulas,
        "inertia_labels": [[inertia_label(i, j) for j in range(n)] for i in range(n)],
        "exact_elements": exact_elements(findings),
        "recursion": recursion_shown(findings),
    }


def _legend(legend: Legend) -> list[Markup]:
    return [*map(Markup, _MATHS.legend(legend))]


def _limits(findings: Findings) -> dict[str, Any]:
    """Torque limits in words, where there are any, and whether one is so near a torque that it is drawn."""
    peaks = findings.model.accuracy.errors.peak_torque
    pairs = [
        (drive.torque_limit, peak, joint.effort_unit)
        for drive, peak, joint in zip(findings.arm.drives, peaks, findings.arm.joints, strict=False)
        if drive.torque_limit is not None
    ]
    return {
        "has_limits": bool(pairs),
        "limit_is_near": any(limit < NEAR * peak for limit, peak, _ in pairs),
        "limits": ", ".join(formatting.amount(limit, unit) for limit, _, unit in pairs),
    }


def _json(values: dict[str, Any]) -> Markup:
    """JSON that cannot end the script element it stands in."""
    text = json.dumps(values, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return Markup(text.replace("<", "\\u003c"))
