"""The main report as a page: the answer, the budget slider, the model, and appendices."""

from __future__ import annotations

import json
from typing import Any

from markupsafe import escape

from gd_analyze.figures.arm import playable
from gd_analyze.figures.svg import panel_svg
from gd_analyze.report.budget import BudgetPath, budget_equations, budget_words, place
from gd_analyze.report.html import (
    drawing_html,
    frame,
    meanings_html,
    opening,
    paragraphs,
    parts_html,
    provenance_html,
    template,
    text,
)
from gd_analyze.report.main_report import MainReport, main_report
from gd_analyze.report.model_sections import made_of, model_parts
from gd_analyze.report.numbering import Numbers
from gd_analyze.result import Section
from gd_analyze.results.findings import Findings
from gd_analyze.results.rows import joint_rows
from gd_analyze.results.run_result import provenance_lines, tube_bound
from gd_analyze.text import amount, percent

_EMPTY_CELL = '<td class="value"></td>'
_APPENDIX_NAMES = {
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


def render_html(findings: Findings, report: MainReport | None = None) -> str:
    """Write the interactive report of one run: one document with styles, drawings and scripts inside."""
    report, path = report or main_report(findings), BudgetPath.of(findings)
    numbers = report.numbers
    letters = dict(zip((section.key for section in report.appendices), "ABCDEFGHIJKLM", strict=False))
    appendices = (
        _appendix(findings, section, letters[section.key], numbers) for section in report.appendices
    )
    body = template("main.html").format(
        opening=opening(report.opening),
        arm=_arm(findings, report),
        contributions=drawing_html(report.contributions, numbers),
        dominance=drawing_html(report.dominance, numbers),
        slider=_slider(findings, path),
        errors=_errors(findings, numbers),
        model=_model(findings, path, numbers),
        appendices="".join(appendices),
    )
    links = [("answer", "Answer"), ("budget", "Budget"), ("the-model", "Model")]
    links += [(key, f"{letter} {_APPENDIX_NAMES[key]}") for key, letter in letters.items()]
    data = {"arm": playable(findings), "budgets": path.data(findings) if path.moves else None}
    written = json.dumps(data, ensure_ascii=False, allow_nan=False, separators=(",", ":"))
    return frame(
        f"{report.opening.title} {report.opening.subtitle}",
        links,
        body,
        data=written.replace("<", "\\u003c"),  # which could end the script element
        run=findings.provenance.get("run", ""),
    )


def _arm(findings: Findings, report: MainReport) -> str:
    """The animated arm."""
    rows = "".join(
        f'<tr><th scope="row">{k} {escape(joint.name)}</th>{2 * _EMPTY_CELL}</tr>\n'
        for k, joint in enumerate(findings.arm.joints, start=1)
    )
    (panel,) = report.arm.figure.panels
    return template("arm.html").format(
        drawn=f'<div id="scene">{panel_svg(panel, report.arm.figure)}</div>',
        rows=rows,
        caption=f"{report.numbers.of_figure('arm')}{text(report.arm.title)}",
    )


def _slider(findings: Findings, path: BudgetPath) -> str:
    """The budget slider, or a note that no other budget gives another model."""
    model, kind, rows = findings.model, made_of(findings), path.rows
    full = model.operations_full.total
    if not path.moves:
        low, high = (escape(budget_words(rows[k]["budget"])) for k in (0, -1))
        nothing = "dropping terms would not save an operation"
        return (
            f'<p class="note">No other model from {low} to {high}: '
            f"{nothing if model.is_exact else 'the model stays the same'}. "
            f"The exact torque takes <b>{full}</b> operations.</p>\n"
        )
    count = len(rows[path.asked]["kept"])
    share, of = float(model.accuracy.shares.max(initial=0.0)), model.accuracy.asked.shares_of
    more, less = "changes more steps", "keeps nothing that a smaller one drops"
    return template("budget.html").format(
        label=escape(budget_words(rows[path.asked]["budget"])),
        last=len(rows) - 1,
        asked=path.asked,
        count=_figure("count", model.operations.total, "operations", f"of {full}"),
        kept=_figure("kept", count, kind, "kept") if kind in ("terms", "parts") else "",
        worst=_figure("worst", text(percent(share)), "largest error,", f"of {of}"),
        budget=escape(model.accuracy.budget),
        what=more if kind == "recursion" else less,
    )


def _figure(key: str, value: Any, first: str, second: str) -> str:
    return f'<p class="result"><b id="budget-{key}">{value}</b> <span>{first}<br>{second}</span></p>'


def _errors(findings: Findings, numbers: Numbers) -> str:
    """Every joint's error against the budget, on a logarithmic scale; the slider updates it."""
    accuracy, proven, rows = findings.model.accuracy, tube_bound(findings), []
    for i, row in enumerate(joint_rows(findings, "simplified_model")):
        allowed, error, unit = row["allowed_error"], row["largest_error"], row["effort_unit"]
        mark, name = "", escape(row["joint_name"])
        if proven is not None and allowed > 0:
            mark = f'<i class="proven-mark" style="left:{place(float(proven[i]) / allowed)}%"></i>'
        at = place(error / allowed if allowed > 0 else float(error > 0))
        rows.append(
            f'<tr style="--error:{at};--budget:{place(1.0)}"><th scope="row"><b>{i + 1}</b> '
            f'<span class="name" title="{name}">{name}</span></th>\n<td class="bar-cell"><span class="log" '
            f'aria-hidden="true"><i class="fill"></i>{mark}<i class="allowed"></i></span></td>\n'
            f'<td class="said">{text(amount(error, unit))} of {text(amount(allowed, unit))}</td>\n'
            f'<td class="value">{text(percent(float(accuracy.shares[i])))}</td></tr>\n'
        )
    title = "Largest torque error of each joint on a logarithmic scale; the line is the budget"
    title += ", the diamond the error proven near the motion." if proven is not None else "."
    return template("errors.html").format(
        caption=f"{numbers.of_table('errors')}{title}",
        rows="".join(rows),
        shares_of=accuracy.asked.shares_of,
        budget=place(1.0),
    )


def _model(findings: Findings, path: BudgetPath, numbers: Numbers) -> str:
    """The model as equations; terms follow the slider."""
    model, kind = findings.model, made_of(findings)
    if kind != "terms":
        lead = template("recursion.html") if kind == "recursion" else ""
        return lead + parts_html(model_parts(findings), numbers)
    inside = template("terms.html").format(
        equations=budget_equations(findings, path), meanings=meanings_html(model.legend)
    )
    if model.refitted or model.level.is_mechanical:
        inside += '<p class="small only-other">Coefficients are those of this report\'s model.</p>\n'
    return inside


def _appendix(findings: Findings, section: Section, letter: str, numbers: Numbers) -> str:
    more = template(f"{section.key}.html") if section.key in ("effects", "equations") else ""
    inside = parts_html(section.parts, numbers, level=3)
    if section.key == "data":
        inside += provenance_html(dict(provenance_lines(findings)))
    return (
        f'<details class="appendix" id="{section.key}">\n<summary><h2><span class="letter">{letter}</span> '
        f"{text(section.title)}</h2></summary>\n{paragraphs(section.note)}{more}{inside}</details>\n"
    )
