"""The main report as a page: the answer, the budget that can be moved, the model, and appendices."""

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
    table_html,
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
    letters = dict(zip((section.key for section in report.appendices), "ABCDEFGHIJKLM", strict=False))
    folded = "".join(
        _appendix(findings, section, letters[section.key], report.numbers) for section in report.appendices
    )
    body = (
        f'<section id="answer">\n{opening(report.opening)}{_first_screen(findings, report)}</section>\n'
        f"{_budget(findings, path, report)}{_the_model(findings, path, report.numbers)}"
        '<section id="appendices" aria-labelledby="appendices-title">\n<div class="appendices-head">'
        '<h2 id="appendices-title">Appendices</h2> '
        '<button type="button" id="open-all">Unfold all</button></div>\n'
        f"{folded}</section>"
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


def _first_screen(findings: Findings, report: MainReport) -> str:
    """The arm that plays beside the stacked torques."""
    rows = "".join(
        f'<tr><th scope="row">{k} {escape(joint.name)}</th>{2 * _EMPTY_CELL}</tr>\n'
        for k, joint in enumerate(findings.arm.joints, start=1)
    )
    (panel,) = report.arm.figure.panels
    card = template("arm.html").format(
        drawn=f'<div id="scene">{panel_svg(panel, report.arm.figure)}</div>',
        rows=rows,
        caption=f"{report.numbers.of_figure('arm')}{text(report.arm.title)}",
    )
    return f'<div class="opening">\n{card}{drawing_html(report.contributions, report.numbers)}</div>\n'


def _budget(findings: Findings, path: BudgetPath, report: MainReport) -> str:
    """The slider, the joints' errors under it, and the trade-off."""
    model, kind, rows = findings.model, made_of(findings), path.rows
    if path.moves:
        kept = (
            _figure("kept", len(rows[path.asked]["kept"]), kind, "kept") if kind in ("terms", "parts") else ""
        )
        share, of = float(model.accuracy.shares.max(initial=0.0)), model.accuracy.asked.shares_of
        more, less = "changes more steps", "keeps nothing that a smaller one drops"
        head = template("budget.html").format(
            label=escape(budget_words(rows[path.asked]["budget"])),
            last=len(rows) - 1,
            asked=path.asked,
            count=_figure("count", model.operations.total, "operations", f"of {model.operations_full.total}"),
            kept=kept,
            worst=_figure("worst", text(percent(share)), "largest error,", f"of {of}"),
            budget=escape(model.accuracy.budget),
            what=more if kind == "recursion" else less,
        )
    else:
        low, high = (escape(budget_words(rows[k]["budget"])) for k in (0, -1))
        nothing = "nothing can be dropped that would save an operation"
        head = (
            f'<p class="note">No other model from {low} to {high}: '
            f"{'the model stays the same' if model.saves else nothing}. "
            f"The exact torque takes <b>{model.operations_full.total}</b> operations.</p>\n"
        )
    trade = fold = ""
    if report.trade_off:
        drawing, table = report.trade_off
        trade = f'<div class="card">{drawing_html(drawing, report.numbers)}</div>'
        inside = table_html(table, report.numbers)
        fold = f"<details><summary>The same in numbers</summary>\n{inside}</details>\n"
    return (
        '<section id="budget" aria-labelledby="budget-title">\n'
        '<h2 id="budget-title">What the budget buys</h2>\n'
        f'{head}<div class="buys{"" if trade else " alone"}">\n'
        f'<div class="card">{_errors(findings, report.numbers)}</div>\n'
        f"{trade}</div>\n{fold}</section>\n"
    )


def _figure(key: str, value: Any, first: str, second: str) -> str:
    return f'<p class="result"><b id="budget-{key}">{value}</b> <span>{first}<br>{second}</span></p>'


def _errors(findings: Findings, numbers: Numbers) -> str:
    """Every joint's error against the budget, on a logarithmic scale that the slider moves."""
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


def _the_model(findings: Findings, path: BudgetPath, numbers: Numbers) -> str:
    """The model as equations; terms follow the slider."""
    model, kind = findings.model, made_of(findings)
    if kind == "terms":
        inside = (
            '<p class="lead">All of the model: a line each for <i>D</i> inertia, <i>h</i> Coriolis and '
            "centrifugal, and <i>c</i> gravity. SI units; three digits shown, all of them in "
            "<code>model.json</code>.</p>\n"
            f'<div class="torques">\n{budget_equations(findings, path)}</div>\n{meanings_html(model.legend)}'
        )
        if model.refitted or model.level.is_mechanical:
            inside += '<p class="small only-other">Coefficients are those of this report\'s model.</p>\n'
    else:
        inside = parts_html(model_parts(findings), numbers)
    if kind == "recursion":
        inside = (
            '<p class="lead">The recursion of Newton and Euler with the constants of this arm: outward for '
            "velocities and accelerations, inward for forces and moments. A simplified step is dropped, "
            'lacks a summand, or has another number. <a href="#model">The appendix</a> has all equations and '
            f"what was left out.</p>\n{inside}"
        )
    return (
        '<section id="the-model" aria-labelledby="model-title">\n<h2 id="model-title">The model</h2>\n'
        f"{inside}{template('reading.html')}</section>\n"
    )


def _appendix(findings: Findings, section: Section, letter: str, numbers: Numbers) -> str:
    more = template(f"{section.key}.html") if section.key in ("effects", "equations") else ""
    inside = parts_html(section.parts, numbers, level=3)
    if section.key == "data":
        inside += provenance_html(dict(provenance_lines(findings)))
    return (
        f'<details class="appendix" id="{section.key}">\n<summary><h2><span class="letter">{letter}</span> '
        f"{text(section.title)}</h2></summary>\n{paragraphs(section.note)}{more}{inside}</details>\n"
    )
